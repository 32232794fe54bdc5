//! What the emulated arm was made to do, kept apart from what it says about it: for tests that want to know whether a
//! motion was ever asked for, or taken, beyond some limit.

use crate::path::{JOINTS, Joints, Leg};

/// Targets kept; of more, only the extremes are known.
const TARGETS_MAX: usize = 200_000;

/// What the arm did since it was switched on first.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Motions begun.
    pub motions: u64,
    /// Where they were to go, legs included, in degrees; the latest are left out when there are too many.
    pub targets: Vec<Joints>,
    /// Where the joints are now, in degrees.
    pub joints: Joints,
    /// The highest share of full speed asked for.
    pub speed_max: f64,
    /// The lowest and highest value that each joint ever had, in degrees.
    pub extremes: [(f64, f64); JOINTS],
    /// The lowest that the finger's tip ever was, in metres.
    pub tip_m_min: f64,
    /// Motions braked before their end.
    pub stops: u64,
    /// Times the emergency stop was pressed.
    pub e_stops: u64,
    /// Times the arm met what does not give way.
    pub envelope_errors: u64,
    /// Lines that came in.
    pub lines: u64,
    /// Times the watchdog stopped a motion.
    pub watchdog_stops: u64,
    /// Pictures taken.
    pub pictures: u64,
    /// Faults that the line had.
    pub faults: u64,
    /// Whether the motors have power.
    pub powered: bool,
    /// Times that power was asked to come up.
    pub power_ups: u64,
    /// Calibrations begun, in which an arm moves by itself.
    pub calibrations_begun: u64,
    /// Calibrations that came to their end.
    pub calibrations: u64,
}

impl Record {
    pub(crate) fn new(joints: Joints) -> Self {
        Self {
            motions: 0,
            targets: Vec::new(),
            joints,
            speed_max: 0.0,
            extremes: joints.map(|value| (value, value)),
            tip_m_min: f64::INFINITY,
            stops: 0,
            e_stops: 0,
            envelope_errors: 0,
            lines: 0,
            watchdog_stops: 0,
            pictures: 0,
            faults: 0,
            powered: false,
            power_ups: 0,
            calibrations_begun: 0,
            calibrations: 0,
        }
    }

    pub(crate) fn motion(&mut self, legs: &[Leg]) {
        self.motions += 1;
        for leg in legs {
            self.speed_max = self.speed_max.max(leg.speed);
            if self.targets.len() < TARGETS_MAX {
                self.targets.push(leg.to);
            }
        }
    }

    /// The figures alone, for a person.
    pub(crate) fn summary(&self) -> String {
        format!(
            "motions {} stops {} watchdog {} e-stops {} envelope {} lines {} pictures {} faults {}",
            self.motions,
            self.stops,
            self.watchdog_stops,
            self.e_stops,
            self.envelope_errors,
            self.lines,
            self.pictures,
            self.faults
        )
    }

    pub(crate) fn passed(&mut self, joints: Joints, tip_m: f64) {
        self.joints = joints;
        for ((low, high), value) in self.extremes.iter_mut().zip(joints) {
            *low = low.min(value);
            *high = high.max(value);
        }
        self.tip_m_min = self.tip_m_min.min(tip_m);
    }
}
