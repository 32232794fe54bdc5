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

closed_set! {
    /// What came of looking for a plan.
    PlanState {
        /// The goal holds, and there is nothing to do.
        HoldsAlready = "holds already",
        /// A plan was found.
        Found = "found",
        /// No chain of schemas that are known brings the goal about from here.
        NothingLeadsThere = "nothing known leads there",
    }
}

/// How a goal could be brought about.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Plan {
    /// The body that would do it.
    pub body: String,
    /// What is wanted, as it prints.
    pub goal: Vec<String>,
    /// What is perceived, under the constraints of the present stage.
    pub world: Vec<ObservationText>,
    /// What came of looking for a plan.
    pub state: PlanState,
    /// The probability that the plan brings the goal about: the product of those of its steps; none without a plan.
    pub probability: Option<f64>,
    /// The steps in order.
    pub steps: Vec<PlanStep>,
    /// Whether the search used up its budget, so that there may be a (better) plan.
    pub search_truncated: bool,
}

/// One schema of a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PlanStep {
    /// The schema.
    pub schema: SchemaInUse,
    /// What the goal or later steps rely on. What is `absent` is relied on not to happen.
    pub relies_on: Vec<Condition>,
    /// Of a generalised schema, the outcomes of its carrier that are its target.
    pub through: Vec<Condition>,
    /// How reliably the body carries the action out.
    pub reliability: f64,
    /// `reliability` times the probabilities of what it goes through and of what is relied on.
    pub probability: f64,
}

closed_set! {
    /// How a goal is doing, or how its pursuit ended.
    PursuitState {
        /// It is pursued.
        Pursued = "pursued",
        /// It was brought about.
        Achieved = "achieved",
        /// It was given up: no chain of schemas that are known brings it about.
        NothingLeadsThere = "nothing known leads there",
        /// It does not hold after all the actions that it might take.
        ActionsUsedUp = "actions used up",
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
    /// What is wanted, as it prints.
    pub goal: Vec<String>,
    /// How it is doing, or how its pursuit ended.
    pub state: PursuitState,
    /// Whether it was achieved.
    pub achieved: bool,
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
    /// The probability that it brings the goal about.
    pub probability: f64,
    /// The schemas in order.
    pub chain: Vec<SchemaInUse>,
    /// Whether the search for it used up its budget.
    pub search_truncated: bool,
}

/// The goal that a decision follows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DecisionGoal {
    /// What is wanted, as it prints.
    pub goal: Vec<String>,
    /// The schemas of the plan, in order.
    pub chain: Vec<SchemaInUse>,
    /// Which of them was executed, as an index.
    pub at: u32,
    /// The probability of the plan when it was made.
    pub probability: f64,
}

/// The goal that is pursued, in short.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct GoalSummary {
    /// Its number.
    pub number: u64,
    /// The body that pursues it.
    pub body: String,
    /// What is wanted, as it prints.
    pub goal: Vec<String>,
    /// Actions sent for it.
    pub actions: u32,
    /// Actions that it may take.
    pub actions_max: u32,
}
