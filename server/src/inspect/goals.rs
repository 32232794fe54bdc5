//! Predictions, plans, and the goal that is pursued.

use pschema_inspect::codec::Problem;
use pschema_inspect::{
    Condition, DecisionGoal, GoalSummary, Plan, PlanCause, PlanQuery, PlanState, PlanStep, Prediction,
    PredictionQuery, Pursuit, PursuitPlan, PursuitQuery, PursuitState, SchemaInUse, Wanted,
};
use pschema_learner::decision;
use pschema_learner::execution::ChainLink;
use pschema_learner::goals;
use pschema_learner::memory::{Content, Memory};
use pschema_learner::notation;
use pschema_learner::observation::{Observation, TypeId};
use pschema_learner::plan;
use pschema_learner::policy::Policy;
use pschema_learner::probability::Count;
use pschema_learner::pursuit::{self, Ending, GOAL_PATTERNS_MAX, Goal, PursueError};
use pschema_learner::schema::PostCondition;
use pschema_learner::vocabulary::{BodyId, PrimitiveId};
use pschema_learner::world_state::WorldState;

use super::question::Inspect;
use super::{claims, schemas, text};
use crate::goal::{self, Asked};
use crate::mind::NO_BODY;
use crate::view::View;

impl Inspect for PredictionQuery {
    fn answer(&self, view: &View) -> Result<Prediction, Problem> {
        let (body, world) = here(view)?;
        let content = &view.content;
        let vocabulary = &content.vocabulary;
        let repertoire =
            vocabulary.bodies().get(usize::from(body.0)).map_or(&[][..], |body| &body.repertoire);
        let primitive =
            notation::parse_primitive(vocabulary, repertoire, &self.action).map_err(Problem::of)?;
        let memory = Memory::restore(content.clone(), view.setup.learner.parameters.clone());
        let found = goals::predict(&memory, body, &world, primitive);
        let at = usize::try_from(primitive.0).unwrap_or(usize::MAX);
        let attempts: Count = content.attempts.get(at).copied().unwrap_or_default();
        let foretold = claims::foretold(content, Some(body), primitive, &world);
        let outcomes = found.iter().flat_map(|prediction| &prediction.outcomes);
        let outcomes = outcomes.map(|post| condition(content, post));
        Ok(Prediction {
            body: text::body(content, body),
            action: notation::primitive(vocabulary, primitive),
            world: text::observations(&content.vocabulary, world.observations()),
            attempts: attempts.trials,
            carried_out: attempts.occurrences,
            outcomes: if foretold.is_empty() { outcomes.collect() } else { claims::singly(&foretold) },
            claims: foretold,
            schema: found.and_then(|prediction| {
                let link =
                    ChainLink { schema: prediction.schema, binding: prediction.binding, carrier: None };
                in_use(content, &link, Some(primitive))
            }),
        })
    }
}

impl Inspect for PlanQuery {
    fn answer(&self, view: &View) -> Result<Plan, Problem> {
        plan(view, Asked { goal: &self.goal, again: self.again, most: self.most.as_deref() })
    }
}

/// A plan that brings about from the world as it is what is asked for.
///
/// # Errors
/// When no body is attached, a pattern can't be read or asks for what the body never senses, or most is wanted of what is no value.
pub(super) fn plan(view: &View, asked: Asked<'_>) -> Result<Plan, Problem> {
    let (body, world) = here(view)?;
    let content = &view.content;
    let goal = goal::wanted(&content.vocabulary, view.declared.as_deref(), asked).map_err(Problem::of)?;
    let given = goal.patterns().len();
    if goal.most().is_none() && !(1..=GOAL_PATTERNS_MAX).contains(&given) {
        return Err(Problem::of(format!("a goal has 1 to {GOAL_PATTERNS_MAX} patterns, not {given}")));
    }
    if goal.most().is_some() && !content.mechanisms.makes_policies() {
        return Err(Problem::of(PursueError::NoPolicies));
    }
    let memory = Memory::restore(content.clone(), view.setup.learner.parameters.clone());
    let plan::PlanSearch { plan, truncated } = plan::plan(&memory, body, &world, &goal);
    let state = match &plan {
        Some(plan) if plan.steps.is_empty() => PlanState::HoldsAlready,
        Some(_) => PlanState::Found,
        None if truncated && content.mechanisms.makes_policies() => PlanState::FurtherThanLooked,
        None if goal.most().is_some() => PlanState::NothingBringsAny,
        None => PlanState::NothingLeadsThere,
    };
    let policy = plan.as_ref().and_then(|plan| plan.policy.as_ref());
    let steps = plan.iter().flat_map(|plan| &plan.steps);
    Ok(Plan {
        body: text::body(content, body),
        wanted: wanted(content, &goal),
        world: text::observations(&content.vocabulary, world.observations()),
        state,
        probability: plan.as_ref().map(|plan| plan.probability),
        expected: policy.and_then(Policy::worth),
        expected_actions: policy.filter(|_| goal.most().is_none()).map(|policy| policy.actions),
        contexts: policy.map(|policy| u32::try_from(policy.rows.len()).unwrap_or(u32::MAX)),
        steps: steps.map(|step| plan_step(content, step)).collect(),
        search_truncated: truncated,
    })
}

impl Inspect for PursuitQuery {
    fn answer(&self, view: &View) -> Result<Pursuit, Problem> {
        let content = &view.content;
        let pursuit = content.pursuit.as_ref().ok_or_else(|| Problem::of("no goal has been pursued yet"))?;
        let state = pursuit.ended.map_or(PursuitState::Pursued, ending);
        let plans = pursuit.plans.iter().map(|plan| PursuitPlan {
            after_actions: plan.after_actions,
            because: cause(plan.because),
            probability: plan.probability,
            expected: plan.policy.as_ref().and_then(|policy| policy.worth()),
            chain: chain(content, &plan.chain),
            course: plan.policy.as_ref().map_or_else(Vec::new, |policy| course(content, policy)),
            search_truncated: plan.truncated,
        });
        Ok(Pursuit {
            number: pursuit.number,
            body: text::body(content, pursuit.body),
            wanted: wanted(content, &pursuit.goal),
            state,
            achieved: state == PursuitState::Achieved,
            came: came(pursuit),
            actions: pursuit.actions,
            actions_max: pursuit.actions_max,
            plans_made: pursuit.plans_made,
            plans: plans.collect(),
        })
    }
}

/// The goal that is pursued, in short.
pub(super) fn summary(view: &View) -> Option<GoalSummary> {
    let content = &view.content;
    let pursuit = content.pursuit.as_ref().filter(|pursuit| pursuit.under_way())?;
    Some(GoalSummary {
        number: pursuit.number,
        body: text::body(content, pursuit.body),
        wanted: wanted(content, &pursuit.goal),
        actions: pursuit.actions,
        actions_max: pursuit.actions_max,
        came: came(pursuit),
    })
}

/// The goal that a decision follows.
pub(super) fn followed(content: &Content, from: &decision::DecisionGoal) -> DecisionGoal {
    DecisionGoal {
        wanted: wanted(content, &from.goal),
        chain: chain(content, &from.chain),
        at: u32::try_from(from.at).unwrap_or(u32::MAX),
        course: from.course.iter().map(|action| notation::primitive(&content.vocabulary, *action)).collect(),
        probability: from.probability,
        expected: from.worth,
    }
}

/// The body that tools ask about, with what it perceives under the constraints of the present stage.
fn here(view: &View) -> Result<(BodyId, WorldState), Problem> {
    let (body, observations) = view.perceived().ok_or_else(|| Problem::of(NO_BODY))?;
    Ok((body, goals::perceived(&view.content, &view.setup.curriculum, body, observations)))
}

fn wanted(content: &Content, goal: &Goal) -> Wanted {
    let pattern = |pattern| notation::pattern(&content.vocabulary, pattern);
    let name = |kind: TypeId| {
        let known = content.vocabulary.types().get(usize::from(kind.0));
        known.map(|known| known.declared.name.clone()).unwrap_or_default()
    };
    Wanted {
        goal: goal.patterns().iter().map(pattern).collect(),
        again: goal.is_again(),
        most: goal.most().map(name),
    }
}

/// The sum of what came for a goal, if most of something is wanted.
fn came(pursuit: &pursuit::Pursuit) -> Option<f64> {
    pursuit.goal.most().map(|_| pursuit.came)
}

fn condition(content: &Content, post: &PostCondition<Observation>) -> Condition {
    text::condition(text::observation(&content.vocabulary, &post.what), post.absent, post.count)
}

fn plan_step(content: &Content, step: &plan::PlanStep) -> PlanStep {
    PlanStep {
        action: notation::primitive(&content.vocabulary, step.action),
        schema: step.link.as_ref().and_then(|link| in_use(content, link, Some(step.action))),
        relies_on: step.relies_on.iter().map(|post| condition(content, post)).collect(),
        through: step.through.iter().map(|post| condition(content, post)).collect(),
        reliability: step.reliability,
        probability: step.probability,
    }
}

/// The actions of a policy when all comes about that is most likely.
fn course(content: &Content, policy: &Policy) -> Vec<String> {
    let rows = policy.course(0).into_iter().filter_map(|at| policy.rows.get(at));
    rows.map(|row| notation::primitive(&content.vocabulary, row.action)).collect()
}

/// The schemas of a chain, each under its binding.
pub(super) fn chain(content: &Content, links: &[ChainLink]) -> Vec<SchemaInUse> {
    links.iter().filter_map(|link| in_use(content, link, None)).collect()
}

/// A schema under its binding; none if memory has no such schema. Its action is `action` if given, else that of its carrier.
fn in_use(content: &Content, link: &ChainLink, action: Option<PrimitiveId>) -> Option<SchemaInUse> {
    let schema = content.schema(link.schema)?;
    let concrete = || content.concrete(link.carrier.unwrap_or(link.schema));
    let action = action.or_else(|| concrete().map(|concrete| concrete.action));
    Some(SchemaInUse {
        id: link.schema.0,
        kind: schemas::kind(schema),
        text: notation::schema(content, schema),
        binding: text::binding(content, link.schema, &link.binding),
        action: action.map(|action| notation::primitive(&content.vocabulary, action)).unwrap_or_default(),
        carrier: link.carrier.map(|carrier| carrier.0),
    })
}

fn cause(cause: pursuit::PlanCause) -> PlanCause {
    match cause {
        pursuit::PlanCause::First => PlanCause::First,
        pursuit::PlanCause::NotReached => PlanCause::NotReached,
        pursuit::PlanCause::NextNotAllowed => PlanCause::NextNotAllowed,
        pursuit::PlanCause::NotCarriedOut => PlanCause::NotCarriedOut,
        pursuit::PlanCause::Interrupted => PlanCause::Interrupted,
    }
}

fn ending(ending: Ending) -> PursuitState {
    match ending {
        Ending::Achieved => PursuitState::Achieved,
        Ending::NothingLeadsThere => PursuitState::NothingLeadsThere,
        Ending::ActionsUsedUp => PursuitState::ActionsUsedUp,
        Ending::Constrained => PursuitState::Constrained,
        Ending::Cancelled => PursuitState::Cancelled,
        Ending::FurtherThanLooked => PursuitState::FurtherThanLooked,
        Ending::NothingBringsAny => PursuitState::NothingBringsAny,
    }
}
