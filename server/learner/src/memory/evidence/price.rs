//! The test of a claim: whether its examples are foretold so much better by a distribution of their own that it pays for its
//! condition. Two marginal likelihoods are compared, of the same outcomes together and apart (Krichevsky & Trofimov's estimator,
//! integrated over all distributions), and the logarithm of how many conditions could have been chosen is taken off. Nothing in
//! it is to be tuned to a world.

use crate::nouns::claim::{Anchor, Condition, Expression, Reference};

/// Sums of logarithms, from which likelihoods are put together.
pub(crate) struct Likelihood {
    /// ln of 1/K · (1/K + 1) · … for as many factors as the index says.
    rising: Vec<f64>,
    /// ln of the factorial of the index.
    factorial: Vec<f64>,
}

impl Likelihood {
    /// For at most `trials` examples with `outcomes` kinds of outcome.
    pub(crate) fn new(trials: usize, outcomes: usize) -> Self {
        let share = 1.0 / outcomes.max(2) as f64;
        let sums = |from: f64| {
            let mut sum = 0.0;
            let mut sums = vec![0.0];
            sums.extend((0..trials).map(|i| {
                sum += libm::log(i as f64 + from);
                sum
            }));
            sums
        };
        Self { rising: sums(share), factorial: sums(1.0) }
    }

    /// The share of ln of the probability of outcomes, in a given order, that is due to one seen so often.
    pub(crate) fn rising(&self, count: usize) -> f64 {
        self.rising.get(count).copied().unwrap_or(f64::NEG_INFINITY)
    }

    /// The share that is due to so many trials, to be taken off.
    pub(crate) fn factorial(&self, trials: usize) -> f64 {
        self.factorial.get(trials).copied().unwrap_or(f64::INFINITY)
    }
}

/// ln of the probability of so many successes and failures in a given order, whatever their chance is.
pub(super) fn of_two(successes: usize, failures: usize) -> f64 {
    let rising = |count: usize| libm::lgamma(count as f64 + 0.5) - libm::lgamma(0.5);
    rising(successes) + rising(failures) - libm::lgamma((successes + failures) as f64 + 1.0)
}

/// How involved a condition is. One that speaks of the action's own values is a shorter sentence than one that gives values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Tier {
    /// It names values by their part in the action alone, and so ties what is seen to what is done.
    Direct,
    /// It names others, or says no more than that there is something.
    Tied,
    /// It gives values.
    Given,
    /// It gives a bound.
    Bound,
    /// It asks for what is recalled.
    Recalled,
}

impl Tier {
    pub(super) const COUNT: usize = 5;

    pub(super) fn of(condition: &Condition) -> Self {
        if condition.is_recalled() {
            return Self::Recalled;
        }
        let Condition::Observed(sketch) = condition else {
            return if matches!(condition, Condition::AtLeast(..)) { Self::Bound } else { Self::Given };
        };
        let tier = |expression: &Expression| match expression {
            Expression::Named(Reference::Recalled(..), _) => Self::Recalled,
            Expression::Constant(_) => Self::Given,
            Expression::Named(Reference::Parameter(_) | Reference::Effect(..), _) => Self::Direct,
            Expression::Named(..) => Self::Tied,
        };
        sketch.properties.iter().map(|(_, e)| tier(e)).max().unwrap_or(Self::Tied)
    }

    /// The price of one of `among` conditions of this tier: a tier costs a bit more than the one before it.
    pub(super) fn price(self, among: usize) -> f64 {
        let share = match self {
            Self::Direct => 2.0,
            Self::Tied => 4.0,
            Self::Given | Self::Bound | Self::Recalled => 8.0,
        };
        libm::log(share * among.max(2) as f64)
    }
}

/// The anchor that a reference is, if it is one.
pub(super) fn anchor(reference: Reference) -> Option<Anchor> {
    match reference {
        Reference::Parameter(at) => Some(Anchor::Parameter(at)),
        Reference::Effect(kind, property) => Some(Anchor::Effect(kind, property)),
        Reference::Only(kind, property) => Some(Anchor::Only(kind, property)),
        Reference::Itself(property) => Some(Anchor::Itself(property)),
        Reference::Age => Some(Anchor::Age),
        Reference::Recalled(..) | Reference::Tied { .. } => None,
    }
}
