//! The record of the emulated arm's motions, apart from its answers on the line: for tests that want to know whether a
//! motion was ever asked for, or carried out, beyond some limit.

use crate::path::{JOINTS, Joints, Leg};

/// Targets that are recorded. Of further ones only the extremes are known.
const TARGETS_MAX: usize = 200_000;

/// The motions of the arm and other events since the emulator was started.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EmulatorRecord {
    /// Motions begun.
    pub motions: u64,
    /// The ends of all legs of those motions, in degrees. When there are too many, the latest are left out.
    pub targets: Vec<Joints>,
    /// The joints now, in degrees.
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
    /// Times the arm met an obstacle that does not give way.
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

impl EmulatorRecord {
    /// The record of an arm that stands and has done nothing yet.
    pub(crate) fn new(joints: Joints) -> Self {
        let extremes = joints.map(|value| (value, value));
        Self { joints, extremes, tip_m_min: f64::INFINITY, ..Self::default() }
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
