//! One motion, from its beginning to its end or until it is stopped.

use std::time::{Duration, Instant};

use crate::config::Setup;
use crate::controller::{Controller, Ended, Fault};
use crate::gate::Permitted;
use crate::switch::{Pressed, StopSwitch};
use crate::v_plus::message::Message;
use crate::watch::Watch;

/// Each so many questions how the motion goes, the arm is measured. Counted, not timed, so that a replay does the same.
const MEASURE_EVERY: u32 = 8;

/// How a motion ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Moved {
    Arrived,
    Touched,
    Stopped,
    OutOfTime,
}

/// Begins a motion and follows it to its end.
pub(crate) fn follow(
    controller: &mut dyn Controller,
    path: &Permitted,
    setup: &Setup,
    watch: &Watch,
    switch: &StopSwitch,
) -> Result<Moved, Fault> {
    match follow_on(controller, path, setup, watch, switch) {
        // A wait that the stop has ended.
        Err(Fault::Stopped(_)) => {
            controller.halt()?;
            Ok(Moved::Stopped)
        }
        followed => followed,
    }
}

fn follow_on(
    controller: &mut dyn Controller,
    path: &Permitted,
    setup: &Setup,
    watch: &Watch,
    switch: &StopSwitch,
) -> Result<Moved, Fault> {
    let begun = Instant::now();
    let time_max = Duration::from_secs_f64(setup.file.motion.time_max_s.get());
    controller.begin(path)?;
    let mut asked = 0;
    loop {
        watch.signs().driver.renew();
        if switch.is_pressed() {
            controller.halt()?;
            return Ok(Moved::Stopped);
        }
        if let Some(ended) = controller.follow()? {
            return moved(ended, switch);
        }
        if begun.elapsed() > time_max {
            switch.press(Pressed::OutOfTime);
            controller.halt()?;
            return Ok(Moved::OutOfTime);
        }
        asked += 1;
        if asked % MEASURE_EVERY == 0 && is_out_of_place(controller, setup)? {
            switch.press(Pressed::OutOfPlace);
        }
    }
}

fn moved(ended: Ended, switch: &StopSwitch) -> Result<Moved, Fault> {
    match ended {
        Ended::Arrived => Ok(Moved::Arrived),
        Ended::Touched => Ok(Moved::Touched),
        Ended::Stopped if switch.is_pressed() => Ok(Moved::Stopped),
        // Somebody had a reason.
        Ended::Stopped => Err(Fault::StoppedElsewhere),
        Ended::Watchdog => {
            let text = "the program on the controller stopped the arm: no line came for too long, or it met an error itself";
            Err(Fault::Refused(Message { code: Some(11), text: text.to_owned() }))
        }
        Ended::Fault(code) => {
            let text = "the motion was ended by an error".to_owned();
            Err(Fault::Refused(Message { code: Some(code), text }))
        }
    }
}

/// Whether the arm passes where it may not be: seen twice, for one slip of a line without sums is no place.
fn is_out_of_place(controller: &mut dyn Controller, setup: &Setup) -> Result<bool, Fault> {
    for _ in 0..2 {
        if setup.gate.check_joints(&controller.passing()?).is_ok() {
            return Ok(false);
        }
    }
    Ok(true)
}
