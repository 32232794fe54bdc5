//! The JSON of `predict`, `plan` and `achieve`.

use pschema_inspect::SchemaInUse;
use serde::Serialize;

use super::json::{Counted, Observation, Values, all};

/// A schema as it is used in one situation.
#[derive(Debug, Serialize)]
pub(super) struct InUse<'a> {
    id: u32,
    kind: &'a str,
    text: &'a str,
    binding: Values<'a>,
    action: &'a str,
    carrier: Option<u32>,
}

impl<'a> From<&'a SchemaInUse> for InUse<'a> {
    fn from(s: &'a SchemaInUse) -> Self {
        let SchemaInUse { id, kind, text, binding, action, carrier } = s;
        Self { id: *id, kind, text, binding: Values(binding), action, carrier: *carrier }
    }
}

/// What `pschema predict --json` prints.
#[derive(Debug, Serialize)]
pub(crate) struct Prediction<'a> {
    body: &'a str,
    action: &'a str,
    world: Vec<Observation<'a>>,
    attempts: u32,
    carried_out: u32,
    schema: Option<InUse<'a>>,
    outcomes: Vec<Counted<'a>>,
}

impl<'a> From<&'a pschema_inspect::Prediction> for Prediction<'a> {
    fn from(p: &'a pschema_inspect::Prediction) -> Self {
        Self {
            body: &p.body,
            action: &p.action,
            world: all(&p.world),
            attempts: p.attempts,
            carried_out: p.carried_out,
            schema: p.schema.as_ref().map(InUse::from),
            outcomes: all(&p.outcomes),
        }
    }
}

/// What `pschema plan --json` prints.
#[derive(Debug, Serialize)]
pub(crate) struct Plan<'a> {
    body: &'a str,
    goal: &'a [String],
    world: Vec<Observation<'a>>,
    state: &'a str,
    probability: Option<f64>,
    steps: Vec<Step<'a>>,
    search_truncated: bool,
}

/// One schema of a plan.
#[derive(Debug, Serialize)]
struct Step<'a> {
    schema: InUse<'a>,
    relies_on: Vec<Counted<'a>>,
    through: Vec<Counted<'a>>,
    reliability: f64,
    probability: f64,
}

impl<'a> From<&'a pschema_inspect::PlanStep> for Step<'a> {
    fn from(s: &'a pschema_inspect::PlanStep) -> Self {
        Self {
            schema: (&s.schema).into(),
            relies_on: all(&s.relies_on),
            through: all(&s.through),
            reliability: s.reliability,
            probability: s.probability,
        }
    }
}

impl<'a> From<&'a pschema_inspect::Plan> for Plan<'a> {
    fn from(p: &'a pschema_inspect::Plan) -> Self {
        Self {
            body: &p.body,
            goal: &p.goal,
            world: all(&p.world),
            state: &p.state,
            probability: p.probability,
            steps: all(&p.steps),
            search_truncated: p.search_truncated,
        }
    }
}

/// What `pschema achieve --json` prints.
#[derive(Debug, Serialize)]
pub(crate) struct Pursuit<'a> {
    number: u64,
    body: &'a str,
    goal: &'a [String],
    state: &'a str,
    achieved: bool,
    actions: u32,
    actions_max: u32,
    plans_made: u32,
    plans: Vec<PlanMade<'a>>,
}

/// A plan made in pursuit of a goal.
#[derive(Debug, Serialize)]
struct PlanMade<'a> {
    after_actions: u32,
    because: &'a str,
    probability: f64,
    chain: Vec<InUse<'a>>,
    search_truncated: bool,
}

impl<'a> From<&'a pschema_inspect::PlanMade> for PlanMade<'a> {
    fn from(p: &'a pschema_inspect::PlanMade) -> Self {
        Self {
            after_actions: p.after_actions,
            because: &p.because,
            probability: p.probability,
            chain: all(&p.chain),
            search_truncated: p.search_truncated,
        }
    }
}

impl<'a> From<&'a pschema_inspect::Pursuit> for Pursuit<'a> {
    fn from(p: &'a pschema_inspect::Pursuit) -> Self {
        Self {
            number: p.number,
            body: &p.body,
            goal: &p.goal,
            state: &p.state,
            achieved: p.state == "achieved",
            actions: p.actions,
            actions_max: p.actions_max,
            plans_made: p.plans_made,
            plans: all(&p.plans),
        }
    }
}

/// The goal that a decision follows, in `pschema explain --json`.
#[derive(Debug, Serialize)]
pub(super) struct Followed<'a> {
    goal: &'a [String],
    chain: Vec<InUse<'a>>,
    at: u32,
    probability: f64,
}

impl<'a> From<&'a pschema_inspect::GoalFollowed> for Followed<'a> {
    fn from(f: &'a pschema_inspect::GoalFollowed) -> Self {
        Self { goal: &f.goal, chain: all(&f.chain), at: f.at, probability: f.probability }
    }
}
