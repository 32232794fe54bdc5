//! Why the daemon can't run.

use pschema_learner::LearnerError;
use pschema_process::SignalError;
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
    /// A thread can't be started.
    #[error("cannot start a thread: {0}")]
    Thread(#[source] std::io::Error),
    /// Signals can't be handled.
    #[error(transparent)]
    Signals(#[from] SignalError),
}
