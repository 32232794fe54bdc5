//! How an order went.

use std::fmt::Display;

/// How an action (or scene command) went.
///
/// ```
/// use pschema_protocol::body::Outcome;
///
/// let outcome = Outcome::refused(format_args!("the lid is at {} degrees", 40));
/// assert_eq!(outcome.reason(), Some("the lid is at 40 degrees"));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Carried out.
    Done,
    /// Not begun: outside what the body allows now, for this reason.
    Refused(String),
    /// Begun and not completed, for this reason: a fault of the body, of which nothing can be learnt.
    Failed(String),
    /// Not completed in the time the body allows.
    TimedOut,
    /// Not carried out, for the episode had ended: nothing leads on from the last frame, and this one begins a new episode.
    EpisodeEnded,
    /// Not carried out, for the episode was cut off from outside (a time limit, a person, others who changed the world): this frame begins
    /// a new one.
    EpisodeCut,
}

impl Outcome {
    /// Not begun, for a reason that the daemon logs and shows: at most [`crate::limits::REASON_BYTES_MAX`] bytes of it.
    #[must_use]
    pub fn refused(reason: impl Display) -> Self {
        Self::Refused(reason.to_string())
    }

    /// Begun and not completed, for a reason that the daemon logs and shows, likewise.
    #[must_use]
    pub fn failed(reason: impl Display) -> Self {
        Self::Failed(reason.to_string())
    }

    /// Why it was not carried out, if the body says so.
    #[must_use]
    pub fn reason(&self) -> Option<&str> {
        match self {
            Self::Refused(reason) | Self::Failed(reason) if !reason.is_empty() => Some(reason),
            _ => None,
        }
    }
}
