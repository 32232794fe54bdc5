//! The ways out: stdout, how to emphasise on it, and the outputs that a person names.

use std::io::{self, IsTerminal, Write};
use std::path::Path;

use pschema_process::{Stream, colour_is_wanted, unread};
use serde::Serialize;

use crate::failure::Failure;

/// The path of this process's stdout.
const STDOUT: &str = "/dev/stdout";

/// Prints a result on stdout, whole or not at all as far as this process can tell.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    let written = Stream::stdout().and_then(|mut stdout| stdout.write_all(text.as_bytes()));
    written.map_err(|error| match error.kind() {
        io::ErrorKind::BrokenPipe => Failure::NobodyReads,
        _ if unread(&error) => Failure::Interrupted,
        _ => Failure::Failed(format!("cannot write to stdout: {error}")),
    })
}

/// Prints a result: as JSON when `json` is set, else as the text for people.
///
/// # Errors
/// When stdout can't be written, or nobody reads it any more.
pub fn show<T: Serialize>(json: bool, value: &T, text: impl FnOnce(&T) -> String) -> Result<(), Failure> {
    if json { print_json(value) } else { print(&text(value)) }
}

/// The path of an output that a person named: `-` is stdout.
pub(crate) fn named(path: &Path) -> &Path {
    if path == Path::new("-") { Path::new(STDOUT) } else { path }
}

/// Whether a person named stdout.
pub(crate) fn is_stdout(path: &Path) -> bool {
    named(path) == Path::new(STDOUT)
}

/// Prints a value as JSON, over several lines.
pub(crate) fn print_json(value: &impl Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(value).map_err(Failure::of)?;
    print(&(text + "\n"))
}

/// Prints a value as JSON on one line.
pub(crate) fn print_json_line(value: &impl Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string(value).map_err(Failure::of)?;
    print(&(text + "\n"))
}

/// Emphasis for people, plain text for everything else.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Style {
    colour: bool,
}

impl Style {
    /// Emphasis where stdout is a terminal that wants it.
    pub(crate) fn of_stdout() -> Self {
        Self { colour: io::stdout().is_terminal() && colour_is_wanted() }
    }

    /// No emphasis.
    #[cfg(test)]
    pub(crate) fn plain() -> Self {
        Self { colour: false }
    }

    pub(crate) fn bold(self, text: &str) -> String {
        self.with("1", text)
    }

    pub(crate) fn good(self, text: &str) -> String {
        self.with("32", text)
    }

    pub(crate) fn bad(self, text: &str) -> String {
        self.with("31", text)
    }

    fn with(self, code: &str, text: &str) -> String {
        if self.colour { format!("\x1b[{code}m{text}\x1b[0m") } else { text.to_owned() }
    }
}
