//! Goals, the plans made for them, and what moves them.

use std::sync::Arc;

use pschema_learner::pursuit as live;

use super::execution::ChainLink;
use super::observation::Pattern;
use crate::format::mirror::{Mirror, mirror};

mirror! {
    /// Why a plan was made.
    enum PlanCause = live::PlanCause {
        First,
        NotReached,
        NextNotAllowed,
        NotCarriedOut,
        Interrupted,
    }

    /// How the pursuit of a goal ended.
    enum Ending = live::Ending {
        Achieved,
        NothingLeadsThere,
        ActionsUsedUp,
        Constrained,
        Cancelled,
    }

    /// A plan made in pursuit of a goal.
    struct PlanRecord = live::PlanRecord {
        after_actions: u32,
        because: PlanCause,
        chain: Vec<ChainLink>,
        probability: f64,
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
        number: u64,
        body: u16,
        goal: Vec<Pattern>,
        actions_max: u32,
        actions: u32,
        plans_made: u32,
        plans: Vec<PlanRecord>,
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
