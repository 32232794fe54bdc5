//! How claims grow from examples: from the most general one, again and again the exception that pays most for its condition.

use std::collections::BTreeMap;

use rustc_hash::FxHashSet;

use crate::memory::evidence::columns::Column;
use crate::memory::evidence::price::{Likelihood, Tier};
use crate::memory::evidence::scene::Scene;
use crate::nouns::claim::{Anchor, Change, Claim, Condition};

/// Exceptions to exceptions, at most.
const DEPTH_MAX: usize = 8;
/// A gain below this is none: it may be an error of rounding.
const GAIN_MIN: f64 = 1e-9;

/// The examples that claims grow from: conditions and changes, each with the examples in which it holds.
pub(super) struct Ground<'a> {
    /// The conditions that may be asked for, by tier and in order.
    pub(super) conditions: &'a [(&'a Condition, &'a Column)],
    /// The changes, each with the examples that it makes.
    pub(super) changes: &'a [(Change, Column)],
    /// The scene of an example.
    pub(super) scene: &'a dyn Fn(usize) -> &'a Scene,
}

/// Examples parted by what followed: each change with those that are put down to it, the most first; then those that none makes.
struct Parted {
    parts: Vec<(usize, Column)>,
    rest: Column,
}

impl Ground<'_> {
    /// The claims that these examples make.
    pub(super) fn grow(&self, examples: Column) -> Claim {
        let outcomes = self.part(&examples).parts.len() + 1;
        let likelihood = Likelihood::new(examples.count(), outcomes);
        self.claim(None, examples, &likelihood, 0)
    }

    fn claim(
        &self,
        of: Option<(f64, Condition)>,
        mut examples: Column,
        likelihood: &Likelihood,
        depth: usize,
    ) -> Claim {
        let mut exceptions = Vec::new();
        let parted = loop {
            let parted = self.part(&examples);
            let uniform = parted.parts.len() + usize::from(parted.rest.count() > 0) < 2;
            if uniform || depth == DEPTH_MAX {
                break parted;
            }
            let Some((gain, condition, holding)) = self.exception(&examples, &parted, likelihood) else {
                break parted;
            };
            examples = examples.without(&holding);
            exceptions.push(self.claim(Some((gain, condition)), holding, likelihood, depth + 1));
        };
        let count = |column: &Column| u32::try_from(column.count()).unwrap_or(u32::MAX);
        let outcomes = parted.parts.iter().map(|(at, column)| (self.changes[*at].0.clone(), count(column)));
        let (gain, condition) = of.unzip();
        let gain = gain.unwrap_or_default();
        Claim { condition, gain, exceptions, outcomes: outcomes.collect(), trials: count(&examples) }
    }

    /// Puts each example down to one of the changes that make it: as few changes as a greedy search finds, in the shortest words.
    fn part(&self, examples: &Column) -> Parted {
        let mut rest = examples.clone();
        let mut parts = Vec::new();
        loop {
            let made = self.changes.iter().enumerate().map(|(at, (change, made))| {
                (rest.count_both(made), std::cmp::Reverse(change.constants()), std::cmp::Reverse(at))
            });
            let Some((1.., _, at)) = made.max() else { return Parted { parts, rest } };
            let made = rest.both(&self.changes[at.0].1);
            rest = rest.without(&made);
            parts.push((at.0, made));
        }
    }

    /// The condition that parts the examples best, if it pays, with its net gain and the examples in which it holds.
    fn exception(
        &self,
        examples: &Column,
        parted: &Parted,
        likelihood: &Likelihood,
    ) -> Option<(f64, Condition, Column)> {
        let all = examples.count();
        let whole: Vec<_> = parted
            .parts
            .iter()
            .map(|(_, part)| part)
            .chain([&parted.rest])
            .map(|part| (part, part.count()))
            .collect();
        let together = likelihood.of(whole.iter().map(|(_, count)| *count));
        let gain = |inside: &[usize]| {
            let outside = whole.iter().zip(inside).map(|((_, count), inside)| count - inside);
            likelihood.of(inside.iter().copied()) + likelihood.of(outside) - together
        };
        // Conditions that hold in the same examples are one choice, of the lowest tier among them.
        let mut seen = FxHashSet::default();
        let mut choices: Vec<(Tier, f64, &Condition, Column)> = Vec::new();
        for (condition, column) in self.conditions {
            let holding = examples.both(column);
            let count = holding.count();
            if count == 0 || count == all || !seen.insert(holding.clone()) {
                continue;
            }
            let inside: Vec<_> = whole.iter().map(|(part, _)| holding.count_both(part)).collect();
            choices.push((Tier::of(condition), gain(&inside), *condition, holding));
        }
        let mut among = [0; Tier::COUNT];
        choices.iter().for_each(|(tier, ..)| among[*tier as usize] += 1);
        let mut best: Option<(f64, Condition, Column)> = None;
        let mut better = |net: f64, condition: &dyn Fn() -> (Condition, Column)| {
            if net > best.as_ref().map_or(GAIN_MIN, |(best, ..)| *best + GAIN_MIN) {
                let (condition, holding) = condition();
                best = Some((net, condition, holding));
            }
        };
        for (tier, gain, condition, holding) in &choices {
            better(gain - tier.price(among[*tier as usize]), &|| ((*condition).clone(), holding.clone()));
        }
        let bounds = self.bounds(examples, &whole);
        let count: usize = bounds.values().map(Vec::len).sum();
        for (anchor, bounds) in &bounds {
            for (least, inside) in bounds {
                better(gain(inside) - Tier::Bound.price(count), &|| {
                    let condition = Condition::AtLeast(*anchor, *least);
                    let mut holding = Column::default();
                    let holds = |at: &usize| (self.scene)(*at).holds(&condition);
                    examples.iter().filter(holds).for_each(|at| holding.insert(at));
                    (condition, holding)
                });
            }
        }
        best
    }

    /// For each number that can be named in all these examples, each bound that parts them, with how many of each outcome are at or
    /// above it.
    fn bounds(
        &self,
        examples: &Column,
        whole: &[(&Column, usize)],
    ) -> BTreeMap<Anchor, Vec<(i64, Vec<usize>)>> {
        let mut values: BTreeMap<Anchor, Vec<(i64, usize)>> = BTreeMap::new();
        let all = examples.count();
        for (outcome, (part, _)) in whole.iter().enumerate() {
            for at in part.iter() {
                for (anchor, value) in (self.scene)(at).numbers() {
                    values.entry(anchor).or_default().push((value, outcome));
                }
            }
        }
        values.retain(|_, values| values.len() == all);
        let bounds = |mut values: Vec<(i64, usize)>| {
            values.sort_unstable();
            let mut inside = vec![0; whole.len()];
            let mut bounds = Vec::new();
            let mut above = None;
            for (value, outcome) in values.into_iter().rev() {
                if above.is_some_and(|above| above != value) {
                    bounds.extend(above.map(|above| (above, inside.clone())));
                }
                above = Some(value);
                inside[outcome] += 1;
            }
            bounds
        };
        values.into_iter().map(|(anchor, values)| (anchor, bounds(values))).collect()
    }
}
