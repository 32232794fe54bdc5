//! Sets of examples, as bits: the test of a claim counts them many times. The conditions that examples meet, each with such a set.

use std::collections::BTreeMap;
use std::hash::Hasher;

use rustc_hash::FxHasher;

use crate::memory::evidence::price::Tier;
use crate::memory::evidence::scene::Scene;
use crate::nouns::claim::Condition;

/// A set of examples by number.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Column(Vec<u64>);

impl Column {
    pub(crate) fn insert(&mut self, at: usize) {
        if self.0.len() <= at / 64 {
            self.0.resize(at / 64 + 1, 0);
        }
        if let Some(word) = self.0.get_mut(at / 64) {
            *word |= 1 << (at % 64);
        }
    }

    pub(crate) fn remove(&mut self, at: usize) {
        if let Some(word) = self.0.get_mut(at / 64) {
            *word &= !(1 << (at % 64));
        }
    }

    pub(crate) fn contains(&self, at: usize) -> bool {
        self.0.get(at / 64).is_some_and(|word| word >> (at % 64) & 1 == 1)
    }

    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        self.0.iter().map(|word| word.count_ones() as usize).sum()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.iter().all(|word| *word == 0)
    }

    fn words_of_both<'a>(&'a self, other: &'a Self) -> impl Iterator<Item = u64> + 'a {
        self.0.iter().zip(&other.0).map(|(a, b)| a & b)
    }

    /// How many are in both, and a number that is the same for all that meet this one in the same.
    pub(crate) fn fingerprint(&self, other: &Self) -> (usize, u64) {
        let mut hasher = FxHasher::default();
        let mut count = 0;
        for (at, word) in self.words_of_both(other).enumerate().filter(|(_, word)| *word != 0) {
            count += word.count_ones() as usize;
            hasher.write_usize(at);
            hasher.write_u64(word);
        }
        (count, hasher.finish())
    }

    /// Whether two others meet this one in the same.
    pub(crate) fn meets_alike(&self, one: &Self, other: &Self) -> bool {
        let word = |of: &Self, at: usize| of.0.get(at).copied().unwrap_or(0);
        self.0.iter().enumerate().all(|(at, mine)| mine & word(one, at) == mine & word(other, at))
    }

    /// The numbers in both, in order.
    pub(crate) fn iter_both<'a>(&'a self, other: &'a Self) -> impl Iterator<Item = usize> + 'a {
        bits(self.words_of_both(other))
    }

    /// How many are in both.
    pub(crate) fn count_both(&self, other: &Self) -> usize {
        self.0.iter().zip(&other.0).map(|(a, b)| (a & b).count_ones() as usize).sum()
    }

    /// Those in both.
    pub(crate) fn both(&self, other: &Self) -> Self {
        let at = |at: usize| other.0.get(at).copied().unwrap_or(0);
        Self(self.0.iter().enumerate().map(|(i, word)| word & at(i)).collect())
    }

    /// Those in this one and not in the other.
    pub(crate) fn without(&self, other: &Self) -> Self {
        let at = |at: usize| other.0.get(at).copied().unwrap_or(0);
        Self(self.0.iter().enumerate().map(|(i, word)| word & !at(i)).collect())
    }

    /// The numbers, in order.
    pub(crate) fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        bits(self.0.iter().copied())
    }
}

/// The numbers of the bits that are set, in order.
fn bits(words: impl Iterator<Item = u64>) -> impl Iterator<Item = usize> {
    words.enumerate().flat_map(|(i, word)| {
        let mut left = word;
        std::iter::from_fn(move || {
            let bit = left.trailing_zeros() as usize;
            left &= left.checked_sub(1)?;
            Some(i * 64 + bit)
        })
    })
}

/// A condition with its tier, and the examples that meet it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Asked {
    pub(super) tier: Tier,
    pub(super) condition: Condition,
    pub(super) column: Column,
}

/// The conditions that examples meet, numbered as they were first met.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Conditions {
    all: Vec<Asked>,
    numbers: BTreeMap<Condition, usize>,
    of_tier: [Vec<usize>; Tier::COUNT],
    /// Those that name several values.
    crossed: Vec<usize>,
    /// The conditions that each example meets.
    met: Vec<Vec<usize>>,
}

impl Conditions {
    pub(super) fn len(&self) -> usize {
        self.all.len()
    }

    pub(super) fn get(&self, number: usize) -> Option<&Asked> {
        self.all.get(number)
    }

    /// A condition that is known.
    pub(super) fn find(&self, condition: &Condition) -> Option<&Asked> {
        self.get(*self.numbers.get(condition)?)
    }

    /// The conditions by tier, and in the order in which they were first met.
    pub(super) fn iter(&self) -> impl Iterator<Item = &Asked> {
        self.of_tier.iter().flatten().filter_map(|number| self.all.get(*number))
    }

    /// The numbers of the conditions that an example meets.
    pub(super) fn met_by(&self, at: usize) -> &[usize] {
        self.met.get(at).map_or(&[], Vec::as_slice)
    }

    /// Enters the example `at` of these scenes, anew if it was there; `scene` gives the scene of each example up to it.
    pub(super) fn enter<'a>(&mut self, at: usize, scene: impl Fn(usize) -> &'a Scene) {
        if self.met.len() <= at {
            self.met.resize(at + 1, Vec::new());
        }
        for number in std::mem::take(&mut self.met[at]) {
            self.all[number].column.remove(at);
        }
        for condition in scene(at).conditions() {
            if let Some(number) = self.numbers.get(&condition) {
                self.meet(*number, at);
                continue;
            }
            let (tier, number) = (Tier::of(&condition), self.all.len());
            // What is seen from an observation itself is asked for wherever it is.
            let crossed = condition.names() > 1 && !condition.is_of_itself();
            self.numbers.insert(condition.clone(), number);
            self.of_tier[tier as usize].push(number);
            self.all.push(Asked { tier, condition, column: Column::default() });
            self.meet(number, at);
            if crossed {
                // Such a condition is asked for in the first names that values have; in earlier examples others came first.
                for earlier in 0..at {
                    if scene(earlier).holds(&self.all[number].condition) {
                        self.meet(number, earlier);
                    }
                }
                self.crossed.push(number);
            }
        }
        for place in 0..self.crossed.len() {
            let number = self.crossed[place];
            if !self.all[number].column.contains(at) && scene(at).holds(&self.all[number].condition) {
                self.meet(number, at);
            }
        }
    }

    fn meet(&mut self, number: usize, at: usize) {
        self.all[number].column.insert(at);
        self.met[at].push(number);
    }
}
