//! Chaining: contexts as vertices, schemas as edges. One search from the present context gives the
//! distance d of equation (1) and the chains that lead to a schema or to a goal.
//!
//! A chain is worth the product of the probabilities of what it relies on: of each schema on the way, the
//! changes of context it makes; of the last one, only what the goal asks for (II-A: that a ball may fall
//! does not matter to who moves a block).

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use rustc_hash::FxHashSet;

use crate::bound::{self, Bound};
use crate::effect::ChainLink;
use crate::memory::Memory;
use crate::observation::{Observation, Substitution, bindings};
use crate::schema::{Concrete, ObservationId, SchemaId};
use crate::target_action::reliability;
use crate::vocabulary::{BodyId, PrimitiveId};
use crate::world_state::WorldState;

/// Bindings of one generalised schema that are considered in one world state.
pub(crate) const BINDINGS_MAX: usize = 64;

/// Contexts waiting to be expanded in one search: bounds its memory in a world with very many edges.
const OPEN_MAX: usize = 65_536;

/// A context that chains lead to.
#[derive(Clone, Debug)]
struct Node {
    context: WorldState,
    ids: FxHashSet<ObservationId>,
    probability: f64,
    depth: u32,
    via: Option<(usize, ChainLink)>,
}

/// What can be reached from one context.
#[derive(Clone, Debug)]
pub(crate) struct Reach {
    nodes: Vec<Node>,
    /// Whether the search used up its budget, so that there may be more.
    pub(crate) truncated: bool,
    key: Key,
}

/// What a search depends on: whose actions, from which context, over which edges, how probable they are, and
/// which observations had numbers (contexts are compared by them).
#[derive(Clone, Debug, PartialEq)]
struct Key {
    body: BodyId,
    context: WorldState,
    edges_version: u64,
    observations: usize,
    evidence: u64,
}

impl Key {
    fn new(memory: &Memory, body: BodyId, world: &WorldState) -> Self {
        Self {
            body,
            context: world.context(memory.rules()),
            edges_version: memory.index().edges_version(),
            observations: memory.content().observations.len(),
            // Probabilities matter as soon as there is anything to go along.
            evidence: if memory.index().has_edges() { memory.evidence() } else { 0 },
        }
    }
}

/// A way to make a concrete schema executable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Access {
    node: usize,
    /// Schemas to be executed before it.
    pub(crate) preceding: u32,
    /// Probability that they lead there.
    pub(crate) probability: f64,
}

#[derive(Clone, Debug)]
struct Open {
    probability: f64,
    depth: u32,
    order: usize,
    context: WorldState,
    via: Option<(usize, ChainLink)>,
}

impl PartialEq for Open {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Open {}
impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Open {
    /// The most probable first; of equals the shortest, then the first found.
    fn cmp(&self, other: &Self) -> Ordering {
        self.probability
            .total_cmp(&other.probability)
            .then_with(|| other.depth.cmp(&self.depth))
            .then_with(|| other.order.cmp(&self.order))
    }
}

impl Reach {
    /// Whether this search still holds for `world`.
    pub(crate) fn is_current(&self, memory: &Memory, body: BodyId, world: &WorldState) -> bool {
        self.key == Key::new(memory, body, world)
    }

    /// Searches from `world` with the actions that `body` has (Dijkstra on products of probabilities).
    pub(crate) fn search(memory: &Memory, body: BodyId, world: &WorldState) -> Self {
        let key = Key::new(memory, body, world);
        let start = key.context.clone();
        let mut reach = Self { nodes: Vec::new(), truncated: false, key };
        let mut open = BinaryHeap::new();
        let mut order = 0;
        open.push(Open { probability: 1.0, depth: 0, order, context: start, via: None });
        let budget = memory.parameters().chain_expansions_max as usize;
        while let Some(best) = open.pop() {
            if reach.nodes.iter().any(|node| node.context == best.context) {
                continue;
            }
            if reach.nodes.len() >= budget {
                reach.truncated = true;
                break;
            }
            let ids = best.context.observations().iter().filter_map(|o| memory.index().id(o)).collect();
            let Open { probability, depth, context, via, .. } = best;
            reach.nodes.push(Node { context, ids, probability, depth, via });
            let at = reach.nodes.len() - 1;
            // One more schema than the links so far must still fit: the one that the chain is for.
            if depth + 1 >= memory.parameters().chain_length_max {
                reach.truncated |= !memory.index().context_changing().is_empty();
                continue;
            }
            for (context, step, link) in edges(memory, body, &reach.nodes[at]) {
                let probability = probability * step;
                if open.len() >= OPEN_MAX {
                    reach.truncated = true;
                    break;
                }
                if probability > 0.0 && !reach.nodes.iter().any(|node| node.context == context) {
                    order += 1;
                    open.push(Open { probability, depth: depth + 1, order, context, via: Some((at, link)) });
                }
            }
        }
        reach
    }

    /// The best way to where all of `pre` hold.
    pub(crate) fn access(&self, pre: &[ObservationId]) -> Option<Access> {
        let node = self.nodes.iter().position(|node| pre.iter().all(|id| node.ids.contains(id)))?;
        let Node { depth, probability, .. } = self.nodes[node];
        Some(Access { node, preceding: depth, probability })
    }

    /// A way to every context reached, the present one first.
    pub(crate) fn all(&self) -> impl Iterator<Item = Access> {
        self.nodes.iter().enumerate().map(|(node, known)| Access {
            node,
            preceding: known.depth,
            probability: known.probability,
        })
    }

    /// The context that `access` leads to.
    pub(crate) fn context(&self, access: Access) -> &WorldState {
        &self.nodes[access.node].context
    }

    /// The concrete schema that achieves `target` most surely where `access` leads, and how surely.
    pub(crate) fn carrier(
        &self,
        memory: &Memory,
        body: BodyId,
        target: &[Observation],
        access: Access,
    ) -> Option<(SchemaId, f64)> {
        carrier(memory, body, target, &self.nodes[access.node].ids)
    }

    /// The schemas that lead to `access`, in order.
    pub(crate) fn chain(&self, access: Access) -> Vec<ChainLink> {
        let mut links = Vec::new();
        let mut at = access.node;
        while let Some((parent, link)) = self.nodes.get(at).and_then(|node| node.via.clone()) {
            links.push(link);
            at = parent;
        }
        links.reverse();
        links
    }
}

/// Contexts that one schema leads to from `node`, with the probability of the change.
fn edges(memory: &Memory, body: BodyId, node: &Node) -> Vec<(WorldState, f64, ChainLink)> {
    let content = memory.content();
    let mut found = Vec::new();
    for id in memory.index().context_changing() {
        let Some(concrete) = content.schema(*id).and_then(|s| s.concrete()) else { continue };
        if !can_do(memory, body, concrete.action) || !concrete.pre.iter().all(|o| node.ids.contains(o)) {
            continue;
        }
        let link = ChainLink { schema: *id, binding: Substitution::new(), carrier: None };
        let Some(bound) = Bound::new(content, *id, &link.binding) else { continue };
        found.extend(
            transition(memory, node, &bound)
                .map(|(context, p)| (context, p * reliability(memory, concrete.action), link)),
        );
    }
    for id in memory.index().generalised() {
        let Some(generalised) = content.schema(*id).and_then(|s| s.generalised()) else { continue };
        for binding in bindings(&generalised.pre, node.context.observations(), BINDINGS_MAX) {
            let Some(bound) = Bound::new(content, *id, &binding) else { continue };
            let Some((context, probability)) = transition(memory, node, &bound) else { continue };
            let target: Option<Vec<_>> = generalised.target.iter().map(|p| p.apply(&binding)).collect();
            let Some((carrier, known)) = target.and_then(|t| carrier(memory, body, &t, &node.ids)) else {
                continue;
            };
            let link = ChainLink { schema: *id, binding, carrier: Some(carrier) };
            found.push((context, probability * known, link));
        }
    }
    found
}

/// The context after `bound` in `node`, and the probability of what changes; none if nothing does.
fn transition(memory: &Memory, node: &Node, bound: &Bound) -> Option<(WorldState, f64)> {
    let mut probability = 1.0;
    let mut after: Vec<Observation> = node.context.observations().to_vec();
    for post in bound.predicted(memory.parameters()) {
        let changes =
            memory.rules().precondition(post.what.kind()) && node.context.contains(&post.what) == post.absent;
        if changes {
            probability *= post.count.ratio();
            match post.absent {
                true => after.retain(|o| *o != post.what),
                false => after.push(post.what.clone()),
            }
        }
    }
    let after = WorldState::new(after);
    (after != node.context).then_some((after, probability))
}

/// Whether `body` has the primitive in its repertoire.
pub(crate) fn can_do(memory: &Memory, body: BodyId, action: PrimitiveId) -> bool {
    let bodies = memory.content().vocabulary.bodies();
    bodies.get(usize::from(body.0)).is_some_and(|known| known.repertoire.binary_search(&action).is_ok())
}

/// How surely `concrete` achieves all of `target`: the product of the lower ends of the intervals of just
/// those outcomes, and of the action's reliability. None if it does not know one of them.
fn achieves(memory: &Memory, concrete: &Concrete, target: &[ObservationId]) -> Option<f64> {
    let mut sure = reliability(memory, concrete.action);
    for wanted in target {
        let post = concrete.post.iter().find(|post| post.what == *wanted && !post.absent)?;
        if !bound::predicted(post.count, memory.parameters()) {
            return None;
        }
        sure *= post.count.interval().0;
    }
    Some(sure)
}

/// Concrete schemas that achieve all of `target`, with how surely, in order of their numbers.
fn achievers<'a>(
    memory: &'a Memory,
    body: BodyId,
    target: &[Observation],
) -> impl Iterator<Item = (SchemaId, &'a Concrete, f64)> + use<'a> {
    let ids: Option<Vec<_>> = target.iter().map(|o| memory.index().id(o)).collect();
    let ids = ids.unwrap_or_default();
    let fewest = ids.iter().map(|id| memory.index().causing(*id)).min_by_key(|list| list.len());
    fewest.unwrap_or_default().iter().filter_map(move |id| {
        let concrete = memory.content().schema(*id)?.concrete()?;
        let sure = achieves(memory, concrete, &ids)?;
        can_do(memory, body, concrete.action).then_some((*id, concrete, sure))
    })
}

/// The concrete schema most likely to achieve `target` where `holding` holds: the surest, then the one
/// with the fewest pre-conditions, then the oldest.
fn carrier(
    memory: &Memory,
    body: BodyId,
    target: &[Observation],
    holding: &FxHashSet<ObservationId>,
) -> Option<(SchemaId, f64)> {
    achievers(memory, body, target)
        .filter(|(_, concrete, _)| concrete.pre.iter().all(|o| holding.contains(o)))
        .max_by(surest)
        .map(|(id, _, sure)| (id, sure))
}

fn surest(a: &(SchemaId, &Concrete, f64), b: &(SchemaId, &Concrete, f64)) -> Ordering {
    a.2.total_cmp(&b.2).then_with(|| b.1.pre.len().cmp(&a.1.pre.len())).then_with(|| b.0.cmp(&a.0))
}

/// How to achieve a target from here.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Achievement {
    /// The concrete schema that achieves it.
    pub(crate) carrier: SchemaId,
    /// How that schema becomes executable.
    pub(crate) access: Access,
}

/// "The schema most likely to achieve the target" (II-E), or the chain to it, from where `reach` was
/// searched. A target that nothing achieves gives none.
pub(crate) fn achieve(
    memory: &Memory,
    reach: &Reach,
    body: BodyId,
    target: &[Observation],
) -> Option<Achievement> {
    achievers(memory, body, target)
        .filter_map(|(id, concrete, sure)| {
            let access = reach.access(&concrete.pre)?;
            Some(((id, concrete, sure * access.probability), access))
        })
        .max_by(|(a, x), (b, y)| {
            a.2.total_cmp(&b.2)
                .then_with(|| b.1.pre.len().cmp(&a.1.pre.len()))
                .then_with(|| y.preceding.cmp(&x.preceding))
                .then_with(|| b.0.cmp(&a.0))
        })
        .map(|((carrier, ..), access)| Achievement { carrier, access })
}
