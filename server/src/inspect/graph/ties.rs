//! The ties between schemas, which follow from the observations that they need, make and have as targets.

use std::collections::BTreeMap;

use pschema_inspect::GraphTie;
use pschema_learner::schema::{Concrete, Form, Generalised, ObservationId, Schema, SchemaId};

use super::basis::{Basis, COMPARISONS_MAX, count, made_by_law, may_be, may_both_be, numbered};
use super::places::Places;

/// Most ties that are listed.
const EDGES_MAX: usize = 20_000;
/// Ties, counted by their nodes and kind.
#[derive(Debug, Default)]
pub(super) struct Edges {
    counted: BTreeMap<(u32, u32, GraphTie), u64>,
    /// How many ties there are, listed or not.
    pub(super) total: u64,
    cut: bool,
}

impl Edges {
    fn add(&mut self, from: u32, to: u32, kind: GraphTie) {
        if from == to {
            return;
        }
        self.total += 1;
        if let Some(count) = self.counted.get_mut(&(from, to, kind)) {
            *count += 1;
        } else if self.counted.len() < EDGES_MAX {
            self.counted.insert((from, to, kind), 1);
        } else {
            self.cut = true;
        }
    }

    pub(super) fn is_cut(&self) -> bool {
        self.cut
    }

    pub(super) fn listed(&self) -> impl Iterator<Item = ((u32, u32, GraphTie), u64)> + '_ {
        self.counted.iter().map(|(tie, count)| (*tie, *count))
    }
}

/// The nodes of single schemas that need an observation, have it as a target, or make it.
#[derive(Clone, Debug, Default)]
struct Uses {
    needed: Vec<u32>,
    targeted: Vec<u32>,
    made: Vec<u32>,
    /// Whether generalised schemas are among them already.
    complete: bool,
}

/// Finds the ties.
pub(super) struct Ties<'a> {
    basis: Basis<'a>,
    places: &'a Places<'a>,
    shown: &'a [(SchemaId, &'a Schema)],
    laws: Vec<(u32, &'a Generalised)>,
    uses: BTreeMap<ObservationId, Uses>,
    comparisons: usize,
    edges: Edges,
}

impl<'a> Ties<'a> {
    pub(super) fn new(basis: Basis<'a>, places: &'a Places<'a>, shown: &'a [(SchemaId, &'a Schema)]) -> Self {
        let mut uses: BTreeMap<ObservationId, Uses> = BTreeMap::new();
        let mut laws = Vec::new();
        for (at, (_, schema)) in shown.iter().enumerate() {
            let node = count(at);
            match &schema.form {
                Form::Generalised(law) => laws.push((node, &**law)),
                Form::Concrete(concrete) => {
                    concrete.pre.iter().for_each(|id| uses.entry(*id).or_default().needed.push(node));
                    basis.made(concrete).for_each(|id| uses.entry(id).or_default().made.push(node));
                }
            }
        }
        Self { basis, places, shown, laws, uses, comparisons: 0, edges: Edges::default() }
    }

    pub(super) fn edges(self) -> Edges {
        let cut = self.edges.cut || self.comparisons >= COMPARISONS_MAX;
        Edges { cut, ..self.edges }
    }

    fn node(&self, id: SchemaId) -> Option<u32> {
        self.places.of(id, self.basis.content.schema(id)?)
    }

    /// Ties from each schema of a chain to the next.
    pub(super) fn follow(&mut self, next: &[(SchemaId, SchemaId)]) {
        for (from, to) in next {
            if let (Some(from), Some(to)) = (self.node(*from), self.node(*to)) {
                self.edges.add(from, to, GraphTie::Next);
            }
        }
    }

    /// Ties of the single schemas to their examples, counter-examples and parents.
    pub(super) fn lineage(&mut self) {
        for (at, (_, schema)) in self.shown.iter().enumerate() {
            let node = count(at);
            if let Form::Generalised(law) = &schema.form {
                for (ids, kind) in [
                    (&law.examples, GraphTie::ExampleOf),
                    (&law.counter_examples, GraphTie::CounterExampleTo),
                ] {
                    for from in ids.iter().filter_map(|id| self.node(*id)).collect::<Vec<_>>() {
                        self.edges.add(from, node, kind);
                    }
                }
            }
            if let Some(parent) = schema.parent.and_then(|parent| self.node(parent)) {
                self.edges.add(parent, node, GraphTie::ParentOf);
            }
        }
    }

    /// Ties between single schemas of which one makes what the other needs.
    pub(super) fn among_shown(&mut self) {
        for (at, (_, schema)) in self.shown.iter().enumerate() {
            let found = match &schema.form {
                Form::Concrete(concrete) => self.served(self.basis.made(concrete)),
                Form::Generalised(law) => self.served_by_law(law),
            };
            self.comparisons = self.comparisons.saturating_add(found.len());
            found.into_iter().for_each(|(to, kind)| self.edges.add(count(at), to, kind));
            if self.comparisons >= COMPARISONS_MAX {
                return;
            }
        }
    }

    /// Ties between single schemas and those that stand together.
    pub(super) fn with_the_rest(&mut self) {
        for (id, schema) in numbered(self.basis.content) {
            // Laws among those that stand together are tied only by their examples and counter-examples.
            let Some(concrete) = schema.concrete() else { continue };
            if self.places.shown.binary_search(&id).is_ok() {
                continue;
            }
            let Some(node) = self.places.of(id, schema) else { continue };
            let (served, serving) = (self.served(self.basis.made(concrete)), self.serving(concrete));
            self.comparisons = self.comparisons.saturating_add(served.len() + serving.len());
            if self.comparisons >= COMPARISONS_MAX {
                return;
            }
            for (to, kind) in served {
                self.edges.add(node, to, kind);
            }
            for from in serving {
                self.edges.add(from, node, GraphTie::Enables);
            }
            if let Some(parent) = schema.parent.filter(|id| self.places.shown.binary_search(id).is_ok())
                && let Some(parent) = self.node(parent)
            {
                self.edges.add(parent, node, GraphTie::ParentOf);
            }
        }
    }

    /// The uses of an observation. Laws are compared with it once, when it is first asked for.
    fn uses(&mut self, id: ObservationId) -> Option<&Uses> {
        let known = self.uses.get(&id).map(|uses| uses.complete);
        if known == Some(true) || self.laws.is_empty() || self.comparisons >= COMPARISONS_MAX {
            return self.uses.get(&id);
        }
        let observation = self.basis.content.observation(id);
        let mut uses = self.uses.remove(&id).unwrap_or_default();
        for (node, law) in &self.laws {
            let patterns = law.pre.iter().chain(&law.target).count() + law.post.len();
            self.comparisons = self.comparisons.saturating_add(patterns);
            if law.pre.iter().any(|pattern| may_be(pattern, observation)) {
                uses.needed.push(*node);
            }
            if law.target.iter().any(|pattern| may_be(pattern, observation)) {
                uses.targeted.push(*node);
            }
            if made_by_law(law).any(|pattern| may_be(pattern, observation)) {
                uses.made.push(*node);
            }
        }
        uses.complete = true;
        Some(self.uses.entry(id).or_insert(uses))
    }

    /// The schemas that need these observations or have them as targets, each once.
    fn served(&mut self, made: impl Iterator<Item = ObservationId>) -> Vec<(u32, GraphTie)> {
        let mut found = Vec::new();
        for id in made {
            let Some(uses) = self.uses(id) else { continue };
            found.extend(uses.needed.iter().map(|node| (*node, GraphTie::Enables)));
            found.extend(uses.targeted.iter().map(|node| (*node, GraphTie::Carries)));
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The schemas that make the pre-conditions of a schema, each once.
    fn serving(&mut self, concrete: &Concrete) -> Vec<u32> {
        let mut found = Vec::new();
        for id in concrete.pre.iter() {
            found.extend(self.uses(*id).into_iter().flat_map(|uses| &uses.made).copied());
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The schemas that need what a law makes, each once. A law carries no target out.
    fn served_by_law(&mut self, law: &Generalised) -> Vec<(u32, GraphTie)> {
        let mut found = Vec::new();
        for pattern in made_by_law(law) {
            for (id, uses) in self.uses.iter().filter(|(_, uses)| !uses.needed.is_empty()) {
                self.comparisons = self.comparisons.saturating_add(1);
                if self.comparisons >= COMPARISONS_MAX {
                    break;
                }
                if may_be(pattern, self.basis.content.observation(*id)) {
                    let concrete =
                        |node: &&u32| self.laws.binary_search_by_key(*node, |(law, _)| *law).is_err();
                    found.extend(uses.needed.iter().filter(concrete).map(|node| (*node, GraphTie::Enables)));
                }
            }
            for (node, other) in &self.laws {
                self.comparisons = self.comparisons.saturating_add(other.pre.len());
                if other.pre.iter().any(|wanted| may_both_be(pattern, wanted)) {
                    found.push((*node, GraphTie::Enables));
                }
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    }
}
