//! The arm: connected or not, enabled by a person or not, one motion at a time, each checked before and after.
//!
//! Its life is that of hardware in other robot software: unconnected, inactive, active. Any error leads back, never
//! straight on. A sign that something or somebody stopped the arm for a reason is latched until a person resets it.

mod ready;

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use pschema_arm::JointPositions;
use pschema_arm::route::{Heading, OUTWARDS, Waypoint};
use pschema_protocol::body::Outcome;

use crate::config::ArmSetup;
use crate::controller::{Controller, ControllerError, ControllerState, Result};
use crate::gate::{Leg, PermittedPath};
use crate::line::recorder::LineRecorder;
use crate::motion::{MotionOutcome, follow};
use crate::path;
use crate::switch::{StopCause, StopSwitch};
use crate::taught::Joints;
use crate::watch::Watch;

/// First and longest pause between two tries to connect; each is twice the one before.
const BACKOFF_FIRST: Duration = Duration::from_millis(20);
const BACKOFF_LAST: Duration = Duration::from_secs(1);
/// Longest way that the finger goes on after a touch that is no longer felt, in metres.
const PRESS_M_MAX: f64 = 0.006;

/// Connects to the controller.
pub type Connect = Box<dyn FnMut(&StopSwitch) -> Result<Box<dyn Controller>> + Send>;

/// The permissions that the process was started with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Permissions {
    /// Motions are carried out. Without this permission they are only checked.
    pub moves: bool,
    /// An arm that is not calibrated is calibrated when it is enabled.
    pub home: bool,
}

/// A phase in the life of the arm.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Nobody answers on the line.
    Unconnected,
    /// The controller answers; no person has enabled the arm.
    Inactive,
    /// The arm moves when asked to.
    Active,
    /// Something stopped the arm, and a person must look.
    Latched(String),
}

/// The arm.
pub struct Arm {
    setup: Arc<ArmSetup>,
    connector: Connect,
    controller: Option<Box<dyn Controller>>,
    switch: StopSwitch,
    watch: Watch,
    recorder: LineRecorder,
    phase: Phase,
    /// A person has enabled the arm since this process began.
    enabled: bool,
    /// This process answers for high power and takes it away in the end: it turned power on, or had the arm move by
    /// itself.
    powered_by_us: bool,
    /// The arm is being calibrated, as far as is known.
    homing: bool,
    may: Permissions,
    replaying: bool,
    heading: Heading,
    /// How often the arm left the place where it stood.
    displacements: u64,
    next_try: Instant,
    backoff: Duration,
}

impl Arm {
    /// An arm, not connected yet.
    #[must_use]
    pub fn new(
        setup: Arc<ArmSetup>,
        connector: Connect,
        switch: StopSwitch,
        watch: Watch,
        recorder: LineRecorder,
        may: Permissions,
    ) -> Self {
        Self {
            setup,
            connector,
            controller: None,
            switch,
            watch,
            recorder,
            phase: Phase::Unconnected,
            enabled: false,
            powered_by_us: false,
            homing: false,
            may,
            replaying: false,
            heading: OUTWARDS,
            displacements: 0,
            next_try: Instant::now(),
            backoff: BACKOFF_FIRST,
        }
    }

    /// The arm file with all that follows from it.
    #[must_use]
    pub fn setup(&self) -> &Arc<ArmSetup> {
        &self.setup
    }

    /// How often the arm left the place where it stood.
    pub(crate) fn displacements(&self) -> u64 {
        self.displacements
    }

    /// Notes that the daemon has just given an order, which is a sign of life like its pulse.
    pub fn ordered(&self) {
        if let Some(daemon) = &self.watch.signs().daemon {
            daemon.renew();
        }
    }

    /// The phase of the arm's life.
    #[must_use]
    pub fn phase(&self) -> &Phase {
        &self.phase
    }

    /// Connects, unless the arm is connected or it is not time for another try. A motion is never resumed.
    ///
    /// # Errors
    /// When nobody answers, or it is not time yet.
    pub fn ensure_connected(&mut self) -> Result<()> {
        if self.controller.is_some() {
            return Ok(());
        }
        if self.replaying {
            return Err(ControllerError::Other("a replay connects when it did then".to_owned()));
        }
        if let Some(left) = self.next_try.checked_duration_since(Instant::now()) {
            return Err(ControllerError::Other(format!(
                "the line is tried again in {} ms",
                left.as_millis()
            )));
        }
        self.connect()
    }

    /// From now on connects by [`Self::connect`] alone, as a replay needs it.
    pub(crate) fn replaying(&mut self) {
        self.replaying = true;
    }

    /// Whether an arm that is not calibrated is calibrated when it is enabled.
    pub(crate) fn may_home(&mut self, home: bool) {
        self.may.home = home;
    }

    /// Connects at once.
    ///
    /// # Errors
    /// When nobody answers, or a controller that is not the one of the arm file.
    pub fn connect(&mut self) -> Result<()> {
        let connected = self.recorded("connect", Self::connect_now, |connected| {
            if connected.is_ok() { "connected" } else { "not connected" }
        });
        match &connected {
            Ok(()) => self.backoff = BACKOFF_FIRST,
            Err(fault) => {
                if self.backoff == BACKOFF_FIRST {
                    tracing::warn!(%fault, "not connected");
                }
                self.disconnect();
                self.next_try = Instant::now() + self.backoff;
                self.backoff = (self.backoff * 2).min(BACKOFF_LAST);
            }
        }
        connected
    }

    fn connect_now(&mut self) -> Result<()> {
        let mut controller = (self.connector)(&self.switch)?;
        let name = controller.greet()?;
        let state = controller.state()?;
        let joints = controller.joints()?;
        tracing::info!(controller = name, ?state, ?joints, "connected");
        self.controller = Some(controller);
        if matches!(self.phase, Phase::Latched(_)) {
            return Ok(());
        }
        self.phase = Phase::Inactive;
        if self.enabled {
            // It was enabled before the line was lost. It goes on only if nothing else has changed meanwhile.
            match self.unfit(&state, &joints) {
                None => self.phase = Phase::Active,
                Some(why) => self.latch(why),
            }
        }
        Ok(())
    }

    /// The reason why the arm may not be active. None when there is none.
    fn unfit(&self, state: &ControllerState, joints: &[f64]) -> Option<String> {
        if state.emergency_stop {
            return Some("an emergency stop is pressed".to_owned());
        }
        if state.latched {
            return Some("the controller has latched a fault".to_owned());
        }
        if !state.power {
            return Some("high power is off".to_owned());
        }
        if !state.calibrated {
            return Some(
                "the arm is not calibrated, or not under the controller's control: see that the key is at AUTO, and \
                 CALIBRATE at the controller; it moves while it does"
                    .to_owned(),
            );
        }
        if state.moving {
            return Some("the arm moves although nothing was ordered".to_owned());
        }
        self.misplaced(joints)
    }

    /// The reason why the arm may not move from where it is. None when there is none.
    fn misplaced(&self, joints: &[f64]) -> Option<String> {
        let gate = &self.setup.gate;
        if let Err(refused) = gate.check_joints(joints) {
            return Some(format!("the arm is beyond its limits ({refused}): bring it back with the pendant"));
        }
        match gate.taught().locate(joints, gate.tolerances()) {
            Some(located) if located.off <= 1.0 => None,
            located => Some(format!(
                "the arm stands {:.1} times the tolerance off what was taught: bring it to its rest posture with the pendant",
                located.map_or(f64::INFINITY, |located| located.off)
            )),
        }
    }

    fn disconnect(&mut self) {
        self.controller = None;
        self.switch.disconnect();
        if !matches!(self.phase, Phase::Latched(_)) {
            self.phase = Phase::Unconnected;
        }
    }

    fn latch(&mut self, why: String) {
        if !matches!(self.phase, Phase::Latched(_)) {
            tracing::error!(why, "the arm is stopped until a person resets it");
            self.phase = Phase::Latched(why);
        }
    }

    /// Enables the arm, as a person has just asked: clears what was latched, turns high power on, and makes sure that
    /// the arm is fit to move.
    ///
    /// # Errors
    /// When the arm is not enabled. A person can remove the cause and ask again.
    pub fn enable(&mut self) -> Result<()> {
        self.ensure_connected()?;
        let order = if self.may.home { "enable home" } else { "enable" };
        let enabled =
            self.recorded(
                order,
                Self::enable_now,
                |enabled| {
                    if enabled.is_ok() { "enabled" } else { "not enabled" }
                },
            );
        if let Err(fault) = &enabled
            && fault.is_of_line()
        {
            self.disconnect();
        }
        enabled
    }

    /// Refuses motions until a person enables the arm again. Nothing is sent to the controller.
    pub fn stand_down(&mut self) {
        self.enabled = false;
        if self.phase == Phase::Active {
            self.phase = Phase::Inactive;
        }
    }

    /// Reads the touch inputs, and notices whether the arm was stopped meanwhile.
    ///
    /// # Errors
    /// When the controller does not tell. The line is opened anew by [`Self::ensure_connected`].
    pub fn signals(&mut self) -> Result<u8> {
        self.ensure_connected()?;
        let ask = |arm: &mut Self| answering(&mut arm.controller)?.state();
        let word = |state: &Result<ControllerState>| {
            state.as_ref().map_or("unknown".to_owned(), |state| format!("{:04b}", state.signals))
        };
        match self.recorded("signals", ask, word) {
            Ok(state) => {
                if self.phase == Phase::Active && self.may.moves {
                    self.notice(&state);
                }
                Ok(state.signals)
            }
            Err(fault) => {
                self.give_up(&fault);
                Err(fault)
            }
        }
    }

    /// Latches the arm when its state needs a person.
    fn notice(&mut self, state: &ControllerState) {
        if state.emergency_stop {
            self.latch("an emergency stop was pressed".to_owned());
        } else if !state.power {
            self.latch("high power was turned off".to_owned());
        } else if state.latched {
            self.latch("the controller has latched a fault".to_owned());
        }
    }

    fn give_up(&mut self, fault: &ControllerError) {
        if fault.needs_a_person() {
            self.latch(fault.to_string());
        }
        if fault.is_of_line() {
            self.disconnect();
        }
    }

    /// The outcome of an order that is not begun, for the arm may not move as it is.
    pub fn refuse(&self) -> Outcome {
        match &self.phase {
            Phase::Latched(why) => Outcome::refused(why),
            _ => Outcome::refused("the arm is not enabled"),
        }
    }

    /// The outcome of a motion that was stopped.
    fn stopped(&self) -> Outcome {
        match &self.phase {
            Phase::Latched(why) => Outcome::failed(why),
            _ => Outcome::failed("the motion was stopped before its end"),
        }
    }

    /// Goes to joint positions of the manifold, until the finger is there or touches something.
    pub fn go(&mut self, to: JointPositions) -> Outcome {
        let connected = self.ensure_connected();
        let go = |arm: &mut Self| {
            if to.are_commandable() {
                return arm.go_recorded(to, connected);
            }
            tracing::warn!(j1 = to.j1, j2 = to.j2, "refused: joint positions are 0 to 1");
            Outcome::refused("joint positions are 0 to 1")
        };
        self.recorded(&format!("go {} {}", to.j1, to.j2), go, word)
    }

    /// Obeys an order, which is recorded with its outcome in the words that `word` finds for it.
    fn recorded<T, W: AsRef<str>>(
        &mut self,
        order: &str,
        obey: impl FnOnce(&mut Self) -> T,
        word: impl FnOnce(&T) -> W,
    ) -> T {
        self.recorder.event("order", order);
        let outcome = obey(self);
        self.recorder.event("outcome", word(&outcome).as_ref());
        outcome
    }

    /// Goes to the rest posture, out of the camera's sight.
    pub fn park(&mut self) -> Outcome {
        let connected = self.ensure_connected();
        self.recorded("park", |arm| arm.go_recorded(arm.setup.rest, connected), word)
    }

    fn go_recorded(&mut self, to: JointPositions, connected: Result<()>) -> Outcome {
        if let Err(fault) = connected {
            tracing::debug!(%fault, "refused");
            return Outcome::refused(fault);
        }
        if self.phase != Phase::Active {
            tracing::debug!(phase = ?self.phase, "refused: the arm is not enabled");
            return self.refuse();
        }
        match self.go_now(to) {
            Ok(outcome) => outcome,
            Err(fault) => {
                tracing::warn!(%fault, "the motion failed");
                self.give_up(&fault);
                Outcome::failed(fault)
            }
        }
    }

    fn go_now(&mut self, to: JointPositions) -> Result<Outcome> {
        if self.watch.signs().stop.load(Ordering::SeqCst) {
            return Ok(Outcome::refused("the arm's process is ending"));
        }
        if let Some(silent) = self.watch.signs().daemon.as_ref().map(|daemon| daemon.age())
            && silent > self.watch.signs().silence_max
        {
            tracing::warn!(silent_ms = silent.as_millis(), "refused: the daemon is silent");
            return Ok(Outcome::refused("the daemon is silent"));
        }
        let Some(controller) = &mut self.controller else { return Ok(self.refuse()) };
        let (state, from) = (controller.state()?, controller.joints()?);
        let unfit = if !self.may.moves { self.misplaced(&from) } else { self.unfit(&state, &from) };
        if let Some(why) = unfit {
            self.latch(why);
            return Ok(self.refuse());
        }
        let Some((path, heading)) = path::path(&self.setup, self.heading, &from, to) else {
            return Ok(Outcome::refused("no permitted path leads there"));
        };
        if !self.may.moves {
            tracing::info!(legs = path.legs().len(), end = ?path.end(), "dry run: not moved");
            return Ok(Outcome::refused("this is a dry run"));
        }
        if !self.setup.gate.is_at(path.end(), &from) {
            self.displacements += 1;
        }
        let moved = self.carry_out(&path)?;
        self.heading = heading;
        match moved {
            MotionOutcome::Arrived => Ok(Outcome::Done),
            MotionOutcome::Touched => self.press(to),
            MotionOutcome::Stopped => Ok(self.stopped()),
            MotionOutcome::OutOfTime => Ok(Outcome::TimedOut),
        }
    }

    /// Carries out a motion until it ends or is stopped, and makes sure of the place where it ended.
    fn carry_out(&mut self, path: &PermittedPath) -> Result<MotionOutcome> {
        let Some(controller) = &mut self.controller else { return Ok(MotionOutcome::Stopped) };
        self.switch.release();
        let watched = self.watch.motion();
        if self.watch.signs().stop.load(Ordering::SeqCst) {
            return Ok(MotionOutcome::Stopped);
        }
        let ended = match follow(controller.as_mut(), path, &self.setup, &self.watch, &self.switch) {
            // The stop ended a wait.
            Err(ControllerError::Stopped(_)) => controller.halt().map(|()| MotionOutcome::Stopped),
            ended => ended,
        };
        drop(watched);
        match ended {
            Ok(MotionOutcome::Arrived) => {
                let joints = controller.joints()?;
                if !self.setup.gate.is_at(path.end(), &joints) {
                    self.latch(format!(
                        "the arm says that it arrived at {:?}, but it is at {joints:?}: find out what holds it",
                        path.end()
                    ));
                    return Ok(MotionOutcome::Stopped);
                }
                Ok(MotionOutcome::Arrived)
            }
            Ok(MotionOutcome::Stopped) if self.switch.pressed_by() == Some(StopCause::OutOfPlace) => {
                self.latch("the arm was measured beyond its limits while it moved".to_owned());
                Ok(MotionOutcome::Stopped)
            }
            Ok(moved) => Ok(moved),
            Err(fault) => {
                // Whatever the error, the arm is to stand still. If the line is gone, the controller's watchdog stops
                // it.
                self.switch.press(StopCause::Trouble);
                if let Err(halting) = controller.halt() {
                    tracing::error!(%halting, "not known to stand still");
                    if !halting.is_of_line() {
                        self.latch(halting.to_string());
                    }
                }
                Err(fault)
            }
        }
    }

    /// After a touch that is no longer felt, goes on a little, to come to rest against the object.
    fn press(&mut self, to: JointPositions) -> Result<Outcome> {
        if self.switch.is_pressed() {
            // The arm was stopped just as it touched: nothing follows.
            return Ok(self.stopped());
        }
        let untouched = if self.setup.file.touch.inverted { 0b1111 } else { 0 };
        let Some(controller) = &mut self.controller else { return Ok(Outcome::Done) };
        if controller.state()?.signals & 0b1111 != untouched {
            return Ok(Outcome::Done);
        }
        let from = controller.joints()?;
        let gate = &self.setup.gate;
        let Some(start) = gate.taught().locate(&from, gate.tolerances()).map(|located| located.at) else {
            return Ok(Outcome::Done);
        };
        let goal = Waypoint { joints: to, lift_m: start.lift_m };
        let way_m = path::way_m(&self.setup, &(start, goal));
        let end = path::between(start, goal, (PRESS_M_MAX / way_m.max(1e-6)).min(1.0));
        let Some(joints) = gate.taught().at(end) else { return Ok(Outcome::Done) };
        let Ok(path) = gate.permit(&from, vec![Leg { to: joints, speed_percent: 1 }], true) else {
            return Ok(Outcome::Done);
        };
        match self.carry_out(&path)? {
            MotionOutcome::Stopped => Ok(self.stopped()),
            _ => Ok(Outcome::Done),
        }
    }

    /// The joints of the arm.
    ///
    /// # Errors
    /// When the controller does not tell.
    pub fn joints(&mut self) -> Result<Joints> {
        self.ensure_connected()?;
        answering(&mut self.controller)?.joints()
    }

    /// Ends the use of the arm: it stands still, and high power is off again if this process turned it on.
    pub fn finish(&mut self) {
        let Some(controller) = &mut self.controller else { return };
        let standing = controller.halt();
        if let Err(fault) = &standing {
            tracing::error!(%fault, "not known to stand still");
        }
        self.take_power();
        self.powered_by_us = false;
        self.enabled = false;
        self.disconnect();
    }
}

/// The controller, which must be connected.
fn answering(controller: &mut Option<Box<dyn Controller>>) -> Result<&mut Box<dyn Controller>> {
    controller.as_mut().ok_or_else(|| ControllerError::Other("nobody answers on the line".to_owned()))
}

/// How an order went, as a recording has it: in one word, without a reason that may name figures of its moment.
pub(crate) fn word(outcome: &Outcome) -> &'static str {
    match outcome {
        Outcome::Done => "Done",
        Outcome::Refused(_) => "Refused",
        Outcome::Failed(_) => "Failed",
        Outcome::TimedOut => "TimedOut",
        Outcome::EpisodeEnded => "EpisodeEnded",
        Outcome::EpisodeCut => "EpisodeCut",
    }
}
