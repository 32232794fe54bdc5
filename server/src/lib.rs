//! The learner daemon: bodies attach to it, it steps the learner, and tools look into what was learnt.
//!
//! [`serve`] is the daemon. [`in_process`] runs a body and its learner in one process, with the same session, translation
//! and wire encoding, and so with the same result. With a data directory ([`Keeping`]) memory outlives the process; without
//! one it is in RAM and ends with the process.
// The examples of the README are compiled too.
#![cfg_attr(doctest, doc = include_str!("../README.md"))]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod args;
pub mod config;
mod daemon;
mod described;
mod error;
pub mod goal;
mod growth;
pub mod in_process;
pub mod inspect;
mod inspector;
mod keeper;
mod latency;
pub mod mind;
mod names;
mod opening;
mod refusals;
mod resident;
mod ring;
pub mod session;
mod sessions;
mod setup;
mod suitability;
mod supervise;
mod trace;
pub mod translate;
pub mod view;
mod waker;

pub use args::{ServerArgs, program, run};
pub use daemon::{Hosting, serve, serve_kept};
pub use error::ServerError;
pub use keeper::Keeping;
pub use pschema_store::{Durability, Retention, StoreError};
pub use setup::{LearnerSettings, Setup};
