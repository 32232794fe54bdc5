//! Files that describe a world or an arm: TOML, checked value by value as it is read, so that an error names line and
//! column.

use std::fmt;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use pschema_protocol::limits::NAME_BYTES_MAX;
use serde::de::DeserializeOwned;
use thiserror::Error;

/// A kind of file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileKind {
    /// What a person calls such a file.
    pub name: &'static str,
    /// Largest file read, in bytes.
    pub bytes_max: u64,
    /// What to do when a file cannot be read.
    pub advice: &'static str,
}

impl fmt::Display for FileKind {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str(self.name)
    }
}

/// Why a file cannot be used.
#[derive(Debug, Error)]
pub enum FileError {
    /// The file cannot be read.
    #[error("cannot read {kind} {path}: {source}; {}", kind.advice)]
    Read {
        /// The kind of file.
        kind: FileKind,
        /// Path of the file.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// The file is too large to be of its kind.
    #[error("{kind} {path} is larger than {} bytes: this is no {kind}", kind.bytes_max)]
    TooLarge {
        /// The kind of file.
        kind: FileKind,
        /// Path of the file.
        path: PathBuf,
    },
    /// The text is not of that kind: syntax, unknown key, or value out of range.
    #[error("{kind} {name}: {source}")]
    Parse {
        /// The kind of file.
        kind: FileKind,
        /// Name of the file.
        name: String,
        /// The mistake, with line and column.
        source: Box<toml::de::Error>,
    },
    /// Each value is allowed, but they do not fit together.
    #[error("{kind} {name}{place}: {problem}")]
    Inconsistent {
        /// The kind of file.
        kind: FileKind,
        /// Name of the file.
        name: String,
        /// Line and column, when one place is to blame.
        place: String,
        /// The values that do not fit, with figures, and the change that would help.
        problem: String,
    },
}

impl FileKind {
    /// Reads the text of a file of this kind, or of stdin where `path` is `-`.
    ///
    /// # Errors
    /// When the file cannot be read, or is too large.
    pub fn read(self, path: &Path) -> Result<String, FileError> {
        let failed = |source| FileError::Read { kind: self, path: path.to_owned(), source };
        let from: Box<dyn Read> = match path.to_str() {
            Some("-") => Box::new(io::stdin().lock()),
            _ => Box::new(File::open(path).map_err(failed)?),
        };
        let mut text = String::new();
        // A pipe does not say how long it is.
        from.take(self.bytes_max + 1).read_to_string(&mut text).map_err(failed)?;
        if text.len() as u64 > self.bytes_max {
            return Err(FileError::TooLarge { kind: self, path: path.to_owned() });
        }
        Ok(text)
    }

    /// Reads a file of this kind from its text; `name` is for error messages.
    ///
    /// # Errors
    /// When the text is not of this kind; the message has line and column.
    pub fn parse<T: DeserializeOwned>(self, name: &str, text: &str) -> Result<T, FileError> {
        let wrong = |source| FileError::Parse { kind: self, name: name.to_owned(), source: Box::new(source) };
        toml::from_str(text).map_err(wrong)
    }

    /// The error that values of a file do not fit together. `text` and `byte` are the place that is to blame, if one is.
    #[must_use]
    pub fn inconsistent(self, name: &str, place: Option<(&str, usize)>, problem: String) -> FileError {
        let place = place.map(|(text, byte)| line_and_column(text, byte)).unwrap_or_default();
        FileError::Inconsistent { kind: self, name: name.to_owned(), place, problem }
    }
}

/// Line and column of a byte of a text, as they are put into messages.
fn line_and_column(text: &str, byte: usize) -> String {
    let before = text.get(..byte).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
    format!(" at line {line}, column {column}")
}

/// Checks the names of a list of a file: there are 1 to `max`, each has an allowed length and is given once.
///
/// # Errors
/// The first name that is wrong, or their number.
pub fn check_names(list: &str, names: &[&String], max: usize) -> Result<(), String> {
    if names.is_empty() || names.len() > max {
        return Err(format!("{} {list}: there must be 1 to {max}", names.len()));
    }
    for (index, name) in names.iter().enumerate() {
        if name.is_empty() || name.len() > NAME_BYTES_MAX {
            return Err(format!("a name in {list} has {} bytes: must be 1 to {NAME_BYTES_MAX}", name.len()));
        }
        if names[..index].contains(name) {
            return Err(format!("{list}: the name {name:?} is given twice; each must be its own"));
        }
    }
    Ok(())
}
