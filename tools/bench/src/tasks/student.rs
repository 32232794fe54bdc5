//! A learner that lives in an exact world, and its foretelling.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::{Duration, Instant};

use pschema_exact::Distribution;
use pschema_exact::declaration::{self, Declaration};
use pschema_learner::curriculum::Curriculum;
use pschema_learner::effect::Effect;
use pschema_learner::evidence::Foretold;
use pschema_learner::execution::Execution;
use pschema_learner::mechanisms::Mechanisms;
use pschema_learner::memory::Memory;
use pschema_learner::observation::{Observation, Pattern, Substitution, TypeId};
use pschema_learner::parameters::Parameters;
use pschema_learner::pursuit::Pursuit;
use pschema_learner::schema::{Concrete, SchemaId};
use pschema_learner::vocabulary::{BodyId, PrimitiveId};
use pschema_learner::world_state::WorldState;
use pschema_learner::{ActionOutcome, Frame, Learner, Output, goals};
use pschema_tools::kit::Failure;

use super::foretelling::Foretelling;
use super::lexicon::{Lexicon, declared};

/// How many alternatives one foretelling keeps: the most probable.
const ALTERNATIVES_MAX: usize = 1_024;

/// A learner in an exact world, with default parameters and no curriculum but to play.
pub(crate) struct Student {
    pub(crate) lexicon: Lexicon,
    learner: Learner,
    body: BodyId,
    /// The concrete schemas of each primitive, and how many of all schemas have been sorted so.
    of_primitive: Vec<Vec<SchemaId>>,
    sorted: usize,
    /// The time that all its steps took, and their number.
    took: Duration,
    steps: u32,
}

impl Student {
    /// A learner that knows nothing in a world that is declared so. If others choose its actions it is held, as an operator holds it: it goes
    /// on learning, and chooses nothing.
    pub(crate) fn new(
        declaration: &Declaration,
        seed: u64,
        led: bool,
        mechanisms: Mechanisms,
    ) -> Result<Self, Failure> {
        let mut learner =
            Learner::new(seed, Parameters::default(), Curriculum::free("exact")).map_err(Failure::of)?;
        learner.set_mechanisms(mechanisms);
        let (body, _) = learner.declare(declared(declaration)).map_err(Failure::of)?;
        let lexicon = Lexicon::new(declaration, &mut learner);
        if led {
            learner.set_held(true);
        }
        let of_primitive = vec![Vec::new(); declaration.repertoire.len()];
        Ok(Self { lexicon, learner, body, of_primitive, sorted: 0, took: Duration::ZERO, steps: 0 })
    }

    /// Perceives `world`, and learns from the action that led there if one was `carried_out`. Returns the action that it chooses; none
    /// when it is led.
    pub(crate) fn step(&mut self, world: &WorldState, carried_out: bool) -> Option<PrimitiveId> {
        self.perceive(world, carried_out.then_some(ActionOutcome::Done))
    }

    /// The same where what came of the action is this; none if there was none.
    pub(crate) fn perceive(
        &mut self,
        world: &WorldState,
        outcome: Option<ActionOutcome>,
    ) -> Option<PrimitiveId> {
        let observations = world.observations().to_vec();
        let frame = Frame { body: self.body, outcome, observations };
        let began = Instant::now();
        let step = self.learner.step(&frame);
        self.took += began.elapsed();
        self.steps += 1;
        self.sort();
        if let Output::Act(primitive) = step.output { Some(primitive) } else { None }
    }

    /// Notes the primitives of new schemas.
    fn sort(&mut self) {
        let content = self.learner.memory().content();
        for at in self.sorted..content.schemas.len() {
            let id = SchemaId(u32::try_from(at).unwrap_or(u32::MAX));
            let of_primitive = content.concrete(id).map(|concrete| concrete.action.0 as usize);
            if let Some(schemas) = of_primitive.and_then(|primitive| self.of_primitive.get_mut(primitive)) {
                schemas.push(id);
            }
        }
        self.sorted = content.schemas.len();
    }

    /// The same learner, as if it had chosen `primitive` itself where it perceived `world`: what it executes is the most specific schema of the
    /// primitive that holds there.
    pub(crate) fn led_to(self, primitive: PrimitiveId, world: &WorldState) -> Result<Self, Failure> {
        let world = &self.perceived(world);
        let schema = self.most_specific(world, primitive).map(|(id, _)| id);
        let execution = Execution {
            schema,
            binding: Substitution::new(),
            carrier: None,
            action: primitive,
            before: world.clone(),
            chain: Vec::new(),
            for_goal: false,
        };
        let random = self.learner.memory().content().random.state();
        let sent = Effect::StepEnded { body: self.body, random, pending: Some(Arc::new(execution)) };
        let (curriculum, mut memory) = (self.learner.curriculum().clone(), self.learner.into_memory());
        memory.apply(&sent).map_err(Failure::of)?;
        let learner = Learner::resume(memory, curriculum).map_err(Failure::of)?;
        Ok(Self { learner, ..self })
    }

    /// The concrete schema of `primitive` that holds in `world` and has the most pre-conditions; of equals the oldest.
    fn most_specific(&self, world: &WorldState, primitive: PrimitiveId) -> Option<(SchemaId, &Concrete)> {
        let content = self.learner.memory().content();
        let of_primitive = self.of_primitive.get(primitive.0 as usize)?;
        let known = of_primitive.iter().rev().filter_map(|id| Some((*id, content.concrete(*id)?)));
        let holds =
            |concrete: &Concrete| world.satisfies(concrete.pre.iter().map(|id| content.observation(*id)));
        known.filter(|(_, concrete)| holds(concrete)).max_by_key(|(_, concrete)| concrete.pre.len())
    }

    /// What it perceives where it senses `world`: what it supposes besides.
    fn perceived(&self, world: &WorldState) -> WorldState {
        self.learner.memory().content().perceived(self.body, world)
    }

    /// The same learner once more.
    pub(crate) fn twin(&self) -> Result<Self, Failure> {
        let content = self.learner.memory().content().clone();
        let memory = Memory::restore(content, self.learner.memory().parameters().clone());
        let learner = Learner::resume(memory, self.learner.curriculum().clone()).map_err(Failure::of)?;
        let Self { ref lexicon, body, ref of_primitive, sorted, took, steps, .. } = *self;
        let (lexicon, of_primitive) = (lexicon.clone(), of_primitive.clone());
        Ok(Self { lexicon, learner, body, of_primitive, sorted, took, steps })
    }

    /// Sends it to where there is `goal`, in at most so many actions.
    pub(crate) fn pursue(&mut self, goal: &declaration::Observation, most: usize) -> Result<(), Failure> {
        let goal = self.lexicon.world_state(&[goal.clone()].into());
        let goal: Vec<Pattern> = goal.observations().iter().map(Pattern::from).collect();
        let most = u32::try_from(most).unwrap_or(u32::MAX);
        self.learner.pursue(self.body, goal, most).map(drop).map_err(Failure::of)
    }

    /// Whether it is on its way to a goal.
    pub(crate) fn pursues(&self) -> bool {
        let pursuit = self.learner.memory().content().pursuit.as_deref();
        pursuit.is_some_and(Pursuit::under_way)
    }

    /// Schemas, laws left out.
    pub(crate) fn schemas(&self) -> usize {
        self.learner.memory().content().schemas.len() - self.all_laws().count()
    }

    /// Laws that are in use.
    pub(crate) fn laws(&self) -> usize {
        self.all_laws().filter(|retired| !retired).count()
    }

    /// Whether each law is retired.
    fn all_laws(&self) -> impl Iterator<Item = bool> {
        let schemas = self.learner.memory().content().schemas.iter();
        schemas.filter_map(|schema| schema.generalised().map(|law| law.retired))
    }

    /// Microseconds that a step took on average.
    pub(crate) fn step_us(&self) -> f64 {
        self.took.as_secs_f64() * 1e6 / f64::from(self.steps.max(1))
    }
}

/// The foretelling of the learner: of its claims if it has the mechanism, else of its schemas.
impl Foretelling for Student {
    fn foretell(&self, world: &WorldState, primitive: PrimitiveId) -> Distribution<WorldState> {
        let world = &self.perceived(world);
        if self.learner.memory().content().mechanisms.claims {
            self.claimed(world, primitive, None)
        } else {
            self.by_schemas(world, primitive)
        }
    }
}

impl Student {
    /// What is foretold of one type, whatever becomes of the others.
    pub(crate) fn foretell_of(
        &self,
        kind: TypeId,
        world: &WorldState,
        primitive: PrimitiveId,
    ) -> Distribution<WorldState> {
        let world = &self.perceived(world);
        let foretold = if self.learner.memory().content().mechanisms.claims {
            self.claimed(world, primitive, Some(kind))
        } else {
            self.by_schemas(world, primitive)
        };
        foretold.map(|world| world.filter(|o| o.kind() == kind))
    }

    /// What the claims in force foretell: each facet by itself, and what no facet is about stays. Of noise, which is not measured, nothing is
    /// told: most of it may come to no form, and would take the rest along. If it is asked `of` one type, only what is about that is looked at.
    fn claimed(
        &self,
        world: &WorldState,
        primitive: PrimitiveId,
        of: Option<TypeId>,
    ) -> Distribution<WorldState> {
        let content = self.learner.memory().content();
        let lasting = self.lexicon.lasting(world);
        let facets = content.evidence.foretell(
            &content.vocabulary,
            Some(self.body),
            primitive,
            lasting.observations(),
        );
        let mut all = vec![(BTreeSet::from_iter(lasting.observations().iter().cloned()), 1.0)];
        let is_noise = |facet: &Foretold| facet.kinds.iter().all(|kind| !self.lexicon.is_measured(*kind));
        let is_asked = |facet: &Foretold| of.is_none_or(|kind| facet.kinds.contains(&kind));
        for facet in facets.iter().filter(|facet| !is_noise(facet) && is_asked(facet)) {
            let mut split = Vec::with_capacity(all.len() * facet.outcomes.len());
            for (mut world, share) in all {
                world.retain(|o| facet.kinds.binary_search(&o.kind()).is_err());
                for (after, count) in &facet.outcomes {
                    let world: BTreeSet<_> = world.iter().chain(after).cloned().collect();
                    split.push((world, share * f64::from(*count) / f64::from(facet.trials)));
                }
            }
            most_probable(&mut split);
            all = split;
        }
        all.into_iter().map(|(world, share)| (WorldState::new(world), share)).collect()
    }

    /// What schemas foretell: that with the most pre-conditions that holds, each outcome by itself, by its counts. A law says nothing of
    /// what its carrier does besides, so the outcomes of the carrier are added.
    fn by_schemas(&self, world: &WorldState, primitive: PrimitiveId) -> Distribution<WorldState> {
        let memory = self.learner.memory();
        let content = memory.content();
        let mut outcomes: Vec<(Observation, bool, f64)> = Vec::new();
        let mut carried = true;
        if let Some(prediction) = goals::predict(memory, self.body, world, primitive) {
            carried = content.generalised(prediction.schema).is_some();
            outcomes.extend(prediction.outcomes.into_iter().map(|p| (p.what, p.absent, p.count.ratio())));
        }
        if let Some((_, carrier)) = self.most_specific(world, primitive).filter(|_| carried) {
            for post in &carrier.post {
                let what = content.observation(post.what);
                if outcomes.iter().all(|(known, ..)| known != what) {
                    outcomes.push((what.clone(), post.absent, post.count.ratio()));
                }
            }
        }
        // No schema tells that an observation goes which may be no pre-condition, as the body's own: one of the same type takes its place.
        let rules = memory.rules();
        let replaced = |known: &Observation| {
            let mut appearing = outcomes.iter().filter(|(_, absent, _)| !absent);
            !rules.of(known.kind()).precondition && appearing.any(|(what, ..)| what.kind() == known.kind())
        };
        let lasting = self.lexicon.lasting(world).filter(|known| !replaced(known));
        independent(lasting.observations().iter().cloned().collect(), outcomes)
    }
}

/// Keeps as many alternatives as one foretelling may have.
fn most_probable(alternatives: &mut Vec<(BTreeSet<Observation>, f64)>) {
    alternatives.retain(|(_, share)| *share > 0.0);
    alternatives.sort_by(|a, b| b.1.total_cmp(&a.1));
    alternatives.truncate(ALTERNATIVES_MAX);
}

/// The worlds that may follow `lasting` when each of these changes comes with its probability, whatever the others do.
fn independent(
    lasting: BTreeSet<Observation>,
    changes: Vec<(Observation, bool, f64)>,
) -> Distribution<WorldState> {
    let mut all = vec![(lasting, 1.0)];
    for (what, absent, probability) in changes {
        let mut split = Vec::with_capacity(all.len() * 2);
        for (world, share) in all {
            if world.contains(&what) != absent {
                split.push((world, share));
                continue;
            }
            let mut changed = world.clone();
            match absent {
                true => changed.remove(&what),
                false => changed.insert(what.clone()),
            };
            split.push((changed, share * probability));
            split.push((world, share * (1.0 - probability)));
        }
        most_probable(&mut split);
        all = split;
    }
    all.into_iter().map(|(world, share)| (WorldState::new(world), share)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_come_one_by_one_and_what_is_so_already_stays() {
        let [a, b, c] = [0, 1, 2].map(|kind| Observation::new(TypeId(kind), []));
        let changes = vec![(a.clone(), true, 0.5), (b.clone(), false, 0.8), (c.clone(), true, 0.3)];
        let foretold = independent([a.clone()].into(), changes);
        let wanted = [(vec![a.clone()], 0.1), (vec![a, b.clone()], 0.4), (vec![b], 0.4), (vec![], 0.1)];
        for (world, probability) in wanted {
            let found = foretold.probability(&WorldState::new(world));
            assert!((found - probability).abs() < 1e-12, "{found} {probability}");
        }
        assert!((foretold.total() - 1.0).abs() < 1e-12);
    }
}
