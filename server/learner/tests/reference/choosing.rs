//! Step 9 of the cycle: candidates, their excitation (equation 1), and the choice among them.

use pschema_learner::decision::Subject;
use pschema_learner::execution::{ChainLink, Execution};
use pschema_learner::observation::{Observation, Substitution};
use pschema_learner::schema::SchemaId;
use pschema_learner::vocabulary::PrimitiveId;
use pschema_learner::world_state::WorldState;

use super::chains::{BINDINGS_MAX, Reached};
use super::learner::Reference;
use super::schema::Schema;

/// Something that could be done: what it is, how much it excites, and the executions that lead to it.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    pub(crate) subject: Subject,
    pub(crate) excitation: f64,
    pub(crate) way: Vec<ChainLink>,
}

impl Reference {
    /// Every candidate, in the order in which equals are drawn from. `drive` is what habituation adds.
    pub(crate) fn candidates(
        &self,
        repertoire: &[PrimitiveId],
        world: &WorldState,
        drive: &[SchemaId],
    ) -> Vec<Candidate> {
        let reached = self.search(repertoire, self.context(world));
        let mut candidates = Vec::new();
        let schemas = &self.memory.schemas;
        for schema in schemas {
            let Some(action) = schema.action.filter(|action| repertoire.contains(action)) else { continue };
            let binding = Substitution::new();
            let pre = schema.pre(&binding);
            let Some(from) = reached.iter().find(|r| r.holds(&pre)) else { continue };
            let link = ChainLink { schema: schema.id, binding, carrier: None };
            candidates.extend(self.candidate(schema, action, link, from, world, drive));
        }
        for schema in schemas.iter().filter(|s| s.action.is_none() && !s.retired) {
            for binding in schema.bindings(&self.context(world), BINDINGS_MAX) {
                let Some(way) = self.achieve(repertoire, schema, &binding, &reached) else { continue };
                let stands_in =
                    way.from.chain.is_empty() && self.stands_in(&schema.pre(&binding), way.action);
                if !stands_in {
                    let link = ChainLink { schema: schema.id, binding, carrier: Some(way.carrier) };
                    candidates.extend(self.candidate(schema, way.action, link, way.from, world, drive));
                }
            }
        }
        for primitive in repertoire {
            if !self.executable(world).iter().any(|s| s.action == Some(*primitive)) {
                let excitation =
                    self.memory.parameters.babbling_excitation * self.memory.reliability(*primitive);
                candidates.push(Candidate {
                    subject: Subject::Primitive(*primitive),
                    excitation,
                    way: vec![],
                });
            }
        }
        if candidates.is_empty() {
            for schema in self.executable(world) {
                if schema.action.is_some_and(|action| repertoire.contains(&action)) {
                    let link = ChainLink { schema: schema.id, binding: Substitution::new(), carrier: None };
                    let subject = Subject::Schema(schema.id);
                    candidates.push(Candidate { subject, excitation: 0.0, way: vec![link] });
                }
            }
        }
        candidates
    }

    /// The concrete schemas whose pre-conditions hold.
    pub(crate) fn executable(&self, world: &WorldState) -> Vec<&Schema> {
        let concrete = self.memory.schemas.iter().filter(|s| s.action.is_some());
        concrete.filter(|s| world.satisfies(&s.pre(&Substitution::new()))).collect()
    }

    fn candidate(
        &self,
        schema: &Schema,
        action: PrimitiveId,
        link: ChainLink,
        from: &Reached,
        world: &WorldState,
        drive: &[SchemaId],
    ) -> Option<Candidate> {
        let reliability = self.memory.reliability(action);
        let mut sum = self.sum(schema, &link.binding, world, reliability);
        if drive.contains(&schema.id) {
            sum += self.memory.parameters.babbling_excitation * reliability;
        }
        let mut way = from.chain.clone();
        way.push(link);
        let excitation = sum / way.len() as f64;
        let subject = Subject::Schema(schema.id);
        (excitation > 0.0).then_some(Candidate { subject, excitation, way })
    }

    /// The sum of equation (1), in its fixed order.
    fn sum(&self, schema: &Schema, binding: &Substitution, world: &WorldState, reliability: f64) -> f64 {
        let parameters = &self.memory.parameters;
        let pre = schema.pre(binding);
        let mut remembered: Vec<(Observation, f64, f64)> =
            pre.iter().map(|o| (o.clone(), 1.0, reliability)).collect();
        if parameters.excite_by_post_conditions {
            for (observation, count) in schema.outcomes(binding, false) {
                if !pre.contains(&observation) {
                    remembered.push((observation, count.ratio(), reliability));
                }
            }
        }
        for (observation, count, since) in &schema.associations {
            if self.strong(schema.id, observation, *count, *since) {
                let weight = reliability * parameters.association_weight;
                remembered.push((observation.clone(), 1.0, weight));
            }
        }
        let mut sum = 0.0;
        for (observation, probability, weight) in remembered {
            let n = if parameters.attention { self.memory.n(&observation) } else { 0 };
            let shared: u32 = world.observations().iter().map(|seen| seen.shared(&observation)).sum();
            sum += ((f64::from(shared) * probability) * weight) / (1.0 + f64::from(n));
        }
        sum
    }

    /// The most excited candidate; of equals one is drawn.
    pub(crate) fn choose(&mut self, candidates: &[Candidate]) -> Option<Candidate> {
        let top = candidates.iter().map(|c| c.excitation).fold(f64::NEG_INFINITY, f64::max);
        let ties: Vec<_> = candidates.iter().filter(|c| c.excitation == top).collect();
        if ties.is_empty() {
            return None;
        }
        let drawn = self.memory.random.below(ties.len());
        Some(ties[drawn].clone())
    }

    /// The next schema of a chain, if it can be executed here.
    pub(crate) fn next_in_chain(&self, chain: &[ChainLink], world: &WorldState) -> Option<Candidate> {
        let next = chain.first()?;
        let mut conditions = self.memory.schema(next.schema).pre(&next.binding);
        if let Some(carrier) = next.carrier {
            conditions.extend(self.memory.schema(carrier).pre(&Substitution::new()));
        }
        let subject = Subject::Schema(next.schema);
        let allowed = !self.memory.schema(next.schema).retired && world.satisfies(&conditions);
        allowed.then(|| Candidate { subject, excitation: 0.0, way: chain.to_vec() })
    }

    /// Step 10: the execution of a candidate's first schema.
    pub(crate) fn resolve(&self, candidate: Candidate, world: &WorldState) -> Execution {
        let mut way = candidate.way;
        let (schema, binding, carrier, action) = match candidate.subject {
            Subject::Primitive(primitive) => (None, Substitution::new(), None, Some(primitive)),
            Subject::Schema(_) => {
                let ChainLink { schema, binding, carrier } = way.remove(0);
                (Some(schema), binding, carrier, self.memory.schema(carrier.unwrap_or(schema)).action)
            }
        };
        let action = action.expect("a generalised schema is executed through a concrete one");
        Execution { schema, binding, carrier, action, before: world.clone(), chain: way, for_goal: false }
    }
}
