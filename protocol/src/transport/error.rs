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

/// For `map_err`: the same of a peer that opens a service. That a service has no room for another node is told as what it means.
pub(crate) fn opening<E: std::fmt::Debug>(doing: &'static str) -> impl FnOnce(E) -> TransportError {
    move |error| {
        let problem = match format!("{error:?}") {
            full if full == "ExceedsMaxNumberOfNodes" => NO_NODE.to_owned(),
            other => other,
        };
        TransportError::Setup { doing, problem }
    }
}

/// What it means that a service has as many nodes as it takes.
const NO_NODE: &str = "there is no room for another process beside those that are attached, or were killed a moment ago and \
                       are still to be cleared away: try again in a second";

/// For `map_err`: an error of the transport with what was being done.
pub(crate) fn setup<E: std::fmt::Debug>(doing: &'static str) -> impl FnOnce(E) -> TransportError {
    move |error| TransportError::Setup { doing, problem: format!("{error:?}") }
}

#[cfg(test)]
mod tests {
    use iceoryx2::service::builder::event::EventOpenError;
    use iceoryx2::service::builder::publish_subscribe::PublishSubscribeOpenError;
    use iceoryx2::service::builder::request_response::RequestResponseOpenError;

    use super::*;

    /// A tool that is killed leaves its node until the daemon has cleared it away.
    #[test]
    fn a_service_that_is_full_of_nodes_is_told_in_words() {
        let told = [
            opening("open a service")(EventOpenError::ExceedsMaxNumberOfNodes),
            opening("open a service")(PublishSubscribeOpenError::ExceedsMaxNumberOfNodes),
            opening("open a service")(RequestResponseOpenError::ExceedsMaxNumberOfNodes),
        ];
        for error in told {
            let told = error.to_string();
            assert!(told.contains("try again in a second") && !told.contains("Exceeds"), "{told}");
        }
        let other = opening("open a service")(EventOpenError::DoesNotExist).to_string();
        assert_eq!(other, "cannot open a service: DoesNotExist");
    }
}
