//! Target actions (paper, II-E and figure 2): an action given as the observations to be achieved.

use crate::memory::Memory;
use crate::nouns::observation::Observation;
use crate::nouns::schema::{Concrete, SchemaId};

/// "The simplest context": of the schemas with this action whose pre-conditions are among those of
/// `seed`, the one with the fewest, and fewer than `seed` has; of equals the oldest.
pub(crate) fn simplest(memory: &Memory, seed: &Concrete) -> Option<SchemaId> {
    let groups = memory.index().groups();
    let mut pre = seed.pre.to_vec();
    pre.sort_unstable();
    groups
        .holding(&pre)
        .into_iter()
        .map(|group| (groups.get(group).pre.len(), group))
        .filter(|(len, _)| *len < seed.pre.len())
        .filter_map(|(len, group)| Some((len, groups.exact(group, seed.action)?)))
        .min()
        .map(|(_, id)| id)
}

/// What the action of `seed` is predicted to bring about in the simplest context; nothing if none simpler is known.
pub(crate) fn achieved<'a>(
    memory: &'a Memory,
    seed: &Concrete,
) -> impl Iterator<Item = &'a Observation> + 'a {
    let known = simplest(memory, seed).and_then(|id| memory.content().concrete(id));
    let post = known.map_or(&[][..], |known| &known.post).iter();
    let predicted = post.filter(|post| !post.absent && memory.parameters().predicts(post.count));
    predicted.map(|post| memory.content().observation(post.what))
}

/// The target that stands for the action of `seed`: what the action achieves in the simplest context, in
/// canonical order. None if nothing simpler is known, or nothing that it achieves.
pub(crate) fn target(memory: &Memory, seed: &Concrete) -> Option<Vec<Observation>> {
    let mut target: Vec<_> = achieved(memory, seed).cloned().collect();
    target.sort_unstable();
    (!target.is_empty()).then_some(target)
}
