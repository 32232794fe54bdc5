//! Goals: whether they hold, and the outcome of a primitive here. [`crate::cycle::plan`] finds the way to one.

use crate::cycle::babbling::executable;
use crate::cycle::{claims, stages};
use crate::memory::evidence::Foretold;
use crate::memory::instance::Instance;
use crate::memory::{Content, Memory};
use crate::nouns::curriculum::Curriculum;
use crate::nouns::execution::ChainLink;
use crate::nouns::observation::{MATCH_ATTEMPTS_MAX, Observation, Pattern, Substitution, Term};
use crate::nouns::pursuit::Patterns;
use crate::nouns::schema::{Concrete, Generalised, PostCondition, SchemaId};
use crate::nouns::vocabulary::{BodyId, PrimitiveId};
use crate::nouns::world_state::WorldState;

/// The expected outcome of a primitive here.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction {
    /// The schema that predicts it: of those that hold here, the one with the most pre-conditions; of equals a concrete one, then
    /// the one executed most, then the oldest.
    pub schema: SchemaId,
    /// The binding of the schema, when it is generalised.
    pub binding: Substitution,
    /// The post-conditions of the schema, each with its count; rarer ones included.
    pub outcomes: Vec<PostCondition<Observation>>,
}

/// The world state that these observations of a body make in the present stage, which may not lift all of their types, with what is
/// supposed besides.
#[must_use]
pub fn perceived(
    content: &Content,
    curriculum: &Curriculum,
    body: BodyId,
    observations: &[Observation],
) -> WorldState {
    let at = content.progress.stage.min(curriculum.stages.len().saturating_sub(1));
    let stage = curriculum.stages.get(at);
    let lifted = stage.map_or_else(Vec::new, |stage| stages::lifted(content, stage));
    let seen = observations.iter().filter(|o| stages::is_lifted(&lifted, o.kind()));
    content.perceived(body, &WorldState::new(seen.cloned()))
}

/// Whether `world` has a match for every one of these patterns.
#[must_use]
pub fn holds(goal: &Patterns, world: &WorldState) -> bool {
    let all: Vec<_> = world.observations().iter().map(|o| (o, 1.0)).collect();
    best_match(goal, &all).is_some()
}

/// Whether `observation` matches `pattern` by itself.
pub(crate) fn fits(pattern: &Pattern, observation: &Observation) -> bool {
    extended(pattern, observation, &Substitution::new()).is_some()
}

/// `binding` with what it takes to make `pattern` match `observation`.
fn extended(pattern: &Pattern, observation: &Observation, binding: &Substitution) -> Option<Substitution> {
    if pattern.kind() != observation.kind() {
        return None;
    }
    let mut binding = binding.clone();
    let mut terms = pattern.terms().iter();
    let agrees = terms.all(|(property, term)| {
        let seen = observation.properties().iter().find(|(known, _)| known == property);
        seen.is_some_and(|(_, value)| match term {
            Term::Constant(constant) => constant == value,
            Term::Variable(variable) => binding.bind(*variable, *value),
        })
    });
    agrees.then_some(binding)
}

/// Observations that together match `goal`, one for each pattern, as indexes into `options`, and the product of
/// their probabilities (each counted once): the most probable such choice, of equals the first.
pub(crate) fn best_match(goal: &Patterns, options: &[(&Observation, f64)]) -> Option<(f64, Vec<usize>)> {
    let mut search = Search { goal, options, budget: MATCH_ATTEMPTS_MAX, best: None };
    search.extend(&mut Vec::new(), &Substitution::new(), 1.0);
    search.best
}

struct Search<'a> {
    goal: &'a Patterns,
    options: &'a [(&'a Observation, f64)],
    budget: usize,
    best: Option<(f64, Vec<usize>)>,
}

impl Search<'_> {
    fn extend(&mut self, taken: &mut Vec<usize>, binding: &Substitution, probability: f64) {
        // Products only fall, so that what is no better already never will be.
        if probability <= 0.0 || self.best.as_ref().is_some_and(|(best, _)| probability <= *best) {
            return;
        }
        let Some(pattern) = self.goal.get(taken.len()) else {
            self.best = Some((probability, taken.clone()));
            return;
        };
        for (at, (observation, likely)) in self.options.iter().enumerate() {
            if self.budget == 0 {
                return;
            }
            self.budget -= 1;
            if let Some(binding) = extended(pattern, observation, binding) {
                let factor = if taken.contains(&at) { 1.0 } else { *likely };
                taken.push(at);
                self.extend(taken, &binding, probability * factor);
                taken.pop();
            }
        }
    }
}

/// The expected outcome of `action` in `world`; none if no schema of it holds here.
#[must_use]
pub fn predict(memory: &Memory, body: BodyId, world: &WorldState, action: PrimitiveId) -> Option<Prediction> {
    let ChainLink { schema, binding, .. } = in_use(memory, body, world, action)?;
    let outcomes = Instance::new(memory.content(), schema, &binding)?.post;
    Some(Prediction { schema, binding, outcomes })
}

/// The schema that predicts what `action` does in `world`, as [`Prediction::schema`] tells; with the concrete schema through which it
/// is carried out, if it is generalised.
pub(crate) fn in_use(
    memory: &Memory,
    body: BodyId,
    world: &WorldState,
    action: PrimitiveId,
) -> Option<ChainLink> {
    if !memory.content().vocabulary.can_do(body, action) {
        return None;
    }
    let content = memory.content();
    let executable = executable(memory, body, &memory.index().known_ids(world)).into_iter();
    let here: Vec<(SchemaId, &Concrete)> = executable
        .filter_map(|id| Some((id, content.concrete(id)?)))
        .filter(|(_, concrete)| concrete.action == action)
        .collect();
    let none = Substitution::new();
    let link = |schema: SchemaId, binding: &Substitution, carrier| ChainLink {
        schema,
        binding: binding.clone(),
        carrier,
    };
    let mut known: Vec<(ChainLink, usize)> =
        here.iter().map(|(id, concrete)| (link(*id, &none, None), concrete.pre.len())).collect();
    let in_force =
        |law: &Generalised| !content.mechanisms.claims || claims::makes(memory, body, action, world, law);
    for (id, law) in memory.laws(memory.index().generalised()) {
        for binding in memory.index().bindings(id, law, world.observations()) {
            let target = law.target_under(&binding);
            let carrier = target.and_then(|target| here.iter().find(|(_, c)| predicts(memory, c, &target)));
            let bound = carrier.zip(Instance::new(content, id, &binding));
            if let Some(((carrier, _), bound)) = bound.filter(|_| in_force(law)) {
                known.push((link(id, &binding, Some(*carrier)), bound.pre.len()));
            }
        }
    }
    let most = known.into_iter().max_by_key(|(link, conditions)| {
        let executions = content.schema(link.schema).map_or(0, |schema| schema.executions.trials);
        (*conditions, link.carrier.is_none(), executions, std::cmp::Reverse(link.schema))
    });
    most.map(|(link, _)| link)
}

/// What claims foretell of `action` in `world`, of each group of types that are told together, by what a
/// body recalls, if it is one's; nothing while no claims are kept.
#[must_use]
pub fn foretell(
    content: &Content,
    body: Option<BodyId>,
    world: &WorldState,
    action: PrimitiveId,
) -> Vec<Foretold> {
    claims::foretell(content, body, action, world)
}

/// Whether `concrete` predicts all of `target`.
fn predicts(memory: &Memory, concrete: &Concrete, target: &[Observation]) -> bool {
    target.iter().all(|wanted| {
        let id = memory.index().id(wanted);
        let post = concrete.post.iter().find(|post| Some(post.what) == id && !post.absent);
        post.is_some_and(|post| memory.parameters().predicts(post.count))
    })
}
