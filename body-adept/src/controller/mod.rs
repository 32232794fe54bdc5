//! The controller as the driver sees it, in either of its two modes.
//!
//! Neither mode resends a motion, believes a position that was not confirmed (by the line's sum, or by a second
//! reading), or moves the arm by anything but a path that has passed the [gate](crate::gate).

mod error;
mod guarded_line;
pub mod monitor;
pub mod program;

use std::time::Duration;

use crate::gate::PermittedPath;
use crate::taught::Joints;
pub use crate::v_plus::ControllerState;
pub use crate::v_plus::program::MotionEnd;
pub use error::{ControllerError, Result};
pub use guarded_line::GuardedLine;

/// How often a question that may be repeated is asked before it counts as unanswered.
const TRIES: usize = 4;
/// Longest wait for high power.
const POWER_WAIT: Duration = Duration::from_secs(20);
/// Longest wait for the arm to be calibrated.
const CALIBRATE_WAIT: Duration = Duration::from_secs(120);
/// Longest that one wait for bytes takes.
const SLICE: Duration = Duration::from_millis(20);

/// A controller on a line.
pub trait Controller: Send {
    /// Throws away the bytes that came before, makes sure which program answers, and stops a motion that is under way.
    ///
    /// # Errors
    /// When nobody answers, or another program or arm than expected.
    fn greet(&mut self) -> Result<String>;

    /// The controller's state.
    ///
    /// # Errors
    /// When the controller does not tell it.
    fn state(&mut self) -> Result<ControllerState>;

    /// The joints of the arm.
    ///
    /// # Errors
    /// When the controller does not tell them, or they are not beyond doubt.
    fn joints(&mut self) -> Result<Joints>;

    /// The joints of the arm while it moves: one reading, which is not beyond doubt when the line has no sums.
    ///
    /// # Errors
    /// When the controller does not tell them.
    fn passing(&mut self) -> Result<Joints>;

    /// Turns high power on or off. Turning on may take seconds, and ends when the switch is pressed.
    ///
    /// # Errors
    /// When the controller refuses, or the switch was pressed: the caller halts then.
    fn power(&mut self, on: bool) -> Result<()>;

    /// Calibrates the arm. It moves by itself, as the controller's maker decided, whatever the limits in the arm file.
    /// The calibration ends when the switch is pressed.
    ///
    /// # Errors
    /// When the controller refuses, or the switch was pressed: the caller halts then.
    fn calibrate(&mut self) -> Result<()>;

    /// Clears a latched fault.
    ///
    /// # Errors
    /// When its cause is still there.
    fn reset(&mut self) -> Result<()>;

    /// Begins a motion.
    ///
    /// # Errors
    /// When the motion has not begun, or that is in doubt: the caller halts then.
    fn begin(&mut self, path: &PermittedPath) -> Result<()>;

    /// Follows the motion for a moment. Returns how it ended, or None while it is under way.
    ///
    /// # Errors
    /// When the controller gave up, or does not tell: the caller halts then.
    fn follow(&mut self) -> Result<Option<MotionEnd>>;

    /// Stops the arm and waits until it is known to stand still.
    ///
    /// # Errors
    /// When the arm does not confirm that it stands.
    fn halt(&mut self) -> Result<()>;
}
