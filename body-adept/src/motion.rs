//! One motion, from its beginning to its end or until it is stopped.

use std::time::{Duration, Instant};

use crate::config::ArmSetup;
use crate::controller::{Controller, ControllerError, MotionEnd, Result};
use crate::gate::PermittedPath;
use crate::switch::{StopCause, StopSwitch};
use crate::v_plus::message::VPlusMessage;
use crate::watch::Watch;

/// The arm is measured once in so many questions about the motion. They are counted, not timed, so that a replay
/// measures at the same points.
const MEASURE_EVERY: u32 = 8;

/// The outcome of a motion for the driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MotionOutcome {
    Arrived,
    Touched,
    Stopped,
    OutOfTime,
}

/// Begins a motion and follows it to its end.
///
/// # Errors
/// [`ControllerError::Stopped`] when the switch ended a wait, before the arm was halted.
pub(crate) fn follow(
    controller: &mut dyn Controller,
    path: &PermittedPath,
    setup: &ArmSetup,
    watch: &Watch,
    switch: &StopSwitch,
) -> Result<MotionOutcome> {
    let begun = Instant::now();
    let time_max = Duration::from_secs_f64(setup.file.motion.time_max_s.get());
    controller.begin(path)?;
    let mut asked = 0;
    loop {
        watch.signs().driver.renew();
        if switch.is_pressed() {
            controller.halt()?;
            return Ok(MotionOutcome::Stopped);
        }
        if let Some(ended) = controller.follow()? {
            return moved(ended, switch);
        }
        if begun.elapsed() > time_max {
            switch.press(StopCause::OutOfTime);
            controller.halt()?;
            return Ok(MotionOutcome::OutOfTime);
        }
        asked += 1;
        if asked % MEASURE_EVERY == 0 && is_out_of_place(controller, setup)? {
            switch.press(StopCause::OutOfPlace);
        }
    }
}

fn moved(ended: MotionEnd, switch: &StopSwitch) -> Result<MotionOutcome> {
    match ended {
        MotionEnd::Arrived => Ok(MotionOutcome::Arrived),
        MotionEnd::Touched => Ok(MotionOutcome::Touched),
        MotionEnd::Stopped if switch.is_pressed() => Ok(MotionOutcome::Stopped),
        // Somebody else stopped it, for a reason.
        MotionEnd::Stopped => Err(ControllerError::StoppedElsewhere),
        MotionEnd::Watchdog => {
            let text = "the program on the controller stopped the arm: no line came for too long, or it met an error itself";
            Err(ControllerError::Refused(VPlusMessage { code: Some(11), text: text.to_owned() }))
        }
        MotionEnd::Fault(code) => {
            let text = "the motion was ended by an error".to_owned();
            Err(ControllerError::Refused(VPlusMessage { code: Some(code), text }))
        }
    }
}

/// Whether the arm is beyond its limits. It is measured twice, because one slip of a line without sums is no position.
fn is_out_of_place(controller: &mut dyn Controller, setup: &ArmSetup) -> Result<bool> {
    for _ in 0..2 {
        if setup.gate.check_joints(&controller.passing()?).is_ok() {
            return Ok(false);
        }
    }
    Ok(true)
}
