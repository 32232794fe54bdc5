//! The messages of a session as plain values, after [`crate::decode`] and before [`crate::encode`].

use crate::body::{Outcome, SensedObservation};
use crate::description::{Action, Description};
use crate::observed::Observed;
use crate::wire::{FrameHeader, HelloHead, Record};

/// A body's introduction as it travels: the head and the repertoire's records.
#[derive(Clone, Debug, PartialEq)]
pub struct RawHello {
    /// Everything but the repertoire.
    pub head: Box<HelloHead>,
    /// The repertoire.
    pub primitives: Vec<Record>,
}

/// A frame as it travels: the header and as many records as it claims.
#[derive(Clone, Debug, PartialEq)]
pub struct RawFrame {
    /// What the frame says of itself.
    pub header: FrameHeader,
    /// Its observations.
    pub records: Vec<Record>,
}

/// A hello that passed every check.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckedHello {
    /// Process of the body, as it says. For people and logs only.
    pub pid: u32,
    /// The body.
    pub description: Description,
}

/// A frame that passed every check, its observations where they came to.
#[derive(Clone, Copy, Debug)]
pub struct Checked<'a> {
    /// The session it belongs to.
    pub session: u64,
    /// Its number in the session, from 1.
    pub sequence: u64,
    /// How the last order went: none in the first frame of a session and after a `wait`.
    pub report: Option<Report>,
    /// What the body senses, in the order reported.
    pub observations: Observed<'a>,
}

/// The same, for who keeps it.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckedFrame {
    /// The session it belongs to.
    pub session: u64,
    /// Its number in the session, from 1.
    pub sequence: u64,
    /// How the last order went: none in the first frame of a session and after a `wait`.
    pub report: Option<Report>,
    /// What the body senses, in the order reported.
    pub observations: Vec<SensedObservation>,
}

/// How an order (action or scene command) went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Report {
    /// How it went.
    pub outcome: Outcome,
    /// Sequence of the frame whose reply gave the order.
    pub answers: u64,
}

/// What the daemon replies to a frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Reply {
    /// Carry this action out.
    Act(Action),
    /// Arrange the surroundings by this scene command.
    Arrange(Action),
    /// Rest, then send a fresh frame.
    Wait {
        /// How long, in milliseconds: at most [`crate::limits::WAIT_MS_MAX`].
        ms: u32,
    },
    /// The frame was not taken.
    Refused {
        /// The number of the refusal.
        code: u32,
        /// Why, for people.
        reason: String,
    },
    /// Leave.
    Detach,
}
