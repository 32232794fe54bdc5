//! Goals: what a primitive would do here, how to bring something about, and with what probability. Only what
//! the goal asks for counts (paper, II-A): that a ball may fall does not matter to who moves a block.

use crate::bound::Bound;
use crate::chaining::{self, Access, BINDINGS_MAX, Reach, can_do};
use crate::effect::ChainLink;
use crate::memory::Memory;
use crate::notation;
use crate::observation::{Observation, Pattern, Substitution, bindings};
use crate::schema::{PostCondition, SchemaId};
use crate::target_action::reliability;
use crate::vocabulary::{BodyId, PrimitiveId};
use crate::world_state::WorldState;

/// What is to be brought about: observations that match all of these patterns, each some observation; what a
/// pattern leaves out may be anything.
pub type Goal = [Pattern];

/// A way to bring a goal about.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The schemas to execute, in order; none when the goal holds already.
    pub chain: Vec<ChainLink>,
    /// The probability that the chain brings the goal about, counting only what it relies on.
    pub probability: f64,
    /// Whether the search used up its budget, so that there may be a better one.
    pub search_truncated: bool,
}

/// What a primitive is expected to do here.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction {
    /// The schema that says so: of those that hold here, the one with the most pre-conditions; of equals a
    /// concrete one, then the one executed most, then the oldest.
    pub schema: SchemaId,
    /// Its binding, when it is generalised.
    pub binding: Substitution,
    /// Each outcome with its count; rarer ones included.
    pub outcomes: Vec<PostCondition<Observation>>,
}

/// Whether `world` has a match for every pattern of `goal`.
#[must_use]
pub fn holds(goal: &Goal, world: &WorldState) -> bool {
    goal.iter().all(|pattern| world.observations().iter().any(|o| fits(pattern, o)))
}

fn fits(pattern: &Pattern, observation: &Observation) -> bool {
    notation::matches(pattern, &Pattern::from(observation))
}

/// What `action` would do in `world`; none if nothing that is known holds here.
#[must_use]
pub fn predict(memory: &Memory, body: BodyId, world: &WorldState, action: PrimitiveId) -> Option<Prediction> {
    let content = memory.content();
    let mut known: Vec<(SchemaId, Substitution, Bound)> = memory
        .index()
        .with_action(action)
        .iter()
        .filter_map(|id| Some((*id, Substitution::new(), Bound::new(content, *id, &Substitution::new())?)))
        .collect();
    let reach = Reach::search(memory, body, world);
    for id in memory.index().generalised() {
        let Some(generalised) = content.schema(*id).and_then(|s| s.generalised()) else { continue };
        for binding in bindings(&generalised.pre, world.observations(), BINDINGS_MAX) {
            let target: Option<Vec<_>> = generalised.target.iter().map(|p| p.apply(&binding)).collect();
            let carried = target.and_then(|target| chaining::achieve(memory, &reach, body, &target));
            let carrier = carried.filter(|found| found.access.preceding == 0).map(|found| found.carrier);
            let does =
                carrier.and_then(|id| content.schema(id)?.concrete()).is_some_and(|c| c.action == action);
            if let Some(bound) = does.then(|| Bound::new(content, *id, &binding)).flatten() {
                known.push((*id, binding, bound));
            }
        }
    }
    known
        .into_iter()
        .filter(|(_, _, bound)| world.satisfies(&bound.pre))
        .max_by_key(|(id, _, bound)| {
            let schema = content.schema(*id);
            let concrete = schema.is_some_and(|s| s.concrete().is_some());
            let executions = schema.map_or(0, |s| s.executions.trials);
            (bound.pre.len(), concrete, executions, std::cmp::Reverse(*id))
        })
        .map(|(schema, binding, bound)| Prediction { schema, binding, outcomes: bound.post })
}

/// The most probable way to bring `goal` about from `world`; of equals the shortest, then the one whose last
/// schema is oldest. None if nothing known leads there.
#[must_use]
pub fn plan(memory: &Memory, body: BodyId, world: &WorldState, goal: &Goal) -> Option<Plan> {
    if holds(goal, world) {
        return Some(Plan { chain: Vec::new(), probability: 1.0, search_truncated: false });
    }
    let reach = Reach::search(memory, body, world);
    let finals = concrete_finals(memory, body, &reach, goal)
        .into_iter()
        .chain(generalised_finals(memory, body, &reach, goal));
    let best = finals.max_by(|a, b| {
        a.probability
            .total_cmp(&b.probability)
            .then_with(|| b.access.preceding.cmp(&a.access.preceding))
            .then_with(|| b.link.schema.cmp(&a.link.schema))
    })?;
    let mut chain = reach.chain(best.access);
    chain.push(best.link);
    Some(Plan { chain, probability: best.probability, search_truncated: reach.truncated })
}

/// The last schema of a possible plan.
struct Final {
    link: ChainLink,
    access: Access,
    probability: f64,
}

fn concrete_finals(memory: &Memory, body: BodyId, reach: &Reach, goal: &Goal) -> Vec<Final> {
    let content = memory.content();
    let mut found = Vec::new();
    for (at, schema) in content.schemas.iter().enumerate() {
        let Some(concrete) = schema.concrete() else { continue };
        let id = SchemaId(u32::try_from(at).unwrap_or(u32::MAX));
        let Some(bound) = Bound::new(content, id, &Substitution::new()) else { continue };
        if !can_do(memory, body, concrete.action) || !touches(memory, &bound, goal) {
            continue;
        }
        let Some(access) = reach.access(&concrete.pre) else { continue };
        let Some(sure) = brings_about(memory, &bound, reach.context(access), goal) else { continue };
        let link = ChainLink { schema: id, binding: Substitution::new(), carrier: None };
        let probability = sure * access.probability * reliability(memory, concrete.action);
        found.push(Final { link, access, probability });
    }
    found
}

fn generalised_finals(memory: &Memory, body: BodyId, reach: &Reach, goal: &Goal) -> Vec<Final> {
    let content = memory.content();
    let mut found = Vec::new();
    for id in memory.index().generalised() {
        let Some(generalised) = content.schema(*id).and_then(|s| s.generalised()) else { continue };
        for access in reach.all() {
            let context = reach.context(access);
            for binding in bindings(&generalised.pre, context.observations(), BINDINGS_MAX) {
                let target: Option<Vec<_>> = generalised.target.iter().map(|p| p.apply(&binding)).collect();
                let carried = target.and_then(|t| reach.carrier(memory, body, &t, access));
                let (Some(bound), Some((carrier, sure))) = (Bound::new(content, *id, &binding), carried)
                else {
                    continue;
                };
                let pre: Vec<_> = bound.pre.iter().collect();
                let action = content.schema(carrier).and_then(|s| s.concrete()).map(|c| c.action);
                let masked = action.is_some_and(|action| memory.index().exact(&pre, action).is_some());
                if masked || !touches(memory, &bound, goal) {
                    continue;
                }
                let Some(known) = brings_about(memory, &bound, context, goal) else { continue };
                let link = ChainLink { schema: *id, binding, carrier: Some(carrier) };
                found.push(Final { link, access, probability: known * sure * access.probability });
            }
        }
    }
    found
}

/// Whether the schema predicts anything of the goal: a plan does not end with what has no part in it.
fn touches(memory: &Memory, bound: &Bound, goal: &Goal) -> bool {
    bound
        .predicted(memory.parameters())
        .any(|post| !post.absent && goal.iter().any(|pattern| fits(pattern, &post.what)))
}

/// The probability that executing the schema in `context` makes all of `goal` hold: the product over just
/// the outcomes that the goal needs; what it needs and the context has already must not be taken away.
fn brings_about(memory: &Memory, bound: &Bound, context: &WorldState, goal: &Goal) -> Option<f64> {
    let mut probability = 1.0;
    for pattern in goal {
        let caused = bound
            .predicted(memory.parameters())
            .filter(|post| !post.absent && fits(pattern, &post.what))
            .map(|post| post.count.ratio())
            .max_by(f64::total_cmp);
        let kept = || {
            let taken = |o: &Observation| bound.post.iter().any(|p| p.absent && p.what == *o);
            context.observations().iter().any(|o| fits(pattern, o) && !taken(o))
        };
        match caused {
            Some(ratio) => probability *= ratio,
            None if kept() => (),
            None => return None,
        }
    }
    Some(probability)
}
