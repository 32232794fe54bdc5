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
        match controller.follow()? {
            None => {}
            Some(Ended::Arrived) => return Ok(Moved::Arrived),
            Some(Ended::Touched) => return Ok(Moved::Touched),
            Some(Ended::Stopped) => return Ok(Moved::Stopped),
            Some(Ended::Watchdog) => {
                let text = "the controller's watchdog stopped the arm: this process was silent".to_owned();
                return Err(Fault::Refused(Message { code: Some(11), text }));
            }
            Some(Ended::Fault(code)) => {
                let text = "the motion was ended by an error".to_owned();
                return Err(Fault::Refused(Message { code: Some(code), text }));
            }
        }
        if begun.elapsed() > time_max {
            switch.press(Pressed::OutOfTime);
            controller.halt()?;
            return Ok(Moved::OutOfTime);
        }
        asked += 1;
        if asked % MEASURE_EVERY == 0 && setup.gate.check_joints(&controller.joints()?).is_err() {
            switch.press(Pressed::OutOfPlace);
        }
    }
}
