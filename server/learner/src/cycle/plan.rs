//! Plans: the chain of schemas that brings a goal about, and with what probability. Only what the goal and the
//! later schemas of the chain rely on counts (paper, II-A): that a ball may fall does not matter to who
//! moves a block.

use std::collections::BTreeSet;

use crate::cycle::babbling::executable;
use crate::cycle::chaining::{Access, Reach};
use crate::cycle::goals::{best_match, fits, foretell, holds, in_use};
use crate::cycle::most::policy_for;
use crate::cycle::policy::PolicySearch;
use crate::memory::Memory;
use crate::memory::evidence::Foresight;
use crate::memory::evidence::Foretold;
use crate::memory::instance::Instance;
use crate::nouns::execution::ChainLink;
use crate::nouns::observation::{Observation, Substitution};
use crate::nouns::policy::{Policy, PolicyRow};
use crate::nouns::probability::Count;
use crate::nouns::pursuit::{Goal, Patterns};
use crate::nouns::schema::{ObservationId, PostCondition, SchemaId};
use crate::nouns::vocabulary::{BodyId, PrimitiveId};
use crate::nouns::world_state::WorldState;

/// How many chains are weighed for one plan; a search that comes to this number says so.
pub const CHAINS_WEIGHED_MAX: usize = 1_024;

/// A plan: a chain of schemas that brings a goal about (II-A), or a policy that does.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The schemas to execute, in order; none when the goal holds already. Of a policy, the actions to the goal when all comes about
    /// that is most likely; fewer than that where a context would come again first.
    pub steps: Vec<PlanStep>,
    /// The probability that it brings the goal about, above 0 and at most 1: the product of those of the steps, or that of a policy,
    /// whatever its actions lead to.
    pub probability: f64,
    /// What to do in each context, if it is a policy.
    pub policy: Option<Policy>,
}

/// The result of a search for a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanSearch {
    /// The best plan; none if nothing known leads there.
    pub plan: Option<Plan>,
    /// Whether the search used up its budget, so that there may be a better one.
    pub truncated: bool,
}

/// One step of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanStep {
    /// The schema, its binding, and its carrier when it is generalised; none where a policy asks for a primitive that no schema covers.
    pub link: Option<ChainLink>,
    /// The primitive to be sent.
    pub action: PrimitiveId,
    /// The outcomes on which the goal or later steps rely: an observation that is to be made, or an absence that is *not* to happen.
    /// Of a policy, what is foretold most surely of all types on which the goal depends, where that is a change.
    pub relies_on: Vec<PostCondition<Observation>>,
    /// Of a generalised schema, the outcomes of its carrier that are its target.
    pub through: Vec<PostCondition<Observation>>,
    /// The reliability of the primitive, in 0..=1: how surely the body carries it out.
    pub reliability: f64,
    /// `reliability` times the probabilities of the outcomes in `through` and in `relies_on`; of a policy, the probability of what is
    /// foretold most surely.
    pub probability: f64,
}

impl Plan {
    /// The schemas, without what they rely on.
    #[must_use]
    pub fn chain(&self) -> Vec<ChainLink> {
        self.steps.iter().filter_map(|step| step.link.clone()).collect()
    }
}

/// The most probable way to bring `goal` about from `world`; of equals the shortest, then the one whose last
/// schema is oldest, then the first found. Events of `world` are over: they hold no goal. For most of something, the policy that brings it.
#[must_use]
pub fn plan(memory: &Memory, body: BodyId, world: &WorldState, goal: &Goal) -> PlanSearch {
    let world = &world.lived_by(memory.rules());
    if memory.content().mechanisms.makes_policies() && !holds_already(memory, world, goal) {
        let PolicySearch { policy, truncated } =
            policy_for(memory, body, world, goal, &mut Foresight::default());
        return PlanSearch { plan: policy.map(|policy| by_policy(memory, body, world, policy)), truncated };
    }
    plan_along(memory, body, world, goal, &Reach::search(memory, body, world))
}

/// Whether nothing need be done for a goal.
fn holds_already(memory: &Memory, world: &WorldState, goal: &Goal) -> bool {
    matches!(goal, Goal::Observed(patterns) if holds(patterns, &world.lasting(memory.rules())))
}

/// The plan that a policy is.
fn by_policy(memory: &Memory, body: BodyId, world: &WorldState, policy: Policy) -> Plan {
    let kinds = &policy.kinds;
    let others = world.filter(|o| kinds.binary_search(&o.kind()).is_err());
    let step = |row: &PolicyRow| {
        let there = row.context.iter().chain(others.observations()).cloned();
        let there = WorldState::new(there);
        let link = in_use(memory, body, &there, row.action);
        let relies_on = foretell(memory.content(), Some(body), &there, row.action)
            .into_iter()
            .filter(|facet| facet.kinds.iter().any(|kind| kinds.binary_search(kind).is_ok()))
            .flat_map(|facet| changes(&facet, &there))
            .collect();
        PlanStep {
            link,
            action: row.action,
            relies_on,
            through: Vec::new(),
            reliability: memory.content().reliability(row.action),
            probability: row.leads.first().map_or(0.0, |lead| lead.probability),
        }
    };
    let course = policy.course(0);
    let steps = course.into_iter().filter_map(|at| policy.rows.get(at)).map(step).collect();
    let probability = policy.rows.first().map_or(0.0, |row| row.probability);
    Plan { steps, probability, policy: Some(policy) }
}

/// What the most frequent outcome of a facet changes.
fn changes(facet: &Foretold, before: &WorldState) -> Vec<PostCondition<Observation>> {
    let Some((after, occurrences)) = facet.outcomes.first() else { return Vec::new() };
    let count = Count { occurrences: *occurrences, trials: facet.trials };
    let new = after.iter().filter(|o| !before.contains(o)).map(|o| (o, false));
    let of_facet = |o: &&Observation| facet.kinds.binary_search(&o.kind()).is_ok();
    let gone = before.observations().iter().filter(of_facet).filter(|o| !after.contains(o));
    let changes = new.chain(gone.map(|o| (o, true)));
    changes.map(|(what, absent)| PostCondition { what: what.clone(), absent, count }).collect()
}

/// As [`plan`], along a search that was made from `world`.
pub(crate) fn plan_along(
    memory: &Memory,
    body: BodyId,
    world: &WorldState,
    goal: &Goal,
    reach: &Reach,
) -> PlanSearch {
    if holds_already(memory, world, goal) {
        return PlanSearch {
            plan: Some(Plan { steps: Vec::new(), probability: 1.0, policy: None }),
            truncated: false,
        };
    }
    let mut found = PlanSearch { plan: None, truncated: reach.truncated };
    if goal.most().is_some() {
        return found;
    }
    let (patterns, again) = (goal.patterns(), goal.is_again());
    let wanted = wanted(memory, patterns);
    let start = world.context(memory.rules());
    let mut weighed = 0;
    for access in reach.all() {
        // Nothing longer is better than what is certain.
        let certain = found.plan.as_ref().filter(|best| best.probability >= 1.0);
        if certain.is_some_and(|best| reach.chain(access).len() >= best.steps.len()) {
            continue;
        }
        let context = reach.context(access);
        // What holds already is not brought about. What is there now is known to the last; further on, as far as it is context.
        let is_first = reach.chain(access).is_empty();
        let holds_there = || {
            if is_first { holds(patterns, &world.lasting(memory.rules())) } else { holds(patterns, context) }
        };
        if again && holds_there() {
            continue;
        }
        let concrete = concrete_finals(memory, body, context, &wanted).into_iter();
        for last in concrete.chain(generalised_finals(memory, body, reach, access, patterns)) {
            if weighed == CHAINS_WEIGHED_MAX {
                found.truncated = true;
                return found;
            }
            weighed += 1;
            let mut chain = reach.chain(access);
            chain.push(last);
            let weighed = weigh(memory, &start, &chain, patterns);
            if let Some(plan) = weighed.filter(|plan| found.plan.as_ref().is_none_or(|best| plan.beats(best)))
            {
                found.plan = Some(plan);
            }
        }
    }
    found
}

impl Plan {
    fn beats(&self, other: &Self) -> bool {
        let last = |plan: &Self| plan.steps.last().and_then(|step| Some(step.link.as_ref()?.schema));
        let shape = |plan: &Self| (plan.steps.len(), last(plan));
        match self.probability.total_cmp(&other.probability) {
            std::cmp::Ordering::Equal => shape(self) < shape(other),
            order => order.is_gt(),
        }
    }
}

fn link(schema: SchemaId, binding: Substitution, carrier: Option<SchemaId>) -> ChainLink {
    ChainLink { schema, binding, carrier }
}

/// Observations that match a pattern of the goal, by number.
fn wanted(memory: &Memory, goal: &Patterns) -> Vec<ObservationId> {
    let known = memory.content().observations.iter();
    let mut ids: Vec<_> = known
        .filter(|o| goal.iter().any(|pattern| fits(pattern, o)))
        .filter_map(|o| memory.index().id(o))
        .collect();
    ids.sort_unstable();
    ids
}

/// Concrete schemas that can be executed in `context` and predict something `wanted`, by number: a plan does not
/// end with what has no part in the goal.
fn concrete_finals(
    memory: &Memory,
    body: BodyId,
    context: &WorldState,
    wanted: &[ObservationId],
) -> Vec<ChainLink> {
    let content = memory.content();
    let has_part = |id: &SchemaId| {
        let concrete = content.concrete(*id);
        concrete.is_some_and(|concrete| {
            let mut caused = concrete.post.iter().filter(|post| !post.absent);
            caused.any(|post| {
                wanted.binary_search(&post.what).is_ok() && memory.parameters().predicts(post.count)
            })
        })
    };
    let executable = executable(memory, body, &memory.index().known_ids(context)).into_iter();
    executable.filter(has_part).map(|id| link(id, Substitution::new(), None)).collect()
}

fn generalised_finals(
    memory: &Memory,
    body: BodyId,
    reach: &Reach,
    access: Access,
    goal: &Patterns,
) -> Vec<ChainLink> {
    let content = memory.content();
    let mut found = Vec::new();
    for (id, law) in memory.laws(memory.index().generalised()) {
        for binding in memory.index().bindings(id, law, reach.context(access).observations()) {
            let Some(bound) = Instance::new(content, id, &binding) else { continue };
            if !has_part(memory, &bound, goal) {
                continue;
            }
            let carried =
                law.target_under(&binding).and_then(|target| reach.carrier(memory, body, &target, access));
            let Some((carrier, _)) = carried else { continue };
            let pre: Vec<_> = bound.pre.iter().collect();
            let action = content.concrete(carrier).map(|c| c.action);
            // An example or counter-example stands in for it (IV-A).
            if action.is_some_and(|action| memory.index().exact(&pre, action).is_none()) {
                found.push(link(id, binding, Some(carrier)));
            }
        }
    }
    found
}

/// Whether the schema predicts anything of the goal.
fn has_part(memory: &Memory, bound: &Instance, goal: &Patterns) -> bool {
    let mut caused = bound.predicted(memory.parameters()).filter(|post| !post.absent);
    caused.any(|post| goal.iter().any(|pattern| fits(pattern, &post.what)))
}

/// One link of a chain in the context that the links before it lead to.
struct LinkInContext {
    link: ChainLink,
    bound: Instance,
    action: PrimitiveId,
    reliability: f64,
    through: Vec<PostCondition<Observation>>,
    /// Its own pre-conditions and its carrier's.
    pre: Vec<Observation>,
    context: WorldState,
}

/// The chain as a plan, if it can bring the goal about from `start`. Goes backwards from the goal: what the goal
/// needs of the last schema or of what was there before it, then what the schemas before have to leave behind.
fn weigh(memory: &Memory, start: &WorldState, chain: &[ChainLink], goal: &Patterns) -> Option<Plan> {
    let mut placed = place(memory, start, chain)?;
    let last = placed.pop()?;
    let (relies_on, kept) = brings_about(memory, &last, goal)?;
    let mut needed: BTreeSet<Observation> = kept.into_iter().collect();
    let mut steps = vec![step(&last, relies_on)];
    needed.extend(last.pre);
    for before in placed.into_iter().rev() {
        let relies_on: Vec<_> = needed.iter().filter_map(|o| outcome(&before.bound, o).cloned()).collect();
        for made in relies_on.iter().filter(|post| !post.absent && !before.context.contains(&post.what)) {
            needed.remove(&made.what);
        }
        steps.push(step(&before, relies_on));
        needed.extend(before.pre);
    }
    steps.reverse();
    let probability = steps.iter().map(|step| step.probability).product();
    (probability > 0.0).then_some(Plan { steps, probability, policy: None })
}

fn step(placed: &LinkInContext, relies_on: Vec<PostCondition<Observation>>) -> PlanStep {
    let LinkInContext { link, action, reliability, through, .. } = placed;
    let needs = through.iter().chain(&relies_on);
    let probability = needs.fold(*reliability, |product, post| product * likely(post));
    let (link, through) = (Some(link.clone()), through.clone());
    PlanStep { link, action: *action, relies_on, through, reliability: *reliability, probability }
}

/// The probability that what is relied on holds: that it happens, or of an absence that it does not.
fn likely(post: &PostCondition<Observation>) -> f64 {
    if post.absent { 1.0 - post.count.ratio() } else { post.count.ratio() }
}

fn place(memory: &Memory, start: &WorldState, chain: &[ChainLink]) -> Option<Vec<LinkInContext>> {
    let content = memory.content();
    let mut context = start.clone();
    let mut placed = Vec::new();
    for link in chain {
        let bound = Instance::new(content, link.schema, &link.binding)?;
        let carrier = content.concrete(link.carrier.unwrap_or(link.schema))?;
        let mut pre = bound.pre.clone();
        if link.carrier.is_some() {
            pre.extend(carrier.pre.iter().map(|o| content.observation(*o).clone()));
        }
        let mut through = Vec::new();
        if let Some(generalised) = content.generalised(link.schema) {
            for pattern in generalised.target.iter() {
                let wanted = pattern.apply(&link.binding)?;
                let id = memory.index().id(&wanted)?;
                let post = carrier.post.iter().find(|post| post.what == id && !post.absent)?;
                through.push(post.of(wanted));
            }
        }
        let after = after(memory, &context, &bound);
        let before = std::mem::replace(&mut context, after);
        let (link, action) = (link.clone(), carrier.action);
        let reliability = memory.content().reliability(action);
        placed.push(LinkInContext { link, bound, action, reliability, through, pre, context: before });
    }
    Some(placed)
}

/// The context after `bound` in `context`, if all comes about that it predicts.
fn after(memory: &Memory, context: &WorldState, bound: &Instance) -> WorldState {
    let mut after = context.observations().to_vec();
    let precondition = |post: &&PostCondition<Observation>| memory.rules().of(post.what.kind()).precondition;
    for post in bound.predicted(memory.parameters()).filter(precondition) {
        match (post.absent, context.contains(&post.what)) {
            (true, true) => after.retain(|o| *o != post.what),
            (false, false) => after.push(post.what.clone()),
            _ => (),
        }
    }
    WorldState::new(after)
}

/// What `bound` does to `observation`, if it was ever seen to do anything: make it hold or leave it, rather than
/// end it.
fn outcome<'a>(bound: &'a Instance, observation: &Observation) -> Option<&'a PostCondition<Observation>> {
    let of = |absent| bound.post.iter().find(|p| p.absent == absent && p.what == *observation);
    of(false).or_else(|| of(true))
}

type Reliance = (Vec<PostCondition<Observation>>, Vec<Observation>);

/// What the goal needs of the last schema: outcomes that it relies on, and observations that must be there
/// before, for the schema leaves them.
fn brings_about(memory: &Memory, last: &LinkInContext, goal: &Patterns) -> Option<Reliance> {
    let LinkInContext { bound, context, .. } = last;
    let wanted = |o: &Observation| goal.iter().any(|pattern| fits(pattern, o));
    let caused = bound.predicted(memory.parameters()).filter(|p| !p.absent && wanted(&p.what));
    let caused: Vec<_> = caused.map(|post| (&post.what, post.count.ratio())).collect();
    let kept = context.observations().iter().filter(|o| wanted(o) && !caused.iter().any(|(c, _)| c == o));
    let kept = kept.map(|o| {
        // What no outcome speaks of stays as it is.
        (o, outcome(bound, o).map_or(1.0, likely))
    });
    let options: Vec<_> = caused.iter().copied().chain(kept).collect();
    let (_, chosen) = best_match(goal, &options)?;
    let chosen: BTreeSet<_> = chosen.into_iter().filter_map(|at| options.get(at)).map(|(o, _)| *o).collect();
    let relied = chosen.iter().filter_map(|o| outcome(bound, o).cloned());
    let before = chosen.iter().filter(|o| context.contains(o)).map(|o| (*o).clone());
    Some((relied.collect(), before.collect()))
}
