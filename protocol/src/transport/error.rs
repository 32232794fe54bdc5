//! Why a message could not be exchanged.

use std::time::Duration;

use crate::domain::DomainError;
use crate::refusal::Refusal;

/// Why a message could not be exchanged.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the sentence of each variant says what its fields are")]
pub enum TransportError {
    /// The learner's domain cannot be made or found.
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// A part of the transport could not be made or used.
    #[error("cannot {doing}: {problem}")]
    Setup { doing: &'static str, problem: String },
    /// Shared memory ran out while a port was being set up.
    #[error(
        "shared memory is full: cannot reserve {bytes} bytes in /dev/shm ({error}); free some, or mount it larger"
    )]
    SharedMemory { bytes: u64, error: std::io::Error },
    /// The daemon has as many peers of this sort as it takes.
    #[error("the daemon already has {limit} {sort}, which is all it takes: stop one first")]
    Full { sort: &'static str, limit: usize },
    /// The daemon has gone, or another has taken its place.
    #[error("the daemon has gone")]
    DaemonGone,
    /// The daemon did not answer in time.
    #[error("the daemon did not answer within {waited:?}: it may be stopped or very busy")]
    TimedOut { waited: Duration },
    /// The caller's stop flag was set.
    #[error("stopped while waiting")]
    Stopped,
    /// The daemon sent a message that is not of the protocol.
    #[error("the daemon sent something wrong: {0}")]
    Wrong(#[source] Refusal),
    /// The daemon refused the hello, or a tool's request.
    #[error("refused ({code}): {reason}")]
    Refused { code: u32, reason: String },
    /// The message to be sent is longer than the protocol allows.
    #[error("{length} bytes are more than the {limit} of one message")]
    TooLong { length: usize, limit: usize },
}

/// For `map_err`: an error of the transport with what was being done.
pub(crate) fn setup<E: std::fmt::Debug>(doing: &'static str) -> impl FnOnce(E) -> TransportError {
    move |error| TransportError::Setup { doing, problem: format!("{error:?}") }
}
