//! Habituation (paper, II-G): before the next constraint is lifted, each schema of the stage is tried until
//! its outcomes are known, so that noise is not put down to what comes next.

use crate::memory::Memory;
use crate::nouns::curriculum::Habituation;
use crate::nouns::schema::SchemaId;

/// Those of the `executable` schemas that were made since `first_step` and are not yet known well enough.
pub(crate) fn unhabituated(
    memory: &Memory,
    rule: &Habituation,
    first_step: u64,
    executable: &[SchemaId],
) -> Vec<SchemaId> {
    let wanting = |id: &SchemaId| {
        let schema = memory.content().schema(*id);
        schema.is_some_and(|schema| schema.created_step >= first_step && rule.wants(schema.executions))
    };
    executable.iter().copied().filter(wanting).collect()
}
