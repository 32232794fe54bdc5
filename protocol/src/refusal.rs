//! Why a message was refused: a number for programs, and a sentence with figures for people.

use crate::limits::{OBSERVATIONS_MAX, PRIMITIVES_MAX, WAIT_MS_MAX};

/// Why a message did not pass its checks.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Refusal {
    /// The message does not begin with the protocol's magic word.
    #[error("not a pschema message: it begins with {found:#010x} instead of {expected:#010x}")]
    Magic {
        /// The word found.
        found: u32,
        /// The word that every message begins with.
        expected: u32,
    },
    /// The peer speaks another version of the protocol.
    #[error(
        "the peer speaks protocol version {theirs}, this process version {ours}: build both from one release"
    )]
    Version {
        /// The peer's version.
        theirs: u32,
        /// This build's version.
        ours: u32,
    },
    /// The frame names a session that is not the attached one.
    #[error("session {found} is not open (expected {expected}): attach again")]
    Session {
        /// The session named.
        found: u64,
        /// The session open, 0 for none.
        expected: u64,
    },
    /// The frame is a replay, or frames before it are missing.
    #[error("frame {found} is out of order: expected {expected}; attach again")]
    Sequence {
        /// The sequence found.
        found: u64,
        /// The sequence expected.
        expected: u64,
    },
    /// The frame's purpose is none of those defined.
    #[error("frame purpose {found} is unknown")]
    Purpose {
        /// The number found.
        found: u32,
    },
    /// The outcome is none of those defined.
    #[error("outcome {found} is unknown")]
    UnknownOutcome {
        /// The number found.
        found: u32,
    },
    /// The outcome does not answer the order given last.
    #[error(
        "the outcome answers the reply to frame {found}, but the order to answer for is that of frame {expected}"
    )]
    Answers {
        /// Sequence claimed.
        found: u64,
        /// Sequence of the last order, 0 for none.
        expected: u64,
    },
    /// A frame claims more observations than a frame may hold, or than came with it.
    #[error(
        "the frame claims {found} observations; it holds {held} and at most {OBSERVATIONS_MAX} are allowed"
    )]
    ObservationCount {
        /// Observations claimed.
        found: u32,
        /// Records that came with it.
        held: usize,
    },
    /// A record's index is beyond what was declared.
    #[error("{place}: index {found} is unknown, {declared} are declared")]
    UnknownIndex {
        /// Where.
        place: String,
        /// The index found.
        found: u16,
        /// How many there are.
        declared: usize,
    },
    /// A record has another number of values than was declared.
    #[error("{place}: {found} values, {declared} are declared")]
    ValueCount {
        /// Where.
        place: String,
        /// Values found.
        found: u16,
        /// Values declared.
        declared: usize,
    },
    /// A value is of another kind than was declared.
    #[error("{place}: {found} given where {declared} is declared")]
    ValueKind {
        /// Where.
        place: String,
        /// Kind found.
        found: String,
        /// Kind declared.
        declared: &'static str,
    },
    /// A value is outside what its property allows.
    #[error("{place} = {value} is outside {allowed}")]
    ValueRange {
        /// Where.
        place: String,
        /// The value.
        value: String,
        /// What is allowed.
        allowed: String,
    },
    /// A declaration has more of something than the protocol allows.
    #[error("{what}: {found}, at most {limit} are allowed")]
    TooMany {
        /// Of what.
        what: String,
        /// How many.
        found: usize,
        /// How many are allowed.
        limit: usize,
    },
    /// A name, or another text, cannot be used.
    #[error("{place}: {problem}")]
    Name {
        /// Where.
        place: String,
        /// What is wrong with it.
        problem: String,
    },
    /// Two things of one sort have the same name.
    #[error("{place}: the name {name:?} is used twice")]
    DuplicateName {
        /// Where.
        place: String,
        /// The name.
        name: String,
    },
    /// A property's declaration contradicts itself.
    #[error("{place}: {problem}")]
    Declaration {
        /// Where.
        place: String,
        /// What is wrong with it.
        problem: String,
    },
    /// The hello claims more primitives than came with it, or than are allowed.
    #[error(
        "the repertoire claims {found} primitives; it holds {held} and at most {PRIMITIVES_MAX} are allowed"
    )]
    PrimitiveCount {
        /// Primitives claimed.
        found: u32,
        /// Records that came with it.
        held: usize,
    },
    /// A reply's kind is none of those defined.
    #[error("reply kind {found} is unknown")]
    UnknownReply {
        /// The number found.
        found: u32,
    },
    /// A reply asks for too long a rest.
    #[error("asked to wait {found} ms, at most {WAIT_MS_MAX} ms are allowed")]
    WaitTooLong {
        /// Milliseconds asked.
        found: u32,
    },
    /// A page of a request or answer contradicts itself.
    #[error("page {page} of {pages}: {problem}")]
    Page {
        /// The page's number, from 0.
        page: u32,
        /// Pages claimed.
        pages: u32,
        /// What is wrong with it.
        problem: String,
    },
    /// A tool's request is none that this release knows.
    #[error("the question can't be read ({problem}): use tools and daemon of one release")]
    Request {
        /// What is wrong with it.
        problem: String,
    },
    /// The daemon does not take the message now, for a reason of its own.
    #[error("{reason}")]
    Unwilling {
        /// Why.
        reason: String,
    },
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

/// What the refusal with the number `code` is about, in a word or two. Refusals are counted under these words.
#[must_use]
pub fn reason(code: u32) -> &'static str {
    match code {
        1 => "magic",
        2 => "version",
        codes::SESSION => "session",
        codes::SEQUENCE => "sequence",
        5 => "purpose",
        6 => "unknown outcome",
        7 => "outcome of another order",
        8 => "observation count",
        9 => "unknown index",
        10 => "value count",
        11 => "value kind",
        12 => "value range",
        13 => "too many",
        14 => "name",
        15 => "duplicate name",
        16 => "declaration",
        17 => "primitive count",
        18 => "unknown reply",
        19 => "wait",
        20 => "page",
        codes::UNWILLING => "unwilling",
        22 => "request",
        _ => "unknown",
    }
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
