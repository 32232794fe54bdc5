//! Version 1. Frozen: the order of fields and of variants is what stands on disk (see `docs/FORMAT.md`).
//!
//! Everything becomes a value of these types on its way to the disk and back, so that the learner's own types are
//! free to change.

mod content;
mod effect;
mod observation;
mod stage;
mod vocabulary;

use serde::{Deserialize, Serialize};

pub(crate) use content::{Bounds, Facts, Reading, Remembered, Schema, blocks};
pub(crate) use effect::Effect;

/// What is on disk cannot be what a learner knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0} on disk refers to something that is not there, or is beyond its limit")]
pub struct Impossible(pub(crate) &'static str);

/// The payload of one frame of the journal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Record {
    /// What one step, one order or one attachment changed.
    Batch {
        /// Steps taken, this one included.
        step: u64,
        /// What changed, in order.
        effects: Vec<Effect>,
    },
    /// What memory is at this place.
    Digest {
        /// Steps taken.
        step: u64,
        /// The digest, in hexadecimal.
        digest: String,
    },
}

/// The payload of one block of a snapshot. First [`Block::Facts`], then observations and schemas in order, then
/// [`Block::End`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Block {
    /// What there is one of.
    Facts(Box<Facts>),
    /// Observations with their counts.
    Observations(Vec<Remembered>),
    /// Schemas.
    Schemas(Vec<Schema>),
    /// All of it has been read.
    End {
        /// The digest of memory, in hexadecimal.
        digest: String,
    },
}

/// A number on disk as an index. One that no list can have becomes one that no list has.
fn index(number: u64) -> usize {
    usize::try_from(number).unwrap_or(usize::MAX)
}
