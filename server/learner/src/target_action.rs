//! Target actions (paper, II-E and figure 2): an action given as the observations to be achieved.

use crate::bound;
use crate::memory::Memory;
use crate::observation::Observation;
use crate::schema::{Concrete, SchemaId};
use crate::vocabulary::PrimitiveId;

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
    let known = simplest(memory, seed).and_then(|id| memory.content().schema(id)?.concrete());
    let post = known.map_or(&[][..], |known| &known.post).iter();
    let predicted = post.filter(|post| !post.absent && bound::predicted(post.count, memory.parameters()));
    predicted.map(|post| memory.content().observation(post.what))
}

/// The target that stands for the action of `seed`: what the action achieves in the simplest context, in
/// canonical order. None if nothing simpler is known, or nothing that it achieves.
pub(crate) fn target(memory: &Memory, seed: &Concrete) -> Option<Vec<Observation>> {
    let mut target: Vec<_> = achieved(memory, seed).cloned().collect();
    target.sort_unstable();
    (!target.is_empty()).then_some(target)
}

/// Of times asked for, the share that the body carried the action out, counting one success in advance:
/// exactly 1 while it never failed. Weighs down what the body refuses or fails to do.
pub(crate) fn reliability(memory: &Memory, action: PrimitiveId) -> f64 {
    let attempts = memory.content().attempts.get(action.0 as usize).copied().unwrap_or_default();
    (1.0 + f64::from(attempts.occurrences)) / (1.0 + f64::from(attempts.trials))
}
