//! Goals, the plans made for them, and what moves them.

use std::sync::Arc;

use pschema_learner::policy as policies;
use pschema_learner::pursuit as live;
use serde::{Deserialize, Serialize};

use super::execution::ChainLink;
use super::observation::{Observation, Pattern};
use crate::format::mirror::{Mirror, list, mirror};

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
        /// Most of something was wanted, and nothing that is known brings any.
        NothingBringsAny,
    }

    /// What is wanted.
    enum Goal = live::Goal {
        /// That this is observed.
        Observed(patterns: Vec<Pattern>),
        /// That this is brought about, though it may be so already.
        Again(patterns: Vec<Pattern>),
        /// Most of the numbers that come with observations of the type of this number.
        Most(kind: u16),
    }

    /// What comes of a row of a policy for most of something.
    struct Yield = policies::Yield {
        /// What is expected to come from there on.
        worth: f64,
        /// What comes with its action most likely.
        brings: f64,
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
        /// The number of actions that it takes to the goal, as expected; of one for most of something, after how many it is made anew.
        actions: f64,
        /// The number of actions that had been sent for the goal when it was made.
        after_actions: u32,
        ..yields,
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
}

/// A goal that is pursued, or was the last to be.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct Pursuit {
    /// Goals are numbered from 1 in the life of a memory.
    pub(crate) number: u64,
    /// The body that pursues it.
    pub(crate) body: u16,
    /// The patterns, which must all hold at once; none if most of something is wanted.
    pub(crate) goal: Vec<Pattern>,
    /// How many actions may be taken for it.
    pub(crate) actions_max: u32,
    /// How many were sent for it, carried out or not.
    pub(crate) actions: u32,
    /// How many plans were made.
    pub(crate) plans_made: u32,
    /// The last of them, the present one at the end.
    pub(crate) plans: Vec<PlanRecord>,
    /// How it ended; none while it is pursued.
    pub(crate) ended: Option<Ending>,
}

/// A goal that is wanted otherwise than that something is observed, and what came for it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct Wanted {
    /// What is wanted.
    pub(crate) goal: Goal,
    /// The sum of what came, if most of it is wanted; else 0.
    pub(crate) came: f64,
}

impl Mirror<live::Pursuit> for Pursuit {
    fn of(live: &live::Pursuit) -> Self {
        // What it is beyond patterns that are to be observed, and what came for it, is written beside it.
        let live::Pursuit { number, body, goal, actions_max, actions, came: _, plans_made, plans, ended } =
            live;
        Self {
            number: *number,
            body: Mirror::of(body),
            goal: list(goal.patterns()),
            actions_max: *actions_max,
            actions: *actions,
            plans_made: *plans_made,
            plans: Mirror::of(plans),
            ended: Mirror::of(ended),
        }
    }

    fn live(self) -> live::Pursuit {
        live::Pursuit {
            number: self.number,
            body: self.body.live(),
            goal: live::Goal::Observed(self.goal.live()),
            actions_max: self.actions_max,
            actions: self.actions,
            came: 0.0,
            plans_made: self.plans_made,
            plans: self.plans.live(),
            ended: self.ended.live(),
        }
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
    /// A goal is pursued that is wanted otherwise than that something is observed.
    Wanted {
        body: u16,
        goal: Goal,
        actions_max: u32,
    },
    /// So much came of what most is wanted of.
    Came(f64),
    /// A plan that is a policy for most of something was made.
    SteeredToMost {
        plan: PlanRecord,
        policy: Box<Policy>,
        yields: Vec<Yield>,
    },
    /// The policy for most of something was made anew.
    RevisedForMost {
        policy: Box<Policy>,
        yields: Vec<Yield>,
    },
}

impl Mirror<live::PursuitEffect> for PursuitEffect {
    fn of(live: &live::PursuitEffect) -> Self {
        match live {
            live::PursuitEffect::Begun { body, goal: live::Goal::Observed(goal), actions_max } => {
                Self::Begun { body: Mirror::of(body), goal: Mirror::of(goal), actions_max: *actions_max }
            }
            live::PursuitEffect::Begun { body, goal, actions_max } => {
                Self::Wanted { body: Mirror::of(body), goal: Mirror::of(goal), actions_max: *actions_max }
            }
            live::PursuitEffect::Planned(plan) => match &plan.policy {
                Some(policy) if policy.yields.is_empty() => {
                    Self::Steered { plan: Mirror::of(plan), policy: Mirror::of(policy) }
                }
                Some(policy) => Self::SteeredToMost {
                    plan: Mirror::of(plan),
                    policy: Mirror::of(policy),
                    yields: Mirror::of(&policy.yields),
                },
                None => Self::Planned(Mirror::of(plan)),
            },
            live::PursuitEffect::Revised(policy) if policy.yields.is_empty() => {
                Self::Revised(Mirror::of(policy))
            }
            live::PursuitEffect::Revised(policy) => {
                Self::RevisedForMost { policy: Mirror::of(policy), yields: Mirror::of(&policy.yields) }
            }
            live::PursuitEffect::Acted => Self::Acted,
            live::PursuitEffect::Came(more) => Self::Came(*more),
            live::PursuitEffect::Ended(ending) => Self::Ended(Mirror::of(ending)),
        }
    }

    fn live(self) -> live::PursuitEffect {
        let steered = |plan: PlanRecord, policy| {
            live::PursuitEffect::Planned(live::PlanRecord { policy: Some(Arc::new(policy)), ..plan.live() })
        };
        match self {
            Self::Begun { body, goal, actions_max } => {
                let goal = live::Goal::Observed(goal.live());
                live::PursuitEffect::Begun { body: body.live(), goal, actions_max }
            }
            Self::Wanted { body, goal, actions_max } => {
                live::PursuitEffect::Begun { body: body.live(), goal: goal.live(), actions_max }
            }
            Self::Planned(plan) => live::PursuitEffect::Planned(plan.live()),
            Self::Steered { plan, policy } => steered(plan, (*policy).live()),
            Self::SteeredToMost { plan, policy, yields } => steered(plan, with_yields(*policy, yields)),
            Self::Revised(policy) => live::PursuitEffect::Revised(policy.live()),
            Self::RevisedForMost { policy, yields } => {
                live::PursuitEffect::Revised(Arc::new(with_yields(*policy, yields)))
            }
            Self::Acted => live::PursuitEffect::Acted,
            Self::Came(more) => live::PursuitEffect::Came(more),
            Self::Ended(ending) => live::PursuitEffect::Ended(ending.live()),
        }
    }
}

/// A policy for most of something.
fn with_yields(policy: Policy, yields: Vec<Yield>) -> policies::Policy {
    policies::Policy { yields: yields.live(), ..policy.live() }
}

impl Mirror<Arc<live::PlanRecord>> for PlanRecord {
    fn of(live: &Arc<live::PlanRecord>) -> Self {
        Self::of(&**live)
    }

    fn live(self) -> Arc<live::PlanRecord> {
        Arc::new(self.live())
    }
}
