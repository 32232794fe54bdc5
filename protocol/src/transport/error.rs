//! Why a message could not be exchanged.

use std::time::Duration;

use pschema_process::TooFewDescriptors;

use crate::domain::DomainError;
use crate::refusal::Refusal;

/// Why a message could not be exchanged.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TransportError {
    /// The learner's domain cannot be made or found.
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// A part of the transport could not be made or used.
    #[error("cannot {doing}: {problem}")]
    Setup {
        /// What was being done.
        doing: &'static str,
        /// What the transport said.
        problem: String,
    },
    /// The process may open too few files.
    #[error(transparent)]
    Descriptors(#[from] TooFewDescriptors),
    /// Shared memory ran out while a port was being set up.
    #[error(
        "shared memory is full: cannot reserve {bytes} bytes in /dev/shm ({error}); free some, or mount it larger"
    )]
    SharedMemory {
        /// Bytes being reserved.
        bytes: u64,
        /// What the operating system said.
        error: std::io::Error,
    },
    /// The daemon has as many peers of this sort as it takes.
    #[error("the daemon already has {limit} {sort}, which is all it takes: stop one first")]
    Full {
        /// `bodies` or `tools`.
        sort: &'static str,
        /// How many it takes.
        limit: usize,
    },
    /// The daemon has gone, or another has taken its place.
    #[error("the daemon has gone")]
    DaemonGone,
    /// The daemon did not answer in time.
    #[error(
        "the daemon did not answer within {waited:?}: it may be stopped, very busy, or waiting for a slow disk"
    )]
    TimedOut {
        /// How long was waited.
        waited: Duration,
    },
    /// The caller's stop flag was set.
    #[error("stopped while waiting")]
    Stopped,
    /// The daemon sent a message that is not of the protocol.
    #[error("the daemon sent something wrong: {0}")]
    Wrong(#[source] Refusal),
    /// The daemon refused the hello, or a tool's request.
    #[error("refused ({code}): {reason}")]
    Refused {
        /// The number of the refusal.
        code: u32,
        /// Why.
        reason: String,
    },
    /// The message to be sent is longer than the protocol allows.
    #[error("{length} bytes are more than the {limit} of one message")]
    TooLong {
        /// Bytes to be sent.
        length: usize,
        /// Bytes allowed.
        limit: usize,
    },
}

/// For `map_err`: an error of the transport with what was being done.
pub(crate) fn setup<E: std::fmt::Debug>(doing: &'static str) -> impl FnOnce(E) -> TransportError {
    move |error| TransportError::Setup { doing, problem: format!("{error:?}") }
}
