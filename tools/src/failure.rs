//! Why a command could not be done, as the person who typed it should read it.

use std::process::ExitCode;

use pschema_process::{Interrupted, OutputError, SignalError, unread};
use pschema_protocol::domain::DomainError;

/// Why a command could not be done. Each is said once, on stderr, by `main`.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// It was typed wrongly.
    #[error("{0}")]
    Usage(String),
    /// No daemon serves the learner.
    #[error("{0}")]
    NoDaemon(String),
    /// Anything else that went wrong: what, the figure, what to do next.
    #[error("{0}")]
    Failed(String),
    /// Stopped by Ctrl-C or SIGTERM before the end.
    #[error("stopped before the end; nothing was left running")]
    Interrupted,
    /// Whoever read stdout went away (`pschema schemas | head -1`): not a failure.
    #[error("nobody reads")]
    NobodyReads,
}

impl Failure {
    /// A failure that is said as `error` is.
    #[must_use]
    pub fn of(error: impl std::fmt::Display) -> Self {
        Self::Failed(error.to_string())
    }

    pub(crate) fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::NobodyReads => 0,
            Self::Failed(_) | Self::Interrupted => 1,
            Self::Usage(_) => 2,
            Self::NoDaemon(_) => 3,
        })
    }
}

impl From<DomainError> for Failure {
    fn from(error: DomainError) -> Self {
        match error {
            DomainError::NotServed { .. } => Self::NoDaemon(error.to_string()),
            DomainError::LearnerName { .. } => Self::Usage(error.to_string()),
            _ => Self::of(error),
        }
    }
}

impl From<Interrupted> for Failure {
    fn from(_: Interrupted) -> Self {
        Self::Interrupted
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        match error {
            error if error.nobody_reads() => Self::NobodyReads,
            OutputError::Io { source, .. } if unread(&source) => Self::Interrupted,
            error => Self::of(error),
        }
    }
}

impl From<SignalError> for Failure {
    fn from(error: SignalError) -> Self {
        Self::of(error)
    }
}
