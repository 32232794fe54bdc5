//! Chains and the achievement of targets: a plain Dijkstra over contexts, made anew in every step.

use pschema_learner::execution::ChainLink;
use pschema_learner::observation::{Observation, Substitution};
use pschema_learner::schema::SchemaId;
use pschema_learner::vocabulary::PrimitiveId;

use super::learner::Reference;
use super::schema::{Schema, put_in};

/// Bindings of one generalised schema that are considered.
pub(crate) const BINDINGS_MAX: usize = 64;

/// A context that a chain leads to.
#[derive(Clone, Debug)]
pub(crate) struct Reached {
    pub(crate) context: Vec<Observation>,
    pub(crate) probability: f64,
    pub(crate) chain: Vec<ChainLink>,
}

impl Reached {
    pub(crate) fn holds(&self, conditions: &[Observation]) -> bool {
        conditions.iter().all(|condition| self.context.contains(condition))
    }
}

/// A schema that can be executed in some context.
struct Edge {
    link: ChainLink,
    /// Reliability of its primitive, or sureness of its carrier.
    sureness: f64,
}

impl Reference {
    /// Every context that chains reach, the surest first.
    pub(crate) fn search(&self, repertoire: &[PrimitiveId], start: Vec<Observation>) -> Vec<Reached> {
        let parameters = &self.memory.parameters;
        let mut open = vec![Reached { context: start, probability: 1.0, chain: Vec::new() }];
        let mut closed: Vec<Reached> = Vec::new();
        while !open.is_empty() && closed.len() < parameters.chain_expansions_max as usize {
            let mut best = 0;
            for at in 1..open.len() {
                let (a, b) = (&open[at], &open[best]);
                if a.probability > b.probability
                    || (a.probability == b.probability && a.chain.len() < b.chain.len())
                {
                    best = at;
                }
            }
            let reached = open.remove(best);
            if closed.iter().any(|known| known.context == reached.context) {
                continue;
            }
            closed.push(reached.clone());
            if reached.chain.len() + 1 >= parameters.chain_length_max as usize {
                continue;
            }
            for edge in self.edges(repertoire, &reached) {
                open.extend(self.follow(&reached, edge));
            }
        }
        closed
    }

    fn edges(&self, repertoire: &[PrimitiveId], from: &Reached) -> Vec<Edge> {
        let mut edges = Vec::new();
        for schema in self.memory.schemas.iter() {
            let Some(action) = schema.action else { continue };
            if repertoire.contains(&action) && from.holds(&schema.pre(&Substitution::new())) {
                let link = ChainLink { schema: schema.id, binding: Substitution::new(), carrier: None };
                edges.push(Edge { link, sureness: self.memory.reliability(action) });
            }
        }
        let here = Reached { probability: 1.0, chain: Vec::new(), ..from.clone() };
        for schema in self.memory.schemas.iter().filter(|s| s.action.is_none() && !s.retired) {
            for binding in schema.bindings(&from.context, BINDINGS_MAX) {
                if let Some(way) = self.achieve(repertoire, schema, &binding, std::slice::from_ref(&here))
                    && !self.stands_in(&schema.pre(&binding), way.action)
                {
                    let link = ChainLink { schema: schema.id, binding, carrier: Some(way.carrier) };
                    edges.push(Edge { link, sureness: way.sureness });
                }
            }
        }
        edges
    }

    /// Whether a concrete schema says what this primitive does under exactly these pre-conditions.
    pub(crate) fn stands_in(&self, pre: &[Observation], action: PrimitiveId) -> bool {
        let mut schemas = self.memory.schemas.iter();
        schemas.any(|schema| schema.action == Some(action) && schema.pre(&Substitution::new()) == pre)
    }

    /// Where an edge leads, unless it changes nothing.
    fn follow(&self, from: &Reached, edge: Edge) -> Option<Reached> {
        let schema = self.memory.schema(edge.link.schema);
        let mut context = from.context.clone();
        let mut changes = 1.0;
        for post in &schema.post {
            let what = put_in(&post.what, &edge.link.binding);
            let predicted = schema.predicts(post.count, self.memory.parameters.prediction_ratio_min);
            if !predicted || !self.rules(what.kind()).pre || from.context.contains(&what) != post.absent {
                continue;
            }
            if post.absent {
                context.retain(|o| *o != what);
            } else {
                context.push(what);
            }
            changes *= post.count.ratio();
        }
        context.sort();
        context.dedup();
        if context == from.context {
            return None;
        }
        let mut chain = from.chain.clone();
        chain.push(edge.link);
        Some(Reached { context, probability: from.probability * (changes * edge.sureness), chain })
    }
}

/// How a target is achieved.
pub(crate) struct Way<'a> {
    pub(crate) carrier: SchemaId,
    pub(crate) action: PrimitiveId,
    pub(crate) sureness: f64,
    /// The context in which the carrier is executed.
    pub(crate) from: &'a Reached,
}

impl Reference {
    /// The surest way to achieve a generalised schema's target from one of the contexts reached.
    pub(crate) fn achieve<'a>(
        &self,
        repertoire: &[PrimitiveId],
        generalised: &Schema,
        binding: &Substitution,
        reached: &'a [Reached],
    ) -> Option<Way<'a>> {
        let target: Vec<Observation> = generalised.target.iter().map(|p| put_in(p, binding)).collect();
        let mut best: Option<(Way<'a>, usize)> = None;
        for schema in &self.memory.schemas {
            let Some(action) = schema.action.filter(|action| repertoire.contains(action)) else { continue };
            let predicted =
                schema.predicted(&Substitution::new(), false, self.memory.parameters.prediction_ratio_min);
            let pre = schema.pre(&Substitution::new());
            let Some(from) = reached.iter().find(|r| r.holds(&pre)) else { continue };
            let mut sureness = self.memory.reliability(action);
            let mut all = true;
            for wanted in &target {
                match predicted.iter().find(|(o, _)| o == wanted) {
                    Some((_, count)) => sureness *= count.interval().0,
                    None => all = false,
                }
            }
            if !all {
                continue;
            }
            sureness *= from.probability;
            let better = best.as_ref().is_none_or(|(way, fewest)| {
                let shape = (pre.len(), from.chain.len());
                sureness > way.sureness
                    || (sureness == way.sureness && shape < (*fewest, way.from.chain.len()))
            });
            if better {
                best = Some((Way { carrier: schema.id, action, sureness, from }, pre.len()));
            }
        }
        best.map(|(way, _)| way)
    }
}
