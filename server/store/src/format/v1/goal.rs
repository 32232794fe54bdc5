//! Goals, the plans made for them, and what moves them.

use std::sync::Arc;

use pschema_learner::pursuit as live;

use super::execution::ChainLink;
use super::observation::Pattern;
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
    }

    /// A change of the goal that is pursued.
    enum PursuitEffect = live::PursuitEffect {
        Begun { body: u16, goal: Vec<Pattern>, actions_max: u32 },
        Planned(plan: PlanRecord),
        Acted,
        Ended(ending: Ending),
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

impl Mirror<Arc<live::PlanRecord>> for PlanRecord {
    fn of(live: &Arc<live::PlanRecord>) -> Self {
        Self::of(&**live)
    }

    fn live(self) -> Arc<live::PlanRecord> {
        Arc::new(self.live())
    }
}
