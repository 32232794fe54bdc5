//! Changes of memory, which are handed over to be kept, and when a change counts as kept.

use std::fmt;

use pschema_learner::Frame;
use pschema_learner::effect::Effect;

use crate::format::mirror::{Mirror, list};
use crate::format::v1;

/// When a reply may leave.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Durability {
    /// As soon as the step that led to it is durable.
    #[default]
    Strict,
    /// At once. Up to a second of steps is lost when the machine loses power. For simulations.
    Relaxed,
}

impl fmt::Display for Durability {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str(match self {
            Self::Strict => "strict",
            Self::Relaxed => "relaxed",
        })
    }
}

/// What led to a change of memory.
#[derive(Clone, Copy, Debug)]
pub enum Cause<'a> {
    /// A body of this name attached.
    Declared(&'a str),
    /// An operator's order, as text.
    Order(&'a str),
    /// A frame, on which a step was taken.
    Step(&'a Frame),
}

/// What one step, one order or one attachment changed.
#[derive(Clone, Copy, Debug)]
pub struct Change<'a> {
    /// What led to the change.
    pub cause: Cause<'a>,
    /// The time of the change, in milliseconds since 1970. It is for people: nothing is decided by it, so a clock that jumps
    /// does no harm.
    pub at_unix_ms: u64,
    /// The effects, in the order in which they were applied.
    pub effects: &'a [Effect],
}

impl Change<'_> {
    /// The record of the journal for this change; `step` is how many steps had been taken after it.
    pub(crate) fn record(&self, step: u64) -> v1::Record {
        let cause = match self.cause {
            Cause::Declared(body) => v1::Cause::Declared(body.to_owned()),
            Cause::Order(order) => v1::Cause::Order(order.to_owned()),
            Cause::Step(frame) => v1::Cause::Step(Mirror::of(frame)),
        };
        v1::Record::Batch { step, at_unix_ms: self.at_unix_ms, cause, effects: list(self.effects) }
    }
}
