//! Motor babbling: the drive to try what no schema covers here (the first stage of the paper's list).

use crate::chaining::can_do;
use crate::memory::Memory;
use crate::schema::{ObservationId, SchemaId};
use crate::vocabulary::{BodyId, PrimitiveId};

/// Concrete schemas that `body` can execute where just `holding` holds, which is ordered; by number.
pub(crate) fn executable(memory: &Memory, body: BodyId, holding: &[ObservationId]) -> Vec<SchemaId> {
    let index = memory.index();
    let groups = index.groups().holding(holding);
    let schemas = groups.iter().flat_map(|group| &index.groups().get(*group).schemas).copied();
    let can = |id: &SchemaId| index.outline(*id).is_some_and(|known| can_do(memory, body, known.action));
    let mut found: Vec<_> = schemas.filter(can).collect();
    found.sort_unstable();
    found
}

/// Primitives of `body` that none of the `executable` schemas covers: never tried, or known only under
/// pre-conditions that do not hold now. In order of their numbers.
pub(crate) fn uncovered(memory: &Memory, body: BodyId, executable: &[SchemaId]) -> Vec<PrimitiveId> {
    let content = memory.content();
    let mut covered = vec![false; content.vocabulary.primitives().len()];
    for outline in executable.iter().filter_map(|id| memory.index().outline(*id)) {
        if let Some(covered) = covered.get_mut(outline.action.0 as usize) {
            *covered = true;
        }
    }
    let repertoire = content.vocabulary.bodies().get(usize::from(body.0)).map_or(&[][..], |b| &b.repertoire);
    let is_covered = |primitive: &PrimitiveId| covered.get(primitive.0 as usize).copied().unwrap_or(false);
    repertoire.iter().filter(|primitive| !is_covered(primitive)).copied().collect()
}
