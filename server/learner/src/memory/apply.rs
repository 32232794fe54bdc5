//! Memory: everything the learner knows. [`Memory::apply`] is the only thing that changes it.

use std::sync::Arc;

use crate::memory::chunks::Chunks;
use crate::memory::content::Content;
use crate::memory::index::Index;
use crate::memory::outline::Basis;
use crate::nouns::effect::{Effect, Score};
use crate::nouns::effect_error::EffectError;
use crate::nouns::observation::Observation;
use crate::nouns::parameters::{Parameters, TypeRules};
use crate::nouns::probability::Count;
use crate::nouns::progress::{Progress, StageEffect};
use crate::nouns::pursuit::{PLANS_KEPT_MAX, Pursuit, PursuitEffect};
use crate::nouns::random::Random;
use crate::nouns::schema::{
    ASSOCIATIONS_MAX, Association, Concrete, EXAMPLES_MAX, Form, Generalised, ObservationId, PostCondition,
    Schema, SchemaId,
};
use crate::nouns::vocabulary::{BodyId, PrimitiveId};

/// Everything the learner knows.
#[derive(Clone, Debug)]
pub struct Memory {
    content: Content,
    index: Index,
    rules: TypeRules,
    parameters: Parameters,
}

impl Memory {
    /// Knows nothing. `seed` is where its randomness begins.
    #[must_use]
    pub fn new(seed: u64, parameters: Parameters) -> Self {
        let content = Content {
            vocabulary: Arc::default(),
            schemas: Chunks::default(),
            observations: Chunks::default(),
            attention: Chunks::default(),
            happened: Chunks::default(),
            attempts: Chunks::default(),
            pending: Vec::new(),
            progress: Progress::default(),
            pursuit: None,
            random: Random::from_seed(seed),
            step: 0,
            generalised_count: 0,
        };
        Self { content, index: Index::default(), rules: TypeRules::default(), parameters }
    }

    /// The memory of which `content` was taken, its indexes built anew: to ask it more than content can
    /// answer, or to go on from it.
    #[must_use]
    pub fn restore(content: Content, parameters: Parameters) -> Self {
        let rules = TypeRules::new(&content.vocabulary, &parameters);
        let index = Index::build(Basis { content: &content, rules: &rules, parameters: &parameters });
        Self { content, index, rules, parameters }
    }

    /// What is known.
    #[must_use]
    pub fn content(&self) -> &Content {
        &self.content
    }

    /// What makes it fast to ask; follows from the content.
    #[must_use]
    pub(crate) fn index(&self) -> &Index {
        &self.index
    }

    /// What each observation type may be part of.
    #[must_use]
    pub fn rules(&self) -> &TypeRules {
        &self.rules
    }

    /// The parameters it learns by.
    #[must_use]
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// N(x).
    #[must_use]
    pub fn attention(&self, observation: &Observation) -> u32 {
        self.index.id(observation).and_then(|id| self.content.attention.get(id.index())).copied().unwrap_or(0)
    }

    /// Changes memory by `effect`.
    ///
    /// # Errors
    /// When the effect speaks of something that is not there; memory is then as it was.
    pub fn apply(&mut self, effect: &Effect) -> Result<(), EffectError> {
        match effect {
            Effect::Declared(declaration) => {
                self.content.vocabulary.check(declaration)?;
                Arc::make_mut(&mut self.content.vocabulary).merge(declaration);
                self.rules = TypeRules::new(&self.content.vocabulary, &self.parameters);
                while self.content.attempts.len() < self.content.vocabulary.primitives().len() {
                    self.content.attempts.push(Count::default());
                }
                self.content.pending.resize(self.content.vocabulary.bodies().len(), None);
                self.index.edges_changed();
                Ok(())
            }
            Effect::SymbolsMet(symbols) => {
                let vocabulary = Arc::make_mut(&mut self.content.vocabulary);
                for symbol in symbols {
                    vocabulary.intern_symbol(symbol);
                }
                Ok(())
            }
            Effect::Attempted { primitive, carried_out } => {
                let before = self.content.reliability(*primitive);
                let count = self.content.attempts.get_mut(primitive.0 as usize);
                count.ok_or(EffectError::Primitive(primitive.0))?.observe(*carried_out);
                if self.content.reliability(*primitive) != before {
                    self.index.edges_changed();
                }
                Ok(())
            }
            Effect::Executed { schema, success, post, associations } => {
                self.score(*schema, *success, post, associations)
            }
            Effect::OutcomeAdded { schema, observation, absent } => {
                self.add_outcome(*schema, observation, *absent)
            }
            Effect::Created { pre, action, post, parent, contradicts } => {
                self.create(pre, *action, post, *parent, *contradicts)
            }
            Effect::Generalised { .. } => self.generalise(effect),
            Effect::Supported { generalised, example } => {
                self.expect_schema(*example)?;
                let general = self.generalised_mut(*generalised)?;
                if general.examples.len() < EXAMPLES_MAX {
                    general.examples.push(*example);
                }
                Ok(())
            }
            Effect::Retired { generalised } => {
                self.generalised_mut(*generalised)?.retired = true;
                self.index.retire(*generalised);
                Ok(())
            }
            Effect::Associated { schema, observation, replaces } => {
                self.associate(*schema, observation, *replaces)
            }
            Effect::Happened(events) => {
                for event in events {
                    let id = self.intern(event);
                    rise(self.content.happened.get_mut(id.index()));
                }
                Ok(())
            }
            Effect::Attended(observations) => {
                for observation in observations {
                    let id = self.intern(observation);
                    rise(self.content.attention.get_mut(id.index()));
                }
                Ok(())
            }
            Effect::Stage(effect) => self.progress(effect),
            Effect::Pursuit(effect) => pursue(&mut self.content, effect),
            Effect::StepEnded { body, random, pending } => {
                let slot = self.content.pending.get_mut(usize::from(body.0));
                slot.ok_or(EffectError::Body(body.0))?.clone_from(pending);
                self.content.random = Random::from_seed(*random);
                self.content.step += 1;
                Ok(())
            }
        }
    }

    fn progress(&mut self, effect: &StageEffect) -> Result<(), EffectError> {
        self.content.progress.apply(effect, self.content.step)?;
        match effect {
            StageEffect::Begun { random, .. } | StageEffect::Spoken { random, .. } => {
                self.content.random = Random::from_seed(*random)
            }
            // What is under way was decided under other constraints: what is sensed for the first time
            // when a constraint is lifted must not be put down to it.
            StageEffect::Entered { .. } | StageEffect::Left => {
                self.content.pending.iter_mut().for_each(|slot| *slot = None);
            }
            _ => (),
        }
        Ok(())
    }

    fn intern(&mut self, observation: &Observation) -> ObservationId {
        if let Some(id) = self.index.id(observation) {
            return id;
        }
        let id = ObservationId(u32::try_from(self.content.observations.len()).unwrap_or(u32::MAX));
        self.content.observations.push(observation.clone());
        self.content.attention.push(0);
        self.content.happened.push(0);
        self.index.add_observation(observation, id);
        id
    }

    /// The index, and what it is made from.
    fn indexed(&mut self) -> (&mut Index, Basis<'_>) {
        let Self { content, index, rules, parameters } = self;
        (index, Basis { content, rules, parameters })
    }

    fn expect_schema(&self, id: SchemaId) -> Result<&Schema, EffectError> {
        self.content.schema(id).ok_or(EffectError::Schema(id.0))
    }

    fn schema_mut(&mut self, id: SchemaId) -> Result<&mut Schema, EffectError> {
        self.content.schemas.get_mut(id.index()).ok_or(EffectError::Schema(id.0))
    }

    fn generalised_mut(&mut self, id: SchemaId) -> Result<&mut Generalised, EffectError> {
        match &mut self.schema_mut(id)?.form {
            Form::Generalised(generalised) => Ok(generalised),
            Form::Concrete(_) => Err(EffectError::Schema(id.0)),
        }
    }

    fn concrete_mut(&mut self, id: SchemaId) -> Result<&mut Concrete, EffectError> {
        match &mut self.schema_mut(id)?.form {
            Form::Concrete(concrete) => Ok(concrete),
            Form::Generalised(_) => Err(EffectError::Schema(id.0)),
        }
    }

    fn score(
        &mut self,
        id: SchemaId,
        success: bool,
        post: &[Score],
        associations: &[Score],
    ) -> Result<(), EffectError> {
        let schema = self.schema_mut(id)?;
        let known = match &schema.form {
            Form::Concrete(concrete) => concrete.post.len(),
            Form::Generalised(generalised) => generalised.post.len(),
        };
        for (given, known) in [(post.len(), known), (associations.len(), schema.associations.len())] {
            if given != known {
                return Err(EffectError::Length { schema: id.0, given, known });
            }
        }
        schema.executions.observe(success);
        let before: Vec<f64>;
        match &mut schema.form {
            Form::Concrete(concrete) => {
                before = concrete.post.iter().map(|p| p.count.ratio()).collect();
                concrete.post.iter_mut().zip(post).for_each(|(p, seen)| observe(&mut p.count, *seen));
            }
            Form::Generalised(generalised) => {
                before = generalised.post.iter().map(|p| p.count.ratio()).collect();
                generalised.post.iter_mut().zip(post).for_each(|(p, seen)| observe(&mut p.count, *seen));
            }
        }
        if !schema.associations.is_empty() {
            self.score_associations(id, associations);
        }
        let (index, basis) = self.indexed();
        index.scored(id, &before, basis);
        Ok(())
    }

    fn score_associations(&mut self, id: SchemaId, seen: &[Score]) {
        let Self { content, index, rules, .. } = self;
        let Some(before) = content.schema(id) else { return };
        let held = |at: usize| seen.get(at) == Some(&Score::Held);
        let held_at: Vec<usize> = (0..before.associations.len()).filter(|at| held(*at)).collect();
        held_at.iter().for_each(|at| index.unrank(id, before, &before.associations[*at]));
        if let Some(schema) = content.schemas.get_mut(id.index()) {
            schema.associations.iter_mut().zip(seen).for_each(|(a, seen)| observe(&mut a.count, *seen));
        }
        let Some(after) = content.schema(id) else { return };
        held_at.iter().for_each(|at| index.rank(id, after, &after.associations[*at], content, rules));
        let (index, basis) = self.indexed();
        index.associations_scored(id, basis);
    }

    fn add_outcome(
        &mut self,
        id: SchemaId,
        observation: &Observation,
        absent: bool,
    ) -> Result<(), EffectError> {
        // An outcome met for the first time could have happened in every execution so far.
        let trials = self.expect_schema(id)?.executions.trials.max(1);
        self.concrete_mut(id)?;
        let what = self.intern(observation);
        let count = Count { occurrences: 1, trials };
        let concrete = self.concrete_mut(id)?;
        concrete.post.push(PostCondition { what, absent, count });
        let (index, basis) = self.indexed();
        index.outcome_added(id, basis);
        Ok(())
    }

    fn create(
        &mut self,
        pre: &[Observation],
        action: PrimitiveId,
        post: &[(Observation, bool)],
        parent: Option<SchemaId>,
        contradicts: Option<SchemaId>,
    ) -> Result<(), EffectError> {
        if self.content.vocabulary.primitives().get(action.0 as usize).is_none() {
            return Err(EffectError::Primitive(action.0));
        }
        let id = SchemaId(u32::try_from(self.content.schemas.len()).unwrap_or(u32::MAX));
        if let Some(generalised) = contradicts {
            let general = self.generalised_mut(generalised)?;
            if general.counter_examples.len() < EXAMPLES_MAX {
                general.counter_examples.push(id);
            }
        }
        let pre: Arc<[_]> = pre.iter().map(|observation| self.intern(observation)).collect();
        let groups = self.index.groups();
        let pre = groups.with_pre(&pre).map_or(pre, |group| groups.get(group).pre.clone());
        let post = post
            .iter()
            .map(|(observation, absent)| PostCondition {
                what: self.intern(observation),
                absent: *absent,
                count: Count::ONCE,
            })
            .collect();
        self.content.schemas.push(Schema {
            form: Form::Concrete(Concrete { pre, action, post, contradicts }),
            executions: Count::ONCE,
            associations: Vec::new(),
            parent,
            created_step: self.content.step,
        });
        let (index, basis) = self.indexed();
        index.add_schema(id, basis);
        Ok(())
    }

    fn generalise(&mut self, effect: &Effect) -> Result<(), EffectError> {
        let Effect::Generalised { pre, target, post, parent, examples } = effect else { return Ok(()) };
        for schema in examples.iter().chain([parent]) {
            self.expect_schema(*schema)?;
        }
        let id = SchemaId(u32::try_from(self.content.schemas.len()).unwrap_or(u32::MAX));
        // Its examples are its evidence so far: each is an execution in which all of it happened.
        let evidence = u32::try_from(examples.len()).unwrap_or(u32::MAX);
        let count = Count { occurrences: evidence, trials: evidence };
        let post = post
            .iter()
            .map(|(what, absent)| PostCondition { what: what.clone(), absent: *absent, count })
            .collect();
        self.content.schemas.push(Schema {
            form: Form::Generalised(Box::new(Generalised {
                pre: pre.clone().into(),
                target: target.clone().into(),
                post,
                examples: examples.iter().copied().take(EXAMPLES_MAX).collect(),
                counter_examples: Vec::new(),
                retired: false,
            })),
            executions: Count::default(),
            associations: Vec::new(),
            parent: Some(*parent),
            created_step: self.content.step,
        });
        self.content.generalised_count += 1;
        let (index, basis) = self.indexed();
        index.add_schema(id, basis);
        Ok(())
    }

    fn associate(
        &mut self,
        id: SchemaId,
        observation: &Observation,
        replaces: Option<usize>,
    ) -> Result<(), EffectError> {
        let known = self.expect_schema(id)?.associations.len();
        if replaces.is_some_and(|at| at >= known) || (replaces.is_none() && known >= ASSOCIATIONS_MAX) {
            return Err(EffectError::Length { schema: id.0, given: replaces.unwrap_or(known), known });
        }
        let observation = self.intern(observation);
        if let Some(at) = replaces {
            let schema = self.schema_mut(id)?;
            let gone = schema.associations.remove(at);
            if let Some(schema) = self.content.schema(id) {
                self.index.unrank(id, schema, &gone);
            }
        }
        let association = Association { observation, count: Count::ONCE, since_step: self.content.step };
        self.schema_mut(id)?.associations.push(association.clone());
        let (index, basis) = self.indexed();
        index.refresh(id, basis);
        if let Some(schema) = self.content.schema(id) {
            self.index.rank(id, schema, &association, &self.content, &self.rules);
        }
        Ok(())
    }
}

/// Applies an effect to the content of memory.
fn pursue(content: &mut Content, effect: &PursuitEffect) -> Result<(), EffectError> {
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

fn rise(count: Option<&mut u32>) {
    if let Some(count) = count {
        *count = count.saturating_add(1);
    }
}

fn observe(count: &mut Count, seen: Score) {
    match seen {
        Score::Held => count.observe(true),
        Score::Missed => count.observe(false),
        Score::Constrained => (),
    }
}
