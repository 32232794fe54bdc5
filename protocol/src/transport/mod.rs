//! How messages travel: iceoryx2, named nowhere else. Request-response services for what is asked and
//! answered, one event service a direction to wake who waits. Ports are single-threaded.

pub mod bare;
pub mod body_link;
mod janitor;
mod payload;
pub mod pictures;
mod replies;
mod reserve;
pub mod server;
mod services;
mod spin;
pub mod tool_link;
mod waker;

use std::time::Duration;

pub use services::VERSION;
pub use spin::{SPIN_US_MAX, SPIN_VARIABLE, Spin};
pub use waker::DaemonWaker;

use crate::domain::DomainError;
use crate::refusal::Refusal;

/// Why a message could not be exchanged.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TransportError {
    /// The learner's domain cannot be made or found.
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// Part of the shared memory transport cannot be set up.
    #[error("cannot {doing}: {problem}")]
    Setup {
        /// What was being done.
        doing: &'static str,
        /// What the transport said.
        problem: String,
    },
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
    /// All places for peers of this sort are taken.
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
    /// Nothing came in time.
    #[error("the daemon did not answer within {waited:?}: it may be stopped or very busy")]
    TimedOut {
        /// How long was waited.
        waited: Duration,
    },
    /// The caller's stop flag was set.
    #[error("stopped while waiting")]
    Stopped,
    /// What the daemon sent is not of the protocol.
    #[error("the daemon sent something wrong: {0}")]
    Wrong(#[source] Refusal),
    /// The daemon refused.
    #[error("refused ({code}): {reason}")]
    Refused {
        /// The number of the refusal.
        code: u32,
        /// Why.
        reason: String,
    },
    /// What was to be sent is longer than the protocol allows.
    #[error("{length} bytes are more than the {limit} of one message")]
    TooLong {
        /// Bytes to be sent.
        length: usize,
        /// Bytes allowed.
        limit: usize,
    },
}

/// Whether the daemon has gone without a reply. Whether there is a reply is asked last: a daemon lets go of a request
/// the moment it has replied, and may itself end then, so before that neither says that no reply will come.
pub(crate) fn has_gone(
    is_connected: impl FnOnce() -> bool,
    is_current: impl FnOnce() -> bool,
    has_reply: impl FnOnce() -> bool,
) -> bool {
    let seems_gone = !is_connected() || !is_current();
    seems_gone && !has_reply()
}

/// For `map_err`: an error of the transport with what was being done.
pub(crate) fn setup<E: std::fmt::Debug>(doing: &'static str) -> impl FnOnce(E) -> TransportError {
    move |error| TransportError::Setup { doing, problem: format!("{error:?}") }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    #[test]
    fn a_daemon_that_replies_while_it_is_looked_for_has_not_gone() {
        let replied = Cell::new(false);
        let lets_go = || {
            replied.set(true);
            false
        };
        assert!(!has_gone(lets_go, || true, || replied.get()), "it let go of the request");
        replied.set(false);
        assert!(!has_gone(|| true, lets_go, || replied.get()), "it ended");
        assert!(!has_gone(|| true, || true, || false), "it takes its time");
        assert!(has_gone(|| false, || true, || false), "it dropped the request");
        assert!(has_gone(|| true, || false, || false), "it died");
    }
}
