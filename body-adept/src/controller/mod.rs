//! The controller as the driver sees it, in either of its two modes.
//!
//! Neither mode resends a motion, believes a position that was not confirmed (by the line's sum, or by a second reading),
//! or moves the arm by anything but a path that has passed the [gate](crate::gate).

mod attention;
pub mod monitor;
pub mod program;

use std::time::Duration;

use thiserror::Error;

use crate::gate::Permitted;
use crate::line::LineError;
use crate::switch::Pressed;
use crate::taught::Joints;
use crate::v_plus::message::Message;
pub use crate::v_plus::program::Ended;

/// Why something was not done.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Fault {
    /// The line is gone, or was never there.
    #[error(transparent)]
    Line(#[from] LineError),
    /// The controller did not answer in time.
    #[error(
        "the controller did not answer {what} within {} ms: check that it is on, the speed of the line, and the mode in \
         arm.toml",
        waited.as_millis()
    )]
    Silent {
        /// What was asked.
        what: String,
        /// How long.
        waited: Duration,
    },
    /// The controller answered, but not what was asked.
    #[error("the controller answered {what} with {answer:?}, which is no answer to it")]
    Garbled {
        /// What was asked.
        what: String,
        /// What came.
        answer: String,
    },
    /// The controller refused, or gave up.
    #[error("the controller says {0}")]
    Refused(Message),
    /// Another program, or arm, answers than arm.toml says.
    #[error("{0}")]
    Other(String),
    /// The switch was pressed.
    #[error("stopped: {0}")]
    Stopped(Pressed),
    /// The arm stands where no part of its path ends, and nobody here stopped it.
    #[error(
        "the arm stands at {at:?}, short of {wanted:?}, where a part of its path was to end: find out who or what stopped it"
    )]
    Short {
        /// Where it is.
        at: Joints,
        /// Where it was to be.
        wanted: Joints,
    },
    /// The arm was stopped, and nobody here did it.
    #[error("the motion was stopped, and not from here: find out who or what stopped it")]
    StoppedElsewhere,
    /// The arm goes on although it was told to stop.
    #[error("the arm does not confirm that it stands still: press the emergency stop")]
    NotStopping,
}

impl Fault {
    /// Whether the line itself is to blame, so that opening it anew may help.
    #[must_use]
    pub fn is_of_line(&self) -> bool {
        matches!(self, Self::Line(_) | Self::Silent { .. } | Self::Garbled { .. })
    }

    /// Whether the arm may move again only once a person has looked.
    #[must_use]
    pub fn needs_a_person(&self) -> bool {
        match self {
            Self::Refused(message) => message.cause().needs_a_person(),
            Self::NotStopping | Self::Short { .. } | Self::StoppedElsewhere => true,
            _ => false,
        }
    }
}

/// The controller's state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct State {
    /// High power is on.
    pub power: bool,
    /// The arm is calibrated, and under the controller's control. Known only while high power is on.
    pub calibrated: bool,
    /// An emergency stop is pressed.
    pub emergency_stop: bool,
    /// A motion is under way, or something else that may move the arm.
    pub moving: bool,
    /// The controller refuses motions until a reset.
    pub latched: bool,
    /// The touch inputs: bit 0 the first.
    pub signals: u8,
}

/// A controller on a line.
pub trait Controller: Send {
    /// Throws away what came before, makes sure who answers, and stops whatever is under way.
    ///
    /// # Errors
    /// When nobody answers, or another program or arm does.
    fn greet(&mut self) -> Result<String, Fault>;

    /// The controller's state.
    ///
    /// # Errors
    /// When it is not told.
    fn state(&mut self) -> Result<State, Fault>;

    /// Where the arm is.
    ///
    /// # Errors
    /// When it is not told, or not beyond doubt.
    fn joints(&mut self) -> Result<Joints, Fault>;

    /// Where the arm passes while it moves: one reading, which is not beyond doubt where the line has no sums.
    ///
    /// # Errors
    /// When it is not told.
    fn passing(&mut self) -> Result<Joints, Fault>;

    /// Turns high power on, which may take seconds and ends when the switch is pressed, or off.
    ///
    /// # Errors
    /// When the controller refuses, or the switch was pressed: the caller halts then.
    fn power(&mut self, on: bool) -> Result<(), Fault>;

    /// Calibrates the arm: it moves by itself, as the controller's maker decided, whatever the limits here are. Ends when
    /// the switch is pressed.
    ///
    /// # Errors
    /// When the controller refuses, or the switch was pressed: the caller halts then.
    fn calibrate(&mut self) -> Result<(), Fault>;

    /// Clears a latched fault.
    ///
    /// # Errors
    /// When its cause is still there.
    fn reset(&mut self) -> Result<(), Fault>;

    /// Begins a motion.
    ///
    /// # Errors
    /// When it has not begun, or that is in doubt: the caller halts then.
    fn begin(&mut self, path: &Permitted) -> Result<(), Fault>;

    /// Follows the motion for a moment. None while it is under way.
    ///
    /// # Errors
    /// When the controller gave up, or does not tell: the caller halts then.
    fn follow(&mut self) -> Result<Option<Ended>, Fault>;

    /// Stops the arm and waits until it is known to stand still.
    ///
    /// # Errors
    /// When that is not confirmed.
    fn halt(&mut self) -> Result<(), Fault>;
}
