//! Attention (paper, II-C): N(x) counts how often x was perceived while the schema being executed referred
//! to it. "In this way the importance of a perception not directly related to the current action is not
//! diminished unnecessarily."

use crate::cycle::association::references;
use crate::memory::Memory;
use crate::memory::instance::Instance;
use crate::nouns::effect::Effect;
use crate::nouns::schema::SchemaId;
use crate::nouns::world_state::WorldState;

/// The effect that counts attention for what was perceived before or after an execution of `schemas`, each with how it
/// reads, each observation once; none when nothing was.
pub(crate) fn attend<'a>(
    memory: &'a Memory,
    schemas: impl Iterator<Item = (SchemaId, &'a Option<Instance>)>,
    before: &WorldState,
    after: &WorldState,
) -> Option<Effect> {
    if !memory.parameters().attention {
        return None;
    }
    let mut attended: Vec<_> = schemas
        .filter_map(|(schema, bound)| Some((schema, bound.as_ref()?)))
        .flat_map(|(schema, bound)| references(memory, schema, bound))
        .filter(|observation| {
            // An event holds for its frame only: one that came before is not perceived any more.
            let event = memory.rules().of(observation.kind()).transient;
            after.contains(observation) || !event && before.contains(observation)
        })
        .filter(|observation| {
            memory.parameters().heard_decays || !memory.rules().of(observation.kind()).heard
        })
        .collect();
    if memory.content().full {
        attended.retain(|observation| memory.attention(observation) > 0);
    }
    attended.sort_unstable();
    attended.dedup();
    (!attended.is_empty()).then(|| Effect::Attended(attended.into_iter().cloned().collect()))
}
