//! Goals: what would happen, how something could be brought about, and bringing it about.

use serde::{Deserialize, Serialize};

use crate::claims::Foretold;
use crate::closed_set::closed_set;
use crate::notation::{Condition, ObservationText};
use crate::schema::SchemaInUse;

/// What an action would do in the world as it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Prediction {
    /// The body that would do it.
    pub body: String,
    /// The primitive as it prints.
    pub action: String,
    /// What is perceived, under the constraints of the present stage.
    pub world: Vec<ObservationText>,
    /// How often the primitive was asked for.
    pub attempts: u32,
    /// How often the body carried it out.
    pub carried_out: u32,
    /// The schema that predicts it; none when nothing that is known holds here.
    pub schema: Option<SchemaInUse>,
    /// Each outcome with its count, the rarer ones included. Where claims are kept, those of a type are counted by what claims
    /// foretell: an observation occurred as often as all the joint outcomes that have it together.
    pub outcomes: Vec<Condition>,
    /// What claims foretell; left out where they foretell nothing, or none are kept.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub claims: Vec<Foretold>,
}

/// What is wanted.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Wanted {
    /// The patterns that are to be observed, as they print; none where most of something is wanted.
    pub goal: Vec<String>,
    /// Whether that is to be brought about though it may be so already; left out if not.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub again: bool,
    /// The value of which most is wanted; left out where patterns are to be observed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub most: Option<String>,
}

closed_set! {
    /// What came of looking for a plan.
    PlanState {
        /// The goal holds, and there is nothing to do.
        HoldsAlready = "holds already",
        /// A plan was found.
        Found = "found",
        /// No chain of schemas that are known brings the goal about from here, and no policy.
        NothingLeadsThere = "nothing known leads there",
        /// None was found as far as was looked, and there is more.
        FurtherThanLooked = "further than looked",
        /// Nothing that is known brings any of that of which most is wanted from here.
        NothingBringsAny = "nothing known brings any",
    }
}

/// How a goal could be brought about.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Plan {
    /// The body that would do it.
    pub body: String,
    /// What is wanted.
    #[serde(flatten)]
    pub wanted: Wanted,
    /// What is perceived, under the constraints of the present stage.
    pub world: Vec<ObservationText>,
    /// What came of looking for a plan.
    pub state: PlanState,
    /// The probability that the plan brings the goal about: the product of those of its steps, or that of the policy, whatever
    /// its actions lead to; none without a plan, and 0 where most of something is wanted, for that arrives nowhere.
    pub probability: Option<f64>,
    /// Where most of something is wanted, what is expected to come from here on, what comes with each further action counted 0.99 times as
    /// much, and nothing after the end of the episode; else left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected: Option<f64>,
    /// The number of actions that the policy is expected to take; left out of a plan that is a chain of schemas, and where most of
    /// something is wanted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected_actions: Option<f64>,
    /// The number of contexts for which the policy says what to do; left out of a plan that is a chain of schemas.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contexts: Option<u32>,
    /// The steps in order. Of a policy, the actions to the goal when all comes about that is most likely; fewer where a context would
    /// come again first.
    pub steps: Vec<PlanStep>,
    /// Whether the search used up its budget, so that there may be a (better) plan.
    pub search_truncated: bool,
}

/// One step of a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PlanStep {
    /// The primitive, as it prints.
    pub action: String,
    /// The schema; none where a policy asks for a primitive that no schema covers.
    pub schema: Option<SchemaInUse>,
    /// What the goal or later steps rely on. What is `absent` is relied on not to happen. Of a policy, what is foretold to change: what is
    /// `absent` is foretold to be there no longer.
    pub relies_on: Vec<Condition>,
    /// Of a generalised schema, the outcomes of its carrier that are its target.
    pub through: Vec<Condition>,
    /// How reliably the body carries the action out.
    pub reliability: f64,
    /// `reliability` times the probabilities of what it goes through and of what is relied on; of a policy, the probability of what is
    /// most likely.
    pub probability: f64,
}

closed_set! {
    /// How a goal is doing, or how its pursuit ended.
    PursuitState {
        /// It is pursued.
        Pursued = "pursued",
        /// It was brought about.
        Achieved = "achieved",
        /// It was given up: no chain of schemas that are known brings it about, and no policy.
        NothingLeadsThere = "nothing known leads there",
        /// It was given up: no way was found as far as was looked, and there is more.
        FurtherThanLooked = "further than looked",
        /// It does not hold after all the actions that it might take; or most of something was brought with so many.
        ActionsUsedUp = "actions used up",
        /// It was given up: nothing that is known brings any of that of which most is wanted, neither more nor less.
        NothingBringsAny = "nothing known brings any",
        /// It was given up: the stage entered meanwhile does not lift what the goal speaks of.
        Constrained = "constrained",
        /// It was called off.
        Cancelled = "cancelled",
    }
}

/// The goal that is pursued, or was the last to be.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Pursuit {
    /// Its number, from 1 in the life of a memory.
    pub number: u64,
    /// The body that pursues it.
    pub body: String,
    /// What is wanted.
    #[serde(flatten)]
    pub wanted: Wanted,
    /// How it is doing, or how its pursuit ended.
    pub state: PursuitState,
    /// Whether it was achieved. There is always more of which most is wanted: that is never achieved.
    pub achieved: bool,
    /// The sum of what came after the actions sent for it, where most of something is wanted; else left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub came: Option<f64>,
    /// Actions sent for it.
    pub actions: u32,
    /// Actions that it may take.
    pub actions_max: u32,
    /// Plans made for it.
    pub plans_made: u32,
    /// The last of them, at most 32, in order.
    pub plans: Vec<PursuitPlan>,
}

closed_set! {
    /// Why a plan was made in pursuit of a goal.
    PlanCause {
        /// It is the first.
        First = "first",
        /// The last schema of the plan before was executed, and the goal does not hold.
        NotReached = "not reached",
        /// The outcome of the last step does not allow the next one.
        NextNotAllowed = "next not allowed",
        /// The body did not carry out the action.
        NotCarriedOut = "not carried out",
        /// The plan before was interrupted.
        Interrupted = "interrupted",
    }
}

/// A plan made in pursuit of a goal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PursuitPlan {
    /// Actions that had been sent for the goal.
    pub after_actions: u32,
    /// Why it was made.
    pub because: PlanCause,
    /// The probability that it brings the goal about; 0 where most of something is wanted.
    pub probability: f64,
    /// Where most of something is wanted, what is expected to come from where it was made: see the plan's `expected`; else left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected: Option<f64>,
    /// The schemas in order; none of a policy.
    pub chain: Vec<SchemaInUse>,
    /// Of a policy, the actions from where it was made to the goal when all comes about that is most likely; left out of a chain.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub course: Vec<String>,
    /// Whether the search for it used up its budget.
    pub search_truncated: bool,
}

/// The goal that a decision follows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DecisionGoal {
    /// What is wanted.
    #[serde(flatten)]
    pub wanted: Wanted,
    /// The schemas of the plan, in order; none of a policy.
    pub chain: Vec<SchemaInUse>,
    /// Which of them was executed, as an index.
    pub at: u32,
    /// Of a policy, the actions from the executed one to the goal when all comes about that is most likely; left out of a chain.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub course: Vec<String>,
    /// The probability of the plan when it was made; of a policy, from where the body was; 0 where most of something is wanted.
    pub probability: f64,
    /// Where most of something is wanted, what is expected to come from where the body was: see the plan's `expected`; else left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected: Option<f64>,
}

/// The goal that is pursued, in short.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct GoalSummary {
    /// Its number.
    pub number: u64,
    /// The body that pursues it.
    pub body: String,
    /// What is wanted.
    #[serde(flatten)]
    pub wanted: Wanted,
    /// Actions sent for it.
    pub actions: u32,
    /// Actions that it may take.
    pub actions_max: u32,
    /// The sum of what came after these actions, where most of something is wanted; else left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub came: Option<f64>,
}
