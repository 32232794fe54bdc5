//! Why something that was read can't be the content of a memory.

use std::fmt::Display;

/// Why something that was read can't be the content of a memory, in words. Whoever reads a file is told where in the file it
/// was; nobody decides anything by the kind of the mistake.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ContentError(String);

impl ContentError {
    /// The mistake in a sentence of its own.
    pub(crate) fn new(problem: impl Display) -> Self {
        Self(problem.to_string())
    }

    /// There is one item of this kind in a memory, and here is another.
    pub(crate) fn second(item: &str) -> Self {
        Self(format!("a second `{item}`"))
    }

    /// An item without which there is no memory is not there.
    pub(crate) fn missing(item: &str) -> Self {
        Self(format!("there is no `{item}`: something is missing"))
    }

    /// A value, or a number of values, that is not allowed there.
    pub(crate) fn value(what: &str) -> Self {
        Self(format!("{what} is out of range, or of another kind"))
    }

    /// More than a memory has room for.
    pub(crate) fn limit(what: &str, limit: usize) -> Self {
        Self(format!("there are more than {limit} {what}, the limit"))
    }
}
