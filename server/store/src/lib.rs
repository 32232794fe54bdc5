//! The memory of a learner on disk: a journal of the effects that changed it, and snapshots of it. `docs/FORMAT.md` describes
//! the bytes.
//!
//! [`open()`] finds a memory again, or begins one, and returns the learner with the [`Store`] that keeps its memory from then on.
//! Damage is reported, and nothing is dropped in silence. The module [`past`] looks back without a daemon.
//!
//! ```
//! use pschema_learner::curriculum::Curriculum;
//! use pschema_learner::parameters::Parameters;
//! use pschema_learner::vocabulary::Declaration;
//! use pschema_store::{Cause, Change, Options, open};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let directory = tempfile::tempdir()?;
//! # let directory = directory.path().join("memory");
//! let curriculum = Curriculum::free("free");
//! let parameters = Parameters::default();
//! let options = Options::new("arm", 7, &parameters, &curriculum);
//! // The closure is called whenever more is durable; a daemon wakes its loop with it.
//! let opened = open(&directory, options, || ())?;
//! let (mut learner, mut store) = (opened.learner, opened.store);
//!
//! let (_, effects) = learner.declare(Declaration { body: "arm".to_owned(), ..Declaration::default() })?;
//! let change = Change { cause: Cause::Declared("arm"), at_unix_ms: 0, effects: &effects };
//! let batch = store.append(&change, learner.memory().content())?;
//! // No reply leaves before `store.is_durable(batch)`.
//! # assert!(batch > 0);
//! store.finish(learner.memory())?;
//!
//! let again = open(&directory, options, || ())?;
//! assert_eq!(again.learner.memory().content().vocabulary.bodies().len(), 1);
//! # Ok(())
//! # }
//! ```
#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod archivist;
mod change;
mod codec;
mod content_error;
mod durable;
mod error;
mod extent;
mod format;
mod frame;
mod journal;
mod lock;
mod manifest;
mod open;
mod options;
pub mod past;
mod recovery;
mod retention;
mod shared;
mod snapshot;
mod storage;
mod store;
#[cfg(test)]
mod tests;
mod writer;

pub use change::{Cause, Change, Durability};
pub use codec::CodecError;
pub use content_error::ContentError;
pub use error::StoreError;
pub use journal::JournalError;
pub use open::{Opened, open};
pub use options::{Options, Retention};
pub use recovery::RecoveryReport;
pub use store::{Ending, Store};
