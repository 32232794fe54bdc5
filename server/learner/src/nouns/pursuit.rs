//! Goals and their pursuit, as part of memory, and the effects that change it.

use std::sync::Arc;

use crate::nouns::execution::ChainLink;
use crate::nouns::observation::Pattern;
use crate::nouns::policy::Policy;
use crate::nouns::vocabulary::BodyId;

/// A goal: an observation is to be brought about for each of these patterns (one may do for several). Properties that a pattern leaves
/// out may have any value; a variable is the same value wherever it occurs in the goal.
pub type Goal = [Pattern];

/// How many patterns one goal may have.
pub const GOAL_PATTERNS_MAX: usize = 8;

/// How many plans of a pursuit are remembered: the last of them.
pub const PLANS_KEPT_MAX: usize = 32;

/// How many actions a goal may be given.
pub const GOAL_ACTIONS_MAX: u32 = 100_000;

/// A goal that is pursued, or was the last to be.
#[derive(Clone, Debug, PartialEq)]
pub struct Pursuit {
    /// Goals are numbered from 1 in the life of a memory.
    pub number: u64,
    /// The body that pursues it.
    pub body: BodyId,
    /// The patterns of the goal; at most [`GOAL_PATTERNS_MAX`].
    pub goal: Vec<Pattern>,
    /// The number of actions that it may take, in 1..=[`GOAL_ACTIONS_MAX`].
    pub actions_max: u32,
    /// The number of actions that were sent for it, carried out or not.
    pub actions: u32,
    /// The number of plans that were made for it.
    pub plans_made: u32,
    /// The last of them, at most [`PLANS_KEPT_MAX`], the present one at the end.
    pub plans: Vec<Arc<PlanRecord>>,
    /// How it ended; none while it is pursued.
    pub ended: Option<Ending>,
}

/// A plan made in pursuit of a goal.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanRecord {
    /// The number of actions that had been sent for the goal when it was made.
    pub after_actions: u32,
    /// Why it was made.
    pub because: PlanCause,
    /// The schemas to execute, in order; none of a policy.
    pub chain: Vec<ChainLink>,
    /// What to do where, when the plan is made of what claims foretell.
    pub policy: Option<Arc<Policy>>,
    /// The probability that it brings the goal about, in 0..=1 (II-A: of the relevant components alone).
    pub probability: f64,
    /// Whether the search for it used up its budget.
    pub truncated: bool,
}

/// Why a plan was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlanCause {
    /// It is the first.
    First,
    /// The last schema of the plan before was executed, and the goal does not hold.
    NotReached,
    /// The last step's outcome does not allow the next schema.
    NextNotAllowed,
    /// The body did not carry out the action.
    NotCarriedOut,
    /// The execution under way was dropped: the learner was held, the body was away, or a new episode began.
    Interrupted,
}

/// How the pursuit of a goal ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// The goal holds.
    Achieved,
    /// Nothing known leads there from here.
    NothingLeadsThere,
    /// It does not hold after all the actions that it was given.
    ActionsUsedUp,
    /// The present stage does not lift a type that the goal speaks of, so it could not be seen to hold.
    Constrained,
    /// It was called off.
    Cancelled,
    /// Nothing leads there as far as was looked, and there is more that was not looked at.
    FurtherThanLooked,
}

/// A change of the goal that is pursued.
#[derive(Clone, Debug, PartialEq)]
pub enum PursuitEffect {
    /// A goal is pursued from now on.
    Begun {
        /// The body that is to pursue it.
        body: BodyId,
        /// The patterns of the goal.
        goal: Vec<Pattern>,
        /// The number of actions that it may take.
        actions_max: u32,
    },
    /// A plan was made.
    Planned(PlanRecord),
    /// The policy of the present plan is made anew, by what is known by now.
    Revised(Arc<Policy>),
    /// An action was sent for the goal.
    Acted,
    /// It is pursued no more.
    Ended(Ending),
}

/// Why a goal can't be pursued, or not be called off.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PursueError {
    /// It asks for nothing.
    #[error("a goal needs something to be observed: give at least one pattern, such as touch{{}}")]
    Empty,
    /// It asks for too much.
    #[error("the goal has {given} patterns; at most {GOAL_PATTERNS_MAX} are taken")]
    Long {
        /// How many patterns it has.
        given: usize,
    },
    /// It may take no action, or too many.
    #[error("a goal may take 1 to {GOAL_ACTIONS_MAX} actions, not {given}")]
    Actions {
        /// How many it was given.
        given: u32,
    },
    /// No body of that number was declared, or it can do nothing.
    #[error("the body has nothing that it can do, so it can pursue no goal")]
    Body,
    /// Another is pursued.
    #[error("goal {number} is pursued, {goal}: wait for its end, or cancel it")]
    Busy {
        /// Its number.
        number: u64,
        /// What it asks for, as it prints.
        goal: String,
    },
    /// An operator holds the learner.
    #[error("an operator holds the learner: let it go on with `pschema stage resume`")]
    Held,
    /// The present stage does not lift a type of it.
    #[error("stage {stage:?} does not lift {kind}, so the goal could never be seen to hold")]
    Constrained {
        /// The present stage.
        stage: String,
        /// The type.
        kind: String,
    },
    /// There is nothing to call off.
    #[error("no goal is pursued")]
    Nothing,
}

impl Pursuit {
    /// Whether it is still pursued.
    #[must_use]
    pub fn under_way(&self) -> bool {
        self.ended.is_none()
    }
}
