//! Motor babbling: the drive to try what no schema covers here (the first stage of the paper's list).

use crate::memory::Memory;
use crate::nouns::schema::{ObservationId, Schema, SchemaId};
use crate::nouns::vocabulary::{BodyId, PrimitiveId};

/// Concrete schemas that `body` can execute where just `holding` holds, which is ordered; by number.
pub(crate) fn executable(memory: &Memory, body: BodyId, holding: &[ObservationId]) -> Vec<SchemaId> {
    let index = memory.index();
    let groups = index.groups().holding(holding);
    let schemas = || groups.iter().map(|group| &index.groups().get(*group).schemas);
    let vocabulary = &memory.content().vocabulary;
    // By primitive, for there may be very many schemas.
    let mut can = vec![false; vocabulary.primitives().len()];
    for primitive in vocabulary.bodies().get(usize::from(body.0)).iter().flat_map(|known| &known.repertoire) {
        if let Some(can) = can.get_mut(primitive.0 as usize) {
            *can = true;
        }
    }
    let can = |id: &SchemaId| {
        index.outline(*id).and_then(|known| can.get(known.action.0 as usize)).copied().unwrap_or(false)
    };
    let mut found = Vec::with_capacity(schemas().map(Vec::len).sum());
    found.extend(schemas().flatten().copied().filter(can));
    found.sort_unstable();
    found
}

/// Primitives of `body` that none of the `executable` schemas covers: never tried, or known only under
/// pre-conditions that do not hold now. In order of their numbers.
pub(crate) fn uncovered(memory: &Memory, body: BodyId, executable: &[SchemaId]) -> Vec<PrimitiveId> {
    let content = memory.content();
    let mut covered = vec![false; content.vocabulary.primitives().len()];
    // With claims, nothing may be known yet of what came of an action that was tried once: whether it was the action's doing.
    let says = |id: &&SchemaId| {
        let known = content.schema(**id).filter(|_| content.mechanisms.claims);
        let silent = |s: &Schema| s.executions.trials < 2 && s.concrete().is_some_and(|c| c.post.is_empty());
        !known.is_some_and(silent)
    };
    for outline in executable.iter().filter(says).filter_map(|id| memory.index().outline(*id)) {
        if let Some(covered) = covered.get_mut(outline.action.0 as usize) {
            *covered = true;
        }
    }
    let repertoire = content.vocabulary.bodies().get(usize::from(body.0)).map_or(&[][..], |b| &b.repertoire);
    let is_covered = |primitive: &PrimitiveId| covered.get(primitive.0 as usize).copied().unwrap_or(false);
    repertoire.iter().filter(|primitive| !is_covered(primitive)).copied().collect()
}
