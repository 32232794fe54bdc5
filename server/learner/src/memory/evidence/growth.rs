//! How claims grow from examples: from the most general one, again and again the exception that pays most for its condition.

use std::collections::BTreeMap;
use std::collections::hash_map::Entry;

use rustc_hash::FxHashMap;

use crate::memory::evidence::columns::{Asked, Column, Conditions};
use crate::memory::evidence::price::{Likelihood, Tier};
use crate::memory::evidence::scene::Scene;
use crate::nouns::claim::{Anchor, Change, Claim, Condition};

/// Exceptions to exceptions, at most.
pub(super) const DEPTH_MAX: usize = 8;
/// So many examples fit into one word.
const FEW: usize = u64::BITS as usize;
/// Where no condition pays by itself, so many of the best are looked at for whether they pay with a second one; and with each of these half as
/// many, for whether that pays with a third one.
const FIRST_MAX: usize = 8;
/// So many more conditions may be needed until they pay together.
const MORE_MAX: usize = 2;
/// A gain below this is none: it may be an error of rounding.
const GAIN_MIN: f64 = 1e-9;

/// The examples that claims grow from: conditions and changes, each with the examples in which it holds.
pub(super) struct Ground<'a> {
    /// The conditions that may be asked for, by tier and in order.
    pub(super) conditions: &'a Conditions,
    /// The changes, each with the examples that it makes.
    pub(super) changes: &'a [(Change, Column)],
    /// Whether what is recalled is not asked for: it follows from what is told.
    pub(super) is_blind: bool,
    /// The scene of an example.
    pub(super) scene: &'a dyn Fn(usize) -> &'a Scene,
}

/// Claims as they grew, with the example that each outcome came in.
pub(super) struct Growth {
    pub(super) claim: Claim,
    /// The place of each example that they were grown from.
    pub(super) places: Vec<(usize, Place)>,
}

/// Where an example belongs: to which claim, counted as in [`Claim::all`], and to which of the changes; none where it came to no form.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Place {
    pub(super) claim: usize,
    pub(super) change: Option<usize>,
}

/// An exception to a claim: the condition, how much it pays, and the examples in which it holds.
struct Exception {
    gain: f64,
    condition: Condition,
    holding: Column,
}

/// Examples parted by what followed: each change with those that are put down to it, the most first; then those that none makes.
struct Parted {
    parts: Vec<(usize, Column)>,
    rest: Column,
}

/// What a number that can be named is in each of some examples, in order.
type Numbers = BTreeMap<Anchor, Vec<(i64, usize)>>;

/// A search for claims.
struct Search<'s, 'g> {
    ground: &'s Ground<'g>,
    likelihood: Likelihood,
    /// The numbers that can be named in all examples that the claims are grown from.
    numbers: Numbers,
    claims: usize,
    places: Vec<(usize, Place)>,
}

impl Ground<'_> {
    /// The claims that these examples make.
    pub(super) fn grow(&self, examples: Column) -> Growth {
        let parted = self.part(&examples);
        let likelihood = Likelihood::new(examples.count(), parted.parts.len() + 1);
        let numbers = if parted.is_uniform() { Numbers::new() } else { self.numbers(&examples) };
        let mut search = Search { ground: self, likelihood, numbers, claims: 0, places: Vec::new() };
        let claim = search.claim(None, examples, 0);
        Growth { claim, places: search.places }
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

    fn numbers(&self, examples: &Column) -> Numbers {
        let mut numbers = Numbers::new();
        for at in examples.iter() {
            let may_ask = |anchor: &Anchor| !(self.is_blind && *anchor == Anchor::Age);
            for (anchor, value) in (self.scene)(at).numbers().filter(|(anchor, _)| may_ask(anchor)) {
                numbers.entry(anchor).or_default().push((value, at));
            }
        }
        numbers.values_mut().for_each(|values| values.sort_unstable());
        numbers
    }
}

impl Parted {
    /// Whether the same followed in all of them.
    fn is_uniform(&self) -> bool {
        self.parts.len() + usize::from(!self.rest.is_empty()) < 2
    }
}

/// The examples of a claim, with the number of the outcome of each and how many had each outcome.
struct Whole<'a> {
    examples: &'a Column,
    all: usize,
    outcome: Vec<usize>,
    counts: Vec<usize>,
}

impl<'a> Whole<'a> {
    fn new(examples: &'a Column, parted: &Parted) -> Self {
        let mut outcome = Vec::new();
        let parts = parted.parts.iter().map(|(_, part)| part).chain([&parted.rest]);
        let counts = parts.enumerate().map(|(number, part)| {
            let mut count = 0;
            for at in part.iter() {
                if outcome.len() <= at {
                    outcome.resize(at + 1, 0);
                }
                outcome[at] = number;
                count += 1;
            }
            count
        });
        let counts: Vec<_> = counts.collect();
        Self { examples, all: counts.iter().sum(), outcome, counts }
    }
}

/// How much better outcomes are told in two parts than together, as the examples of one part are counted one by one.
struct Gain<'a> {
    likelihood: &'a Likelihood,
    counts: &'a [usize],
    all: usize,
    inside: Vec<usize>,
    /// The outcomes that were counted.
    counted: Vec<usize>,
    trials: usize,
}

impl<'a> Gain<'a> {
    fn new(likelihood: &'a Likelihood, whole: &'a Whole<'_>) -> Self {
        let inside = vec![0; whole.counts.len()];
        Self { likelihood, counts: &whole.counts, all: whole.all, inside, counted: Vec::new(), trials: 0 }
    }

    fn count(&mut self, outcome: usize) {
        if self.inside[outcome] == 0 {
            self.counted.push(outcome);
        }
        self.inside[outcome] += 1;
        self.trials += 1;
    }

    fn so_far(&self) -> f64 {
        let change = |outcome: &usize| {
            let (inside, all) = (self.inside[*outcome], self.counts[*outcome]);
            self.likelihood.rising(inside) + self.likelihood.rising(all - inside)
                - self.likelihood.rising(all)
        };
        self.counted.iter().map(change).sum::<f64>() + self.likelihood.factorial(self.all)
            - self.likelihood.factorial(self.trials)
            - self.likelihood.factorial(self.all - self.trials)
    }

    fn clear(&mut self) {
        self.counted.drain(..).for_each(|outcome| self.inside[outcome] = 0);
        self.trials = 0;
    }
}

impl Search<'_, '_> {
    fn claim(&mut self, of: Option<(f64, Condition)>, mut examples: Column, depth: usize) -> Claim {
        let number = self.claims;
        self.claims += 1;
        let mut exceptions = Vec::new();
        let parted = loop {
            let parted = self.ground.part(&examples);
            if parted.is_uniform() || depth == DEPTH_MAX {
                break parted;
            }
            let Some(Exception { gain, condition, holding }) = self.exception(&examples, &parted) else {
                break parted;
            };
            examples = examples.without(&holding);
            exceptions.push(self.claim(Some((gain, condition)), holding, depth + 1));
        };
        for (change, part) in &parted.parts {
            let place = Place { claim: number, change: Some(*change) };
            self.places.extend(part.iter().map(|at| (at, place)));
        }
        let formless = Place { claim: number, change: None };
        self.places.extend(parted.rest.iter().map(|at| (at, formless)));
        let count = |column: &Column| u32::try_from(column.count()).unwrap_or(u32::MAX);
        let changes = self.ground.changes;
        let outcomes = parted.parts.iter().map(|(at, column)| (changes[*at].0.clone(), count(column)));
        let (gain, condition) = of.unzip();
        let gain = gain.unwrap_or_default();
        Claim { condition, gain, exceptions, outcomes: outcomes.collect(), trials: count(&examples) }
    }

    /// The condition that parts the examples best, if it pays.
    fn exception(&self, examples: &Column, parted: &Parted) -> Option<Exception> {
        let exception = self.best(examples, parted, MORE_MAX, FIRST_MAX)?;
        (exception.gain > GAIN_MIN).then_some(exception)
    }

    /// The condition that parts the examples best. Where none pays by itself, so many of the best are looked at for whether they pay together
    /// with a second one among the examples in which they hold, which may pay with a third one, and so on, up to so many `more`.
    fn best(&self, examples: &Column, parted: &Parted, more: usize, firsts: usize) -> Option<Exception> {
        let choices = self.choices(examples, parted);
        let best = choices.iter().fold(None, better)?;
        if best.0 > GAIN_MIN || more == 0 {
            return Some(self.chosen(best, examples));
        }
        // Equal but for rounding is equal, and then they stay in their order.
        let mut order: Vec<_> = choices.iter().collect();
        order.sort_by_key(|(gain, _)| std::cmp::Reverse((gain / GAIN_MIN).round() as i64));
        let both = order.into_iter().take(firsts).filter_map(|choice| {
            let first = self.chosen(choice, examples);
            let parted = self.ground.part(&first.holding);
            let second = if parted.is_uniform() {
                None
            } else {
                self.best(&first.holding, &parted, more - 1, firsts / 2)
            };
            let second = second.filter(|second| second.gain > GAIN_MIN)?;
            Some(Exception { gain: first.gain + second.gain, ..first })
        });
        both.fold(None, |best: Option<Exception>, other| match best {
            Some(best) if other.gain <= best.gain + GAIN_MIN => Some(best),
            _ => Some(other),
        })
    }

    /// The exception that a choice makes.
    fn chosen(&self, (gain, choice): &(f64, Choice<'_>), examples: &Column) -> Exception {
        let gain = *gain;
        match choice {
            Choice::Met(asked) => {
                Exception { gain, condition: asked.condition.clone(), holding: examples.both(&asked.column) }
            }
            Choice::Bound(anchor, least) => {
                let condition = Condition::AtLeast(*anchor, *least);
                let mut holding = Column::default();
                let holds = |at: &usize| (self.ground.scene)(*at).holds(&condition);
                examples.iter().filter(holds).for_each(|at| holding.insert(at));
                Exception { gain, condition, holding }
            }
        }
    }

    /// The conditions that part the examples, in order, each with its net gain.
    fn choices(&self, examples: &Column, parted: &Parted) -> Vec<(f64, Choice<'_>)> {
        let whole = Whole::new(examples, parted);
        let mut gain = Gain::new(&self.likelihood, &whole);
        let mut met: Vec<(f64, &Asked)> = Vec::new();
        for asked in self.different(&whole) {
            examples.iter_both(&asked.column).for_each(|at| gain.count(whole.outcome[at]));
            met.push((gain.so_far(), asked));
            gain.clear();
        }
        let mut among = [0; Tier::COUNT];
        met.iter().for_each(|(_, asked)| among[asked.tier as usize] += 1);
        let price = |tier: Tier| tier.price(among[tier as usize]);
        let met = met.into_iter().map(|(gain, asked)| (gain - price(asked.tier), Choice::Met(asked)));
        let bounds = self.bounds(&whole, &mut gain);
        let price = Tier::Bound.price(bounds.len());
        let bounds =
            bounds.into_iter().map(|(anchor, least, gain)| (gain - price, Choice::Bound(anchor, least)));
        met.chain(bounds).collect()
    }

    fn may_ask(&self, asked: &Asked) -> bool {
        !(self.ground.is_blind && asked.condition.rests_on_recall())
    }

    /// The conditions that part these examples, by tier and in order. Those that hold in the same of them are one choice, of the
    /// lowest tier among them.
    fn different(&self, whole: &Whole<'_>) -> Vec<&Asked> {
        let conditions = self.ground.conditions;
        if whole.all > FEW {
            let mut seen: FxHashMap<u64, usize> = FxHashMap::default();
            let mut different: Vec<&Asked> = Vec::new();
            for asked in conditions.iter().filter(|asked| self.may_ask(asked)) {
                let (count, mut hash) = whole.examples.fingerprint(&asked.column);
                if count == 0 || count == whole.all {
                    continue;
                }
                let alike = loop {
                    match seen.entry(hash) {
                        Entry::Vacant(place) => {
                            place.insert(different.len());
                            break false;
                        }
                        Entry::Occupied(known) => {
                            let known = &different[*known.get()].column;
                            if whole.examples.meets_alike(known, &asked.column) {
                                break true;
                            }
                            hash = hash.wrapping_add(1);
                        }
                    }
                };
                if !alike {
                    different.push(asked);
                }
            }
            return different;
        }
        // Few examples meet few of the conditions.
        let mut holding = vec![0_u64; conditions.places().len()];
        let mut met = Vec::new();
        for (bit, at) in whole.examples.iter().enumerate() {
            for number in conditions.met_by(at) {
                if holding[*number] == 0 {
                    met.push(*number);
                }
                holding[*number] |= 1 << bit;
            }
        }
        let (all, order) = (u64::MAX >> (64 - whole.all), conditions.places());
        let mut first: FxHashMap<u64, (usize, usize)> = FxHashMap::default();
        for number in met.into_iter().filter(|number| holding[*number] != all) {
            let asked = conditions.get(number);
            if !asked.is_some_and(|asked| self.may_ask(asked)) {
                continue;
            }
            let place = (order[number], number);
            first.entry(holding[number]).and_modify(|known| *known = place.min(*known)).or_insert(place);
        }
        let mut places: Vec<_> = first.into_values().collect();
        places.sort_unstable();
        places.into_iter().filter_map(|(_, number)| conditions.get(number)).collect()
    }

    /// For each number that can be named in all these examples, each bound that parts them, with its gain.
    fn bounds(&self, whole: &Whole<'_>, gain: &mut Gain<'_>) -> Vec<(Anchor, i64, f64)> {
        let mut bounds = Vec::new();
        for (anchor, values) in &self.numbers {
            let here = || values.iter().rev().filter(|(_, at)| whole.examples.contains(*at));
            if here().count() != whole.all {
                continue;
            }
            let mut above = None;
            for (value, at) in here() {
                if above.is_some_and(|above| above != *value) {
                    bounds.extend(above.map(|above| (*anchor, above, gain.so_far())));
                }
                above = Some(*value);
                gain.count(whole.outcome[*at]);
            }
            gain.clear();
        }
        bounds
    }
}

/// A condition that parts examples.
enum Choice<'a> {
    /// One that is asked for where it is met.
    Met(&'a Asked),
    /// A bound of a number.
    Bound(Anchor, i64),
}

/// The better one of two choices, each with its net gain; the first of equals.
fn better<'a, 's>(
    best: Option<&'a (f64, Choice<'s>)>,
    other: &'a (f64, Choice<'s>),
) -> Option<&'a (f64, Choice<'s>)> {
    match best {
        Some(best) if other.0 <= best.0 + GAIN_MIN => Some(best),
        _ => Some(other),
    }
}
