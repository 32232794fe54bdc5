//! Errors of keeping memory and of finding it again.

use std::io;

use pschema_learner::LearnerError;

use crate::codec::CodecError;
use crate::content_error::ContentError;
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
    /// What was read can't be the content of a memory.
    #[error(transparent)]
    Content(#[from] ContentError),
    /// A sound frame can't be replayed.
    #[error("{file}, byte {offset}: frame {frame} can't be replayed: {problem}")]
    Replay {
        /// Which file.
        file: String,
        /// The place in the file, in bytes.
        offset: usize,
        /// Which frame.
        frame: u64,
        /// Why it can't be replayed.
        problem: String,
    },
    /// The disk failed.
    #[error("cannot {what} {path}: {error}")]
    Disk {
        /// What was tried.
        what: &'static str,
        /// The file or directory.
        path: String,
        /// Why it failed.
        #[source]
        error: io::Error,
    },
    /// A file that the next start needs was cut short.
    #[error(
        "{problem}. Steps that were acknowledged are lost with them: put this data directory back from a copy; or `pschema repair \
         --dry-run` says what can be saved of it"
    )]
    Cut {
        /// The path, and how much of it is left.
        problem: String,
    },
    /// The data directory, or a file there that the next start needs, is no longer where it was opened.
    #[error(
        "{problem}. Every step that was acknowledged is in the directory that was opened: put it back if it was moved or replaced, \
         and start the daemon on it"
    )]
    Displaced {
        /// The path, and what became of it.
        problem: String,
    },
    /// The directory has other files and no memory.
    #[error(
        "{path} holds no memory, and files of others ({found}): name the directory of a memory, or an empty or new one, with \
         --data"
    )]
    Foreign {
        /// Which directory.
        path: String,
        /// Some of the files.
        found: String,
    },
    /// Another daemon has the directory.
    #[error("data directory {path} is in use by {holder}: stop it, or name another directory with --data")]
    Locked {
        /// Which directory.
        path: String,
        /// The daemon that has it, as it said itself.
        holder: String,
    },
    /// The directory belongs to a memory that was begun with another seed.
    #[error(
        "{path} holds a memory begun with seed = {kept}, and {given} was given: give the same or none, or begin another \
         memory in another directory"
    )]
    OtherSeed {
        /// Which directory.
        path: String,
        /// The seed that it was begun with.
        kept: u64,
        /// The seed that was given now.
        given: u64,
    },
    /// The memory lives under other parameters or another curriculum.
    #[error("{path} holds a memory that lives under other settings than are given:{}", listed(differences))]
    OtherSetting {
        /// Which directory.
        path: String,
        /// Each setting that differs: its name, its value there, and the value that was given.
        differences: Vec<(String, String, String)>,
    },
    /// A learner can't go on from what was read.
    #[error(transparent)]
    Learner(#[from] LearnerError),
    /// The manifest can't be understood.
    #[error("{path}: {problem}")]
    Manifest {
        /// The file.
        path: String,
        /// What is wrong.
        problem: String,
    },
    /// The disk took too long at the end.
    #[error(
        "the disk did not confirm the last {changes} changes of memory within {seconds} s, and the daemon waits no longer. \
         Under strict durability no reply left that rests on them"
    )]
    Slow {
        /// So many changes.
        changes: u64,
        /// How long was waited.
        seconds: u64,
    },
    /// Memory could not be written, so nothing more may be done.
    #[error("memory could not be written, so the daemon ends before anything more is done: {0}")]
    Failed(String),
}

/// So many differences are shown.
const DIFFERENCES_MAX: usize = 20;
/// The longest value that is shown whole, in characters.
const VALUE_CHARS_MAX: usize = 60;

/// The differences, and what can be done about them.
fn listed(differences: &[(String, String, String)]) -> String {
    let short = |text: &str| match text.char_indices().nth(VALUE_CHARS_MAX) {
        Some((at, _)) => format!("{}…", text.get(..at).unwrap_or_default()),
        None => text.to_owned(),
    };
    let shown = differences.iter().take(DIFFERENCES_MAX);
    let mut lines: Vec<String> = shown
        .map(|(key, kept, given)| format!("  {key}: {} there, {} given", short(kept), short(given)))
        .collect();
    if let Some(more) = differences.len().checked_sub(DIFFERENCES_MAX).filter(|more| *more > 0) {
        lines.push(format!("  and {more} more"));
    }
    if lines.is_empty() {
        lines.push("  the order of what they list".to_owned());
    }
    format!(
        "\n{}\nLeave out --curriculum, --config and --set to go on as it is. Add --change to go on under what is given, \
         from the first stage of the curriculum; what was learnt stays",
        lines.join("\n")
    )
}

impl StoreError {
    /// Whether the journal is damaged, or can't be replayed: what is before the damage can still be read.
    pub(crate) fn is_damage(&self) -> bool {
        let journal = matches!(
            self,
            Self::Journal(
                JournalError::Damaged { .. } | JournalError::Missing { .. } | JournalError::Gone { .. }
            )
        );
        journal || matches!(self, Self::Replay { .. })
    }

    pub(crate) fn disk(what: &'static str, path: String) -> impl FnOnce(io::Error) -> Self {
        move |error| Self::Disk { what, path, error }
    }
}
