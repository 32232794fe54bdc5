//! Goals and their pursuit, as part of memory, and the effects that change it.

use std::sync::Arc;

use crate::nouns::execution::ChainLink;
use crate::nouns::observation::{Pattern, TypeId};
use crate::nouns::policy::Policy;
use crate::nouns::vocabulary::BodyId;

/// What is to be observed: something for each of these patterns (one thing may do for several). Properties that a pattern leaves out may
/// have any value; a variable is the same value wherever it occurs.
pub type Patterns = [Pattern];

/// What is wanted.
#[derive(Clone, Debug, PartialEq)]
pub enum Goal {
    /// That this is observed.
    Observed(Vec<Pattern>),
    /// That this is brought about, though it may be so already: that it is observed after an action in whose lasting world state it
    /// was not.
    Again(Vec<Pattern>),
    /// As much as can be of the numbers that come with observations of this type, a value.
    Most(TypeId),
}

impl From<Vec<Pattern>> for Goal {
    /// That this is observed.
    fn from(patterns: Vec<Pattern>) -> Self {
        Self::Observed(patterns)
    }
}

impl Goal {
    /// What is to be observed; nothing of a goal that wants most of something.
    #[must_use]
    pub fn patterns(&self) -> &Patterns {
        match self {
            Self::Observed(patterns) | Self::Again(patterns) => patterns,
            Self::Most(_) => &[],
        }
    }

    /// Whether it wants that something is brought about which may be so already.
    #[must_use]
    pub fn is_again(&self) -> bool {
        matches!(self, Self::Again(_))
    }

    /// The type of which it wants most.
    #[must_use]
    pub fn most(&self) -> Option<TypeId> {
        match self {
            Self::Most(kind) => Some(*kind),
            Self::Observed(_) | Self::Again(_) => None,
        }
    }

    /// The types that it speaks of, in the order of its patterns.
    pub fn kinds(&self) -> impl Iterator<Item = TypeId> + '_ {
        self.patterns().iter().map(Pattern::kind).chain(self.most())
    }
}

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
    /// What is wanted; at most [`GOAL_PATTERNS_MAX`] patterns.
    pub goal: Goal,
    /// The number of actions that it may take, in 1..=[`GOAL_ACTIONS_MAX`].
    pub actions_max: u32,
    /// The number of actions that were sent for it, carried out or not.
    pub actions: u32,
    /// The sum of what came after these actions, if the goal wants most of it; else 0.
    pub came: f64,
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
    /// The probability that it brings the goal about, in 0..=1 (II-A: of the relevant components alone); 0 of one for most of something,
    /// which arrives nowhere.
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
    /// Most of something was wanted, and nothing that is known brings any of it from here, neither more nor less.
    NothingBringsAny,
}

/// A change of the goal that is pursued.
#[derive(Clone, Debug, PartialEq)]
pub enum PursuitEffect {
    /// A goal is pursued from now on.
    Begun {
        /// The body that is to pursue it.
        body: BodyId,
        /// What is wanted.
        goal: Goal,
        /// The number of actions that it may take.
        actions_max: u32,
    },
    /// A plan was made.
    Planned(PlanRecord),
    /// The policy of the present plan is made anew, by what is known by now.
    Revised(Arc<Policy>),
    /// An action was sent for the goal.
    Acted,
    /// So much came after such an action, of what most is wanted of.
    Came(f64),
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
    /// Most is wanted of what is no value.
    #[error(
        "{kind} is no value, so there is no most of it: a body declares a number that comes with its frames as a value{}",
        if values.is_empty() { ", and none does".to_owned() } else { format!("; there are {}", values.join(", ")) }
    )]
    NoValue {
        /// The type.
        kind: String,
        /// The types that are values.
        values: Vec<String>,
    },
    /// Most is wanted of something, and nothing weighs what claims foretell.
    #[error(
        "most of something is brought by a policy, and no policies are made: the mechanism `policies` is off, as it is under the profile \
         `paper`; it is on under the profile `full`"
    )]
    NoPolicies,
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
