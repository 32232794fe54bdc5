//! What came in each example of a facet, by number: outcomes are compared and counted again and again.

use rustc_hash::FxHashMap;

use crate::nouns::observation::Observation;

/// The different outcomes of a facet's examples, the observations of its types, in the order in which they came first.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Outcomes {
    all: Vec<Vec<Observation>>,
    numbers: FxHashMap<Vec<Observation>, u32>,
    /// The number of each example's; of one that tells nothing of the facet it has no meaning.
    of: Vec<u32>,
}

impl Outcomes {
    /// Enters what came in the example `at`, and returns its number.
    pub(super) fn enter(&mut self, at: usize, after: &[Observation]) -> u32 {
        let number = self.number(after).unwrap_or_else(|| {
            let number = u32::try_from(self.all.len()).unwrap_or(u32::MAX);
            self.all.push(after.to_vec());
            self.numbers.insert(after.to_vec(), number);
            number
        });
        if self.of.len() <= at {
            self.of.resize(at + 1, 0);
        }
        self.of[at] = number;
        number
    }

    /// The number of an outcome; none if it never came.
    pub(super) fn number(&self, after: &[Observation]) -> Option<u32> {
        self.numbers.get(after).copied()
    }

    /// The number of what came in an example that tells of the facet.
    pub(super) fn of(&self, at: usize) -> Option<u32> {
        self.of.get(at).copied()
    }

    /// What came in these examples, which tell of the facet, each with how often, in the order in which it came first.
    pub(super) fn counted(&self, examples: impl Iterator<Item = usize>) -> Vec<(Vec<Observation>, u32)> {
        let mut counted: Vec<(u32, u32)> = Vec::new();
        let mut places = vec![usize::MAX; self.all.len()];
        for number in examples.filter_map(|at| self.of(at)) {
            let Some(place) = places.get_mut(number as usize) else { continue };
            if *place == usize::MAX {
                *place = counted.len();
                counted.push((number, 0));
            }
            counted[*place].1 += 1;
        }
        let outcome = |(number, count): (u32, u32)| Some((self.all.get(number as usize)?.clone(), count));
        counted.into_iter().filter_map(outcome).collect()
    }
}
