//! The search for chains: Dijkstra on products of probabilities, over contexts as sets of numbers. No more contexts
//! wait than may still be reached, so that a search among very many edges stays as short as its budget.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::rc::Rc;

use rustc_hash::FxHashMap;

use crate::cycle::carrier::carrier;
use crate::memory::Memory;
use crate::memory::groups::GroupId;
use crate::memory::instance::Instance;
use crate::memory::outline::Change;
use crate::nouns::execution::ChainLink;
use crate::nouns::observation::{Observation, Substitution};
use crate::nouns::schema::{ObservationId, SchemaId};
use crate::nouns::vocabulary::BodyId;
use crate::nouns::world_state::WorldState;

/// Contexts waiting to be expanded in one search: bounds its memory where the budget does not.
const OPEN_MAX: usize = 65_536;

/// How much is looked at in one search where there is curiosity: for each context one more than there are observations.
const LOOKS_MAX: usize = 512;

/// A context that chains lead to.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub(crate) context: WorldState,
    /// The same by number, in that order.
    pub(crate) ids: Box<[ObservationId]>,
    pub(crate) probability: f64,
    pub(crate) depth: u32,
    /// From which node, and how.
    pub(crate) via: Option<(usize, ChainLink)>,
}

impl Node {
    pub(crate) fn holds(&self, conditions: &[ObservationId]) -> bool {
        conditions.iter().all(|condition| self.ids.binary_search(condition).is_ok())
    }
}

/// The outcome of a search.
#[derive(Debug, Default)]
pub(crate) struct SearchResult {
    pub(crate) nodes: Vec<Node>,
    /// Whether it used up its budget, so that there may be more.
    pub(crate) truncated: bool,
    /// Observations of targets that were to be achieved on the way, with the version of what causes them.
    pub(crate) asked: BTreeMap<ObservationId, u64>,
    /// Whether any observation was met that has no number.
    pub(crate) strangers: bool,
}

/// The most probable first; of equals the shortest, then the first found. Probabilities are not negative, so that
/// their bits are in their order.
type Priority = (u64, Reverse<u32>, Reverse<DiscoveryOrder>);

/// When a way is found, going from context to context, and in each first along concrete schemas, then along
/// generalised ones: from which node, whether generalised, which schema, which of its bindings.
type DiscoveryOrder = (usize, bool, SchemaId, usize);

struct OpenContext {
    context: Box<[ObservationId]>,
    via: Option<(usize, ChainLink)>,
}

/// Where a context that was found stands.
enum ContextState {
    Waiting(Priority),
    Reached,
}

/// A concrete schema that may change a context.
struct Edge {
    schema: SchemaId,
    reliability: f64,
    /// The highest probability that it can add to a chain.
    most: f64,
}

struct Search<'a> {
    memory: &'a Memory,
    body: BodyId,
    found: SearchResult,
    budget: usize,
    waiting: BTreeMap<Priority, OpenContext>,
    known: FxHashMap<Box<[ObservationId]>, ContextState>,
    /// Observations without a number, each with one that nothing in memory has.
    strangers: Vec<Observation>,
    /// The edges of groups that were come to.
    edges: FxHashMap<GroupId, Rc<[Edge]>>,
}

/// How many contexts may be reached. With curiosity the frontier looks further than chains of schemas can, and a crowd must not make each
/// step slow.
fn budget(memory: &Memory, context: &WorldState) -> usize {
    let most = memory.parameters().chain_expansions_max as usize;
    match memory.content().mechanisms.is_curious() {
        true => most.min(LOOKS_MAX / (1 + context.observations().len())).max(1),
        false => most,
    }
}

/// Searches from `context` with the actions that `body` has.
pub(crate) fn search(memory: &Memory, body: BodyId, context: &WorldState) -> SearchResult {
    let mut search = Search {
        memory,
        body,
        found: SearchResult::default(),
        budget: budget(memory, context),
        waiting: BTreeMap::new(),
        known: FxHashMap::default(),
        strangers: Vec::new(),
        edges: FxHashMap::default(),
    };
    let mut start: Vec<_> = context.observations().iter().map(|o| search.number(o)).collect();
    start.sort_unstable();
    search.offer(&start, (1.0_f64.to_bits(), Reverse(0), Reverse((0, false, SchemaId(0), 0))), || None);
    while let Some((priority, best)) = search.waiting.pop_last() {
        search.reach(priority, best);
    }
    search.found.strangers = !search.strangers.is_empty();
    search.found
}

impl Search<'_> {
    fn number(&mut self, observation: &Observation) -> ObservationId {
        self.memory.index().id(observation).unwrap_or_else(|| {
            let known = self.strangers.iter().position(|stranger| stranger == observation);
            let at = known.unwrap_or_else(|| {
                self.strangers.push(observation.clone());
                self.strangers.len() - 1
            });
            ObservationId(u32::MAX - u32::try_from(at).unwrap_or(u32::MAX))
        })
    }

    fn observation(&self, id: ObservationId) -> Observation {
        match self.strangers.get((u32::MAX - id.0) as usize) {
            Some(stranger) => stranger.clone(),
            None => self.memory.content().observation(id).clone(),
        }
    }

    /// How many more contexts may be reached.
    fn room(&self) -> usize {
        (self.budget - self.found.nodes.len()).min(OPEN_MAX)
    }

    /// Whether a way may lead to where the search still comes: not if enough better ones wait.
    fn is_wanted(&self, priority: Priority) -> bool {
        let worst = self.waiting.first_key_value();
        self.waiting.len() < self.room() || worst.is_some_and(|(worst, _)| *worst < priority)
    }

    /// Takes a way to `context` into account.
    fn offer(
        &mut self,
        context: &[ObservationId],
        priority: Priority,
        via: impl FnOnce() -> Option<(usize, ChainLink)>,
    ) {
        match self.known.get_mut(context) {
            Some(ContextState::Reached) => return,
            Some(ContextState::Waiting(known)) if *known >= priority => return,
            Some(ContextState::Waiting(known)) => {
                let Some(mut open) = self.waiting.remove(known) else { return };
                *known = priority;
                open.via = via();
                self.waiting.insert(priority, open);
                return;
            }
            None => (),
        }
        if !self.is_wanted(priority) {
            self.found.truncated = true;
            return;
        }
        let context: Box<[_]> = context.into();
        self.known.insert(context.clone(), ContextState::Waiting(priority));
        self.waiting.insert(priority, OpenContext { context, via: via() });
        if self.waiting.len() > self.room()
            && let Some((_, worst)) = self.waiting.pop_first()
        {
            self.known.remove(&worst.context);
            self.found.truncated = true;
        }
    }

    /// Enters the best context that waits, and offers the contexts that can be reached from there.
    fn reach(&mut self, (probability, Reverse(depth), _): Priority, best: OpenContext) {
        let OpenContext { context: ids, via } = best;
        let best = (probability, Reverse(depth + 1), Reverse((0, false, SchemaId(0), 0)));
        let probability = f64::from_bits(probability);
        if let Some(standing) = self.known.get_mut(&ids) {
            *standing = ContextState::Reached;
        }
        let context = WorldState::new(ids.iter().map(|id| self.observation(*id)));
        let groups = self.memory.index().groups().holding(&ids);
        self.found.nodes.push(Node { context, ids, probability, depth, via });
        let at = self.found.nodes.len() - 1;
        // One more schema than the links so far must still fit: the one that the chain is for.
        let fits = depth + 1 < self.memory.parameters().chain_length_max;
        let index = self.memory.index();
        let leads = !index.generalised_changing().is_empty()
            || groups.iter().any(|group| !index.groups().get(*group).changing.is_empty());
        if !leads {
            return;
        }
        // Nothing from here is more probable than being here.
        if !fits || !self.is_wanted(best) {
            self.found.truncated = true;
            return;
        }
        self.along_concrete(at, &groups);
        self.along_generalised(at, &groups);
    }

    fn along_concrete(&mut self, at: usize, groups: &[GroupId]) {
        let Node { probability, depth, ref ids, .. } = self.found.nodes[at];
        let ids = ids.clone();
        let mut after = Vec::with_capacity(ids.len() + 1);
        for group in groups {
            for Edge { schema, reliability, most } in self.edges(*group).iter() {
                let priority = |probability: f64, schema| {
                    (probability.to_bits(), Reverse(depth + 1), Reverse((at, false, schema, 0)))
                };
                // The schemas that follow in the group are no more probable.
                if !self.is_wanted(priority(probability * most, SchemaId(0))) {
                    self.found.truncated = true;
                    break;
                }
                let Some(outline) = self.memory.index().outline(*schema) else { continue };
                let Some(changes) = probability_of_change(&ids, outline.changes()) else { continue };
                let priority = priority(probability * (changes * reliability), *schema);
                if priority.0 == 0 {
                    continue;
                }
                after.clear();
                after.extend_from_slice(&ids);
                outline.changes().for_each(|change| make(&ids, &mut after, change));
                after.sort_unstable();
                after.dedup();
                let link = || ChainLink { schema: *schema, binding: Substitution::new(), carrier: None };
                self.offer(&after, priority, || Some((at, link())));
            }
        }
    }

    /// The edges that the concrete schemas of `group` are, the most probable first.
    fn edges(&mut self, group: GroupId) -> Rc<[Edge]> {
        let Self { memory, body, .. } = *self;
        let edge = |schema: &SchemaId| {
            let outline = memory.index().outline(*schema)?;
            // No more probable than any one of its changes, whichever a context leaves to be made.
            let most = outline.changes().map(|change| change.probability).max_by(f64::total_cmp)?;
            let reliability = memory.content().reliability(outline.action);
            let edge = Edge { schema: *schema, reliability, most: most * reliability };
            memory.content().vocabulary.can_do(body, outline.action).then_some(edge)
        };
        let known = self.edges.entry(group).or_insert_with(|| {
            let mut edges: Vec<_> =
                memory.index().groups().get(group).changing.iter().filter_map(edge).collect();
            edges.sort_by(|a, b| b.most.total_cmp(&a.most));
            edges.into()
        });
        Rc::clone(known)
    }

    fn along_generalised(&mut self, at: usize, groups: &[GroupId]) {
        let memory = self.memory;
        let content = memory.content();
        for (id, law) in memory.laws(memory.index().generalised_changing()) {
            let bindings = memory.index().bindings(id, law, self.found.nodes[at].context.observations());
            for (number, binding) in bindings.into_iter().enumerate() {
                let bound = Instance::new(content, id, &binding);
                let Some((target, bound)) = law.target_under(&binding).zip(bound) else { continue };
                let link = |carrier| ChainLink { schema: id, binding, carrier: Some(carrier) };
                self.along_binding((at, true, id, number), groups, &target, &bound, link);
            }
        }
    }

    fn along_binding(
        &mut self,
        place: DiscoveryOrder,
        groups: &[GroupId],
        target: &[Observation],
        bound: &Instance,
        link: impl FnOnce(SchemaId) -> ChainLink,
    ) {
        let memory = self.memory;
        let Node { probability, depth, ref ids, .. } = self.found.nodes[place.0];
        let ids = ids.clone();
        let changes = self.changes(bound);
        let Some(changed) = probability_of_change(&ids, changes.iter().copied()) else { return };
        let mut after = ids.to_vec();
        changes.into_iter().for_each(|change| make(&ids, &mut after, change));
        after.sort_unstable();
        after.dedup();
        for wanted in target {
            let wanted = self.number(wanted);
            self.found.asked.insert(wanted, memory.index().causing_version(wanted));
        }
        let Some((carrier, sure)) = carrier(memory, self.body, target, groups) else { return };
        let pre: Vec<_> = bound.pre.iter().collect();
        let action = memory.index().outline(carrier).map(|outline| outline.action);
        // The schema that is known of just this case "is selected instead" (IV-A), and is an edge itself if it leads anywhere.
        if action.is_none_or(|action| memory.index().exact(&pre, action).is_some()) {
            return;
        }
        let probability = probability * (changed * sure);
        if probability > 0.0 {
            let priority = (probability.to_bits(), Reverse(depth + 1), Reverse(place));
            self.offer(&after, priority, || Some((place.0, link(carrier))));
        }
    }

    /// The predictions of a schema under a binding that may change a context.
    fn changes(&mut self, bound: &Instance) -> Vec<Change> {
        let memory = self.memory;
        let predicted = bound.predicted(memory.parameters());
        let changes = predicted.filter(|post| memory.rules().of(post.what.kind()).precondition).map(|post| {
            let what = self.number(&post.what);
            Change { what, absent: post.absent, probability: post.count.ratio() }
        });
        changes.collect()
    }
}

/// The probability of those of `changes` that change `before`; none if nothing does.
fn probability_of_change(before: &[ObservationId], changes: impl Iterator<Item = Change>) -> Option<f64> {
    let mut probability = None;
    for change in changes.filter(|change| changed(before, change)) {
        probability = Some(probability.unwrap_or(1.0) * change.probability);
    }
    probability
}

fn changed(before: &[ObservationId], change: &Change) -> bool {
    before.binary_search(&change.what).is_ok() == change.absent
}

pub(crate) fn make(before: &[ObservationId], after: &mut Vec<ObservationId>, change: Change) {
    if changed(before, &change) {
        match change.absent {
            true => after.retain(|known| *known != change.what),
            false => after.push(change.what),
        }
    }
}
