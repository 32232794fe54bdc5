//! Goals, the plans made for them, and what moves them.

use std::sync::Arc;

use pschema_learner::policy as policies;
use pschema_learner::pursuit as live;
use serde::{Deserialize, Serialize};

use super::execution::ChainLink;
use super::observation::{Observation, Pattern};
use crate::format::mirror::{Mirror, mirror};

mirror! {
    /// Why a plan was made.
    enum PlanCause = live::PlanCause {
        /// It was the first for the goal.
        First,
        /// The plan before was carried out, and the goal does not hold.
        NotReached,
        /// The outcome of the last step does not allow the next schema.
        NextNotAllowed,
        /// The body did not carry out the action.
        NotCarriedOut,
        /// The learner was held, or the body was away.
        Interrupted,
    }

    /// How the pursuit of a goal ended.
    enum Ending = live::Ending {
        /// The goal holds.
        Achieved,
        /// Nothing that is known leads there.
        NothingLeadsThere,
        /// It does not hold after all the actions that it was given.
        ActionsUsedUp,
        /// The stage does not lift a type of which the goal speaks.
        Constrained,
        /// It was called off.
        Cancelled,
        /// Nothing led there as far as was looked.
        FurtherThanLooked,
    }

    /// A plan made in pursuit of a goal.
    struct PlanRecord = live::PlanRecord {
        /// The number of actions that had been sent for the goal when it was made.
        after_actions: u32,
        /// Why it was made.
        because: PlanCause,
        /// The schemas, in the order of their execution.
        chain: Vec<ChainLink>,
        /// The probability that it brings the goal about.
        probability: f64,
        /// Whether the search for it used up its budget.
        truncated: bool,
        ..policy,
    }

    /// What to do in each context on the way to a goal.
    struct Policy = policies::Policy {
        /// The numbers of the types whose observations tell contexts apart, in order.
        kinds: Vec<u16>,
        /// The numbers of the types that are left to chance, in order.
        chance: Vec<u16>,
        /// Their observations when it was made, in canonical order.
        circumstances: Vec<Observation>,
        /// The contexts; that in which it was found is the first.
        rows: Vec<PolicyRow>,
        /// The number of actions that it takes to the goal, as expected.
        actions: f64,
        /// The number of actions that had been sent for the goal when it was made.
        after_actions: u32,
    }

    /// What to do in one context.
    struct PolicyRow = policies::PolicyRow {
        /// The observations, in canonical order.
        context: Vec<Observation>,
        /// The number of the primitive.
        action: u32,
        /// The probability with which the goal is reached from there.
        probability: f64,
        /// What the action leads to, the most probable first.
        leads: Vec<Lead>,
    }

    /// Where an action leads.
    struct Lead = policies::Lead {
        /// The context, by its row; `null` is the goal.
        to: Option<u32>,
        /// The probability.
        probability: f64,
    }

    /// A goal that is pursued, or was the last to be.
    struct Pursuit = live::Pursuit {
        /// Goals are numbered from 1 in the life of a memory.
        number: u64,
        /// The body that pursues it.
        body: u16,
        /// The patterns, which must all hold at once.
        goal: Vec<Pattern>,
        /// How many actions may be taken for it.
        actions_max: u32,
        /// How many were sent for it, carried out or not.
        actions: u32,
        /// How many plans were made.
        plans_made: u32,
        /// The last of them, the present one at the end.
        plans: Vec<PlanRecord>,
        /// How it ended; none while it is pursued.
        ended: Option<Ending>,
    }
}

/// A change of the goal that is pursued.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub(crate) enum PursuitEffect {
    Begun {
        body: u16,
        goal: Vec<Pattern>,
        actions_max: u32,
    },
    /// A plan of schemas was made.
    Planned(PlanRecord),
    Acted,
    Ended(Ending),
    /// A plan that is a policy was made.
    Steered {
        plan: PlanRecord,
        policy: Box<Policy>,
    },
    /// The policy of the present plan was made anew.
    Revised(Box<Policy>),
}

impl Mirror<live::PursuitEffect> for PursuitEffect {
    fn of(live: &live::PursuitEffect) -> Self {
        match live {
            live::PursuitEffect::Begun { body, goal, actions_max } => {
                Self::Begun { body: Mirror::of(body), goal: Mirror::of(goal), actions_max: *actions_max }
            }
            live::PursuitEffect::Planned(plan) => match &plan.policy {
                Some(policy) => Self::Steered { plan: Mirror::of(plan), policy: Mirror::of(policy) },
                None => Self::Planned(Mirror::of(plan)),
            },
            live::PursuitEffect::Revised(policy) => Self::Revised(Mirror::of(policy)),
            live::PursuitEffect::Acted => Self::Acted,
            live::PursuitEffect::Ended(ending) => Self::Ended(Mirror::of(ending)),
        }
    }

    fn live(self) -> live::PursuitEffect {
        match self {
            Self::Begun { body, goal, actions_max } => {
                live::PursuitEffect::Begun { body: body.live(), goal: goal.live(), actions_max }
            }
            Self::Planned(plan) => live::PursuitEffect::Planned(plan.live()),
            Self::Steered { plan, policy } => {
                let policy = Some(policy.live());
                live::PursuitEffect::Planned(live::PlanRecord { policy, ..plan.live() })
            }
            Self::Revised(policy) => live::PursuitEffect::Revised(policy.live()),
            Self::Acted => live::PursuitEffect::Acted,
            Self::Ended(ending) => live::PursuitEffect::Ended(ending.live()),
        }
    }
}

impl Mirror<Arc<live::PlanRecord>> for PlanRecord {
    fn of(live: &Arc<live::PlanRecord>) -> Self {
        Self::of(&**live)
    }

    fn live(self) -> Arc<live::PlanRecord> {
        Arc::new(self.live())
    }
}
