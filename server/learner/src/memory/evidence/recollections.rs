//! What a body recalls: what was there when it was last as an observation shows it.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::memory::evidence::scene::of_kind;
use crate::nouns::experience::Recalled;
use crate::nouns::observation::{Observation, TypeId};

/// Ways to be of which it is recalled what was there; beyond it those that were the longest ago are forgotten.
pub(super) const RECOLLECTIONS_MAX: usize = 1_024;

/// What was there at last, by the observation that shows how the body was.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recollections {
    all: BTreeMap<Observation, (u64, Arc<[Observation]>)>,
    /// How many experiences there were.
    noted: u64,
}

/// What was there at last when an observation showed how a body was.
#[derive(Clone, Debug, PartialEq)]
pub struct Recollection {
    /// The observation.
    pub shown: Observation,
    /// After how many experiences of the body that was.
    pub noted: u64,
    /// What was there, in canonical order.
    pub there: Arc<[Observation]>,
}

impl Recollections {
    /// What is recalled after so many experiences.
    #[must_use]
    pub fn new(noted: u64, all: impl IntoIterator<Item = Recollection>) -> Self {
        let all = all.into_iter().map(|Recollection { shown, noted, there }| (shown, (noted, there)));
        Self { all: all.collect(), noted }
    }

    /// How many experiences the body had.
    #[must_use]
    pub fn noted(&self) -> u64 {
        self.noted
    }

    /// All that is recalled, in the order of the observations that show how the body was.
    pub fn all(&self) -> impl Iterator<Item = Recollection> + '_ {
        let one = |(shown, (noted, there)): (&Observation, &(u64, Arc<[Observation]>))| Recollection {
            shown: shown.clone(),
            noted: *noted,
            there: there.clone(),
        };
        self.all.iter().map(one)
    }

    /// What was there when it was shown by `one`.
    pub(super) fn of(&self, one: &Observation) -> Option<Recalled> {
        let (noted, there) = self.all.get(one)?;
        let age = u32::try_from(self.noted.saturating_sub(*noted).saturating_add(1)).unwrap_or(u32::MAX);
        Some(Recalled { observations: there.clone(), age })
    }

    /// Notes what is there after an experience, as observations of these types show how the body is: each of which there is one only.
    pub(super) fn note(&mut self, keys: impl IntoIterator<Item = TypeId>, there: &Arc<[Observation]>) {
        self.noted = self.noted.saturating_add(1);
        for key in keys {
            if let [one] = of_kind(there, key) {
                self.all.insert(one.clone(), (self.noted, there.clone()));
            }
        }
        while self.all.len() > RECOLLECTIONS_MAX {
            let oldest = self.all.iter().min_by_key(|(_, (noted, _))| *noted).map(|(one, _)| one.clone());
            oldest.iter().for_each(|oldest| drop(self.all.remove(oldest)));
        }
    }
}
