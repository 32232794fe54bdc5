//! Memory: everything the learner knows. [`Memory::apply`] is the only thing that changes it.

use std::collections::VecDeque;
use std::sync::Arc;

use crate::memory::check::Check;
use crate::memory::content::Content;
use crate::memory::index::Index;
use crate::memory::outline::Basis;
use crate::nouns::effect::{Effect, Score};
use crate::nouns::effect_error::EffectError;
use crate::nouns::experience::Experience;
use crate::nouns::item::{EXPERIENCES_MAX, Item, Line};
use crate::nouns::observation::{Observation, Pattern};
use crate::nouns::parameters::{Parameters, TypeRules};
use crate::nouns::probability::Count;
use crate::nouns::progress::StageEffect;
use crate::nouns::pursuit::{PLANS_KEPT_MAX, Pursuit, PursuitEffect};
use crate::nouns::random::Random;
use crate::nouns::schema::{
    Association, Concrete, EXAMPLES_MAX, Form, Generalised, ObservationId, PostCondition, SCHEMAS_MAX,
    Schema, SchemaId,
};
use crate::nouns::vocabulary::{BodyId, Declaration, PrimitiveId};

/// Everything that a learner knows, with the indexes that make it fast to ask. Effects are the only thing that changes it.
///
/// ```
/// use pschema_learner::digest::digest;
/// use pschema_learner::effect::Effect;
/// use pschema_learner::memory::Memory;
/// use pschema_learner::parameters::Parameters;
///
/// let effect = Effect::SymbolsMet(vec!["touch".to_owned()]);
/// let (mut one, mut other) = (Memory::new(7, Parameters::default()), Memory::new(7, Parameters::default()));
/// one.apply(&effect)?;
/// assert_ne!(digest(one.content()), digest(other.content()));
/// other.apply(&effect)?;
/// assert_eq!(digest(one.content()), digest(other.content()));
/// # Ok::<(), pschema_learner::effect_error::EffectError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Memory {
    content: Content,
    index: Index,
    rules: TypeRules,
    parameters: Parameters,
    /// The experience that was taken in and of which it is not yet said whose it is: never from one step to the next.
    latest: Option<Arc<Experience>>,
}

impl Memory {
    /// A memory that knows nothing. `seed` decides all random numbers of its life.
    #[must_use]
    pub fn new(seed: u64, parameters: Parameters) -> Self {
        let content = Content { random: Random::from_seed(seed), ..Content::default() };
        Self { content, index: Index::default(), rules: TypeRules::default(), parameters, latest: None }
    }

    /// The memory of which `content` was taken, with its indexes built anew: to ask it more than content can answer, or to go on from
    /// it. This takes time in proportion to memory.
    #[must_use]
    pub fn restore(content: Content, parameters: Parameters) -> Self {
        let rules = TypeRules::new(&content.vocabulary, &parameters);
        let index = Index::build(Basis { content: &content, rules: &rules, parameters: &parameters });
        Self { content, index, rules, parameters, latest: None }
    }

    /// All that is known.
    #[must_use]
    pub fn content(&self) -> &Content {
        &self.content
    }

    /// The indexes; they follow from the content.
    #[must_use]
    pub(crate) fn index(&self) -> &Index {
        &self.index
    }

    /// The parts in learning that each observation type may have.
    #[must_use]
    pub fn rules(&self) -> &TypeRules {
        &self.rules
    }

    /// The parameters it learns by.
    #[must_use]
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Those of the schemas `ids` that are generalised, each with what it says.
    pub(crate) fn laws(&self, ids: &[SchemaId]) -> impl Iterator<Item = (SchemaId, &Generalised)> {
        ids.iter().filter_map(|id| Some((*id, self.content.generalised(*id)?)))
    }

    /// N(x) of equation (1): how often `observation` was perceived while the executed schema referred to it (II-C).
    #[must_use]
    pub fn attention(&self, observation: &Observation) -> u32 {
        self.index.id(observation).and_then(|id| self.content.attention.get(id.index())).copied().unwrap_or(0)
    }

    /// Changes memory by `effect`, or refuses the effect: if it refers to anything that is not there, if it is longer or more than
    /// memory holds, or if it would break an invariant of memory. It never panics, and a refused effect changes nothing.
    ///
    /// # Errors
    /// The first thing in it for which it is refused.
    pub fn apply(&mut self, effect: &Effect) -> Result<(), EffectError> {
        Check { content: &self.content, index: &self.index }.effect(effect)?;
        match effect {
            Effect::Declared(declaration) => self.declare(declaration),
            Effect::SymbolsMet(symbols) => Arc::make_mut(&mut self.content.vocabulary).meet(symbols),
            Effect::Attempted { primitive, carried_out } => self.attempt(*primitive, *carried_out),
            Effect::Executed { schema, success, post, associations } => {
                self.score(*schema, *success, post, associations);
            }
            Effect::OutcomeAdded { schema, observation, absent } => {
                self.add_outcome(*schema, observation, *absent);
            }
            Effect::Created { pre, action, post, parent, contradicts } => {
                self.create(pre, *action, post, *parent, *contradicts);
            }
            Effect::Generalised { pre, target, post, parent, examples } => {
                self.generalise(pre, target, post, *parent, examples);
            }
            Effect::Supported { generalised, example } => {
                self.change_law(*generalised, |law| push_example(&mut law.examples, *example));
            }
            Effect::Retired { generalised } => {
                self.change_law(*generalised, |law| law.retired = true);
                self.index.retire(*generalised);
            }
            Effect::Associated { schema, observation, replaces } => {
                self.associate(*schema, observation, *replaces);
            }
            Effect::Happened(events) => {
                for event in events {
                    let id = self.intern(event);
                    rise(self.content.happened.get_mut(id.index()));
                }
            }
            Effect::Attended(observations) => {
                for observation in observations {
                    let id = self.intern(observation);
                    rise(self.content.attention.get_mut(id.index()));
                }
            }
            Effect::Stage(effect) => self.progress(effect),
            Effect::Pursuit(effect) => self.pursue(effect),
            Effect::StepEnded { body, random, pending } => {
                if let Some(slot) = self.content.pending.get_mut(usize::from(body.0)) {
                    slot.clone_from(pending);
                }
                self.content.random = Random::from_seed(*random);
                self.content.step += 1;
            }
            Effect::Full(full) => self.content.full = *full,
            Effect::Mechanisms(mechanisms) => {
                // What was lived through without the items is not followed by what is lived through with them.
                if !mechanisms.supposes() {
                    self.begin_lines();
                }
                // And what was there then says nothing of what will be there when it is recalled again.
                if !mechanisms.recalls() {
                    self.content.evidence.forget_recollections();
                }
                self.content.mechanisms = *mechanisms;
            }
            Effect::Experienced(experience) => {
                let recalls = self.content.mechanisms.recalls();
                self.content.evidence.experience(&self.content.vocabulary, experience, recalls);
                if self.content.mechanisms.supposes() {
                    self.latest = Some(Arc::new((**experience).clone()));
                }
            }
            Effect::Followed { body, on } => self.follow(*body, on),
            Effect::Supposed { body, on, primitive, kinds, updates } => {
                let number = self.content.items.all.len();
                let (kind, property) = Arc::make_mut(&mut self.content.vocabulary).suppose(number);
                let (primitive, kinds, updates) = (*primitive, kinds.clone(), updates.clone());
                let item = Item { kind, property, primitive, kinds, updates, dropped: false };
                self.suppose(*body, *on, item);
            }
            Effect::Dropped { item } => {
                let all = Arc::make_mut(&mut self.content.items.all);
                if let Some(item) = all.get_mut(*item as usize) {
                    item.dropped = true;
                }
            }
            Effect::Described { body, text } => {
                let descriptions = &mut self.content.descriptions;
                descriptions.resize(self.content.vocabulary.bodies().len(), None);
                if let Some(slot) = descriptions.get_mut(usize::from(body.0)) {
                    *slot = Some(text.as_str().into());
                }
            }
        }
        Ok(())
    }

    // The functions below are called for checked effects alone. A number that nothing has would change nothing.

    fn declare(&mut self, declaration: &Declaration) {
        let Self { content, index, rules, parameters, .. } = self;
        Arc::make_mut(&mut content.vocabulary).merge(declaration);
        *rules = TypeRules::new(&content.vocabulary, parameters);
        while content.attempts.len() < content.vocabulary.primitives().len() {
            content.attempts.push(Count::default());
        }
        content.pending.resize(content.vocabulary.bodies().len(), None);
        index.edges_changed();
    }

    /// What a body lived through of late.
    fn line(&mut self, body: BodyId) -> Option<&mut Line> {
        let lines = &mut self.content.items.lines;
        if lines.len() <= usize::from(body.0) {
            lines.resize(usize::from(body.0) + 1, Line::default());
        }
        lines.get_mut(usize::from(body.0))
    }

    /// Items are sought in what comes from here on.
    fn begin_lines(&mut self) {
        for line in &mut self.content.items.lines {
            (line.recent, line.taken) = (VecDeque::new(), 0);
        }
    }

    fn follow(&mut self, body: BodyId, on: &[bool]) {
        let latest = self.latest.take();
        let Some(line) = self.line(body) else { return };
        line.on = on.to_vec();
        if let Some(experience) = latest {
            line.recent.push_back(experience);
            line.taken = line.taken.saturating_add(1);
            if line.recent.len() > EXPERIENCES_MAX {
                line.recent.pop_front();
            }
        }
    }

    fn suppose(&mut self, body: BodyId, on: bool, item: Item) {
        Arc::make_mut(&mut self.content.items.all).push(item);
        let count = self.content.items.all.len();
        if let Some(line) = self.line(body) {
            line.on.resize(count, false);
            line.on.last_mut().into_iter().for_each(|last| *last = on);
        }
        // The next item is sought where this one is perceived.
        self.begin_lines();
        self.rules = TypeRules::new(&self.content.vocabulary, &self.parameters);
        self.index.edges_changed();
    }

    fn attempt(&mut self, primitive: PrimitiveId, carried_out: bool) {
        let before = self.content.reliability(primitive);
        let forgives = carried_out && self.content.mechanisms.is_curious();
        if let Some(count) = self.content.attempts.get_mut(primitive.0 as usize) {
            // What is carried out again is soon tried as before, and what never is falls off.
            if forgives {
                count.trials = count.occurrences + (count.trials - count.occurrences) / 2;
            }
            count.observe(carried_out);
        }
        if self.content.reliability(primitive) != before {
            self.index.edges_changed();
        }
    }

    fn progress(&mut self, effect: &StageEffect) {
        Arc::make_mut(&mut self.content.progress).apply(effect, self.content.step);
        match effect {
            StageEffect::Begun { random, .. } | StageEffect::Spoken { random, .. } => {
                self.content.random = Random::from_seed(*random);
            }
            // What is under way was decided under other constraints: what is sensed for the first time
            // when a constraint is lifted must not be put down to it.
            StageEffect::Entered { .. } | StageEffect::Left => {
                self.content.pending.iter_mut().for_each(|slot| *slot = None);
            }
            _ => (),
        }
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
        let Self { content, index, rules, parameters, .. } = self;
        (index, Basis { content, rules, parameters })
    }

    fn change_law(&mut self, id: SchemaId, change: impl FnOnce(&mut Generalised)) {
        if let Some(Form::Generalised(law)) = self.content.schemas.get_mut(id.index()).map(|s| &mut s.form) {
            change(law);
        }
    }

    fn score(&mut self, id: SchemaId, success: bool, post: &[Score], associations: &[Score]) {
        let Some(schema) = self.content.schemas.get_mut(id.index()) else { return };
        schema.executions.observe(success);
        let counts: Vec<&mut Count> = match &mut schema.form {
            Form::Concrete(concrete) => concrete.post.iter_mut().map(|p| &mut p.count).collect(),
            Form::Generalised(generalised) => generalised.post.iter_mut().map(|p| &mut p.count).collect(),
        };
        let before: Vec<f64> = counts.iter().map(|count| count.ratio()).collect();
        counts.into_iter().zip(post).for_each(|(count, score)| observe(count, *score));
        if !schema.associations.is_empty() {
            self.score_associations(id, associations);
        }
        let (index, basis) = self.indexed();
        index.scored(id, &before, basis);
    }

    fn score_associations(&mut self, id: SchemaId, scores: &[Score]) {
        let Self { content, index, rules, .. } = self;
        let Some(before) = content.schema(id) else { return };
        let held = |at: usize| scores.get(at) == Some(&Score::Held);
        let held_at: Vec<usize> = (0..before.associations.len()).filter(|at| held(*at)).collect();
        held_at.iter().for_each(|at| index.unrank(id, before, &before.associations[*at]));
        if let Some(schema) = content.schemas.get_mut(id.index()) {
            schema.associations.iter_mut().zip(scores).for_each(|(a, score)| observe(&mut a.count, *score));
        }
        let Some(after) = content.schema(id) else { return };
        held_at.iter().for_each(|at| index.rank(id, after, &after.associations[*at], content, rules));
        let (index, basis) = self.indexed();
        index.associations_scored(id, basis);
    }

    fn add_outcome(&mut self, id: SchemaId, observation: &Observation, absent: bool) {
        let what = self.intern(observation);
        let Some(schema) = self.content.schemas.get_mut(id.index()) else { return };
        // An outcome met for the first time could have happened in every execution so far.
        let count = Count { occurrences: 1, trials: schema.executions.trials.max(1) };
        if let Form::Concrete(concrete) = &mut schema.form {
            concrete.post.push(PostCondition { what, absent, count });
        }
        let (index, basis) = self.indexed();
        index.outcome_added(id, basis);
    }

    fn create(
        &mut self,
        pre: &[Observation],
        action: PrimitiveId,
        post: &[(Observation, bool)],
        parent: Option<SchemaId>,
        contradicts: Option<SchemaId>,
    ) {
        let id = self.next_id();
        if let Some(law) = contradicts {
            self.change_law(law, |law| push_example(&mut law.counter_examples, id));
        }
        let pre: Arc<[_]> = pre.iter().map(|observation| self.intern(observation)).collect();
        let groups = self.index.groups();
        let pre = groups.with_pre(&pre).map_or(pre, |group| groups.get(group).pre.clone());
        let post = post.iter().map(|(observation, absent)| PostCondition {
            what: self.intern(observation),
            absent: *absent,
            count: Count::ONCE,
        });
        let post = post.collect();
        self.add_schema(Schema {
            form: Form::Concrete(Concrete { pre, action, post, contradicts }),
            executions: Count::ONCE,
            associations: Vec::new(),
            parent,
            created_step: self.content.step,
        });
    }

    fn generalise(
        &mut self,
        pre: &[Pattern],
        target: &[Pattern],
        post: &[(Pattern, bool)],
        parent: SchemaId,
        examples: &[SchemaId],
    ) {
        // Its examples are its evidence so far: each is an execution in which all of it happened.
        let evidence = u32::try_from(examples.len()).unwrap_or(u32::MAX);
        let count = Count { occurrences: evidence, trials: evidence };
        let post =
            post.iter().map(|(what, absent)| PostCondition { what: what.clone(), absent: *absent, count });
        self.content.generalised_count += 1;
        self.add_schema(Schema {
            form: Form::Generalised(Box::new(Generalised {
                pre: pre.into(),
                target: target.into(),
                post: post.collect(),
                examples: examples.iter().copied().take(EXAMPLES_MAX).collect(),
                counter_examples: Vec::new(),
                retired: false,
            })),
            executions: Count::default(),
            associations: Vec::new(),
            parent: Some(parent),
            created_step: self.content.step,
        });
    }

    /// Whether no more schemas can be made.
    pub(crate) fn is_full(&self) -> bool {
        self.content.full || self.content.schemas.len() >= SCHEMAS_MAX
    }

    /// The number that the next schema will have.
    pub(crate) fn next_id(&self) -> SchemaId {
        SchemaId(u32::try_from(self.content.schemas.len()).unwrap_or(u32::MAX))
    }

    fn add_schema(&mut self, schema: Schema) {
        let id = self.next_id();
        self.content.schemas.push(schema);
        let (index, basis) = self.indexed();
        index.add_schema(id, basis);
    }

    fn associate(&mut self, id: SchemaId, observation: &Observation, replaces: Option<usize>) {
        let observation = self.intern(observation);
        let association = Association { observation, count: Count::ONCE, since_step: self.content.step };
        let Some(schema) = self.content.schemas.get_mut(id.index()) else { return };
        let gone = replaces.map(|at| schema.associations.remove(at));
        schema.associations.push(association.clone());
        let Self { content, index, rules, parameters, .. } = self;
        let Some(schema) = content.schema(id) else { return };
        gone.iter().for_each(|gone| index.unrank(id, schema, gone));
        index.rank(id, schema, &association, content, rules);
        index.refresh(id, Basis { content, rules, parameters });
    }

    fn pursue(&mut self, effect: &PursuitEffect) {
        let content = &mut self.content;
        if let PursuitEffect::Begun { body, goal, actions_max } = effect {
            content.forget_chain(*body);
            content.pursuit = Some(Arc::new(Pursuit {
                number: content.pursuit.as_ref().map_or(0, |before| before.number).saturating_add(1),
                body: *body,
                goal: goal.clone(),
                actions_max: *actions_max,
                actions: 0,
                came: 0.0,
                plans_made: 0,
                plans: Vec::new(),
                ended: None,
            }));
        }
        let Some(pursuit) = content.pursuit.as_mut().map(Arc::make_mut) else { return };
        match effect {
            PursuitEffect::Begun { .. } => (),
            PursuitEffect::Planned(plan) => {
                if pursuit.plans.len() >= PLANS_KEPT_MAX {
                    pursuit.plans.remove(0);
                }
                pursuit.plans.push(Arc::new(plan.clone()));
                pursuit.plans_made = pursuit.plans_made.saturating_add(1);
            }
            PursuitEffect::Revised(policy) => {
                if let Some(plan) = pursuit.plans.last_mut() {
                    Arc::make_mut(plan).policy = Some(policy.clone());
                }
            }
            PursuitEffect::Acted => pursuit.actions = pursuit.actions.saturating_add(1),
            PursuitEffect::Came(more) => pursuit.came = (pursuit.came + more).clamp(f64::MIN, f64::MAX),
            PursuitEffect::Ended(ending) => {
                pursuit.ended = Some(*ending);
                let body = pursuit.body;
                content.forget_chain(body);
            }
        }
    }
}

/// Adds to the examples or counter-examples of a law, of which so many are listed.
fn push_example(list: &mut Vec<SchemaId>, id: SchemaId) {
    if list.len() < EXAMPLES_MAX {
        list.push(id);
    }
}

fn rise(count: Option<&mut u32>) {
    if let Some(count) = count {
        *count = count.saturating_add(1);
    }
}

fn observe(count: &mut Count, score: Score) {
    match score {
        Score::Held => count.observe(true),
        Score::Missed => count.observe(false),
        Score::Constrained => (),
    }
}
