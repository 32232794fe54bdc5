//! What the reference learner knows: plain lists, searched from end to end, and its own way of applying
//! effects to them.

use pschema_learner::curriculum::Curriculum;
use pschema_learner::effect::{Effect, Score};
use pschema_learner::execution::Execution;
use pschema_learner::observation::{Observation, Pattern};
use pschema_learner::parameters::Parameters;
use pschema_learner::probability::Count;
use pschema_learner::random::Random;
use pschema_learner::schema::SchemaId;
use pschema_learner::vocabulary::{Declaration, DeclaredType, Parameter, PrimitiveId};

use super::pursuing::Pursuit;
use super::schema::{Post, Schema};
use super::standing::Standing;

/// Everything known.
#[derive(Clone, Debug)]
pub(crate) struct Memory {
    pub(crate) parameters: Parameters,
    pub(crate) curriculum: Curriculum,
    pub(crate) types: Vec<DeclaredType>,
    pub(crate) properties: Vec<String>,
    pub(crate) symbols: Vec<String>,
    pub(crate) primitives: Vec<(String, Vec<Parameter>)>,
    pub(crate) bodies: Vec<(String, Vec<PrimitiveId>)>,
    pub(crate) schemas: Vec<Schema>,
    pub(crate) attention: Vec<(Observation, u32)>,
    /// Events, with the number of executions around which each was perceived.
    pub(crate) happened: Vec<(Observation, u32)>,
    pub(crate) attempts: Vec<Count>,
    pub(crate) pending: Vec<Option<Execution>>,
    pub(crate) standing: Standing,
    pub(crate) pursuit: Option<Pursuit>,
    pub(crate) random: Random,
    pub(crate) step: u64,
    pub(crate) full: bool,
}

impl Memory {
    pub(crate) fn new(seed: u64, parameters: Parameters, curriculum: Curriculum) -> Self {
        Self {
            parameters,
            curriculum,
            types: Vec::new(),
            properties: Vec::new(),
            symbols: Vec::new(),
            primitives: Vec::new(),
            bodies: Vec::new(),
            schemas: Vec::new(),
            attention: Vec::new(),
            happened: Vec::new(),
            attempts: Vec::new(),
            pending: Vec::new(),
            standing: Standing::default(),
            pursuit: None,
            random: Random::from_seed(seed),
            step: 0,
            full: false,
        }
    }

    pub(crate) fn schema(&self, id: SchemaId) -> &Schema {
        &self.schemas[id.index()]
    }

    pub(crate) fn n(&self, observation: &Observation) -> u32 {
        self.attention.iter().find(|(known, _)| known == observation).map_or(0, |(_, n)| *n)
    }

    /// (1 + carried out) / (1 + attempts).
    pub(crate) fn reliability(&self, primitive: PrimitiveId) -> f64 {
        let count = self.attempts[primitive.0 as usize];
        (1.0 + f64::from(count.occurrences)) / (1.0 + f64::from(count.trials))
    }

    pub(crate) fn apply(&mut self, effect: &Effect) {
        match effect {
            Effect::Declared(declaration) => self.declared(declaration),
            Effect::SymbolsMet(symbols) => self.symbols.extend(symbols.iter().cloned()),
            Effect::Attempted { primitive, carried_out } => {
                self.attempts[primitive.0 as usize].observe(*carried_out);
            }
            Effect::Executed { schema, success, post, associations } => {
                let schema = &mut self.schemas[schema.index()];
                schema.executions.observe(*success);
                for (post, seen) in schema.post.iter_mut().zip(post) {
                    count(&mut post.count, *seen);
                }
                for ((_, known, _), seen) in schema.associations.iter_mut().zip(associations) {
                    count(known, *seen);
                }
            }
            Effect::OutcomeAdded { schema, observation, absent } => {
                let schema = &mut self.schemas[schema.index()];
                let count = Count { occurrences: 1, trials: schema.executions.trials };
                schema.post.push(Post { what: observation.into(), absent: *absent, count });
            }
            Effect::Created { pre, action, post, parent: _, contradicts } => {
                let pre = pre.iter().map(Pattern::from).collect();
                let post = post.iter().map(|(what, absent)| (what.into(), *absent)).collect();
                let id = self.add(pre, post, Count::ONCE);
                self.schemas[id.index()].action = Some(*action);
                if let Some(generalised) = contradicts {
                    self.schemas[generalised.index()].counter_examples.push(id);
                }
            }
            Effect::Generalised { pre, target, post, parent: _, examples } => {
                let n = u32::try_from(examples.len()).unwrap();
                let id = self.add(pre.clone(), post.clone(), Count { occurrences: n, trials: n });
                self.schemas[id.index()].executions = Count::default();
                self.schemas[id.index()].target.clone_from(target);
                self.schemas[id.index()].examples.clone_from(examples);
            }
            Effect::Supported { generalised, example } => {
                self.schemas[generalised.index()].examples.push(*example);
            }
            Effect::Retired { generalised } => self.schemas[generalised.index()].retired = true,
            Effect::Associated { schema, observation, replaces } => {
                let associations = &mut self.schemas[schema.index()].associations;
                if let Some(at) = replaces {
                    associations.remove(*at);
                }
                associations.push((observation.clone(), Count::ONCE, self.step));
            }
            Effect::Attended(observations) => {
                observations.iter().for_each(|observation| tally(&mut self.attention, observation));
            }
            Effect::Happened(events) => events.iter().for_each(|event| tally(&mut self.happened, event)),
            Effect::Stage(effect) => self.staged(effect),
            Effect::Pursuit(effect) => self.pursued(effect),
            Effect::StepEnded { body, random, pending } => {
                self.random = Random::from_seed(*random);
                self.pending[usize::from(body.0)] = pending.as_deref().cloned();
                self.step += 1;
            }
            Effect::Full(full) => self.full = *full,
            // It decides nothing.
            Effect::Described { .. } => (),
            // It is the learner of the paper, and is given no others.
            Effect::Mechanisms(_)
            | Effect::Experienced(_)
            | Effect::Followed { .. }
            | Effect::Supposed { .. }
            | Effect::Dropped { .. } => (),
        }
    }

    fn add(&mut self, pre: Vec<Pattern>, post: Vec<(Pattern, bool)>, count: Count) -> SchemaId {
        let id = SchemaId(u32::try_from(self.schemas.len()).unwrap());
        self.schemas.push(Schema {
            id,
            pre,
            action: None,
            target: Vec::new(),
            post: post.into_iter().map(|(what, absent)| Post { what, absent, count }).collect(),
            executions: count,
            associations: Vec::new(),
            examples: Vec::new(),
            counter_examples: Vec::new(),
            retired: false,
            created_step: self.step,
        });
        id
    }

    fn declared(&mut self, declaration: &Declaration) {
        for declared in &declaration.observation_types {
            if !self.types.contains(declared) {
                self.types.push(declared.clone());
            }
            for property in &declared.properties {
                if !self.properties.contains(&property.name) {
                    self.properties.push(property.name.clone());
                }
            }
        }
        let mut repertoire = Vec::new();
        for (action, parameters) in &declaration.repertoire {
            let primitive = (declaration.actions[*action].name.clone(), parameters.clone());
            let at = self.primitives.iter().position(|known| *known == primitive).unwrap_or_else(|| {
                self.primitives.push(primitive);
                self.attempts.push(Count::default());
                self.primitives.len() - 1
            });
            repertoire.push(PrimitiveId(u32::try_from(at).unwrap()));
        }
        repertoire.sort_unstable();
        repertoire.dedup();
        match self.bodies.iter_mut().find(|(name, _)| *name == declaration.body) {
            Some((_, known)) => *known = repertoire,
            None => {
                self.bodies.push((declaration.body.clone(), repertoire));
                self.pending.push(None);
            }
        }
    }
}

fn tally(counts: &mut Vec<(Observation, u32)>, observation: &Observation) {
    match counts.iter_mut().find(|(known, _)| known == observation) {
        Some((_, n)) => *n += 1,
        None => counts.push((observation.clone(), 1)),
    }
}

fn count(count: &mut Count, seen: Score) {
    match seen {
        Score::Held => count.observe(true),
        Score::Missed => count.observe(false),
        Score::Constrained => {}
    }
}
