//! Beginnings of episodes: what was to be learnt where the last ones began, which is to be expected where the next one does.

use crate::memory::evidence::Evidence;
use crate::nouns::experience::Experience;
use crate::nouns::vocabulary::{BodyId, Vocabulary};

/// How far an earlier beginning counts after each.
const KEPT: f64 = 0.9;
/// So many count together, at most.
pub(super) const BEGINNINGS_MAX: f64 = 1.0 / (1.0 - KEPT) + 1e-6;

/// What was to be learnt where episodes of a body began.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Beginnings {
    /// Whether an episode begins and nothing was carried out in it yet.
    pub is_next: bool,
    /// How much was to be learnt, all added up, and of how many; an earlier one counts less.
    pub learnable: (f64, f64),
}

impl Evidence {
    /// Takes in how much is to be learnt where an episode begins, with the first experience in it.
    pub(super) fn note_beginning(&mut self, vocabulary: &Vocabulary, experience: &Experience) {
        if !self.beginnings.get(&experience.body).is_some_and(|known| known.is_next) {
            return;
        }
        let body = vocabulary.bodies().get(usize::from(experience.body.0));
        let repertoire = body.map_or(&[][..], |body| &body.repertoire);
        // For what was met before no episode need end.
        let learnable = match self.background.is_met(&experience.before) {
            true => 0.0,
            false => {
                self.curiosity(vocabulary, repertoire, &experience.before).into_iter().fold(0.0, f64::max)
            }
        };
        let (all, count) = self.beginnings.get(&experience.body).copied().unwrap_or_default().learnable;
        let learnable = (all * KEPT + learnable, count * KEPT + 1.0);
        self.beginnings.insert(experience.body, Beginnings { is_next: false, learnable });
    }

    /// How much may be learnt where the next episode of a body begins, from 0 to 1: as much as where the last ones did.
    pub(crate) fn beginning(&self, body: BodyId) -> f64 {
        let (all, count) = self.beginnings.get(&body).copied().unwrap_or_default().learnable;
        all / count.max(1.0)
    }
}
