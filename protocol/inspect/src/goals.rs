//! What tools ask about goals: what would happen, how something could be brought about, and bringing it about.

use serde::{Deserialize, Serialize};

use super::{Condition, ObservationText, ValueText};

/// What an action would do in the world as it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// The schema that says so; none when nothing that is known holds here.
    pub schema: Option<SchemaInUse>,
    /// Each outcome with its count, the rarer ones included.
    pub outcomes: Vec<Condition>,
}

/// A schema as it is used in one situation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SchemaInUse {
    /// Its number.
    pub id: u32,
    /// `concrete`, `generalised`, `counter-example`.
    pub kind: String,
    /// The schema as it prints.
    pub text: String,
    /// Values of its variables.
    pub binding: Vec<(String, ValueText)>,
    /// The primitive that it comes to, as it prints.
    pub action: String,
    /// The concrete schema that achieves its target, when it is generalised.
    pub carrier: Option<u32>,
}

/// How a goal could be brought about.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// The body that would do it.
    pub body: String,
    /// What is wanted, as it prints.
    pub goal: Vec<String>,
    /// What is perceived, under the constraints of the present stage.
    pub world: Vec<ObservationText>,
    /// `holds already`, `found`, or `nothing known leads there`.
    pub state: String,
    /// The probability that the plan brings the goal about: the product of those of its steps; none without a plan.
    pub probability: Option<f64>,
    /// The steps in order.
    pub steps: Vec<PlanStep>,
    /// Whether the search used up its budget, so that there may be a (better) plan.
    pub search_truncated: bool,
}

/// One schema of a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlanStep {
    /// The schema.
    pub schema: SchemaInUse,
    /// What the goal or later steps rely on. One that is `absent` is relied on not to happen.
    pub relies_on: Vec<Condition>,
    /// Of a generalised schema, the outcomes of its carrier that are its target.
    pub through: Vec<Condition>,
    /// How reliably the body carries the action out.
    pub reliability: f64,
    /// `reliability` times the probabilities of what it goes through and of what is relied on.
    pub probability: f64,
}

/// The goal that is pursued, or was the last to be.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pursuit {
    /// Its number, from 1 in the life of a memory.
    pub number: u64,
    /// The body that pursues it.
    pub body: String,
    /// What is wanted, as it prints.
    pub goal: Vec<String>,
    /// `pursued`, `achieved`, `nothing known leads there`, `actions used up`, `constrained` (the stage entered
    /// meanwhile does not lift what the goal speaks of) or `cancelled`.
    pub state: String,
    /// Actions sent for it.
    pub actions: u32,
    /// Actions that it may take.
    pub actions_max: u32,
    /// Plans made for it.
    pub plans_made: u32,
    /// The last of them, at most 32, in order.
    pub plans: Vec<PlanMade>,
}

/// A plan made in pursuit of a goal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlanMade {
    /// Actions that had been sent for the goal.
    pub after_actions: u32,
    /// `first`, `not reached` (the last schema was executed and the goal does not hold), `next not allowed` (by the
    /// outcome of the last step), `not carried out` or `interrupted`.
    pub because: String,
    /// The probability that it brings the goal about.
    pub probability: f64,
    /// The schemas in order.
    pub chain: Vec<SchemaInUse>,
    /// Whether the search for it used up its budget.
    pub search_truncated: bool,
}

/// The goal that a decision follows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GoalFollowed {
    /// What is wanted, as it prints.
    pub goal: Vec<String>,
    /// The plan's schemas in order.
    pub chain: Vec<SchemaInUse>,
    /// Which of them was executed, as an index.
    pub at: u32,
    /// The probability of the plan when it was made.
    pub probability: f64,
}

/// The goal that is pursued, in short.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
