//! The line as a controller uses it: every wait looks at the switch, and every order that may move the arm passes it.

use std::mem;
use std::time::Duration;

use super::error::{ControllerError, Result};
use crate::line::Line;
use crate::switch::{StopCause, StopSwitch};
use crate::watch::Beat;

/// Bytes received at a time.
const CHUNK_BYTES: usize = 512;

/// The activity of a controller for the driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Activity {
    /// It asks while the arm stands. An earlier stop does not matter.
    Asking,
    /// It has the arm move, or is about to. A stop ends every wait.
    Ordering,
    /// It makes sure that the arm stands, and repeats the order to stop itself.
    Halting,
}

/// A line with the switch that stops the arm, and the sign of life of the driver.
pub struct GuardedLine {
    line: Box<dyn Line>,
    switch: StopSwitch,
    driver: Beat,
    activity: Activity,
}

impl GuardedLine {
    /// Guards a line. `driver` is renewed with each answer.
    #[must_use]
    pub fn new(line: Box<dyn Line>, switch: StopSwitch, driver: Beat) -> Self {
        Self { line, switch, driver, activity: Activity::Asking }
    }

    /// Receives the bytes that have come, or come within `wait`, and adds them to `into`. Returns how many came.
    ///
    /// # Errors
    /// When the line is gone, or the wait is over because the arm was stopped.
    pub(super) fn receive(&mut self, into: &mut Vec<u8>, wait: Duration) -> Result<usize> {
        match self.activity {
            Activity::Ordering if self.switch.is_pressed() => return Err(self.stopped()),
            Activity::Halting => self.driver.renew(),
            Activity::Asking | Activity::Ordering => {}
        }
        let mut buffer = [0; CHUNK_BYTES];
        let count = self.line.receive(&mut buffer, wait)?;
        into.extend_from_slice(buffer.get(..count).unwrap_or_default());
        Ok(count)
    }

    /// Sends bytes. Those that move the arm, or may, are not sent while the switch is pressed.
    ///
    /// # Errors
    /// When the line is gone or stuck, or the switch was pressed.
    pub(super) fn send(&mut self, bytes: &[u8], may_move: bool) -> Result<()> {
        if !may_move {
            return Ok(self.line.send(bytes)?);
        }
        let line = &mut self.line;
        let sent = self.switch.order(|| line.send(bytes));
        sent.map_err(|error| error.map_or_else(|| self.stopped(), ControllerError::Line))
    }

    /// Sends the bytes that stop the arm, by the way of the switch.
    pub(super) fn send_stop(&self) {
        self.switch.send();
    }

    /// Throws away the bytes that came and were not received.
    ///
    /// # Errors
    /// When the line is gone.
    pub(super) fn discard(&mut self) -> Result<()> {
        Ok(self.line.discard()?)
    }

    /// The controller has answered: on a slow line a path takes longer to send than the driver may be silent.
    pub(super) fn answered(&self) {
        self.driver.renew();
    }

    fn stopped(&self) -> ControllerError {
        ControllerError::Stopped(self.switch.pressed_by().unwrap_or(StopCause::Trouble))
    }
}

/// A controller with a line.
pub(super) trait OnLine: Sized {
    /// Its line.
    fn line(&mut self) -> &mut GuardedLine;

    /// Acts in an activity, which decides how waits on the line end.
    ///
    /// # Errors
    /// Those of `act`.
    fn during<T>(&mut self, activity: Activity, act: impl FnOnce(&mut Self) -> Result<T>) -> Result<T> {
        let before = mem::replace(&mut self.line().activity, activity);
        let done = act(self);
        self.line().activity = before;
        done
    }
}
