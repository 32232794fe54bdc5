//! Motor babbling: the drive to try what no schema covers here (the first stage of the paper's list).

use rustc_hash::FxHashSet;

use crate::chaining::can_do;
use crate::memory::Memory;
use crate::schema::{ObservationId, SchemaId};
use crate::vocabulary::{BodyId, PrimitiveId};

/// Concrete schemas that `body` can execute where just `holding` holds, in order of their numbers.
pub(crate) fn executable(memory: &Memory, body: BodyId, holding: &FxHashSet<ObservationId>) -> Vec<SchemaId> {
    let content = memory.content();
    let mut ordered: Vec<_> = holding.iter().copied().collect();
    ordered.sort_unstable();
    let conditional = ordered.iter().flat_map(|observation| memory.index().requiring(*observation));
    let mut found: Vec<_> = memory
        .index()
        .unconditional()
        .iter()
        .chain(conditional)
        .copied()
        .filter(|id| {
            content.schema(*id).and_then(|s| s.concrete()).is_some_and(|concrete| {
                concrete.pre.iter().all(|o| holding.contains(o)) && can_do(memory, body, concrete.action)
            })
        })
        .collect();
    found.sort_unstable();
    found.dedup();
    found
}

/// Primitives of `body` that none of the `executable` schemas covers: never tried, or known only under
/// pre-conditions that do not hold now. In order of their numbers.
pub(crate) fn uncovered(memory: &Memory, body: BodyId, executable: &[SchemaId]) -> Vec<PrimitiveId> {
    let content = memory.content();
    let covered: FxHashSet<_> = executable
        .iter()
        .filter_map(|id| content.schema(*id).and_then(|s| s.concrete()).map(|concrete| concrete.action))
        .collect();
    let repertoire = content.vocabulary.bodies().get(usize::from(body.0)).map_or(&[][..], |b| &b.repertoire);
    repertoire.iter().filter(|primitive| !covered.contains(primitive)).copied().collect()
}
