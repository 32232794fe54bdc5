//! Why a controller did not do what it was asked.

use std::time::Duration;

use thiserror::Error;

use crate::line::LineError;
use crate::switch::StopCause;
use crate::taught::Joints;
use crate::v_plus::message::VPlusMessage;

/// The result of asking a controller for something.
pub type Result<T, E = ControllerError> = std::result::Result<T, E>;

/// Why a controller did not do what it was asked.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ControllerError {
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
        /// The question.
        what: String,
        /// How long the answer was waited for.
        waited: Duration,
    },
    /// The controller's answer is no answer to the question.
    #[error("the controller answered {what} with {answer:?}, which is no answer to it")]
    Garbled {
        /// The question.
        what: String,
        /// The text that came.
        answer: String,
    },
    /// The controller refused, or gave up.
    #[error("the controller says {0}")]
    Refused(VPlusMessage),
    /// The program or arm that answers is not the one of arm.toml, or another condition does not hold.
    #[error("{0}")]
    Other(String),
    /// The switch was pressed.
    #[error("stopped: {0}")]
    Stopped(StopCause),
    /// The arm stands where no part of its path ends, and nobody here stopped it.
    #[error(
        "the arm stands at {at:?}, short of {wanted:?}, where a part of its path was to end: find out who or what stopped it"
    )]
    Short {
        /// Where the arm is.
        at: Joints,
        /// Where it should be.
        wanted: Joints,
    },
    /// The arm was stopped, but not by this driver.
    #[error("the motion was stopped, and not from here: find out who or what stopped it")]
    StoppedElsewhere,
    /// The arm does not stand still although it was told to stop.
    #[error("the arm does not confirm that it stands still: press the emergency stop")]
    NotStopping,
}

impl ControllerError {
    /// Whether the line itself is to blame, so that opening it anew may help.
    #[must_use]
    pub fn is_of_line(&self) -> bool {
        matches!(self, Self::Line(_) | Self::Silent { .. } | Self::Garbled { .. })
    }

    /// Whether the controller was asked, and the next answer may be another: it was silent, not understood, or refused.
    pub(super) fn may_pass(&self) -> bool {
        matches!(self, Self::Silent { .. } | Self::Garbled { .. } | Self::Refused(_))
    }

    /// Whether a person must look before the arm may move again.
    #[must_use]
    pub fn needs_a_person(&self) -> bool {
        match self {
            Self::Refused(message) => message.cause().needs_a_person(),
            Self::NotStopping | Self::Short { .. } | Self::StoppedElsewhere => true,
            _ => false,
        }
    }
}
