//! The world state Υ: the set of observations that hold in one frame.

use std::sync::Arc;

use crate::nouns::observation::Observation;
use crate::nouns::parameters::TypeRules;

/// A set of observations in canonical order, each once: the same object reported twice is one. Shared by its clones: what was
/// perceived is kept by the execution, the decision and its explanation.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct WorldState(Arc<Vec<Observation>>);

impl WorldState {
    /// The set of `observations`, in any order and with any repetitions.
    #[must_use]
    pub fn new(observations: impl IntoIterator<Item = Observation>) -> Self {
        let mut observations: Vec<_> = observations.into_iter().collect();
        observations.sort_unstable();
        observations.dedup();
        Self(Arc::new(observations))
    }

    /// The observations in canonical order.
    #[must_use]
    pub fn observations(&self) -> &[Observation] {
        &self.0
    }

    /// Whether `observation` holds.
    #[must_use]
    pub fn contains(&self, observation: &Observation) -> bool {
        self.0.binary_search(observation).is_ok()
    }

    /// Whether all of `observations` hold.
    #[must_use]
    pub fn satisfies<'a>(&self, observations: impl IntoIterator<Item = &'a Observation>) -> bool {
        observations.into_iter().all(|observation| self.contains(observation))
    }

    /// The part of which `keep` is true.
    #[must_use]
    pub fn filter(&self, keep: impl Fn(&Observation) -> bool) -> Self {
        Self(Arc::new(self.0.iter().filter(|observation| keep(observation)).cloned().collect()))
    }

    /// The context: the part that may become a pre-condition.
    #[must_use]
    pub fn context(&self, rules: &TypeRules) -> Self {
        self.filter(|observation| rules.of(observation.kind()).precondition)
    }

    /// The part that the learner lives by: all but values.
    #[must_use]
    pub fn lived_by(&self, rules: &TypeRules) -> Self {
        let is_apart = |observation: &Observation| rules.of(observation.kind()).is_apart();
        if self.0.iter().any(is_apart) {
            self.filter(|observation| !is_apart(observation))
        } else {
            self.clone()
        }
    }

    /// The part that goes on holding unless something changes it: all but events.
    #[must_use]
    pub fn lasting(&self, rules: &TypeRules) -> Self {
        self.filter(|observation| !rules.of(observation.kind()).transient)
    }
}
