//! What is handed over to be kept, and when that counts as done.

use std::fmt;

use pschema_learner::Frame;
use pschema_learner::effect::Effect;

use crate::format::v1;

/// When a reply may leave.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Durability {
    /// When the step that led to it is durable.
    #[default]
    Strict,
    /// At once; up to a second of steps is lost with the machine's power. For simulations.
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
    /// What led to it.
    pub cause: Cause<'a>,
    /// When, in milliseconds since 1970. For people: nothing is decided by it, so a clock that jumps does no harm.
    pub at_unix_ms: u64,
    /// What changed, in order.
    pub effects: &'a [Effect],
}

impl Change<'_> {
    /// As it stands on disk; `step` counts this one.
    pub(crate) fn record(&self, step: u64) -> v1::Record {
        let cause = match self.cause {
            Cause::Declared(body) => v1::Cause::Declared(body.to_owned()),
            Cause::Order(order) => v1::Cause::Order(order.to_owned()),
            Cause::Step(frame) => v1::Cause::Step(frame.into()),
        };
        let effects = self.effects.iter().map(v1::Effect::from).collect();
        v1::Record::Batch { step, at_unix_ms: self.at_unix_ms, cause, effects }
    }
}
