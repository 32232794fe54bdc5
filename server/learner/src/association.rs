//! Associated observations (paper, II-B): "seen to occur frequently alongside a schema but neither
//! required for the schema to be executed, nor directly effected by the action taken".

use crate::bound::Bound;
use crate::effect::Effect;
use crate::memory::Memory;
use crate::observation::{Observation, Substitution, TypeId};
use crate::probability::Count;
use crate::schema::{ASSOCIATIONS_MAX, Association, SchemaId};
use crate::world_state::WorldState;

/// Whether an association counts as an associated observation. An event that happened while the schema
/// ran does at once: that they coincided is evidence, and one example of a word is enough (VI-B). A state
/// that was there anyway does when it is there frequently; else every bystander would be given attention,
/// which II-C rules out.
pub(crate) fn is_associated(memory: &Memory, association: &Association) -> bool {
    let kind = memory.content().observation(association.observation).kind();
    is_strong(memory, kind, association.count)
}

fn is_strong(memory: &Memory, kind: TypeId, count: Count) -> bool {
    memory.rules().transient(kind) || count.interval().0 >= memory.parameters().association_low_min
}

/// Effects that associate with `schema` what was there for the first time in `before` or `after`.
/// `explained` are the schemas whose conditions account for what was seen.
pub(crate) fn associate(
    memory: &Memory,
    schema: SchemaId,
    explained: &[Bound],
    before: &WorldState,
    after: &WorldState,
) -> Vec<Effect> {
    let content = memory.content();
    let Some(known) = content.schema(schema).map(|s| &s.associations) else { return Vec::new() };
    let both = WorldState::new(before.observations().iter().chain(after.observations()).cloned());
    let mut standing: Vec<(bool, u32, Observation)> = known
        .iter()
        .map(|a| {
            let strong = is_associated(memory, a);
            (strong, a.count.occurrences, content.observation(a.observation).clone())
        })
        .collect();
    let mut effects = Vec::new();
    for observation in both.observations() {
        let candidate = !memory.rules().own(observation.kind())
            && !explained.iter().any(|bound| bound.mentions(observation))
            && !standing.iter().any(|(_, _, known)| known == observation);
        if !candidate {
            continue;
        }
        let replaces = (standing.len() >= ASSOCIATIONS_MAX).then(|| weakest(&standing)).flatten();
        if let Some(at) = replaces {
            standing.remove(at);
        }
        let strong = is_strong(memory, observation.kind(), Count::ONCE);
        standing.push((strong, 1, observation.clone()));
        effects.push(Effect::Associated { schema, observation: observation.clone(), replaces });
    }
    effects
}

/// The association that makes room: a weak one before a strong one, the rarest, the oldest.
fn weakest(standing: &[(bool, u32, Observation)]) -> Option<usize> {
    (0..standing.len()).min_by_key(|at| (standing[*at].0, standing[*at].1, *at))
}

/// The observations by which `schema` is known under `binding`: conditions wanted and associated.
pub(crate) fn references(memory: &Memory, schema: SchemaId, binding: &Substitution) -> Vec<Observation> {
    let content = memory.content();
    let Some(bound) = Bound::new(content, schema, binding) else { return Vec::new() };
    let associated = content.schema(schema).map_or(&[][..], |s| &s.associations);
    let associated = associated.iter().filter(|a| is_associated(memory, a));
    let post = bound.post.into_iter().filter(|p| !p.absent).map(|p| p.what);
    bound
        .pre
        .into_iter()
        .chain(post)
        .chain(associated.map(|a| content.observation(a.observation).clone()))
        .collect()
}
