//! The learner daemon: bodies attach to it, it steps the learner, and tools look into what was learnt.
//!
//! [`serve`] is the daemon; [`in_process`] runs a body and its learner in one process, on the same session,
//! translation and wire encoding, with the same result. **Memory is kept in RAM only in this version**: when
//! the process ends, what was learnt is gone.
#![forbid(unsafe_code)]

mod args;
pub mod config;
mod daemon;
pub mod in_process;
pub mod inspect;
mod inspector;
pub mod latency;
pub mod mind;
pub mod session;
mod trace;
pub mod translate;

use pschema_learner::step::LearnerError;
use pschema_protocol::domain::DomainError;
use pschema_protocol::transport::TransportError;

pub use args::{ServerArgs, program, run};
pub use daemon::serve;
pub use mind::Setup;

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
    /// A thread can't be started.
    #[error("cannot start a thread: {0}")]
    Thread(#[source] std::io::Error),
    /// Signals can't be handled.
    #[error("cannot handle signals: {0}")]
    Signals(#[source] std::io::Error),
}
