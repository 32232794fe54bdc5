//! Distributions over finitely many outcomes, exact but for the rounding of a float.

use std::collections::BTreeMap;

use fastrand::Rng;

/// The generator of chances that begins with `seed`. It is a fork: generators of this kind that begin with neighbouring numbers give
/// numbers that resemble each other.
#[must_use]
pub fn chances(seed: u64) -> Rng {
    Rng::with_seed(seed).fork()
}

/// Outcomes, each with its probability. Equal outcomes are one.
#[derive(Clone, Debug, PartialEq)]
pub struct Distribution<T>(BTreeMap<T, f64>);

impl<T: Ord> FromIterator<(T, f64)> for Distribution<T> {
    fn from_iter<I: IntoIterator<Item = (T, f64)>>(outcomes: I) -> Self {
        let mut all = BTreeMap::new();
        for (outcome, probability) in outcomes.into_iter().filter(|(_, probability)| *probability > 0.0) {
            *all.entry(outcome).or_insert(0.0) += probability;
        }
        Self(all)
    }
}

impl<T: Ord> Distribution<T> {
    /// One outcome for certain.
    #[must_use]
    pub fn certain(outcome: T) -> Self {
        Self::from_iter([(outcome, 1.0)])
    }

    /// These outcomes, each as likely.
    #[must_use]
    pub fn even(outcomes: impl IntoIterator<Item = T, IntoIter: ExactSizeIterator>) -> Self {
        let outcomes = outcomes.into_iter();
        let share = 1.0 / outcomes.len() as f64;
        outcomes.map(|outcome| (outcome, share)).collect()
    }

    /// The outcomes with their probabilities, in the order of the outcomes.
    pub fn iter(&self) -> impl Iterator<Item = (&T, f64)> {
        self.0.iter().map(|(outcome, probability)| (outcome, *probability))
    }

    /// The probability of `outcome`; 0 when it can't come.
    #[must_use]
    pub fn probability(&self, outcome: &T) -> f64 {
        self.0.get(outcome).copied().unwrap_or(0.0)
    }

    /// The sum of the probabilities: 1 of a whole distribution, less of one that leaves some outcomes untold.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.0.values().sum()
    }

    /// The distribution of what `view` shows of each outcome.
    #[must_use]
    pub fn map<U: Ord>(&self, view: impl Fn(&T) -> U) -> Distribution<U> {
        self.iter().map(|(outcome, probability)| (view(outcome), probability)).collect()
    }

    /// The distribution of what comes of each outcome by `next`.
    #[must_use]
    pub fn then<U: Ord + Clone>(&self, next: impl Fn(&T) -> Distribution<U>) -> Distribution<U> {
        let mut all = BTreeMap::new();
        for (outcome, probability) in self.iter() {
            for (later, share) in next(outcome).iter() {
                *all.entry(later.clone()).or_insert(0.0) += probability * share;
            }
        }
        Distribution(all)
    }

    /// The same where it is known that `holds` is true of the outcome; none when it can't be.
    #[must_use]
    pub fn given(self, holds: impl Fn(&T) -> bool) -> Option<Self> {
        let mut left = self.0;
        left.retain(|outcome, _| holds(outcome));
        let total: f64 = left.values().sum();
        left.values_mut().for_each(|probability| *probability /= total);
        (total > 0.0).then_some(Self(left))
    }

    /// The most probable outcome, of equals the first; none when there is no outcome.
    #[must_use]
    pub fn most_probable(&self) -> Option<&T> {
        let best = self.0.values().copied().fold(0.0, f64::max);
        self.iter().find(|(_, probability)| *probability >= best).map(|(outcome, _)| outcome)
    }

    /// Draws an outcome; none when there is no outcome.
    pub fn draw(&self, random: &mut Rng) -> Option<&T> {
        let mut left = random.f64() * self.total();
        let drawn = self.iter().find(|(_, probability)| {
            left -= probability;
            left < 0.0
        });
        // Rounding may leave a remainder, which belongs to the last outcome.
        drawn.map(|(outcome, _)| outcome).or_else(|| self.0.keys().next_back())
    }

    /// Total variation of `foretold` from this distribution, which is whole: half the sum of the differences of the probabilities of
    /// each outcome, and half of the probability that `foretold` leaves untold.
    #[must_use]
    pub fn distance(&self, foretold: &Self) -> f64 {
        let shared = self.iter().map(|(outcome, truth)| truth.min(foretold.probability(outcome)));
        // Rounding may take the sum beyond 1.
        (1.0 - shared.sum::<f64>()).max(0.0)
    }
}
