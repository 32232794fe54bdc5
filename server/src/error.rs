//! Why the daemon can't run.

use pschema_learner::LearnerError;
use pschema_process::{SignalError, TooFewDescriptors};
use pschema_protocol::domain::DomainError;
use pschema_protocol::transport::TransportError;
use pschema_store::StoreError;

use crate::config::ConfigError;

/// Why the daemon can't run.
#[derive(Debug, thiserror::Error)]
pub enum ServerError {
    /// A file of settings can't be used.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// The learner can't be made.
    #[error(transparent)]
    Learner(#[from] LearnerError),
    /// The place in the runtime directory can't be taken.
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// Shared memory can't be used.
    #[error(transparent)]
    Transport(#[from] TransportError),
    /// Memory can't be kept, or found again.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// Peers could no longer join the epoch, and no other could be begun.
    #[error("{why}; the daemon ends, for it can't begin anew: {error}")]
    Unreachable {
        /// What was lost.
        why: String,
        /// Why no other epoch could be begun.
        error: Box<ServerError>,
    },
    /// The process may open too few files.
    #[error(transparent)]
    Descriptors(#[from] TooFewDescriptors),
    /// The process may take less memory than it takes without having learnt anything.
    #[error(
        "--memory-max {max}: the daemon takes {taken} bytes before it has learnt anything, so it could learn nothing: allow it \
         more, such as {}MiB, or leave --memory-max out for half of the machine's memory", advised_mib(*taken)
    )]
    MemoryMax {
        /// How many bytes it may take.
        max: u64,
        /// How many bytes it takes by now.
        taken: u64,
    },
    /// A thread can't be started.
    #[error("cannot start a thread: {0}")]
    Thread(#[source] std::io::Error),
    /// Signals can't be handled.
    #[error(transparent)]
    Signals(#[from] SignalError),
}

/// A limit that leaves as much again for memory and more, in MiB.
fn advised_mib(taken: u64) -> u64 {
    (taken >> 20).saturating_mul(4).max(64)
}
