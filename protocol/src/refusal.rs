//! Why a message was refused: a number for programs, and a sentence with figures for people.

use crate::limits::{OBSERVATIONS_MAX, PRIMITIVES_MAX, WAIT_MS_MAX};

/// Why a message did not pass its checks.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the sentence of each variant says what its fields are")]
pub enum Refusal {
    /// The message does not begin with the protocol's magic word.
    #[error("not a pschema message: it begins with {found:#010x} instead of {expected:#010x}")]
    Magic { found: u32, expected: u32 },
    /// The peer speaks another version of the protocol.
    #[error(
        "the peer speaks protocol version {theirs}, this process version {ours}: build both from one release"
    )]
    Version { theirs: u32, ours: u32 },
    /// The frame names a session that is not the attached one.
    #[error("session {found} is not open (expected {expected}): attach again")]
    Session {
        found: u64,
        /// The session open, 0 for none.
        expected: u64,
    },
    /// The frame is a replay, or frames before it are missing.
    #[error("frame {found} is out of order: expected {expected}; attach again")]
    Sequence { found: u64, expected: u64 },
    /// The frame's purpose is none of those defined.
    #[error("frame purpose {found} is unknown")]
    Purpose { found: u32 },
    /// The outcome is none of those defined.
    #[error("outcome {found} is unknown")]
    UnknownOutcome { found: u32 },
    /// The outcome does not answer the order given last.
    #[error(
        "the outcome answers the reply to frame {found}, but the order to answer for is that of frame {expected}"
    )]
    Answers {
        found: u64,
        /// Sequence of the last order, 0 for none.
        expected: u64,
    },
    /// A frame claims more observations than a frame may hold, or than came with it.
    #[error(
        "the frame claims {found} observations; it holds {held} and at most {OBSERVATIONS_MAX} are allowed"
    )]
    ObservationCount { found: u32, held: usize },
    /// A record's index is beyond what was declared.
    #[error("{place}: index {found} is unknown, {declared} are declared")]
    UnknownIndex { place: String, found: u16, declared: usize },
    /// A record has another number of values than was declared.
    #[error("{place}: {found} values, {declared} are declared")]
    ValueCount { place: String, found: u16, declared: usize },
    /// A value is of another kind than was declared.
    #[error("{place}: {found} given where {declared} is declared")]
    ValueKind { place: String, found: String, declared: &'static str },
    /// A value is outside what its property allows.
    #[error("{place} = {value} is outside {allowed}")]
    ValueRange { place: String, value: String, allowed: String },
    /// A declaration has more of something than the protocol allows.
    #[error("{what}: {found}, at most {limit} are allowed")]
    TooMany { what: String, found: usize, limit: usize },
    /// A name, or another text, cannot be used.
    #[error("{place}: {problem}")]
    Name { place: String, problem: String },
    /// Two things of one sort have the same name.
    #[error("{place}: the name {name:?} is used twice")]
    DuplicateName { place: String, name: String },
    /// A property's declaration contradicts itself.
    #[error("{place}: {problem}")]
    Declaration { place: String, problem: String },
    /// The hello claims more primitives than came with it, or than are allowed.
    #[error(
        "the repertoire claims {found} primitives; it holds {held} and at most {PRIMITIVES_MAX} are allowed"
    )]
    PrimitiveCount { found: u32, held: usize },
    /// A reply's kind is none of those defined.
    #[error("reply kind {found} is unknown")]
    UnknownReply { found: u32 },
    /// A reply asks for too long a rest.
    #[error("asked to wait {found} ms, at most {WAIT_MS_MAX} ms are allowed")]
    WaitTooLong { found: u32 },
    /// A page of a request or answer contradicts itself.
    #[error("page {page} of {pages}: {problem}")]
    Page {
        /// The page's number, from 0.
        page: u32,
        pages: u32,
        problem: String,
    },
    /// A tool's request is none that this release knows.
    #[error("the question can't be read ({problem}): use tools and daemon of one release")]
    Request { problem: String },
    /// The daemon does not take the message now, for a reason of its own.
    #[error("{reason}")]
    Unwilling { reason: String },
}

impl Refusal {
    /// The number that stands for this refusal on the wire; above zero and never reused.
    #[must_use]
    pub fn code(&self) -> u32 {
        match self {
            Self::Magic { .. } => 1,
            Self::Version { .. } => 2,
            Self::Session { .. } => codes::SESSION,
            Self::Sequence { .. } => codes::SEQUENCE,
            Self::Purpose { .. } => 5,
            Self::UnknownOutcome { .. } => 6,
            Self::Answers { .. } => 7,
            Self::ObservationCount { .. } => 8,
            Self::UnknownIndex { .. } => 9,
            Self::ValueCount { .. } => 10,
            Self::ValueKind { .. } => 11,
            Self::ValueRange { .. } => 12,
            Self::TooMany { .. } => 13,
            Self::Name { .. } => 14,
            Self::DuplicateName { .. } => 15,
            Self::Declaration { .. } => 16,
            Self::PrimitiveCount { .. } => 17,
            Self::UnknownReply { .. } => 18,
            Self::WaitTooLong { .. } => 19,
            Self::Page { .. } => 20,
            Self::Unwilling { .. } => codes::UNWILLING,
            Self::Request { .. } => 22,
        }
    }
}

/// The word or two that each refusal is about, in the order of their numbers, from 1.
const REASONS: [&str; 22] = [
    "magic",
    "version",
    "session",
    "sequence",
    "purpose",
    "unknown outcome",
    "outcome of another order",
    "observation count",
    "unknown index",
    "value count",
    "value kind",
    "value range",
    "too many",
    "name",
    "duplicate name",
    "declaration",
    "primitive count",
    "unknown reply",
    "wait",
    "page",
    "unwilling",
    "request",
];

/// What the refusal with the number `code` is about, in a word or two. Refusals are counted under these words.
#[must_use]
pub fn reason(code: u32) -> &'static str {
    let index = usize::try_from(code).ok().and_then(|code| code.checked_sub(1));
    index.and_then(|index| REASONS.get(index)).copied().unwrap_or("unknown")
}

/// The numbers of refusals that a peer acts on.
pub mod codes {
    /// The session is not open: attach again.
    pub const SESSION: u32 = 3;
    /// A frame is out of order: attach again.
    pub const SEQUENCE: u32 = 4;
    /// The daemon is unwilling for a reason of its own; trying later may help.
    pub const UNWILLING: u32 = 21;
}
