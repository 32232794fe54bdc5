//! How a pool learns of values, apart from all else: see [`crate::memory::evidence::values`].

use crate::memory::evidence::facet::{ANYTHING, Facet, Time};
use crate::memory::evidence::pool::Pool;
use crate::memory::evidence::values::Values;
use crate::nouns::experience::Experience;
use crate::nouns::observation::{Observation, TypeId};
use crate::nouns::vocabulary::PrimitiveId;

impl Pool {
    /// All facets, those of values last.
    pub(super) fn all_facets(&self) -> impl Iterator<Item = &Facet> {
        self.facets.iter().chain(&self.values.facets)
    }

    /// Enters the example `at` in the columns of values.
    pub(super) fn enter_values(&mut self, at: usize) {
        let mut facets = std::mem::take(&mut self.values.facets);
        facets.iter_mut().for_each(|facet| facet.enter(self.examples(), at));
        self.values.facets = facets;
    }

    /// A facet for each value that is met for the first time.
    pub(super) fn add_values(&mut self, at: usize) {
        let Some((experience, _)) = self.examples.get(at) else { return };
        let mut new = new_values(&self.values, experience);
        new.retain(|kind| !self.values.facets.iter().any(|facet| facet.kinds.contains(kind)));
        for kind in new {
            let facet = Facet::new(vec![kind], self.examples());
            self.values.facets.push(facet);
        }
    }

    /// Takes the newest example, which is with this primitive, into the claims about values; those about the `renamed` ones, whose own effect
    /// changed, grow anew. What there is to seek of them takes no time from what is sought of others.
    pub(super) fn learn_values(&mut self, at: usize, primitive: PrimitiveId, renamed: &[PrimitiveId]) {
        let mut time = Time::new();
        let mut facets = std::mem::take(&mut self.values.facets);
        for facet in &mut facets {
            let examples = self.examples();
            if facet.general.examples <= at {
                facet.count(examples, at, primitive != ANYTHING);
                facet.seek(examples, primitive, &mut time);
            }
            renamed.iter().for_each(|primitive| facet.rename(examples, *primitive));
        }
        self.values.facets = facets;
    }
}

/// The values that came with an experience, in order. An end of an episode tells of none.
fn new_values(values: &Values, experience: &Experience) -> Vec<TypeId> {
    let mut kinds: Vec<_> =
        experience.after.iter().map(Observation::kind).filter(|kind| values.has(*kind)).collect();
    kinds.dedup();
    kinds.retain(|kind| experience.sensed.binary_search(kind).is_ok() && !experience.is_end());
    kinds
}
