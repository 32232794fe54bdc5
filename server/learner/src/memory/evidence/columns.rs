//! Sets of examples, as bits: the test of a claim counts them many times. The conditions that examples meet, each with such a set.

use std::collections::BTreeMap;
use std::hash::Hasher;
use std::sync::OnceLock;

use rustc_hash::FxHasher;

use crate::memory::evidence::price::Tier;
use crate::memory::evidence::scene::Scene;
use crate::nouns::claim::{Condition, Sketch};

/// A set of examples by number. What is entered and taken out again leaves no trace, so that equal sets are equal.
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
        while self.0.last() == Some(&0) {
            self.0.pop();
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
        self.0.iter().rev().all(|word| *word == 0)
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
    /// If it names several values: the examples in whose first names it is asked for; it holds in others as well.
    by: Column,
    /// Whether it has its place in the order.
    placed: bool,
}

impl Asked {
    fn is_crossed(&self) -> bool {
        // What is seen from an observation itself is asked for wherever it is.
        self.condition.names() > 1 && !self.condition.is_of_itself()
    }

    /// Whether an example meets it: then one asks for it.
    fn counts(&self) -> bool {
        !self.column.is_empty()
    }
}

/// The conditions that examples meet. One that no example asks for any more counts for nothing.
#[derive(Clone, Debug, Default)]
pub(super) struct Conditions {
    all: Vec<Asked>,
    numbers: BTreeMap<Condition, usize>,
    /// Those that count, in the order of the conditions themselves: so that it does not tell which was met first.
    of_tier: [Vec<usize>; Tier::COUNT],
    /// The place of each in this order, once it is asked for.
    places: OnceLock<Vec<usize>>,
    /// Those that were met or missed of late, and may have come into the order or gone from it.
    unplaced: Vec<usize>,
    /// Those that count and name several values, each with the conditions that name one of these.
    crossed: Vec<(usize, Vec<usize>)>,
    /// The examples that have more to see than is asked for.
    crowded: Column,
    /// The conditions that each example meets.
    met: Vec<Vec<usize>>,
}

impl PartialEq for Conditions {
    fn eq(&self, other: &Self) -> bool {
        self.iter().eq(other.iter())
    }
}

impl Conditions {
    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.of_tier.iter().map(Vec::len).sum()
    }

    pub(super) fn get(&self, number: usize) -> Option<&Asked> {
        self.all.get(number)
    }

    /// A condition that is known.
    pub(super) fn find(&self, condition: &Condition) -> Option<&Asked> {
        self.get(*self.numbers.get(condition)?)
    }

    /// The conditions by tier, and in their own order.
    pub(super) fn iter(&self) -> impl Iterator<Item = &Asked> {
        self.of_tier.iter().flatten().filter_map(|number| self.all.get(*number))
    }

    /// The place of each condition in this order, by its number.
    pub(super) fn places(&self) -> &[usize] {
        self.places.get_or_init(|| {
            let mut places = vec![usize::MAX; self.all.len()];
            let ordered = self.of_tier.iter().flatten();
            ordered.enumerate().for_each(|(place, number)| places[*number] = place);
            places
        })
    }

    /// The numbers of the conditions that an example meets.
    pub(super) fn met_by(&self, at: usize) -> &[usize] {
        self.met.get(at).map_or(&[], Vec::as_slice)
    }

    /// Enters the example `at`, anew if it was there; `scene` gives the scene of each that was entered, of which `twin` has the same. What
    /// changes by it is put in order by [`Conditions::put_in_order`], which must come before the conditions are gone through.
    pub(super) fn enter<'a>(&mut self, at: usize, twin: Option<usize>, scene: impl Fn(usize) -> &'a Scene) {
        if self.met.len() <= at {
            self.met.resize(at + 1, Vec::new());
        }
        if let Some(twin) = twin.filter(|_| self.met[at].is_empty()) {
            return self.enter_like(at, twin);
        }
        let before = std::mem::take(&mut self.met[at]);
        before.iter().for_each(|number| self.change(*number, |column| column.remove(at)));
        if scene(at).is_crowded() {
            self.crowded.insert(at);
        }
        let mut asked = Vec::new();
        for condition in scene(at).conditions() {
            let number = self.number(condition);
            self.meet(number, at);
            if self.all[number].is_crossed() {
                asked.push(number);
            }
        }
        for number in &asked {
            let new = self.all[*number].by.is_empty();
            self.all[*number].by.insert(at);
            if new {
                let parts = self.parts(*number);
                // In other examples other names came first. Those that are not entered yet meet nothing, and see to it then.
                for other in (0..self.met.len()).filter(|other| *other != at) {
                    let entered = !self.met[other].is_empty();
                    if entered
                        && self.may_hold(&parts, other)
                        && scene(other).holds(&self.all[*number].condition)
                    {
                        self.meet(*number, other);
                    }
                }
                self.crossed.push((*number, parts));
            }
        }
        for place in 0..self.crossed.len() {
            let (number, parts) = &self.crossed[place];
            let (number, may_hold) = (*number, self.may_hold(parts, at));
            debug_assert!(
                may_hold || !scene(at).holds(&self.all[number].condition),
                "a part is not asked for"
            );
            if may_hold
                && !self.all[number].column.contains(at)
                && scene(at).holds(&self.all[number].condition)
            {
                self.meet(number, at);
            }
        }
        for number in before {
            if self.all[number].by.contains(at) && !asked.contains(&number) {
                self.ask_no_more(number, at);
            }
        }
    }

    /// Enters a new example that meets the conditions, and asks for those, that another meets and asks for.
    fn enter_like(&mut self, at: usize, twin: usize) {
        if self.crowded.contains(twin) {
            self.crowded.insert(at);
        }
        for number in self.met[twin].clone() {
            self.meet(number, at);
            if self.all[number].by.contains(twin) {
                self.all[number].by.insert(at);
            }
        }
    }

    /// The conditions that each name one of the values that this one names.
    fn parts(&self, number: usize) -> Vec<usize> {
        let Condition::Observed(Sketch { kind, properties }) = &self.all[number].condition else {
            return Vec::new();
        };
        let part = |named: &(_, _)| {
            let part = Sketch { kind: *kind, properties: [*named].into() };
            self.numbers.get(&Condition::Observed(part)).copied()
        };
        properties.iter().filter_map(part).collect()
    }

    /// Whether a condition with these parts may hold in an example: where it does they do, and all that hold are asked for where there is no
    /// crowd. To look this up is much faster than to look at the example.
    fn may_hold(&self, parts: &[usize], at: usize) -> bool {
        self.crowded.contains(at) || parts.iter().all(|part| self.all[*part].column.contains(at))
    }

    fn number(&mut self, condition: Condition) -> usize {
        if let Some(number) = self.numbers.get(&condition) {
            return *number;
        }
        let (tier, number) = (Tier::of(&condition), self.all.len());
        self.numbers.insert(condition.clone(), number);
        self.all.push(Asked {
            tier,
            condition,
            column: Column::default(),
            by: Column::default(),
            placed: false,
        });
        number
    }

    fn meet(&mut self, number: usize, at: usize) {
        if !self.all[number].column.contains(at) {
            self.change(number, |column| column.insert(at));
            self.met[at].push(number);
        }
    }

    /// Changes the examples that meet a condition.
    fn change(&mut self, number: usize, change: impl Fn(&mut Column)) {
        let asked = &mut self.all[number];
        let counted = asked.counts();
        change(&mut asked.column);
        if asked.counts() != counted {
            self.unplaced.push(number);
        }
    }

    /// Gives those that came to count their places in the order, and takes out those that count no more.
    pub(super) fn put_in_order(&mut self) {
        let all = &mut self.all;
        let mut new = std::mem::take(&mut self.unplaced);
        let mut gone = false;
        for number in &new {
            let asked = &mut all[*number];
            gone |= asked.placed && !asked.counts();
            asked.placed &= asked.counts();
        }
        new.retain(|number| {
            let asked = &mut all[*number];
            asked.counts() && !std::mem::replace(&mut asked.placed, true)
        });
        if gone {
            self.of_tier.iter_mut().for_each(|numbers| numbers.retain(|number| all[*number].placed));
        }
        if gone || !new.is_empty() {
            self.places.take();
        }
        if new.len() > all.len() / 16 {
            // All of them in their order are soon gone through.
            self.of_tier.iter_mut().for_each(Vec::clear);
            for number in self.numbers.values().filter(|number| all[**number].placed) {
                self.of_tier[all[*number].tier as usize].push(*number);
            }
            return;
        }
        new.sort_unstable_by(|a, b| all[*a].condition.cmp(&all[*b].condition));
        for (tier, numbers) in self.of_tier.iter_mut().enumerate() {
            let of_tier: Vec<_> =
                new.iter().copied().filter(|number| all[*number].tier as usize == tier).collect();
            if of_tier.is_empty() {
                continue;
            }
            let known = std::mem::take(numbers);
            numbers.reserve(known.len() + of_tier.len());
            let mut rest = &known[..];
            for number in of_tier {
                let condition = &all[number].condition;
                let before = rest.partition_point(|known| all[*known].condition.cmp(condition).is_lt());
                let (smaller, larger) = rest.split_at(before);
                numbers.extend_from_slice(smaller);
                numbers.push(number);
                rest = larger;
            }
            numbers.extend_from_slice(rest);
        }
    }

    /// An example does not ask any more for a condition that names several values.
    fn ask_no_more(&mut self, number: usize, at: usize) {
        self.all[number].by.remove(at);
        if !self.all[number].by.is_empty() {
            return;
        }
        for example in self.all[number].column.iter() {
            self.met[example].retain(|met| *met != number);
        }
        self.change(number, |column| *column = Column::default());
        self.crossed.retain(|(crossed, _)| *crossed != number);
    }
}
