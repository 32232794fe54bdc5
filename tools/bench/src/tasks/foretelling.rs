//! Foretelling what an action brings about: what is compared with the truth, and the baselines beside it.

use std::collections::BTreeMap;

use pschema_exact::Distribution;
use pschema_learner::vocabulary::PrimitiveId;
use pschema_learner::world_state::WorldState;

/// Somebody who foretells.
pub(crate) trait Foretelling {
    /// The worlds that may follow when `primitive` is carried out in `world`, with their probabilities. They may add up to less than 1:
    /// the rest is what the foreteller can't say.
    fn foretell(&self, world: &WorldState, primitive: PrimitiveId) -> Distribution<WorldState>;
}

/// "Nothing changes": the world stays as it is.
pub(crate) struct Unchanging;

impl Foretelling for Unchanging {
    fn foretell(&self, world: &WorldState, _primitive: PrimitiveId) -> Distribution<WorldState> {
        Distribution::certain(world.clone())
    }
}

/// A table of the first order: what came, and how often, of each action in each world as it was perceived. Nothing changes where
/// an action was never tried.
#[derive(Default)]
pub(crate) struct FirstOrder(BTreeMap<(WorldState, PrimitiveId), BTreeMap<WorldState, u32>>);

impl FirstOrder {
    /// Counts that `after` came.
    pub(crate) fn count(&mut self, before: WorldState, primitive: PrimitiveId, after: WorldState) {
        *self.0.entry((before, primitive)).or_default().entry(after).or_default() += 1;
    }
}

impl Foretelling for FirstOrder {
    fn foretell(&self, world: &WorldState, primitive: PrimitiveId) -> Distribution<WorldState> {
        let Some(counts) = self.0.get(&(world.clone(), primitive)) else {
            return Unchanging.foretell(world, primitive);
        };
        let all: u32 = counts.values().sum();
        counts.iter().map(|(after, count)| (after.clone(), f64::from(*count) / f64::from(all))).collect()
    }
}
