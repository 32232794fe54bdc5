//! A file of settings: how it is read, and how a mistake in it is reported with its place.

use std::io::Read;
use std::ops::Range;
use std::path::{Path, PathBuf};

use pschema_process::input;

/// Longest file read, in bytes: far more than any curriculum needs.
pub const FILE_BYTES_MAX: u64 = 1024 * 1024;

/// Why a file can't be used.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    /// It can't be read.
    #[error("cannot read {path}: {error}")]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        error: std::io::Error,
    },
    /// It is longer than any such file needs to be.
    #[error("{path} is longer than {FILE_BYTES_MAX} bytes: this is no file of settings")]
    TooLong {
        /// The file.
        path: PathBuf,
    },
    /// Two files of settings are to be read from stdin.
    #[error(
        "--config and --curriculum are both `-`, and stdin can be read once: name a file for one of them"
    )]
    StdinTwice,
    /// Something in it is wrong.
    #[error("{source_name}:{line}:{column}: {problem}")]
    Wrong {
        /// The file, or the built-in text.
        source_name: String,
        /// The line, from 1.
        line: usize,
        /// The column, in characters from 1.
        column: usize,
        /// What is wrong and what would be right.
        problem: String,
    },
    /// Neither a built-in curriculum nor a file.
    #[error(
        "no curriculum {name:?}: it is none of the built-in ones ({built_in}), and there is no such file"
    )]
    NoCurriculum {
        /// What was asked for.
        name: String,
        /// The names there are.
        built_in: String,
    },
}

/// A text of settings, with the name to report it by.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a> {
    pub(super) name: &'a str,
    pub(super) text: &'a str,
}

/// A mistake and where it is, in bytes from the start of the text.
#[derive(Debug)]
pub struct Mistake {
    at: Range<usize>,
    problem: String,
}

impl Mistake {
    /// A mistake at `at`: what is wrong, and what would be right.
    pub fn new(at: Range<usize>, problem: impl Into<String>) -> Self {
        Self { at, problem: problem.into() }
    }
}

impl<'a> Source<'a> {
    /// A text that is called `name` in reports.
    #[must_use]
    pub fn new(name: &'a str, text: &'a str) -> Self {
        Self { name, text }
    }

    /// The report of a mistake, with its line and column.
    #[must_use]
    pub fn wrong(&self, mistake: Mistake) -> ConfigError {
        let before = self.text.get(..mistake.at.start).unwrap_or(self.text);
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        ConfigError::Wrong {
            source_name: self.name.to_owned(),
            line: before.matches('\n').count() + 1,
            column: before.get(line_start..).unwrap_or("").chars().count() + 1,
            problem: mistake.problem,
        }
    }

    /// Reads the text as TOML.
    ///
    /// # Errors
    /// [`ConfigError::Wrong`] with the first mistake and its place.
    pub fn parse<T: serde::de::DeserializeOwned>(&self) -> Result<T, ConfigError> {
        toml::from_str(self.text).map_err(|error| {
            let at = error.span().unwrap_or(0..0);
            // The parser breaks its messages into lines; ours are one.
            self.wrong(Mistake::new(at, error.message().trim_end().replace('\n', ", ")))
        })
    }
}

/// The text of the file at `path`, of stdin where that is `-`, if it is no longer than [`FILE_BYTES_MAX`].
pub(super) fn read(path: &Path) -> Result<String, ConfigError> {
    let failed = |error| ConfigError::Read { path: path.to_owned(), error };
    let mut text = String::new();
    let file = input(path).map_err(failed)?;
    file.take(FILE_BYTES_MAX + 1).read_to_string(&mut text).map_err(failed)?;
    if text.len() as u64 > FILE_BYTES_MAX {
        return Err(ConfigError::TooLong { path: path.to_owned() });
    }
    Ok(text)
}
