//! The arm and its controller's state: power, calibration, emergency stop, softstops, one motion at a time. It knows
//! no text and no line: the monitor and the server program are two ways to drive it.
//!
//! Behind the machine is the world of `pschema-sim`: the same arm, table, blocks and camera as the simulated body's.
//! The trajectory is this controller's own.

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use pschema_arm::{FileError, Side};
use pschema_protocol::body::Outcome;
use pschema_sim::body::SimBody;
use pschema_sim::config::WorldFile;
use pschema_sim::world::STEP_S;
use pschema_vision::image::RgbImage;

use crate::messages::{self, VPlusMessage};
use crate::path::{JOINTS, JointPath, Joints, Leg};
use crate::record::EmulatorRecord;

/// Softstops of the emulated robot, in degrees: first and last value of each joint. Wider than its work space, as
/// those of a real one are.
pub const SOFTSTOPS_DEG: [(f64, f64); JOINTS] =
    [(-120.0, 120.0), (-170.0, 10.0), (0.0, 140.0), (-80.0, 10.0)];
/// Time that power takes to come up, in seconds. From memory of such machines.
pub(crate) const POWER_UP_S: f64 = 2.0;
/// Time that calibration takes, in seconds. From memory; a real one also moves the arm a little.
pub(crate) const CALIBRATION_S: f64 = 3.0;
/// When the finger is deeper than this in an obstacle, the arm has not followed its path, in metres.
const ENVELOPE_M: f64 = 0.006;
/// When the finger's ball is nearer to the table than this, it scrapes the table, in metres.
const SCRAPE_M: f64 = 0.0005;
/// Longest wait for blocks to come to rest after a motion, in steps.
const SETTLE_STEPS_MAX: u32 = 240;
/// The first of the digital inputs that the touch pads are wired to; the others follow in the order of [`Side::ALL`].
pub(crate) const FIRST_SIGNAL: u16 = 1001;

/// High power to the motors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PowerState {
    Off,
    /// Power is coming up; the seconds that are left.
    Coming(f64),
    On,
}

/// How a motion ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MotionEnd {
    Arrived,
    /// A touch signal came on.
    Touched,
    /// Stopped by order.
    Stopped,
    /// An error, after which power is off.
    Error(VPlusMessage),
}

/// The touch signals that end a motion before its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TouchGuard {
    None,
    /// A touch signal that comes on.
    On,
    /// A touch signal that goes off.
    Off,
}

struct Motion {
    path: JointPath,
    guard: TouchGuard,
    signals: u8,
    why: Option<MotionEnd>,
}

/// An event that no order brought about at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MachineEvent {
    /// A motion ended.
    Ended(MotionEnd),
    /// Power is up.
    PowerUp,
    /// Calibration is done.
    Calibrated,
    /// Power coming up, or a calibration, has ended before its time.
    Interrupted(VPlusMessage),
}

/// The controller with its arm.
pub(crate) struct Machine {
    body: SimBody,
    /// The touch pads' inputs are on when nothing is touched.
    inverted: bool,
    joints: Joints,
    speeds_deg_per_s: Joints,
    power: PowerState,
    /// The seconds of calibration that are left.
    calibrating: Option<f64>,
    calibrated: bool,
    e_stop: bool,
    motion: Option<Motion>,
    events: Vec<MachineEvent>,
    /// Time that has passed and is not a whole step yet, in seconds.
    over_s: f64,
    record: Arc<Mutex<EmulatorRecord>>,
}

impl Machine {
    /// A controller that has just been switched on, its arm at rest in a world.
    pub(crate) fn new(world: &str, seed: u64) -> Result<Self, FileError> {
        let body = SimBody::new("emulated", WorldFile::load(world)?, world, seed, false)?;
        let joints = body.posture().angles_rad.map(f64::to_degrees);
        let full = body.workspace().file.arm.joint_speed_max_deg_per_s.get();
        Ok(Self {
            body,
            inverted: false,
            joints,
            speeds_deg_per_s: [full; JOINTS],
            power: PowerState::Off,
            calibrating: None,
            calibrated: false,
            e_stop: false,
            motion: None,
            events: Vec::new(),
            over_s: 0.0,
            record: Arc::new(Mutex::new(EmulatorRecord::new(joints))),
        })
    }

    pub(crate) fn body(&self) -> &SimBody {
        &self.body
    }

    /// The joints of the arm, in degrees.
    pub(crate) fn joints(&self) -> Joints {
        self.joints
    }

    pub(crate) fn is_moving(&self) -> bool {
        self.motion.is_some()
    }

    pub(crate) fn has_power(&self) -> bool {
        self.power == PowerState::On
    }

    pub(crate) fn is_stopped(&self) -> bool {
        self.e_stop
    }

    /// Whether a motion, a calibration or power coming up is under way.
    pub(crate) fn is_busy(&self) -> bool {
        self.motion.is_some() || self.calibrating.is_some() || matches!(self.power, PowerState::Coming(_))
    }

    /// Whether power comes up or the arm is being calibrated.
    pub(crate) fn is_preparing(&self) -> bool {
        self.calibrating.is_some() || matches!(self.power, PowerState::Coming(_))
    }

    /// `STATE(1)` of V+, as far as it is emulated.
    pub(crate) fn overall_state(&self) -> u8 {
        match self.power {
            PowerState::Off => 2,
            PowerState::Coming(_) => 3,
            PowerState::On if self.calibrating.is_some() => 5,
            PowerState::On if self.calibrated => 7,
            PowerState::On => 8,
        }
    }

    /// Wires the touch pads so that their inputs are on when nothing is touched.
    pub(crate) fn invert(&mut self, inverted: bool) {
        self.inverted = inverted;
    }

    /// The touch pads' inputs as bits, the first signal lowest.
    pub(crate) fn signals(&self) -> u8 {
        let bit = |side: &Side| Side::ALL.iter().position(|other| other == side).map_or(0, |at| 1 << at);
        let touched = self.body.contact().sides.iter().map(bit).fold(0, |all, bit| all | bit);
        if self.inverted { !touched & 0b1111 } else { touched }
    }

    /// A digital input. Those of the touch pads are emulated, all others are off.
    pub(crate) fn signal(&self, number: u16) -> bool {
        number.checked_sub(FIRST_SIGNAL).is_some_and(|at| at < 4 && self.signals() & (1 << at) != 0)
    }

    /// Begins to bring power up.
    pub(crate) fn enable_power(&mut self) -> Result<(), VPlusMessage> {
        if self.e_stop {
            return Err(messages::E_STOP);
        }
        if self.power == PowerState::Off {
            self.power = PowerState::Coming(POWER_UP_S);
            self.record().power_ups += 1;
        }
        Ok(())
    }

    /// Takes power away. The brakes stop a motion.
    pub(crate) fn disable_power(&mut self) {
        self.cut_power();
        self.calibrating = None;
        self.stop_for(MotionEnd::Stopped);
    }

    fn cut_power(&mut self) {
        self.power = PowerState::Off;
        self.record().powered = false;
    }

    /// Begins to calibrate.
    pub(crate) fn calibrate(&mut self) -> Result<(), VPlusMessage> {
        if self.power != PowerState::On {
            return Err(messages::POWER_OFF);
        }
        self.calibrated = false;
        self.calibrating = Some(CALIBRATION_S);
        self.record().calibrations_begun += 1;
        Ok(())
    }

    /// Presses the emergency stop, or pulls it out again. Power stays off until it is enabled anew; calibration is
    /// kept.
    pub(crate) fn press(&mut self, pressed: bool) {
        if pressed && !self.e_stop {
            self.record().e_stops += 1;
            if self.is_preparing() {
                self.events.push(MachineEvent::Interrupted(messages::E_STOP));
            }
            self.cut_power();
            self.calibrating = None;
            self.stop_for(MotionEnd::Error(messages::E_STOP));
        }
        self.e_stop = pressed;
    }

    /// Switches the controller off and on again. It forgets everything; the brakes hold the arm where it is.
    pub(crate) fn cycle(&mut self) {
        self.disable_power();
        self.finish_motion();
        self.calibrated = false;
        self.events.clear();
    }

    /// Begins a motion.
    pub(crate) fn start(&mut self, legs: &[Leg], guard: TouchGuard) -> Result<(), VPlusMessage> {
        if self.e_stop {
            return Err(messages::E_STOP);
        }
        if self.power != PowerState::On {
            return Err(messages::POWER_OFF);
        }
        if !self.calibrated || self.calibrating.is_some() {
            return Err(messages::NOT_CALIBRATED);
        }
        if legs.iter().any(|leg| !within_softstops(&leg.to)) {
            return Err(messages::OUT_OF_RANGE);
        }
        self.record().motion(legs);
        let path = JointPath::new(self.joints, legs, self.speeds_deg_per_s);
        self.motion = Some(Motion { path, guard, signals: self.signals(), why: None });
        Ok(())
    }

    /// Brakes a motion. A calibration that is cut short does not count.
    pub(crate) fn stop(&mut self) {
        self.calibrating = None;
        self.stop_for(MotionEnd::Stopped);
    }

    fn stop_for(&mut self, why: MotionEnd) {
        if self.motion.is_some() {
            self.record().stops += 1;
        }
        if let Some(motion) = &mut self.motion {
            // An error weighs more than the reason that stopped the motion before.
            if motion.why.is_none() || matches!(why, MotionEnd::Error(_)) {
                motion.why = Some(why);
            }
            motion.path.brake();
        }
    }

    /// Lets time pass.
    pub(crate) fn advance(&mut self, time_s: f64) {
        if let PowerState::Coming(left_s) = self.power {
            self.power = PowerState::Coming(left_s - time_s);
            if left_s <= time_s {
                self.power = PowerState::On;
                self.record().powered = true;
                self.events.push(MachineEvent::PowerUp);
            }
        }
        if let Some(left_s) = self.calibrating {
            self.calibrating = Some(left_s - time_s).filter(|left_s| *left_s > 0.0);
            if self.calibrating.is_none() {
                self.calibrated = true;
                self.record().calibrations += 1;
                self.events.push(MachineEvent::Calibrated);
            }
        }
        self.over_s += time_s;
        while self.over_s >= STEP_S {
            self.over_s -= STEP_S;
            if self.motion.is_none() {
                // A world at rest stays at rest.
                self.over_s = 0.0;
                return;
            }
            self.step();
        }
    }

    /// The events since the last call.
    pub(crate) fn events(&mut self) -> Vec<MachineEvent> {
        std::mem::take(&mut self.events)
    }

    /// One step of a motion.
    fn step(&mut self) {
        let Some(motion) = &mut self.motion else { return };
        if !motion.path.is_over() {
            self.joints = motion.path.advance(STEP_S);
            let posture = self.body.workspace().arm.posture_of(self.joints.map(f64::to_radians));
            self.body.drive(&posture);
            self.record().passed(self.joints, posture.tip_m.z);
            self.feel();
        }
        if self.motion.as_ref().is_some_and(|motion| motion.path.is_over()) {
            self.finish_motion();
        }
    }

    /// The reflex of a guarded motion, and the error of a motion that an obstacle holds up.
    fn feel(&mut self) {
        let felt = self.body.contact();
        let signals = self.signals();
        let file = &self.body.workspace().file;
        let scrapes = self.body.posture().tip_m.z < file.finger.ball_radius_mm.metres() + SCRAPE_M;
        if felt.overlap_m > ENVELOPE_M || scrapes {
            let braking =
                self.motion.as_ref().is_some_and(|motion| matches!(motion.why, Some(MotionEnd::Error(_))));
            if !braking {
                self.cut_power();
                self.record().envelope_errors += 1;
                self.stop_for(MotionEnd::Error(messages::ENVELOPE));
            }
            return;
        }
        let Some(motion) = &mut self.motion else { return };
        // As REACTI does: a signal that comes on counts, not one that is on.
        let touched = match motion.guard {
            TouchGuard::None => false,
            TouchGuard::On => signals & !motion.signals != 0,
            TouchGuard::Off => motion.signals & !signals != 0,
        };
        motion.signals = signals;
        if touched && motion.why.is_none() {
            motion.why = Some(MotionEnd::Touched);
            motion.path.brake();
        }
    }

    /// Ends the motion, and waits until the blocks that it set going rest.
    fn finish_motion(&mut self) {
        let Some(motion) = self.motion.take() else { return };
        let posture = *self.body.posture();
        let mut waited = 0;
        while waited < SETTLE_STEPS_MAX && !self.body.world().is_still() {
            self.body.drive(&posture);
            waited += 1;
        }
        let arrived = motion.path.has_arrived();
        let end =
            motion.why.filter(|why| !arrived || *why != MotionEnd::Stopped).unwrap_or(MotionEnd::Arrived);
        self.events.push(MachineEvent::Ended(end));
    }

    /// Takes a picture.
    pub(crate) fn picture(&mut self) -> &RgbImage {
        self.body.look().0
    }

    /// Puts an object down, as a person does who sees that the arm is out of the way.
    pub(crate) fn put(&mut self, object: &str, position: usize) -> Result<(), String> {
        if self.is_moving() {
            return Err("the arm is moving".to_owned());
        }
        let index = self.object(object)?;
        let places = self.body.workspace().places.len();
        if position >= places {
            return Err(format!(
                "there is no position {position}: they are 0 to {}",
                places.saturating_sub(1)
            ));
        }
        match self.body.put(index, position) {
            Outcome::Done => Ok(()),
            _ => Err("something else is in the way".to_owned()),
        }
    }

    /// Takes an object away.
    pub(crate) fn take_away(&mut self, object: &str) -> Result<(), String> {
        let index = self.object(object)?;
        match self.body.take_away(index) {
            Outcome::Done => Ok(()),
            _ => Err(format!("there is no {object}")),
        }
    }

    fn object(&self, name: &str) -> Result<usize, String> {
        let objects = &self.body.workspace().file.objects;
        objects.iter().position(|object| object.name == name).ok_or_else(|| {
            let known: BTreeSet<_> = objects.iter().map(|object| object.name.as_str()).collect();
            format!("there is no {name}, only {}", known.into_iter().collect::<Vec<_>>().join(", "))
        })
    }

    /// The record of the motions and of everything else that happened.
    pub(crate) fn record(&self) -> MutexGuard<'_, EmulatorRecord> {
        self.record.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The same record, for another thread.
    pub(crate) fn watched(&self) -> Arc<Mutex<EmulatorRecord>> {
        Arc::clone(&self.record)
    }
}

/// Whether every joint is within its softstops. NaN is not.
pub(crate) fn within_softstops(joints: &Joints) -> bool {
    joints.iter().zip(SOFTSTOPS_DEG).all(|(value, (first, last))| (first..=last).contains(value))
}
