//! Frames of a body, which go into a step, and the action of the body, which comes out of it.

use crate::nouns::curriculum::SceneCommand;
use crate::nouns::decision::Decision;
use crate::nouns::effect::Effect;
use crate::nouns::observation::Observation;
use crate::nouns::vocabulary::{BodyId, PrimitiveId};

/// The report of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// The body that reports.
    pub body: BodyId,
    /// How the last action, or the arranging, went; none when the body was asked for nothing.
    pub outcome: Option<ActionOutcome>,
    /// The observations that the body makes, in any order, words heard since the last frame included.
    pub observations: Vec<Observation>,
}

/// How an action went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ActionOutcome {
    /// Carried out.
    Done,
    /// Not begun.
    Refused,
    /// Begun and not completed.
    Failed,
    /// Not completed in time.
    TimedOut,
    /// Not carried out: the episode had ended, so that nothing leads on from the frame before, and this frame begins a new one.
    EpisodeEnded,
    /// Not carried out: the episode was cut off from outside (a time limit, a person), and this frame begins a new one.
    EpisodeCut,
}

impl ActionOutcome {
    /// Whether the frame begins a new episode: nothing in it came of what was done before.
    #[must_use]
    pub fn begins_episode(self) -> bool {
        matches!(self, Self::EpisodeEnded | Self::EpisodeCut)
    }
}

/// The result of a step: the next action of the body, and every change of memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// The next action of the body.
    pub output: Output,
    /// The changes of memory, in the order in which they were applied.
    pub effects: Vec<Effect>,
    /// The decision, when an action was chosen.
    pub decision: Option<Decision>,
}

/// The next action of a body.
#[derive(Clone, Debug, PartialEq)]
pub enum Output {
    /// The body is to carry out this primitive.
    Act(PrimitiveId),
    /// The surroundings are to be arranged by these commands, in this order.
    Arrange(Vec<SceneCommand>),
    /// Nothing for now.
    Hold,
}
