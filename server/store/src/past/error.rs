//! Why a question about the past can't be answered, and reading again what a daemon changed meanwhile.

use crate::error::StoreError;
use crate::journal::JournalError;

/// How often files are read again that a daemon changed meanwhile.
pub(super) const READ_AGAIN_MAX: u32 = 16;

/// Why a question about the past can't be answered.
#[derive(Debug, thiserror::Error)]
pub enum PastError {
    /// The directory can't be read, or is damaged.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// There is no memory in it.
    #[error(
        "there is no memory in {path}: no manifest and no journal. Give a directory that was given to `pschema server --data`"
    )]
    Nothing {
        /// The directory.
        path: String,
    },
    /// The step is still to come.
    #[error("step {asked} has not been taken yet: the last step on disk in {path} is {last}")]
    Beyond {
        /// The directory.
        path: String,
        /// The step asked for.
        asked: u64,
        /// The last step that was taken.
        last: u64,
    },
    /// The step is no longer kept.
    #[error(
        "step {asked} is no longer kept: {path} goes back to step {first}. `--history` of the daemon says how much is kept"
    )]
    Before {
        /// The directory.
        path: String,
        /// The step asked for.
        asked: u64,
        /// The first step that is kept.
        first: u64,
    },
    /// The step decided nothing.
    #[error("step {step} decided nothing: {why}")]
    Undecided {
        /// The step.
        step: u64,
        /// Why it decided nothing.
        why: String,
    },
    /// Taking the step again leads elsewhere.
    #[error(
        "step {step} can't be explained: {why}. It was taken by a release that learns otherwise, or is damaged"
    )]
    Unlike {
        /// The step.
        step: u64,
        /// In what it differs.
        why: String,
    },
    /// Nothing can be saved.
    #[error(
        "nothing in {path} can be saved: no snapshot in it is sound, and the journal does not reach back to its beginning. \
         Put it back from a copy"
    )]
    Lost {
        /// The directory.
        path: String,
    },
    /// A directory that is to be made is not empty.
    #[error("{path} is not empty: name a directory that is not there yet")]
    Taken {
        /// The directory.
        path: String,
    },
    /// Nothing was decided at all.
    #[error("nothing was decided up to step {last}, as far as {path} goes back")]
    NeverDecided {
        /// The directory.
        path: String,
        /// The last step that was looked at.
        last: u64,
    },
}

impl From<JournalError> for PastError {
    fn from(error: JournalError) -> Self {
        Self::Store(error.into())
    }
}

/// Reads again, a few times, if a daemon removed meanwhile files that it keeps no longer.
pub(super) fn beside<T>(mut read: impl FnMut() -> Result<T, PastError>) -> Result<T, PastError> {
    for _ in 0..READ_AGAIN_MAX {
        match read() {
            Err(PastError::Store(error)) if is_gone(&error) => (),
            done => return done,
        }
    }
    read()
}

/// Whether a file is no longer there, or the journal begins later than before.
pub(super) fn is_gone(error: &StoreError) -> bool {
    let error = match error {
        StoreError::Journal(JournalError::Missing { .. }) => return true,
        StoreError::Journal(JournalError::Read { error, .. }) | StoreError::Disk { error, .. } => error,
        _ => return false,
    };
    error.kind() == std::io::ErrorKind::NotFound
}

/// The damage in words, without the advice of a daemon that can't start.
pub(super) fn damage_text(error: &StoreError) -> String {
    match error {
        StoreError::Journal(JournalError::Damaged { file, offset, lost, claimed }) => format!(
            "{file}, byte {offset}: frame {lost} and what follows it can't be read, though frames up to {claimed} were on \
             disk and acted on"
        ),
        error => error.to_string(),
    }
}
