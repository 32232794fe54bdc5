//! The learner's memory on disk: a journal of what changed it, and snapshots of it. `docs/FORMAT.md` has the bytes.
//!
//! [`open`] finds a memory again, or begins one, and returns it with the [`Writer`] that keeps it from then on. What is
//! damaged is reported and never dropped in silence.
#![forbid(unsafe_code)]

mod archivist;
mod change;
mod codec;
mod error;
mod format;
mod frame;
#[cfg(test)]
mod golden_tests;
mod journal;
#[cfg(test)]
mod journal_tests;
#[cfg(test)]
mod keeping_tests;
mod lock;
mod manifest;
mod options;
pub mod past;
mod recovery;
mod retention;
mod shared;
mod snapshot;
mod storage;
mod store;
#[cfg(test)]
mod store_tests;
#[cfg(test)]
mod twin;
mod writer;

pub use change::{Cause, Change, Durability};
pub use codec::CodecError;
pub use error::StoreError;
pub use format::v1::Impossible;
pub use journal::JournalError;
pub use options::{Options, Retention};
pub use recovery::Recovered;
pub use store::{Opened, Store, open};
