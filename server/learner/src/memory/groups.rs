//! Concrete schemas with the same pre-conditions, and which of these groups hold in a context. What a body can do
//! somewhere is found by what holds there, not by looking through all that it knows.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use crate::nouns::schema::{ObservationId, SchemaId};
use crate::nouns::vocabulary::PrimitiveId;

/// A group of concrete schemas, numbered in the order of the first of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct GroupId(u32);

impl GroupId {
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }
}

/// Concrete schemas with the same pre-conditions.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    /// In canonical order, as its schemas have them.
    pub(crate) pre: Arc<[ObservationId]>,
    /// Its schemas by number.
    pub(crate) schemas: Vec<SchemaId>,
    /// Those whose effect changes what may be a pre-condition, by number.
    pub(crate) changing: Vec<SchemaId>,
    /// What its schemas have as post-conditions, absences included: by observation, then schema.
    outcomes: Vec<(ObservationId, SchemaId)>,
    /// Its schemas by action; there is never more than one for each.
    by_action: Vec<(PrimitiveId, SchemaId)>,
}

impl Group {
    /// Its schemas that have `what` as a post-condition, observed or absent, by number.
    pub(crate) fn with_outcome(&self, what: ObservationId) -> impl Iterator<Item = SchemaId> + '_ {
        let from = self.outcomes.partition_point(|(known, _)| *known < what);
        self.outcomes[from..].iter().take_while(move |(known, _)| *known == what).map(|(_, id)| *id)
    }
}

/// All groups.
#[derive(Clone, Debug, Default)]
pub(crate) struct Groups {
    groups: Vec<Group>,
    by_pre: FxHashMap<Arc<[ObservationId]>, GroupId>,
    /// The pre-conditions of all groups, each ordered by number, as the paths of a tree.
    tree: Tree,
}

/// Adds to a sorted list, mostly at its end.
pub(crate) fn insert<T: Ord>(list: &mut Vec<T>, item: T) {
    if list.last().is_none_or(|last| *last < item) {
        list.push(item);
    } else if let Err(at) = list.binary_search(&item) {
        list.insert(at, item);
    }
}

impl Groups {
    /// Adds a schema, and says which group it is in.
    pub(crate) fn add(&mut self, id: SchemaId, pre: &Arc<[ObservationId]>, action: PrimitiveId) -> GroupId {
        let group = self.with_pre(pre).unwrap_or_else(|| {
            let group = GroupId(u32::try_from(self.groups.len()).unwrap_or(u32::MAX));
            self.groups.push(Group {
                pre: pre.clone(),
                schemas: Vec::new(),
                changing: Vec::new(),
                outcomes: Vec::new(),
                by_action: Vec::new(),
            });
            self.by_pre.insert(pre.clone(), group);
            self.tree.add(pre, group);
            group
        });
        let entered = &mut self.groups[group.index()];
        insert(&mut entered.schemas, id);
        insert(&mut entered.by_action, (action, id));
        group
    }

    /// Takes over a post-condition of a schema in `group`.
    pub(crate) fn add_outcome(&mut self, group: GroupId, id: SchemaId, what: ObservationId) {
        insert(&mut self.groups[group.index()].outcomes, (what, id));
    }

    /// Notes that a schema in `group` may change the context.
    pub(crate) fn add_changing(&mut self, group: GroupId, id: SchemaId) {
        insert(&mut self.groups[group.index()].changing, id);
    }

    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.groups.len()
    }

    pub(crate) fn get(&self, group: GroupId) -> &Group {
        &self.groups[group.index()]
    }

    /// Those numbered `from` and later.
    pub(crate) fn since(&self, from: usize) -> impl Iterator<Item = (GroupId, &Group)> {
        let number = |at: usize| GroupId(u32::try_from(at).unwrap_or(u32::MAX));
        self.groups.iter().enumerate().skip(from).map(move |(at, group)| (number(at), group))
    }

    /// The group with just these pre-conditions, in canonical order.
    pub(crate) fn with_pre(&self, pre: &[ObservationId]) -> Option<GroupId> {
        self.by_pre.get(pre).copied()
    }

    /// The schema of `group` with this action; there is never more than one.
    pub(crate) fn exact(&self, group: GroupId, action: PrimitiveId) -> Option<SchemaId> {
        let by_action = &self.groups[group.index()].by_action;
        let at = by_action.binary_search_by_key(&action, |(action, _)| *action).ok()?;
        by_action.get(at).map(|(_, id)| *id)
    }

    /// The groups whose pre-conditions are all among `holding`, which is ordered by number.
    pub(crate) fn holding(&self, holding: &[ObservationId]) -> Vec<GroupId> {
        let mut found = Vec::new();
        self.tree.subsets(holding, &mut found);
        found
    }
}

/// Sets of observations as paths from the root: sets that begin alike share the beginning, so that the sets within a
/// given one are found by going along just what it contains.
#[derive(Clone, Debug)]
struct Tree(Vec<Branch>);

#[derive(Clone, Debug, Default)]
struct Branch {
    group: Option<GroupId>,
    /// By observation.
    next: Vec<(ObservationId, u32)>,
}

impl Default for Tree {
    fn default() -> Self {
        Self(vec![Branch::default()])
    }
}

impl Tree {
    fn add(&mut self, set: &[ObservationId], group: GroupId) {
        let mut ordered = set.to_vec();
        ordered.sort_unstable();
        let mut at = 0;
        for observation in ordered {
            at = match self.0[at].next.binary_search_by_key(&observation, |(o, _)| *o) {
                Ok(found) => self.0[at].next[found].1 as usize,
                Err(place) => {
                    let new = self.0.len();
                    self.0.push(Branch::default());
                    let number = u32::try_from(new).unwrap_or(u32::MAX);
                    self.0[at].next.insert(place, (observation, number));
                    new
                }
            };
        }
        self.0[at].group = Some(group);
    }

    fn subsets(&self, holding: &[ObservationId], found: &mut Vec<GroupId>) {
        // Branches to be entered, each with the observations that may still follow on its way.
        let mut open = vec![(0_usize, holding)];
        while let Some((at, rest)) = open.pop() {
            let branch = &self.0[at];
            found.extend(branch.group);
            // Whichever is shorter is gone through; the other is looked up.
            if branch.next.len() < rest.len() {
                for (observation, next) in &branch.next {
                    if let Ok(place) = rest.binary_search(observation) {
                        open.push((*next as usize, &rest[place + 1..]));
                    }
                }
            } else {
                for (place, observation) in rest.iter().enumerate() {
                    if let Ok(next) = branch.next.binary_search_by_key(observation, |(o, _)| *o) {
                        open.push((branch.next[next].1 as usize, &rest[place + 1..]));
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nouns::random::Random;

    fn ids(numbers: impl IntoIterator<Item = u32>) -> Vec<ObservationId> {
        numbers.into_iter().map(ObservationId).collect()
    }

    #[test]
    fn what_holds_is_found_as_by_looking_through_all() {
        let seed = 5;
        let mut random = Random::from_seed(seed);
        let mut some = |of: u32, most: usize| {
            let count = random.below(most + 1);
            let mut set = ids((0..count).map(|_| random.below(of as usize) as u32));
            set.sort_unstable();
            set.dedup();
            set
        };
        let mut groups = Groups::default();
        for number in 0..300 {
            let mut pre = some(12, 4);
            // Canonical order is not that of numbers.
            pre.reverse();
            groups.add(SchemaId(number), &pre.into(), PrimitiveId(number % 7));
        }
        for _ in 0..200 {
            let holding = some(12, 9);
            let mut found = groups.holding(&holding);
            found.sort_unstable();
            let holds = |group: &Group| group.pre.iter().all(|o| holding.contains(o));
            let expected: Vec<_> = groups.since(0).filter(|(_, g)| holds(g)).map(|(id, _)| id).collect();
            assert_eq!(found, expected, "seed {seed}, {holding:?}");
        }
    }

    #[test]
    fn outcomes_are_found_within_their_group() {
        let mut groups = Groups::default();
        let here = groups.add(SchemaId(0), &ids([3]).into(), PrimitiveId(0));
        assert_eq!(groups.add(SchemaId(4), &ids([3]).into(), PrimitiveId(1)), here);
        let there = groups.add(SchemaId(5), &ids([]).into(), PrimitiveId(1));
        for (group, schema, what) in [(here, 4, 9), (here, 0, 9), (here, 0, 2), (there, 5, 9), (here, 0, 9)] {
            groups.add_outcome(group, SchemaId(schema), ObservationId(what));
        }
        let found: Vec<_> = groups.get(here).with_outcome(ObservationId(9)).collect();
        assert_eq!(found, [SchemaId(0), SchemaId(4)]);
        assert_eq!(groups.get(there).with_outcome(ObservationId(2)).count(), 0);
        assert_eq!(groups.exact(here, PrimitiveId(1)), Some(SchemaId(4)));
        assert_eq!(groups.exact(there, PrimitiveId(0)), None);
    }
}
