//! Carriers: the concrete schemas that achieve the target of a generalised one (paper, II-E).

use std::cmp::Ordering;

use crate::memory::Memory;
use crate::memory::groups::GroupId;
use crate::nouns::observation::Observation;
use crate::nouns::schema::{Concrete, ObservationId, SchemaId};
use crate::nouns::vocabulary::BodyId;

/// How surely `concrete` achieves all of `target`: the product of the lower ends of the intervals of just
/// those outcomes, and of the action's reliability. None if it does not know one of them.
fn achieves(memory: &Memory, concrete: &Concrete, target: &[ObservationId]) -> Option<f64> {
    let mut sure = memory.content().reliability(concrete.action);
    for wanted in target {
        let post = concrete.post.iter().find(|post| post.what == *wanted && !post.absent)?;
        if !memory.parameters().predicts(post.count) {
            return None;
        }
        sure *= post.count.interval().0;
    }
    Some(sure)
}

/// A concrete schema that achieves a target, and how surely.
pub(crate) type Achiever<'a> = (SchemaId, &'a Concrete, f64);

pub(crate) fn achiever<'a>(
    memory: &'a Memory,
    body: BodyId,
    id: SchemaId,
    target: &[ObservationId],
) -> Option<Achiever<'a>> {
    let concrete = memory.content().concrete(id)?;
    let sure = achieves(memory, concrete, target)?;
    memory.content().vocabulary.can_do(body, concrete.action).then_some((id, concrete, sure))
}

/// The numbers of all of `target`; what has none is caused by nothing.
pub(crate) fn numbered(memory: &Memory, target: &[Observation]) -> Option<Vec<ObservationId>> {
    target.iter().map(|o| memory.index().id(o)).collect()
}

/// The concrete schema of these groups most likely to achieve `target`: the surest, then the one with the fewest
/// pre-conditions, then the oldest.
pub(crate) fn carrier(
    memory: &Memory,
    body: BodyId,
    target: &[Observation],
    groups: &[GroupId],
) -> Option<(SchemaId, f64)> {
    let target = numbered(memory, target)?;
    let first = *target.first()?;
    groups
        .iter()
        .flat_map(|group| memory.index().groups().get(*group).with_outcome(first))
        .filter_map(|id| achiever(memory, body, id, &target))
        .max_by(surest)
        .map(|(id, _, sure)| (id, sure))
}

fn surest(a: &Achiever<'_>, b: &Achiever<'_>) -> Ordering {
    a.2.total_cmp(&b.2).then_with(|| b.1.pre.len().cmp(&a.1.pre.len())).then_with(|| b.0.cmp(&a.0))
}
