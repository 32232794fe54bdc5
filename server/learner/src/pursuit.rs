//! Pursuing a goal: the plan's next schema is executed until the goal holds, a new plan is made when a step's
//! outcome does not allow the next, and it ends when nothing known leads there or its actions are used up.
//! What is being pursued is part of memory.

use crate::chaining::Reach;
use crate::choice::{self, Situation};
use crate::curriculum::Curriculum;
use crate::decision::{Decision, ForGoal, Reason};
use crate::draft::Draft;
use crate::effect::{ChainLink, Effect, Execution};
use crate::excitation::Perceived;
use crate::goals::{GOAL_PATTERNS_MAX, Goal, holds};
use crate::memory::{Content, EffectError, Memory};
use crate::notation;
use crate::observation::Pattern;
use crate::plan::plan_along;
use crate::stages;
use crate::step::{ActionOutcome, Frame};
use crate::vocabulary::BodyId;
use crate::world_state::WorldState;

/// Plans of a pursuit that are remembered: the last of them.
pub const PLANS_KEPT_MAX: usize = 32;

/// Actions that a goal may be given.
pub const GOAL_ACTIONS_MAX: u32 = 100_000;

/// A goal that is pursued, or was the last to be.
#[derive(Clone, Debug, PartialEq)]
pub struct Pursuit {
    /// Goals are numbered from 1 in the life of a memory.
    pub number: u64,
    /// The body that pursues it.
    pub body: BodyId,
    /// What is to be brought about.
    pub goal: Vec<Pattern>,
    /// Actions that it may take.
    pub actions_max: u32,
    /// Actions sent for it.
    pub actions: u32,
    /// Plans made for it.
    pub plans_made: u32,
    /// The last of them, at most [`PLANS_KEPT_MAX`], the present one at the end.
    pub plans: Vec<PlanMade>,
    /// How it ended; none while it is pursued.
    pub ended: Option<Ending>,
}

/// A plan made in pursuit of a goal.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanMade {
    /// Actions that had been sent for the goal.
    pub after_actions: u32,
    /// Why it was made.
    pub because: Because,
    /// The schemas to execute, in order.
    pub chain: Vec<ChainLink>,
    /// The probability that it brings the goal about.
    pub probability: f64,
    /// Whether the search for it used up its budget.
    pub truncated: bool,
}

/// Why a plan was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Because {
    /// It is the first.
    First,
    /// The last schema of the plan before was executed, and the goal does not hold.
    NotReached,
    /// The last step's outcome does not allow the next schema.
    NextNotAllowed,
    /// The body did not carry out the action.
    NotCarriedOut,
    /// What was under way was dropped: the learner was held, or the body was away.
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
}

/// A change of what is pursued.
#[derive(Clone, Debug, PartialEq)]
pub enum PursuitEffect {
    /// A goal is pursued from now on.
    Begun {
        /// The body that is to pursue it.
        body: BodyId,
        /// What is to be brought about.
        goal: Vec<Pattern>,
        /// Actions that it may take.
        actions_max: u32,
    },
    /// A plan was made.
    Planned(PlanMade),
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

/// The goal that `body` pursues.
pub(crate) fn of(content: &Content, body: BodyId) -> Option<&Pursuit> {
    content.pursuit.as_ref().filter(|pursuit| pursuit.under_way() && pursuit.body == body)
}

/// A goal as it prints.
#[must_use]
pub fn text(content: &Content, goal: &Goal) -> String {
    let patterns: Vec<_> =
        goal.iter().map(|pattern| notation::pattern(&content.vocabulary, pattern)).collect();
    patterns.join(" & ")
}

/// Takes up a goal.
pub(crate) fn begin(
    draft: &mut Draft<'_>,
    curriculum: &Curriculum,
    body: BodyId,
    goal: Vec<Pattern>,
    actions_max: u32,
) -> Result<(), PursueError> {
    let content = draft.memory().content();
    if goal.is_empty() {
        return Err(PursueError::Empty);
    }
    if goal.len() > GOAL_PATTERNS_MAX {
        return Err(PursueError::Long { given: goal.len() });
    }
    if !(1..=GOAL_ACTIONS_MAX).contains(&actions_max) {
        return Err(PursueError::Actions { given: actions_max });
    }
    let known = content.vocabulary.bodies().get(usize::from(body.0));
    if known.is_none_or(|known| known.repertoire.is_empty()) {
        return Err(PursueError::Body);
    }
    if let Some(pursuit) = content.pursuit.as_ref().filter(|pursuit| pursuit.under_way()) {
        return Err(PursueError::Busy { number: pursuit.number, goal: text(content, &pursuit.goal) });
    }
    if content.progress.held {
        return Err(PursueError::Held);
    }
    if let Some(pattern) = constrained(draft.memory(), curriculum, &goal) {
        let kind = content.vocabulary.types().get(usize::from(pattern.kind().0));
        let kind = kind.map(|kind| kind.declared.name.clone()).unwrap_or_default();
        let stage = stages::present(draft.memory(), curriculum).name.clone();
        return Err(PursueError::Constrained { stage, kind });
    }
    draft.emit(Effect::Pursuit(PursuitEffect::Begun { body, goal, actions_max }));
    Ok(())
}

/// Calls the goal off that is pursued.
pub(crate) fn cancel(draft: &mut Draft<'_>) -> Result<(), PursueError> {
    let pursuit = draft.memory().content().pursuit.as_ref();
    if !pursuit.is_some_and(Pursuit::under_way) {
        return Err(PursueError::Nothing);
    }
    draft.emit(Effect::Pursuit(PursuitEffect::Ended(Ending::Cancelled)));
    Ok(())
}

/// A pattern of `goal` whose type the present stage does not lift.
fn constrained<'a>(memory: &Memory, curriculum: &Curriculum, goal: &'a Goal) -> Option<&'a Pattern> {
    let lifted = stages::lifted(&memory.content().vocabulary, stages::present(memory, curriculum));
    goal.iter().find(|pattern| !stages::is_lifted(&lifted, pattern.kind()))
}

/// What a frame of the pursuing body means for the goal. Events count only right after an action: what is felt
/// before anything was done was not brought about.
pub(crate) fn observed(
    draft: &mut Draft<'_>,
    curriculum: &Curriculum,
    frame: &Frame,
    world: &WorldState,
    after_action: bool,
) {
    let memory = draft.memory();
    let Some(pursuit) = of(memory.content(), frame.body) else { return };
    let lasting;
    let counted = if after_action {
        world
    } else {
        lasting = world.lasting(memory.rules());
        &lasting
    };
    let ending = if constrained(memory, curriculum, &pursuit.goal).is_some() {
        Ending::Constrained
    } else if holds(&pursuit.goal, counted) {
        Ending::Achieved
    } else if pursuit.actions >= pursuit.actions_max {
        Ending::ActionsUsedUp
    } else {
        return;
    };
    draft.emit(Effect::Pursuit(PursuitEffect::Ended(ending)));
}

/// What came of the execution before, for the choice of the next.
pub(crate) struct Before<'a> {
    /// How the body says it went, if it was sent out for the goal.
    pub(crate) outcome: Option<ActionOutcome>,
    /// What was left of the plan.
    pub(crate) chain: &'a [ChainLink],
}

/// The next execution for the goal that `body` pursues: the plan's next schema if the outcome allows it, else the
/// first of a new plan. None, and the goal is given up, if nothing known leads there.
pub(crate) fn next(
    draft: &mut Draft<'_>,
    body: BodyId,
    world: &WorldState,
    reach: &Reach,
    before: &Before<'_>,
) -> Option<(Execution, Decision)> {
    let perceived = &Perceived::new(world);
    let memory = draft.memory();
    let situation = Situation { memory, body, world, perceived, reach, unhabituated: &[], executable: &[] };
    let goal = of(memory.content(), body)?.goal.clone();
    let mut planned = None;
    let chosen = choice::continue_chain(&situation, before.chain).or_else(|| {
        let found = plan_along(memory, body, world, &goal, reach);
        let plan = found.plan?;
        let chosen = choice::continue_chain(&situation, &plan.chain())?;
        let pursuit = of(memory.content(), body)?;
        planned = Some(PlanMade {
            after_actions: pursuit.actions,
            because: because(pursuit, before),
            chain: plan.chain(),
            probability: plan.probability,
            truncated: found.truncated,
        });
        Some(chosen)
    });
    if let Some(planned) = planned {
        draft.emit(Effect::Pursuit(PursuitEffect::Planned(planned)));
    }
    let Some((mut execution, mut decision)) = chosen else {
        draft.emit(Effect::Pursuit(PursuitEffect::Ended(Ending::NothingLeadsThere)));
        return None;
    };
    draft.emit(Effect::Pursuit(PursuitEffect::Acted));
    execution.for_goal = true;
    decision.reason = Reason::Goal;
    let current = of(draft.memory().content(), body).and_then(|pursuit| pursuit.plans.last());
    decision.goal = current.map(|plan| ForGoal {
        goal,
        chain: plan.chain.clone(),
        at: plan.chain.len().saturating_sub(execution.chain.len() + 1),
        probability: plan.probability,
    });
    Some((execution, decision))
}

fn because(pursuit: &Pursuit, before: &Before<'_>) -> Because {
    match before.outcome {
        _ if pursuit.plans_made == 0 => Because::First,
        None => Because::Interrupted,
        Some(ActionOutcome::Done) if before.chain.is_empty() => Because::NotReached,
        Some(ActionOutcome::Done) => Because::NextNotAllowed,
        Some(_) => Because::NotCarriedOut,
    }
}

/// Applies an effect to the content of memory.
pub(crate) fn apply(content: &mut Content, effect: &PursuitEffect) -> Result<(), EffectError> {
    if let PursuitEffect::Begun { body, goal, actions_max } = effect {
        let before = content.pursuit.as_ref();
        if before.is_some_and(Pursuit::under_way) {
            return Err(EffectError::Goal);
        }
        let number = before.map_or(0, |pursuit| pursuit.number) + 1;
        forget_chain(content, *body)?;
        content.pursuit = Some(Pursuit {
            number,
            body: *body,
            goal: goal.clone(),
            actions_max: *actions_max,
            actions: 0,
            plans_made: 0,
            plans: Vec::new(),
            ended: None,
        });
        return Ok(());
    }
    if let PursuitEffect::Planned(plan) = effect {
        let mut schemas = plan.chain.iter().flat_map(|link| [Some(link.schema), link.carrier]).flatten();
        if let Some(unknown) = schemas.find(|schema| content.schema(*schema).is_none()) {
            return Err(EffectError::Schema(unknown.0));
        }
    }
    let pursuit = content.pursuit.as_mut().filter(|pursuit| pursuit.under_way()).ok_or(EffectError::Goal)?;
    match effect {
        PursuitEffect::Begun { .. } => (),
        PursuitEffect::Planned(plan) => {
            if pursuit.plans.len() >= PLANS_KEPT_MAX {
                pursuit.plans.remove(0);
            }
            pursuit.plans.push(plan.clone());
            pursuit.plans_made = pursuit.plans_made.saturating_add(1);
        }
        PursuitEffect::Acted => pursuit.actions = pursuit.actions.saturating_add(1),
        PursuitEffect::Ended(ending) => {
            pursuit.ended = Some(*ending);
            let body = pursuit.body;
            forget_chain(content, body)?;
        }
    }
    Ok(())
}

/// The chain under way was for something else, or is for nothing any more; its present schema is still learnt from.
fn forget_chain(content: &mut Content, body: BodyId) -> Result<(), EffectError> {
    let slot = content.pending.get_mut(usize::from(body.0)).ok_or(EffectError::Body(body.0))?;
    if let Some(execution) = slot {
        execution.chain.clear();
    }
    Ok(())
}
