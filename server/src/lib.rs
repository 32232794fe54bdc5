//! The learner daemon: bodies attach to it, it steps the learner, and tools look into what was learnt.
//!
//! [`serve`] is the daemon; [`in_process`] runs a body and its learner in one process, on the same session,
//! translation and wire encoding, with the same result. With a data directory ([`Keeping`]) memory survives the process;
//! without one it is in RAM and ends with it.
#![forbid(unsafe_code)]

mod args;
pub mod config;
mod daemon;
mod growth;
pub mod in_process;
pub mod inspect;
mod inspector;
mod keeper;
pub mod latency;
pub mod mind;
mod refusals;
pub mod session;
mod supervise;
mod trace;
pub mod translate;

use pschema_learner::LearnerError;
use pschema_process::SignalError;
use pschema_protocol::domain::DomainError;
use pschema_protocol::transport::TransportError;

pub use args::{ServerArgs, program, run};
pub use daemon::{serve, serve_kept};
pub use keeper::Keeping;
pub use mind::Setup;
pub use pschema_store::{Durability, Retention, StoreError};

/// Why the daemon can't run.
#[derive(Debug, thiserror::Error)]
pub enum ServerError {
    /// A file of settings can't be used.
    #[error(transparent)]
    Config(#[from] config::ConfigError),
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
