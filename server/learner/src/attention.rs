//! Attention (paper, II-C): N(x) counts how often x was perceived while the schema being executed referred
//! to it. "In this way the importance of a perception not directly related to the current action is not
//! diminished unnecessarily."

use crate::association::references;
use crate::effect::Effect;
use crate::memory::Memory;
use crate::observation::Substitution;
use crate::schema::SchemaId;
use crate::world_state::WorldState;

/// The effect that counts attention for what was perceived before or after an execution of `schemas`, each
/// observation once; none when nothing was.
pub(crate) fn attend(
    memory: &Memory,
    schemas: &[(SchemaId, &Substitution)],
    before: &WorldState,
    after: &WorldState,
) -> Option<Effect> {
    if !memory.parameters().attention {
        return None;
    }
    let mut attended: Vec<_> = schemas
        .iter()
        .flat_map(|(schema, binding)| references(memory, *schema, binding))
        .filter(|observation| {
            // An event holds for its frame only: one that came before is not perceived any more.
            let event = memory.rules().transient(observation.kind());
            after.contains(observation) || !event && before.contains(observation)
        })
        .filter(|observation| memory.parameters().heard_decays || !memory.rules().heard(observation.kind()))
        .collect();
    attended.sort_unstable();
    attended.dedup();
    (!attended.is_empty()).then_some(Effect::Attended(attended))
}
