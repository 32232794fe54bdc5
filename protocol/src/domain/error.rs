//! Why a domain could not be made or found.

use std::path::{Path, PathBuf};

/// Why a domain could not be made or found.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DomainError {
    /// The name of the learner is not one.
    #[error("{name:?} is no name for a learner: use 1 to 32 of a-z, 0-9, _ and -")]
    LearnerName {
        /// The name.
        name: String,
    },
    /// The runtime directory cannot be trusted or used.
    #[error("runtime directory {path}: {problem}")]
    Runtime {
        /// The directory.
        path: PathBuf,
        /// What is wrong and what to do.
        problem: String,
    },
    /// Another daemon serves this learner.
    #[error(
        "learner {name} is already served by process {pid}: stop that daemon first, or choose another --name"
    )]
    AlreadyServed {
        /// The learner.
        name: String,
        /// The process, as the lock file has it.
        pid: String,
    },
    /// No daemon serves this learner.
    #[error("no daemon serves learner {name} in {runtime}: start one with `pschema server --name {name}`")]
    NotServed {
        /// The learner.
        name: String,
        /// The runtime directory looked in.
        runtime: PathBuf,
    },
    /// The learner's daemon is not ready yet.
    #[error(
        "the daemon of learner {name}, process {pid}, is still starting, for which a long memory or a slow disk takes a while: \
         try again in a moment"
    )]
    Starting {
        /// The learner.
        name: String,
        /// The daemon's process, as the lock file has it.
        pid: String,
    },
    /// The daemon speaks another version of the protocol.
    #[error(
        "the daemon of learner {name} speaks protocol version {theirs}, this process version {ours}: use one release"
    )]
    Version {
        /// The learner.
        name: String,
        /// The daemon's version.
        theirs: u32,
        /// This build's version.
        ours: u32,
    },
    /// The domain file is damaged.
    #[error("{path} is damaged ({problem}): restart the daemon, it writes a new one")]
    Record {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
    /// Too little shared memory is left.
    #[error("/dev/shm has {available} bytes free, {needed} are needed: free some, or mount it larger")]
    SharedMemory {
        /// Bytes free.
        available: u64,
        /// Bytes needed.
        needed: u64,
    },
    /// The operating system refused.
    #[error("cannot {doing} {path}: {error}")]
    Io {
        /// What was being done.
        doing: &'static str,
        /// To what.
        path: PathBuf,
        /// What it said.
        error: std::io::Error,
    },
}

/// For `map_err`: an operating system error with what was being done to which file.
pub(crate) fn io(doing: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> DomainError {
    let path = path.to_owned();
    move |error| DomainError::Io { doing, path, error }
}
