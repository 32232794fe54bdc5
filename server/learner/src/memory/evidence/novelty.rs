//! How new it is to do something in a context: equation 1's 1 / (1 + N), squared, with N counted of two observations and a primitive
//! together.

use crate::memory::evidence::columns::{Column, Conditions};
use crate::nouns::claim::{Condition, Expression, Sketch};
use crate::nouns::observation::Observation;

/// Observations of a context that are looked at; more are not, so that a crowd can't make a step slow.
const OBSERVATIONS_MAX: usize = 48;
/// What was tried so often is known.
pub(super) const KNOWN: usize = 16;
/// How far an experience counts after each one like it.
const KEPT: f64 = 0.97;

/// A context, as it was met by the examples of a pool.
pub(super) struct Novelty<'a> {
    /// The examples in whose context each of the first observations was; none of those that were in no context.
    columns: Vec<Option<&'a Column>>,
    /// Of each pair of observations in the context, an observation with itself included, the examples in which both were there.
    pairs: Vec<Column>,
}

impl<'a> Novelty<'a> {
    /// The same of each observation by itself, and of no pairs.
    pub(super) fn of_each(conditions: &'a Conditions, context: &[Observation]) -> Self {
        let columns = context.iter().take(OBSERVATIONS_MAX).map(|observation| met(conditions, observation));
        Self { columns: columns.collect(), pairs: Vec::new() }
    }

    pub(super) fn new(conditions: &'a Conditions, context: &[Observation]) -> Self {
        let Self { columns, .. } = Self::of_each(conditions, context);
        let none = Column::default();
        let mut pairs = Vec::with_capacity(columns.len() * (columns.len() + 1) / 2);
        for (at, one) in columns.iter().enumerate() {
            for other in &columns[at..] {
                let (one, other) = (one.unwrap_or(&none), other.unwrap_or(&none));
                pairs.push(one.both(other));
            }
        }
        Self { columns, pairs }
    }

    /// The mean of newness over the pairs, by the number of those among the examples that `tried` the primitive, where what comes is left so
    /// `open`; from 0 to 1. If the context is that of one of them, it may be left out: `already`.
    pub(super) fn of(&self, tried: &Column, open: f64, already: bool) -> f64 {
        let new = |count: usize| newness(count.saturating_sub(usize::from(already)), open);
        if self.pairs.is_empty() {
            return new(tried.count());
        }
        self.pairs.iter().map(|both| new(both.count_both(tried))).sum::<f64>() / self.pairs.len() as f64
    }

    /// Those that `tried` the primitive with all of the context together, those of its observations left out, by their places, that `matter`
    /// not.
    pub(super) fn together(&self, tried: &Column, matter: impl Fn(usize) -> bool) -> Column {
        let columns =
            self.columns.iter().enumerate().filter(|(at, _)| matter(*at)).map(|(_, column)| *column);
        columns.fold(tried.clone(), |left, column| column.map_or_else(Column::default, |met| left.both(met)))
    }

    /// The share of the pairs in which none of those that `tried` the primitive was.
    pub(super) fn unmet(&self, tried: &Column) -> f64 {
        if self.pairs.is_empty() {
            return 0.0;
        }
        let unmet = self.pairs.iter().filter(|both| both.count_both(tried) == 0);
        unmet.count() as f64 / self.pairs.len() as f64
    }
}

/// How much one more trial may teach after so many of the same: the more is known, the less likely is it that it is otherwise than
/// foretold, and the less does that change what is foretold. Both go by 1 / (1 + N); but what is left `open`, from 0 to 1, as where an
/// action has chances, is otherwise as often however much is known.
pub(super) fn newness(count: usize, open: f64) -> f64 {
    let of = |count: usize| {
        let new = 1.0 / (1 + count) as f64;
        new * (new + (1.0 - new) * open)
    };
    let known = of(KNOWN);
    (of(count) - known).max(0.0) / (1.0 - known)
}

/// The examples in whose context an observation was; none if it is in no context.
pub(super) fn met<'a>(conditions: &'a Conditions, observation: &Observation) -> Option<&'a Column> {
    let given = |(property, value): &(_, _)| (*property, Expression::Constant(*value));
    let properties = observation.properties().iter().map(given).collect();
    let known = conditions.find(&Condition::Observed(Sketch { kind: observation.kind(), properties }));
    known.map(|asked| &asked.column)
}

/// How much a facet surprised: by so much was it improbable, as it was foretold, that comes about what came. Of late, for an earlier
/// experience counts less.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Surprise {
    /// Surprise and experiences, by how new they were.
    pub(super) new: (f64, f64),
    /// The same, by how familiar they were.
    pub(super) familiar: (f64, f64),
}

impl Surprise {
    /// Notes an experience that was so new, from 0 to 1.
    pub(super) fn note(&mut self, newness: f64, surprise: bool) {
        let note = |(surprises, all): (f64, f64), weight: f64| {
            let kept = libm::pow(KEPT, weight);
            (surprises * kept + if surprise { weight } else { 0.0 }, all * kept + weight)
        };
        self.new = note(self.new, newness);
        self.familiar = note(self.familiar, 1.0 - newness);
    }

    /// Whether it surprised by more than one in four, and there was something.
    pub(super) fn is_often(&self) -> bool {
        let all = self.new.1 + self.familiar.1;
        all >= 8.0 && (self.new.0 + self.familiar.0) * 4.0 > all
    }

    /// By how much more it surprises where it is new than where it is familiar: what surprises there as well is noise. So much may be
    /// learnt. From 0 to 1; 1 at first.
    pub(super) fn of_new(&self) -> f64 {
        let noise = self.familiar.0 / (self.familiar.1 + 1.0);
        ((self.new.0 + 1.0) / (self.new.1 + 1.0) - noise).max(0.0)
    }
}
