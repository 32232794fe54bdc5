//! The messages of a session as plain values, after [`super::decode`] and before [`super::encode`].

use super::layout::{FrameHeader, HelloHead, Reason, Record};
use super::observations::Observations;
use crate::description::{Action, Description};
use crate::outcome::Outcome;

/// A body's introduction as it travels: the head and the repertoire's records.
#[derive(Clone, Debug, PartialEq)]
pub struct RawHello {
    /// The hello without the repertoire.
    pub head: Box<HelloHead>,
    /// The repertoire.
    pub primitives: Vec<Record>,
}

/// A frame as it travels: the header, as many records as it claims, and the reason.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RawFrame {
    /// The header.
    pub header: FrameHeader,
    /// Its observations.
    pub records: Vec<Record>,
    /// Why the last order was not carried out, if [`FrameHeader::has_reason`]; else it means nothing.
    pub reason: Reason,
}

/// A hello that passed every check.
#[derive(Clone, Debug, PartialEq)]
pub struct Introduction {
    /// Process of the body, as the body says. For people and logs only.
    pub pid: u32,
    /// The body.
    pub description: Description,
}

/// A frame that passed every check. Its observations stay in the copy that was checked.
#[derive(Clone, Debug)]
pub struct SensorFrame<'a> {
    /// The session it belongs to.
    pub session: u64,
    /// Its number in the session, from 1.
    pub sequence: u64,
    /// How the last order went: none in the first frame of a session and after a `wait`.
    pub report: Option<OrderReport>,
    /// What the body senses, in the order reported.
    pub observations: Observations<'a>,
}

/// How an order (action or scene command) went.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OrderReport {
    /// How the order went.
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

/// The daemon's answer to a hello, once checked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Admission {
    /// The session is open.
    Accepted {
        /// The session's number.
        session: u64,
        /// The learner's name.
        learner: String,
    },
    /// The body is not taken.
    Refused {
        /// The number of the refusal.
        code: u32,
        /// Why.
        reason: String,
    },
}
