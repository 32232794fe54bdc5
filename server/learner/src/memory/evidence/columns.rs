//! Sets of examples, as bits: the test of a claim counts them many times. The conditions that examples meet, each with such a set.

use std::collections::BTreeMap;
use std::hash::Hasher;
use std::sync::OnceLock;

use rustc_hash::FxHasher;

use crate::memory::evidence::price::Tier;
use crate::memory::evidence::scene::Scene;
use crate::nouns::claim::Condition;

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
}

impl Asked {
    fn is_crossed(&self) -> bool {
        self.condition.names() > 1
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
    /// How many of them count.
    count: usize,
    /// Those that count and name several values.
    crossed: Vec<usize>,
    /// The conditions that each example meets.
    met: Vec<Vec<usize>>,
    /// Their order, once it is asked for.
    order: OnceLock<Order>,
}

/// Conditions by tier, and in the order of the conditions themselves: so that it is not told by it which was met first.
#[derive(Clone, Debug, Default)]
struct Order {
    numbers: Vec<usize>,
    /// The place of each of the numbers in it.
    places: Vec<usize>,
}

impl PartialEq for Conditions {
    fn eq(&self, other: &Self) -> bool {
        self.iter().eq(other.iter())
    }
}

impl Conditions {
    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.count
    }

    /// One more than the highest number of a condition.
    pub(super) fn numbers(&self) -> usize {
        self.all.len()
    }

    pub(super) fn get(&self, number: usize) -> Option<&Asked> {
        self.all.get(number)
    }

    /// A condition that is known.
    pub(super) fn find(&self, condition: &Condition) -> Option<&Asked> {
        self.get(*self.numbers.get(condition)?)
    }

    /// The conditions in their order.
    pub(super) fn iter(&self) -> impl Iterator<Item = &Asked> {
        self.order().numbers.iter().filter_map(|number| self.all.get(*number))
    }

    /// The place of a condition in the order.
    pub(super) fn place(&self, number: usize) -> usize {
        self.order().places.get(number).copied().unwrap_or(usize::MAX)
    }

    fn order(&self) -> &Order {
        self.order.get_or_init(|| {
            let mut of_tier: [Vec<usize>; Tier::COUNT] = Default::default();
            for number in self.numbers.values() {
                if let Some(asked) = self.all.get(*number).filter(|asked| asked.counts()) {
                    of_tier[asked.tier as usize].push(*number);
                }
            }
            let numbers = of_tier.concat();
            let mut places = vec![usize::MAX; self.all.len()];
            numbers.iter().enumerate().for_each(|(place, number)| places[*number] = place);
            Order { numbers, places }
        })
    }

    /// The numbers of the conditions that an example meets.
    pub(super) fn met_by(&self, at: usize) -> &[usize] {
        self.met.get(at).map_or(&[], Vec::as_slice)
    }

    /// Enters the example `at`, anew if it was there; `scene` gives the scene of each that was entered.
    pub(super) fn enter<'a>(&mut self, at: usize, scene: impl Fn(usize) -> &'a Scene) {
        if self.met.len() <= at {
            self.met.resize(at + 1, Vec::new());
        }
        let before = std::mem::take(&mut self.met[at]);
        before.iter().for_each(|number| self.change(*number, |column| column.remove(at)));
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
                self.crossed.push(*number);
                // In other examples other names came first. Those that are not entered yet meet nothing, and see to it then.
                for other in (0..self.met.len()).filter(|other| *other != at) {
                    if !self.met[other].is_empty() && scene(other).holds(&self.all[*number].condition) {
                        self.meet(*number, other);
                    }
                }
            }
        }
        for place in 0..self.crossed.len() {
            let number = self.crossed[place];
            if !self.all[number].column.contains(at) && scene(at).holds(&self.all[number].condition) {
                self.meet(number, at);
            }
        }
        for number in before {
            if self.all[number].by.contains(at) && !asked.contains(&number) {
                self.ask_no_more(number, at);
            }
        }
    }

    fn number(&mut self, condition: Condition) -> usize {
        if let Some(number) = self.numbers.get(&condition) {
            return *number;
        }
        let (tier, number) = (Tier::of(&condition), self.all.len());
        self.numbers.insert(condition.clone(), number);
        self.all.push(Asked { tier, condition, column: Column::default(), by: Column::default() });
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
            self.count = if counted { self.count - 1 } else { self.count + 1 };
            self.order.take();
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
        self.crossed.retain(|crossed| *crossed != number);
    }
}
