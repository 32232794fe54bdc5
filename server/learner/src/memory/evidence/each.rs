//! Claims about each observation of a type by itself: whether it is there after an action, whatever becomes of the others.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::memory::evidence::columns::{Column, Conditions};
use crate::memory::evidence::facet::{ANYTHING, Examples, Facet, Grown, Time, conditions, path};
use crate::memory::evidence::foretold::{Foretold, Part, Seen, View};
use crate::memory::evidence::scene::{Scene, of_kind};
use crate::nouns::claim::{Claim, Condition};
use crate::nouns::experience::Experience;
use crate::nouns::observation::{Observation, TypeId};
use crate::nouns::vocabulary::PrimitiveId;

/// Observations of a type that are told one by one; more are a crowd.
pub(super) const KNOWN_MAX: usize = 32;
/// Examples of one observation that are kept; beyond it those of the older half of the experiences are not looked at any more.
pub(super) const EXAMPLES_MAX: usize = 4_096;
/// Combinations of what may be there together that are foretold: the most probable.
const OUTCOMES_MAX: usize = 16;

/// The claims about each observation of a type.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Each {
    kind: TypeId,
    /// The number of the first example of the pool that is looked at.
    pub(super) from: usize,
    /// The observations of the type that were met, in order.
    pub(super) known: Vec<Observation>,
    /// Of each example of the pool that tells of the type, one for each of these.
    pub(super) examples: Vec<(Arc<Experience>, Scene)>,
    conditions: Conditions,
    of_primitive: BTreeMap<PrimitiveId, Column>,
    pub(super) facet: Facet,
}

/// What a claim in force says of one observation.
struct One<'a> {
    observation: Observation,
    was_there: bool,
    /// How often it was there afterwards, in how many trials.
    there: u32,
    trials: u32,
    conditions: Vec<&'a Condition>,
    scene: Scene,
}

impl Each {
    /// The claims that the examples of a pool make, from one on; none where there is a crowd.
    pub(super) fn new(kind: TypeId, examples: Examples<'_>, from: usize) -> Option<Self> {
        let recent = examples.all.get(from..).unwrap_or_default();
        let known: BTreeSet<_> = recent.iter().flat_map(|(experience, _)| met(experience, kind)).collect();
        if known.is_empty() || known.len() > KNOWN_MAX {
            return None;
        }
        let from = from.max(examples.all.len().saturating_sub(EXAMPLES_MAX / known.len() / 2));
        let mut each = Self::entered(kind, from, known.into_iter().cloned().collect(), examples);
        let mut facet = std::mem::take(&mut each.facet);
        facet.grow_all(each.examples());
        each.facet = facet;
        Some(each)
    }

    /// These examples of a pool, from one on, each with each of these observations; no claims are grown yet.
    pub(super) fn entered(
        kind: TypeId,
        from: usize,
        known: Vec<Observation>,
        examples: Examples<'_>,
    ) -> Self {
        let mut each = Self {
            kind,
            from,
            known,
            examples: Vec::new(),
            conditions: Conditions::default(),
            of_primitive: BTreeMap::new(),
            facet: Facet::of(kind, examples.all),
        };
        for (experience, scene) in examples.all.iter().skip(from) {
            each.enter(experience, scene);
        }
        each.conditions.put_in_order();
        each
    }

    /// Enters an experience with each observation that is known; returns the numbers of these examples.
    fn enter(&mut self, experience: &Arc<Experience>, scene: &Scene) -> std::ops::Range<usize> {
        let from = self.examples.len();
        if self.facet.is_told_by(experience) {
            for one in 0..self.known.len() {
                let at = self.examples.len();
                self.examples.push((experience.clone(), scene.of(&self.known[one])));
                self.of_primitive.entry(experience.primitive).or_default().insert(at);
                let examples = &self.examples;
                self.conditions.enter(at, None, |at| &examples[at].1);
                let mut facet = std::mem::take(&mut self.facet);
                facet.enter(self.examples(), at);
                self.facet = facet;
            }
        }
        from..self.examples.len()
    }

    /// Takes the example `at` of the pool in, the newest. Returns whether each can still be told by itself.
    pub(super) fn learn(&mut self, examples: Examples<'_>, at: usize, time: &mut Time) -> bool {
        let Some((experience, scene)) = examples.all.get(at) else { return true };
        let is_known = |o: &Observation| self.known.binary_search(o).is_ok();
        if !met(experience, self.kind).all(is_known) || self.examples.len() > EXAMPLES_MAX {
            let anew = Self::new(self.kind, examples, self.from);
            return anew.is_some_and(|mut anew| {
                anew.facet.scores = std::mem::take(&mut self.facet.scores);
                *self = anew;
                true
            });
        }
        let entered = self.enter(experience, scene);
        self.conditions.put_in_order();
        let mut facet = std::mem::take(&mut self.facet);
        let particular = experience.primitive != ANYTHING;
        entered.for_each(|at| facet.count(self.examples(), at, particular));
        facet.seek(self.examples(), experience.primitive, time);
        self.facet = facet;
        true
    }

    /// Its examples.
    pub(super) fn examples(&self) -> Examples<'_> {
        let Self { examples, conditions, of_primitive, .. } = self;
        Examples { all: examples, conditions, of_primitive, alike: None, key: None }
    }

    fn grown(&self, view: View, primitive: PrimitiveId) -> Option<&Grown> {
        match view {
            View::General => Some(&self.facet.general),
            View::Particular => self.facet.particular.get(&primitive),
            View::Remembered => None,
        }
    }

    /// The claims: those about a primitive alone, or those about the action.
    pub(super) fn claim(&self, primitive: Option<PrimitiveId>) -> Option<&Claim> {
        let view = if primitive.is_some() { View::Particular } else { View::General };
        self.grown(view, primitive.unwrap_or(ANYTHING)).map(|grown| &grown.claim)
    }

    /// All claims that there are.
    pub(super) fn all(&self) -> impl Iterator<Item = &Claim> {
        let particular = self.facet.particular.values().map(|grown| &grown.claim);
        std::iter::once(&self.facet.general.claim).chain(particular)
    }

    /// What a view has seen of `after`, one observation after another; from what was learnt `already` it takes one away.
    pub(super) fn told(
        &self,
        view: View,
        primitive: PrimitiveId,
        scene: &Scene,
        after: &[Observation],
        already: bool,
    ) -> Option<f64> {
        let grown = self.grown(view, primitive)?;
        let mut told = 0.0;
        for one in &self.known {
            let scene = scene.of(one);
            let seen = Seen::of_claim(grown, &scene, after, &self.facet)?;
            let seen = if already { seen.without_one() } else { seen };
            told += libm::log(seen.probability(2));
        }
        // What was never met is as good as not foretold.
        let new = after.iter().filter(|o| self.known.binary_search(o).is_err()).count();
        told -= new as f64 * libm::log((self.known.len() + 1) as f64);
        Some(told)
    }

    /// What a view says of each observation that is known, or is there.
    fn each(&self, view: View, primitive: PrimitiveId, scene: &Scene) -> Option<Vec<One<'_>>> {
        let grown = self.grown(view, primitive)?;
        let present = of_kind(&scene.context, self.kind);
        let all: BTreeSet<_> = self.known.iter().chain(present).cloned().collect();
        let one = |observation: Observation| {
            let scene = scene.of(&observation);
            let (at, claim) = path(&grown.claim, &scene);
            let there = claim.outcomes.iter().filter(|(change, _)| change.vanishes.is_empty());
            let there: u32 = there.map(|(_, count)| count).sum();
            (claim.trials > 0).then(|| One {
                was_there: present.binary_search(&observation).is_ok(),
                observation,
                there,
                trials: claim.trials,
                conditions: conditions(&grown.claim, &at).collect(),
                scene,
            })
        };
        all.into_iter().map(one).collect()
    }

    /// What is foretold of all of them together, each whatever becomes of the others.
    pub(super) fn foretold(&self, view: View, primitive: PrimitiveId, scene: &Scene) -> Option<Foretold> {
        let each = self.each(view, primitive, scene)?;
        let trials = each.iter().map(|one| one.trials).min()?;
        let mut all = vec![(Vec::new(), 1.0)];
        for one in &each {
            let share = f64::from(one.there) / f64::from(one.trials);
            let mut split = Vec::with_capacity(all.len() * 2);
            for (after, probability) in all {
                if share > 0.0 {
                    let mut with: Vec<_> = after.clone();
                    with.push(one.observation.clone());
                    split.push((with, probability * share));
                }
                if share < 1.0 {
                    split.push((after, probability * (1.0 - share)));
                }
            }
            split.sort_by(|a: &(Vec<_>, f64), b| b.1.total_cmp(&a.1));
            split.truncate(OUTCOMES_MAX);
            all = split;
        }
        Some(Foretold {
            kinds: vec![self.kind],
            outcomes: counted(all, trials),
            trials,
            view,
            relied_on: Vec::new(),
            claim: None,
            attributed: true,
            is_of_each: true,
            parts: each.into_iter().filter_map(One::part).collect(),
        })
    }
}

/// Claims about each observation, tried beside those about all of them together.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Trial {
    pub(super) each: Each,
    /// How well what came was told since by the general and the particular claims about all together, and by those about each: ln of the
    /// probabilities.
    pub(super) together: [f64; 2],
    pub(super) singly: [f64; 2],
}

impl Trial {
    pub(super) fn new(each: Each) -> Self {
        Self { each, together: [0.0; 2], singly: [0.0; 2] }
    }

    /// Scores both by what came, before it is learnt from. Claims about all together gave it the probabilities of which `together` is ln.
    pub(super) fn score(
        &mut self,
        together: [f64; 2],
        primitive: PrimitiveId,
        scene: &Scene,
        after: &[Observation],
    ) {
        let told = |view: View| {
            let told = self.each.told(view, primitive, scene, after, false);
            told.unwrap_or_else(|| -(self.each.known.len() as f64) * libm::log(2.0))
        };
        let singly = [told(View::General), told(View::Particular)];
        self.together.iter_mut().zip(together).for_each(|(score, told)| *score += told);
        self.singly.iter_mut().zip(singly).for_each(|(score, told)| *score += told);
    }

    /// Whether it is certain that each by itself is told better, or that it is not; none while neither is.
    pub(super) fn verdict(&self, certain: f64) -> Option<bool> {
        let best = |[general, particular]: [f64; 2]| general.max(particular);
        let (together, singly) = (best(self.together), best(self.singly));
        if singly > together + certain {
            Some(true)
        } else if together > singly + certain {
            Some(false)
        } else {
            None
        }
    }
}

impl One<'_> {
    /// What becomes of it, if it is more likely than that it stays as it is.
    fn part(self) -> Option<Part> {
        let Self { observation, was_there, there, trials, conditions, scene } = self;
        let is_there = there * 2 >= trials;
        let relied_on = conditions.iter().filter_map(|condition| scene.relied_on(condition)).cloned();
        let (observed, vanished) =
            if is_there { (vec![observation], Vec::new()) } else { (Vec::new(), vec![observation]) };
        (is_there != was_there).then(|| Part {
            observed,
            vanished,
            relied_on: relied_on.collect(),
            count: if is_there { there } else { trials - there },
            trials,
            of_all: true,
            names_action: conditions.iter().any(|condition| condition.is_of_action()),
            attributed: true,
        })
    }
}

/// How often each outcome is to be expected in so many trials: whole numbers that add up to what all of them are expected (the largest
/// remainders are rounded up). Those that are not expected once are left out.
fn counted<T>(outcomes: Vec<(T, f64)>, trials: u32) -> Vec<(T, u32)> {
    let expected = outcomes.into_iter().map(|(outcome, share)| (outcome, share * f64::from(trials)));
    let mut counted: Vec<_> =
        expected.map(|(outcome, count)| (outcome, count, libm::floor(count) as u32)).collect();
    let all = libm::round(counted.iter().map(|(_, count, _)| count).sum()) as u32;
    let left = all.saturating_sub(counted.iter().map(|(.., whole)| whole).sum());
    let mut by_remainder: Vec<_> = (0..counted.len()).collect();
    by_remainder.sort_by(|a, b| {
        let remainder = |at: &usize| counted[*at].1 - f64::from(counted[*at].2);
        remainder(b).total_cmp(&remainder(a))
    });
    by_remainder.into_iter().take(left as usize).for_each(|at| counted[at].2 += 1);
    let mut counted: Vec<_> = counted.into_iter().map(|(outcome, _, count)| (outcome, count)).collect();
    counted.retain(|(_, count)| *count > 0);
    counted.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    counted
}

/// The observations of a type that were there before an experience, or after it.
fn met(experience: &Experience, kind: TypeId) -> impl Iterator<Item = &Observation> {
    of_kind(&experience.before, kind).iter().chain(of_kind(&experience.after, kind))
}
