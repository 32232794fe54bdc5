//! Version 1. Frozen: the order of fields and of variants is what stands on disk (see `docs/FORMAT.md`).
//!
//! Everything becomes a value of these types on its way to the disk and back, so that the learner's own types are
//! free to change.

mod content;
mod effect;
mod observation;
mod setting;
mod stage;
mod vocabulary;

use pschema_learner::frame;
use pschema_learner::vocabulary::BodyId;
use serde::{Deserialize, Serialize};

use observation::{Observation, back, list};
use stage::StageReport;
use vocabulary::{Body, Primitive};

pub(crate) use content::{Bounds, Facts, Reading, Remembered, Schema, Whole, blocks};
pub(crate) use effect::Effect;
pub(crate) use setting::{Curriculum, Parameters, Setting};

/// What is on disk cannot be what a learner knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0} on disk refers to something that is not there, or is beyond its limit")]
pub struct Impossible(pub(crate) &'static str);

/// The payload of one frame of the journal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Record {
    /// What one step, one order or one attachment changed.
    Batch {
        /// Steps taken, this one included.
        step: u64,
        /// When, by the machine's clock, in milliseconds since 1970: for people; nothing is decided by it.
        at_unix_ms: u64,
        /// What led to it.
        cause: Cause,
        /// What changed, in order.
        effects: Vec<Effect>,
    },
    /// The digest of memory at this place follows in a later frame, for it takes time; or never, when the daemon ended.
    Mark {
        /// Steps taken.
        step: u64,
    },
    /// What memory was at an earlier place.
    Digest {
        /// The frame of the [`Record::Mark`].
        mark: u64,
        /// Steps taken there.
        step: u64,
        /// The digest, in hexadecimal.
        digest: String,
    },
}

/// What led to a batch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Cause {
    /// A body of this name attached.
    Declared(String),
    /// An operator's order, as it was given.
    Order(String),
    /// A body's frame.
    Step(Input),
    /// Memory goes on under this from here: its effects say what that changed of it.
    Changed(Box<Setting>),
}

/// What a step was taken on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Input {
    body: u16,
    outcome: Option<Outcome>,
    observations: Vec<Observation>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Outcome {
    Done,
    Refused,
    Failed,
    TimedOut,
}

impl From<&frame::Frame> for Input {
    fn from(frame::Frame { body, outcome, observations }: &frame::Frame) -> Self {
        let outcome = outcome.map(|outcome| match outcome {
            frame::ActionOutcome::Done => Outcome::Done,
            frame::ActionOutcome::Refused => Outcome::Refused,
            frame::ActionOutcome::Failed => Outcome::Failed,
            frame::ActionOutcome::TimedOut => Outcome::TimedOut,
        });
        Self { body: body.0, outcome, observations: list(observations) }
    }
}

impl From<Input> for frame::Frame {
    fn from(Input { body, outcome, observations }: Input) -> Self {
        let outcome = outcome.map(|outcome| match outcome {
            Outcome::Done => frame::ActionOutcome::Done,
            Outcome::Refused => frame::ActionOutcome::Refused,
            Outcome::Failed => frame::ActionOutcome::Failed,
            Outcome::TimedOut => frame::ActionOutcome::TimedOut,
        });
        Self { body: BodyId(body), outcome, observations: back(observations) }
    }
}

/// The payload of one block of a snapshot. First [`Block::Facts`], then the others in this order, as many of each as the
/// facts say, then [`Block::End`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Block {
    /// What there is one of.
    Facts(Box<Facts>),
    /// Symbols.
    Symbols(Vec<String>),
    /// Primitives.
    Primitives(Vec<Primitive>),
    /// A body.
    Body(Body),
    /// What is left in a pool of the curriculum.
    Pool(Vec<i64>),
    /// What happened in a stage.
    Report(Box<StageReport>),
    /// Observations with their counts.
    Observations(Vec<Remembered>),
    /// Schemas.
    Schemas(Vec<Schema>),
    /// All of it has been read.
    End {
        /// The digest of memory, in hexadecimal.
        digest: String,
    },
}

/// A number on disk as an index. One that no list can have becomes one that no list has.
fn index(number: u64) -> usize {
    usize::try_from(number).unwrap_or(usize::MAX)
}
