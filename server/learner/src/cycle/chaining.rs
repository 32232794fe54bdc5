//! Chaining: contexts as vertices, schemas as edges. One search from the present context gives the
//! distance d of equation (1) and the chains that lead to a schema or to a goal.
//!
//! A chain is worth the product of the probabilities of what it relies on: of each schema on the way, the
//! changes of context it makes; of the last one, only what the goal asks for (II-A: that a ball may fall
//! does not matter to who moves a block).

use std::cmp::Ordering;
use std::collections::BTreeMap;

use crate::cycle::carrier::{Achiever, achiever, carrier, numbered};
use crate::cycle::search::{self, Node, SearchResult};
use crate::memory::Memory;
use crate::memory::groups::{Group, GroupId, Groups};
use crate::nouns::execution::ChainLink;
use crate::nouns::observation::Observation;
use crate::nouns::schema::{ObservationId, SchemaId};
use crate::nouns::vocabulary::{BodyId, PrimitiveId};
use crate::nouns::world_state::WorldState;

/// What can be reached from one context.
#[derive(Clone, Debug)]
pub(crate) struct Reach {
    nodes: Vec<Node>,
    /// Whether the search used up its budget, so that there may be more.
    pub(crate) truncated: bool,
    /// The best way to where the schemas of each group can be executed, for those that can be reached; by group.
    ways: Vec<(GroupId, Access)>,
    /// Groups that there were.
    groups: usize,
    key: ReachKey,
}

/// What a search depends on: whose actions, from which context, over which edges and how probable they are.
#[derive(Clone, Debug)]
struct ReachKey {
    body: BodyId,
    context: WorldState,
    edges_version: u64,
    /// How many observations have numbers, if any was met that has none (contexts are compared by them).
    observations: Option<usize>,
    /// If a generalised schema was an edge: what its target could be achieved by then, and how many schemas could have stood
    /// in for it.
    asked: BTreeMap<ObservationId, u64>,
    schemas: usize,
}

impl ReachKey {
    fn holds(&self, memory: &Memory, body: BodyId, world: &WorldState) -> bool {
        let index = memory.index();
        self.body == body
            && self.edges_version == index.edges_version()
            && self.observations.is_none_or(|known| known == memory.content().observations.len())
            && (self.asked.is_empty() || self.schemas == memory.content().schemas.len())
            && self.asked.iter().all(|(id, version)| index.causing_version(*id) == *version)
            && self.context == world.context(memory.rules())
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

impl Access {
    /// The same with so many more schemas to be executed before, which lead there with this probability.
    pub(crate) fn after(self, more: usize, probability: f64) -> Self {
        let preceding = self.preceding.saturating_add(u32::try_from(more).unwrap_or(u32::MAX));
        Self { preceding, probability: self.probability * probability, ..self }
    }
}

impl Reach {
    /// What can be reached from `world` now: `known`, while it holds.
    pub(crate) fn renew<'a>(
        known: &'a mut Option<Self>,
        memory: &Memory,
        body: BodyId,
        world: &WorldState,
    ) -> &'a Self {
        let current = known.take().filter(|known| known.key.holds(memory, body, world));
        let reach = known.insert(current.unwrap_or_else(|| Self::search(memory, body, world)));
        reach.take_in_groups(memory);
        reach
    }

    /// Searches from `world` with the actions that `body` has.
    pub(crate) fn search(memory: &Memory, body: BodyId, world: &WorldState) -> Self {
        let context = world.context(memory.rules());
        let SearchResult { nodes, truncated, asked, strangers } = search::search(memory, body, &context);
        let key = ReachKey {
            body,
            context,
            edges_version: memory.index().edges_version(),
            observations: strangers.then(|| memory.content().observations.len()),
            asked,
            schemas: memory.content().schemas.len(),
        };
        let groups = memory.index().groups();
        let mut ways = Vec::new();
        for (at, node) in nodes.iter().enumerate() {
            for group in groups.holding(&node.ids) {
                let (preceding, probability) = (node.depth, node.probability);
                ways.push((group, Access { node: at, preceding, probability }));
            }
        }
        // Of several ways to a group, the first is the best.
        ways.sort_by_key(|(group, _)| *group);
        ways.dedup_by_key(|(group, _)| *group);
        Self { nodes, truncated, ways, groups: groups.len(), key }
    }

    /// Finds the ways to groups that are newer than the search.
    fn take_in_groups(&mut self, memory: &Memory) {
        let groups = memory.index().groups();
        for (id, group) in groups.since(self.groups) {
            self.ways.extend(way(&self.nodes, &group.pre).map(|way| (id, way)));
        }
        self.groups = groups.len();
    }

    /// The best way to where the schemas of `group` can be executed.
    pub(crate) fn way(&self, group: GroupId) -> Option<Access> {
        let at = self.ways.binary_search_by_key(&group, |(group, _)| *group).ok()?;
        self.ways.get(at).map(|(_, way)| *way)
    }

    /// The groups of schemas that can be reached, each with the best way.
    pub(crate) fn ways<'a>(&self, groups: &'a Groups) -> impl Iterator<Item = (Access, &'a Group)> {
        self.ways.iter().map(|(group, way)| (*way, groups.get(*group)))
    }

    /// A way to every context reached, the present one first.
    pub(crate) fn all(&self) -> impl Iterator<Item = Access> {
        self.nodes.iter().enumerate().map(|(node, known)| Access {
            node,
            preceding: known.depth,
            probability: known.probability,
        })
    }

    /// The observations of the context that `access` leads to, by number and in that order.
    pub(crate) fn ids(&self, access: Access) -> &[ObservationId] {
        &self.nodes[access.node].ids
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
        let holding = memory.index().groups().holding(&self.nodes[access.node].ids);
        carrier(memory, body, target, &holding)
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

/// The first of `nodes` where all of `conditions` hold: they are in the order in which they were reached.
fn way(nodes: &[Node], conditions: &[ObservationId]) -> Option<Access> {
    let node = nodes.iter().position(|node| node.holds(conditions))?;
    Some(Access { node, preceding: nodes[node].depth, probability: nodes[node].probability })
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
    let index = memory.index();
    let target = numbered(memory, target)?;
    let rarest = *target.iter().min_by_key(|id| index.causing(**id).len())?;
    let mut best: Option<(Achiever<'_>, Access)> = None;
    let mut weigh = |id: SchemaId, action: PrimitiveId, access: Access| {
        // However surely it achieves the target, it is no surer than this.
        let most = memory.content().reliability(action) * access.probability;
        if best.as_ref().is_some_and(|((.., sure), _)| most < *sure) {
            return;
        }
        let Some((id, concrete, sure)) = achiever(memory, body, id, &target) else { return };
        let found = ((id, concrete, sure * access.probability), access);
        if best.as_ref().is_none_or(|best| better(&found, best)) {
            best = Some(found);
        }
    };
    let action = |id: SchemaId| index.outline(id).map(|outline| outline.action);
    // Whichever is less is gone through: what can be reached, or what brings it about. The choice does not depend on the order.
    if reach.ways.len() < index.causing(rarest).len() {
        for (group, access) in &reach.ways {
            for id in index.groups().get(*group).with_outcome(rarest) {
                action(id).into_iter().for_each(|action| weigh(id, action, *access));
            }
        }
    } else {
        for id in index.causing(rarest) {
            let Some(outline) = index.outline(*id) else { continue };
            reach.way(outline.group).into_iter().for_each(|access| weigh(*id, outline.action, access));
        }
    }
    best.map(|((carrier, ..), access)| Achievement { carrier, access })
}

/// Whether `a` is surer than `b`, then has fewer pre-conditions, then a shorter chain, then is older.
fn better(a: &(Achiever<'_>, Access), b: &(Achiever<'_>, Access)) -> bool {
    let shape = |(known, access): &(Achiever<'_>, Access)| (known.1.pre.len(), access.preceding, known.0);
    match a.0.2.total_cmp(&b.0.2) {
        Ordering::Equal => shape(a) < shape(b),
        order => order.is_gt(),
    }
}
