//! Why nothing could be counted.

use std::io;
use std::path::PathBuf;

use crate::counted::Tally;

/// Why nothing could be counted.
#[derive(Debug, thiserror::Error)]
pub(crate) enum CountFailure {
    #[error("valgrind is not installed; `apt-get install valgrind` brings it")]
    NoValgrind,
    #[error("there is no file {path} with budgets; --rewrite counts and writes it", path = .0.display())]
    NoBudgets(PathBuf),
    #[error("there is no work {0:?}")]
    NoSuchWork(String),
    #[error("no directory for what is learnt: {0}")]
    Directory(io::Error),
    #[error("{path}: {problem}", path = .path.display())]
    File { path: PathBuf, problem: String },
    #[error("{command} in a process of its own: {problem}")]
    Process { command: String, problem: String },
    #[error("what a process printed can't be read: {0}")]
    Printed(#[from] serde_json::Error),
    #[error(
        "{work} is not the same work each time: natively {natively:?}, under callgrind {watched:?}. Something in it follows a \
         clock, an address or a random number without a seed"
    )]
    Unrepeatable { work: String, natively: Tally, watched: Tally },
    #[error("{path} has no instruction of {function}: the function was compiled into its caller, or renamed", path = .path.display())]
    Uncounted { path: PathBuf, function: &'static str },
    #[error("{work}: {problem}")]
    Work { work: &'static str, problem: String },
}

impl CountFailure {
    /// The failure of a part of `work`.
    pub(crate) fn of<E: ToString>(work: &'static str) -> impl FnOnce(E) -> Self {
        move |error| Self::Work { work, problem: error.to_string() }
    }

    /// The failure to read or write the file at `path`.
    pub(crate) fn file<E: ToString>(path: impl Into<PathBuf>) -> impl FnOnce(E) -> Self {
        move |error| Self::File { path: path.into(), problem: error.to_string() }
    }
}
