//! What goes into a step and what comes out of it: a frame of a body, and what that body is to do.

use crate::nouns::curriculum::SceneCommand;
use crate::nouns::decision::Decision;
use crate::nouns::effect::Effect;
use crate::nouns::observation::Observation;
use crate::nouns::vocabulary::{BodyId, PrimitiveId};

/// What a body reports.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Which body.
    pub body: BodyId,
    /// How the last action, or arranging, went; none when nothing was asked.
    pub outcome: Option<ActionOutcome>,
    /// Everything it perceives, words heard since the last frame included.
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
}

/// What a step decided, and everything it changed.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// What the body is to do.
    pub output: Output,
    /// What changed, in order.
    pub effects: Vec<Effect>,
    /// Why, when an action was chosen.
    pub decision: Option<Decision>,
}

/// What a body is to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Output {
    /// Carry this out.
    Act(PrimitiveId),
    /// Arrange the surroundings so, in this order.
    Arrange(Vec<SceneCommand>),
    /// Nothing for now.
    Hold,
}
