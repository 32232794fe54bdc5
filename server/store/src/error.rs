//! Why memory can't be kept or found again.

use std::io;

use crate::codec::CodecError;
use crate::format::v1::Impossible;
use crate::journal::JournalError;

/// Why memory can't be kept or found again.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The journal can't be read.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// A value can't be written or read.
    #[error(transparent)]
    Codec(#[from] CodecError),
    /// What was read can't be what a learner knows.
    #[error(transparent)]
    Impossible(#[from] Impossible),
    /// What was read can't be taken into memory.
    #[error("{0}")]
    Content(String),
    /// A sound frame can't be replayed.
    #[error("{file}, byte {offset}: frame {frame} can't be replayed: {problem}")]
    Replay {
        /// Which file.
        file: String,
        /// Where in it.
        offset: usize,
        /// Which frame.
        frame: u64,
        /// Why.
        problem: String,
    },
    /// The disk failed.
    #[error("cannot {what} {path}: {error}")]
    Disk {
        /// What was tried.
        what: &'static str,
        /// On what.
        path: String,
        /// Why it failed.
        #[source]
        error: io::Error,
    },
    /// Another daemon has the directory.
    #[error("data directory {path} is in use by {holder}: stop it, or name another directory with --data")]
    Locked {
        /// Which directory.
        path: String,
        /// Who has it, as it said itself.
        holder: String,
    },
    /// The directory belongs to a memory that was begun with something else.
    #[error(
        "{path} holds a memory begun with {key} = {kept}, and {given} was given: give the same, or begin another \
         memory in another directory"
    )]
    Differs {
        /// Which directory.
        path: String,
        /// What differs.
        key: String,
        /// What it was begun with.
        kept: String,
        /// What was given now.
        given: String,
    },
    /// The manifest can't be understood.
    #[error("{path}: {problem}")]
    Manifest {
        /// The file.
        path: String,
        /// What is wrong.
        problem: String,
    },
    /// Memory could not be written, so nothing more may be done.
    #[error("memory could not be written, so the daemon ends before anything more is done: {0}")]
    Failed(String),
}

impl StoreError {
    pub(crate) fn disk(what: &'static str, path: String) -> impl FnOnce(io::Error) -> Self {
        move |error| Self::Disk { what, path, error }
    }
}
