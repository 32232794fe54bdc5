//! Beginnings of episodes: what was to be learnt where the last ones began, which is to be expected where the next one does.

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

impl Beginnings {
    /// Takes in how much was to be learnt where an episode began.
    pub(super) fn note(&mut self, learnable: f64) {
        let (all, count) = self.learnable;
        *self = Self { is_next: false, learnable: (all * KEPT + learnable, count * KEPT + 1.0) };
    }

    /// How much may be learnt where the next one begins, from 0 to 1: as much as where the last ones did.
    pub(super) fn next(&self) -> f64 {
        let (all, count) = self.learnable;
        all / count.max(1.0)
    }
}
