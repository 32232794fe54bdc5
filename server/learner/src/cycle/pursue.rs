//! Pursuing a goal: the plan's next schema is executed until the goal holds, a new plan is made when a step's
//! outcome does not allow the next, and it ends when nothing known leads there or its actions are used up.
//! What is being pursued is part of memory.

use std::sync::Arc;

use crate::cycle::chaining::Reach;
use crate::cycle::choice::{self, Situation};
use crate::cycle::claims;
use crate::cycle::curiosity::Curiosity;
use crate::cycle::excitation::PairCounts;
use crate::cycle::goals::holds;
use crate::cycle::most::policy_for;
use crate::cycle::plan::plan_along;
use crate::cycle::policy::PolicySearch;
use crate::cycle::stages;
use crate::memory::draft::Draft;
use crate::memory::evidence::Foresight;
use crate::memory::notation;
use crate::memory::{Content, Memory};
use crate::nouns::curriculum::Curriculum;
use crate::nouns::decision::{Decision, DecisionGoal, Reason};
use crate::nouns::effect::Effect;
use crate::nouns::execution::{ChainLink, Execution};
use crate::nouns::frame::ActionOutcome;
use crate::nouns::observation::TypeId;
use crate::nouns::policy::{Policy, PolicyRow};
use crate::nouns::pursuit::{
    Ending, GOAL_ACTIONS_MAX, GOAL_PATTERNS_MAX, Goal, PlanCause, PlanRecord, PursueError, Pursuit,
    PursuitEffect,
};
use crate::nouns::vocabulary::BodyId;
use crate::nouns::world_state::WorldState;

/// Takes up a goal.
pub(crate) fn begin(
    draft: &mut Draft<'_>,
    curriculum: &Curriculum,
    body: BodyId,
    goal: Goal,
    actions_max: u32,
) -> Result<(), PursueError> {
    let content = draft.memory().content();
    wantable(content, &goal)?;
    if !(1..=GOAL_ACTIONS_MAX).contains(&actions_max) {
        return Err(PursueError::Actions { given: actions_max });
    }
    let known = content.vocabulary.bodies().get(usize::from(body.0));
    if known.is_none_or(|known| known.repertoire.is_empty()) {
        return Err(PursueError::Body);
    }
    if let Some(pursuit) = content.pursuit.as_ref().filter(|pursuit| pursuit.under_way()) {
        return Err(PursueError::Busy {
            number: pursuit.number,
            goal: notation::goal(&content.vocabulary, &pursuit.goal),
        });
    }
    if content.progress.held {
        return Err(PursueError::Held);
    }
    if let Some(kind) = constrained(draft.memory(), curriculum, &goal) {
        let kind = notation::type_name(&content.vocabulary, kind);
        let stage = stages::present(draft.memory(), curriculum).name.clone();
        return Err(PursueError::Constrained { stage, kind });
    }
    draft.emit(Effect::Pursuit(PursuitEffect::Begun { body, goal, actions_max }));
    Ok(())
}

/// Whether something can be wanted at all.
fn wantable(content: &Content, goal: &Goal) -> Result<(), PursueError> {
    let Content { vocabulary, mechanisms, .. } = content;
    match goal {
        Goal::Observed(patterns) | Goal::Again(patterns) => match patterns.len() {
            0 => Err(PursueError::Empty),
            1..=GOAL_PATTERNS_MAX => Ok(()),
            given => Err(PursueError::Long { given }),
        },
        Goal::Most(kind) if !vocabulary.is_value(*kind) => {
            let name = |kind| notation::type_name(vocabulary, kind);
            Err(PursueError::NoValue { kind: name(*kind), values: vocabulary.values().map(name).collect() })
        }
        Goal::Most(_) if !mechanisms.makes_policies() => Err(PursueError::NoPolicies),
        Goal::Most(_) => Ok(()),
    }
}

/// Calls the goal off that is pursued.
pub(crate) fn cancel(draft: &mut Draft<'_>) -> Result<(), PursueError> {
    let pursuit = draft.memory().content().pursuit.as_deref();
    if !pursuit.is_some_and(Pursuit::under_way) {
        return Err(PursueError::Nothing);
    }
    draft.emit(Effect::Pursuit(PursuitEffect::Ended(Ending::Cancelled)));
    Ok(())
}

/// A type that `goal` speaks of and the present stage does not lift.
fn constrained(memory: &Memory, curriculum: &Curriculum, goal: &Goal) -> Option<TypeId> {
    let lifted = stages::lifted(memory.content(), stages::present(memory, curriculum));
    goal.kinds().find(|kind| !stages::is_lifted(&lifted, *kind))
}

/// Whether a goal is achieved in a frame that follows an action which was decided `before`, or none. Events count only right after an
/// action: what is felt before anything was done was not brought about.
fn is_achieved(memory: &Memory, goal: &Goal, before: Option<&WorldState>, world: &WorldState) -> bool {
    let lasting = |world: &WorldState| world.lasting(memory.rules());
    match (goal, before) {
        (Goal::Most(_), _) | (Goal::Again(_), None) => false,
        (Goal::Observed(patterns), Some(_)) => holds(patterns, world),
        (Goal::Observed(patterns), None) => holds(patterns, &lasting(world)),
        (Goal::Again(patterns), Some(before)) => holds(patterns, world) && !holds(patterns, &lasting(before)),
    }
}

/// What a frame of the pursuing body means for the goal; it follows an action that was carried out and decided `before`, or none.
pub(crate) fn observed(
    draft: &mut Draft<'_>,
    curriculum: &Curriculum,
    body: BodyId,
    world: &WorldState,
    before: Option<&WorldState>,
) {
    let memory = draft.memory();
    let Some(pursuit) = memory.content().pursuit_of(body) else { return };
    let ending = if constrained(memory, curriculum, &pursuit.goal).is_some() {
        Ending::Constrained
    } else if is_achieved(memory, &pursuit.goal, before, world) {
        Ending::Achieved
    } else if pursuit.actions >= pursuit.actions_max {
        Ending::ActionsUsedUp
    } else {
        return;
    };
    draft.emit(Effect::Pursuit(PursuitEffect::Ended(ending)));
}

/// Takes account of what came after an action that was sent for most of something, and returns it.
pub(crate) fn came(draft: &mut Draft<'_>, body: BodyId, world: &WorldState) -> Option<f64> {
    let content = draft.memory().content();
    let value = content.pursuit_of(body)?.goal.most()?;
    let came = content.vocabulary.sum_of(value, world.observations());
    if came != 0.0 {
        draft.emit(Effect::Pursuit(PursuitEffect::Came(came)));
    }
    Some(came)
}

/// What came of the execution before, for the choice of the next.
pub(crate) struct PreviousExecution<'a> {
    /// How the body says it went, if it was sent out for the goal.
    pub(crate) outcome: Option<ActionOutcome>,
    /// What was left of the plan.
    pub(crate) chain: &'a [ChainLink],
    /// The world state in which it was decided, if it was sent out for the goal.
    pub(crate) world: Option<&'a WorldState>,
    /// What came with it, if it was sent out for most of something.
    pub(crate) came: Option<f64>,
}

/// The next execution for the goal that `body` pursues: the plan's next schema if the outcome allows it, else the
/// first of a new plan. None, and the goal is given up, if nothing known leads there.
pub(crate) fn next(
    draft: &mut Draft<'_>,
    body: BodyId,
    world: &WorldState,
    reach: &Reach,
    foresight: &mut Foresight,
    before: &PreviousExecution<'_>,
) -> Option<(Execution, Decision)> {
    let perceived = &PairCounts::new(world);
    let memory = draft.memory();
    if memory.content().mechanisms.makes_policies() {
        return steer(draft, body, world, reach, foresight, before);
    }
    let curiosity = &Curiosity::new(memory, body, world);
    let situation =
        Situation { body, world, perceived, reach, unhabituated: &[], executable: &[], curiosity };
    let goal = memory.content().pursuit_of(body)?.goal.clone();
    if goal.most().is_some() {
        // The mechanism was switched off meanwhile.
        return give_up(draft, Ending::NothingBringsAny);
    }
    let mut planned = None;
    let chosen = choice::continue_chain(memory, &situation, before.chain).or_else(|| {
        let found = plan_along(memory, body, world, &goal, reach);
        let plan = found.plan?;
        let chosen = choice::continue_chain(memory, &situation, &plan.chain())?;
        let pursuit = memory.content().pursuit_of(body)?;
        planned = Some(PlanRecord {
            after_actions: pursuit.actions,
            because: because(pursuit, before, before.chain.is_empty()),
            chain: plan.chain(),
            policy: None,
            probability: plan.probability,
            truncated: found.truncated,
        });
        Some(chosen)
    });
    if let Some(planned) = planned {
        draft.emit(Effect::Pursuit(PursuitEffect::Planned(planned)));
    }
    let Some((mut execution, mut decision)) = chosen else {
        return stand(draft, &situation).or_else(|| give_up(draft, Ending::NothingLeadsThere));
    };
    draft.emit(Effect::Pursuit(PursuitEffect::Acted));
    execution.for_goal = true;
    decision.reason = Reason::Goal;
    let current = draft.memory().content().pursuit_of(body).and_then(|pursuit| pursuit.plans.last());
    decision.goal = current.map(|plan| DecisionGoal {
        goal,
        chain: plan.chain.clone(),
        at: plan.chain.len().saturating_sub(execution.chain.len() + 1),
        course: Vec::new(),
        probability: plan.probability,
        worth: None,
    });
    Some((execution, decision))
}

/// The goal is over: there is nothing more to do for it.
fn give_up<T>(draft: &mut Draft<'_>, ending: Ending) -> Option<T> {
    draft.emit(Effect::Pursuit(PursuitEffect::Ended(ending)));
    None
}

/// Where an episode is known to have ended nothing leads on, but a new one will begin, whatever is asked of the body. So the goal is not
/// given up: anything is asked.
fn stand(draft: &mut Draft<'_>, situation: &Situation<'_>) -> Option<(Execution, Decision)> {
    let Situation { body, world, .. } = *situation;
    let memory = draft.memory();
    if !claims::ended(memory, world) {
        return None;
    }
    let goal = memory.content().pursuit_of(body)?.goal.clone();
    let known = memory.content().vocabulary.bodies().get(usize::from(body.0));
    let action = *known?.repertoire.first()?;
    let (mut execution, mut decision) = choice::carry_out(memory, situation, action);
    draft.emit(Effect::Pursuit(PursuitEffect::Acted));
    (execution.for_goal, decision.reason) = (true, Reason::Goal);
    let course = vec![action];
    decision.goal =
        Some(DecisionGoal { goal, chain: Vec::new(), at: 0, course, probability: 0.0, worth: None });
    Some((execution, decision))
}

/// The same by a policy: that which was made last as long as what comes about is what it expects most, and it is not overdue; else by
/// what is known by now.
fn steer(
    draft: &mut Draft<'_>,
    body: BodyId,
    world: &WorldState,
    reach: &Reach,
    foresight: &mut Foresight,
    before: &PreviousExecution<'_>,
) -> Option<(Execution, Decision)> {
    let memory = draft.memory();
    let perceived = &PairCounts::new(world);
    let curiosity = &Curiosity::new(memory, body, world);
    let situation =
        Situation { body, world, perceived, reach, unhabituated: &[], executable: &[], curiosity };
    let pursuit = memory.content().pursuit_of(body)?;
    let (goal, context) = (pursuit.goal.clone(), claims::context(memory.content(), world));
    let known = pursuit.plans.last().and_then(|plan| plan.policy.as_deref());
    let last = known.zip(before.world).and_then(|(policy, world)| {
        let at = policy.row(&claims::context(memory.content(), world))?;
        Some((policy, policy.rows.get(at)?))
    });
    let done = before.outcome == Some(ActionOutcome::Done);
    let next = last.filter(|_| done).and_then(|(policy, last)| next_row(policy, last, &context));
    // What a cut episode leaves is as good as it was, if it says what to do where the new one begins; one that ended taught something.
    let cut = before.outcome == Some(ActionOutcome::EpisodeCut);
    let as_expected = |(policy, last): (&Policy, &PolicyRow)| {
        if cut {
            return policy.fits(&context)
                && !policy.is_overdue(pursuit.actions)
                && policy.row(&context).is_some();
        }
        let most = last.leads.first().and_then(|lead| policy.rows.get(lead.to? as usize));
        policy.fits(&context)
            && !policy.is_overdue(pursuit.actions)
            && brought(policy, last) == before.came
            && most.is_some_and(|most| next.is_some_and(|next| next.context == most.context))
    };
    if !last.is_some_and(as_expected) {
        let PolicySearch { policy, truncated } = policy_for(memory, body, world, &goal, foresight);
        let Some(policy) = policy else {
            let ending = match (truncated, goal.most()) {
                (true, _) => Ending::FurtherThanLooked,
                (false, None) => Ending::NothingLeadsThere,
                (false, Some(_)) => Ending::NothingBringsAny,
            };
            return stand(draft, &situation).or_else(|| give_up(draft, ending));
        };
        let after_actions = pursuit.actions;
        let policy = Arc::new(Policy { after_actions, ..policy });
        let begins = before.outcome.is_some_and(ActionOutcome::begins_episode) && known.is_some();
        let made = if next.is_some() || begins {
            PursuitEffect::Revised(policy)
        } else {
            let because = because(pursuit, before, last.is_some_and(|(_, last)| last.may_arrive()));
            let probability = policy.rows.first().map_or(0.0, |row| row.probability);
            let (chain, policy) = (Vec::new(), Some(policy));
            PursuitEffect::Planned(PlanRecord {
                after_actions,
                because,
                chain,
                policy,
                probability,
                truncated,
            })
        };
        draft.emit(Effect::Pursuit(made));
    }
    draft.emit(Effect::Pursuit(PursuitEffect::Acted));
    let memory = draft.memory();
    let pursuit = memory.content().pursuit_of(body)?;
    let policy = pursuit.plans.last().and_then(|plan| plan.policy.as_ref())?;
    let at = policy.row(&context)?;
    let row = policy.rows.get(at)?;
    let (mut execution, mut decision) = choice::carry_out(memory, &situation, row.action);
    execution.for_goal = true;
    decision.reason = Reason::Goal;
    let course = policy.course(at).into_iter().filter_map(|at| policy.rows.get(at)).map(|row| row.action);
    let course = course.collect();
    let (probability, worth) = (row.probability, policy.yields.get(at).map(|one| one.worth));
    decision.goal = Some(DecisionGoal { goal, chain: Vec::new(), at: 0, course, probability, worth });
    Some((execution, decision))
}

/// What was to come with the last action of a policy for most of something, most likely.
fn brought(policy: &Policy, last: &PolicyRow) -> Option<f64> {
    let at = policy.rows.iter().position(|row| row.context == last.context)?;
    policy.yields.get(at).map(|one| one.brings)
}

/// What a policy says of what comes next: where its last action led to another context, and that was foretold. One for most of something may
/// well stay where it is.
fn next_row<'a>(policy: &'a Policy, last: &PolicyRow, context: &WorldState) -> Option<&'a PolicyRow> {
    let to = policy.row(context)?;
    let foretold = last.leads.iter().any(|lead| lead.to.map(|to| to as usize) == Some(to));
    policy.rows.get(to).filter(|row| foretold && (row.context != last.context || !policy.yields.is_empty()))
}

/// Why another plan is made, when the last action was the last of the plan before, or not.
fn because(pursuit: &Pursuit, before: &PreviousExecution<'_>, was_last: bool) -> PlanCause {
    match before.outcome {
        _ if pursuit.plans_made == 0 => PlanCause::First,
        None => PlanCause::Interrupted,
        Some(outcome) if outcome.begins_episode() => PlanCause::Interrupted,
        Some(ActionOutcome::Done) if was_last => PlanCause::NotReached,
        Some(ActionOutcome::Done) => PlanCause::NextNotAllowed,
        Some(_) => PlanCause::NotCarriedOut,
    }
}
