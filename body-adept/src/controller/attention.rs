//! What the waits of a controller go by besides the line: whether the switch was pressed, and whether the driver lives.

use std::mem;

use super::Fault;
use crate::line::LineError;
use crate::switch::{Pressed, StopSwitch};
use crate::watch::Beat;

/// What a controller is doing for the driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Doing {
    /// It asks while the arm stands: a stop from before is nothing to it.
    Asking,
    /// It has the arm move, or is about to: a stop ends every wait.
    Ordering,
    /// It makes sure that the arm stands, and repeats the order to stop itself.
    Halting,
}

/// Looked at again and again while a controller waits.
pub(super) struct Attention {
    pub(super) switch: StopSwitch,
    driver: Beat,
    doing: Doing,
}

impl Attention {
    pub(super) fn new(switch: StopSwitch, driver: Beat) -> Self {
        Self { switch, driver, doing: Doing::Asking }
    }

    /// Changes what is being done; what was before, to be put back.
    pub(super) fn turn_to(&mut self, doing: Doing) -> Doing {
        mem::replace(&mut self.doing, doing)
    }

    /// A moment of a wait has passed.
    ///
    /// # Errors
    /// When the wait is over because the arm was stopped.
    pub(super) fn moment(&self) -> Result<(), Fault> {
        match self.doing {
            Doing::Ordering if self.switch.is_pressed() => Err(self.stopped()),
            Doing::Halting => {
                self.driver.renew();
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// The controller has answered: on a slow line a path takes longer to send than the driver may be silent.
    pub(super) fn answered(&self) {
        self.driver.renew();
    }

    /// Writes an order that moves the arm, or may, unless the switch is pressed.
    ///
    /// # Errors
    /// That it was pressed, or what `write` said.
    pub(super) fn order(&self, write: impl FnOnce() -> Result<(), LineError>) -> Result<(), Fault> {
        self.switch.order(write).map_err(|error| error.map_or_else(|| self.stopped(), Fault::Line))
    }

    fn stopped(&self) -> Fault {
        Fault::Stopped(self.switch.pressed_by().unwrap_or(Pressed::Trouble))
    }
}
