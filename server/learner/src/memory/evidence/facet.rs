//! A facet: types of observations that change together, with the claims about them.

use std::collections::BTreeMap;

use crate::memory::evidence::columns::Column;
use crate::memory::evidence::growth::Ground;
use crate::memory::evidence::price::Tier;
use crate::memory::evidence::scene::{Scene, of_kind};
use crate::nouns::claim::{Change, Claim, Condition};
use crate::nouns::experience::Experience;
use crate::nouns::observation::{Observation, TypeId};
use crate::nouns::vocabulary::PrimitiveId;

/// Stands for any primitive, where all are looked at as one.
pub(super) const ANYTHING: PrimitiveId = PrimitiveId(u32::MAX);
/// Different changes that are kept apart; others are outcomes without a form.
const CHANGES_MAX: usize = 64;
/// New claims are sought when so many outcomes were not the most frequent one of the claim in force, as a share of those that were
/// not when claims were sought last: a rare surprise is looked into at once, and noise is not looked into again and again.
const UNFORETOLD_SHARE: usize = 8;

/// Claims, with the examples that they were grown from: the first so many.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Grown {
    pub(super) claim: Claim,
    /// How many examples there were when they grew.
    pub(super) examples: usize,
    /// How many of these had an outcome that was not the most frequent one of its claim.
    exceptional: usize,
    /// How many since then.
    unforetold: usize,
}

impl Grown {
    fn new(ground: &Ground<'_>, examples: Column, of: usize) -> Self {
        let claim = ground.grow(examples);
        let exceptional =
            |claim: &Claim| claim.trials - claim.outcomes.first().map_or(0, |(_, count)| *count);
        let exceptional: u32 = claim.all().map(exceptional).sum();
        Self { claim, examples: of, exceptional: exceptional as usize, unforetold: 0 }
    }

    /// Counts a further example. `makes` says of a change whether it makes what came after; `other` is one that does.
    fn count(&mut self, scene: &Scene, makes: impl Fn(&Change) -> bool, other: Option<&Change>) {
        let claim = in_force(&mut self.claim, scene);
        claim.trials += 1;
        let known = claim.outcomes.iter().position(|(change, _)| makes(change));
        self.unforetold += usize::from(known != Some(0));
        match known {
            Some(at) => claim.outcomes[at].1 += 1,
            None => claim.outcomes.extend(other.map(|change| (change.clone(), 1))),
        }
        claim.outcomes.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    }

    /// Whether more than one thing follows where one of its claims is in force.
    fn varies(&self) -> bool {
        self.claim.all().any(|claim| claim.outcomes.first().is_none_or(|(_, count)| *count < claim.trials))
    }

    fn is_stale(&self) -> bool {
        self.examples < 2 || self.unforetold > self.exceptional / UNFORETOLD_SHARE
    }
}

/// The claim in force in a scene: from the top, the first exception whose condition holds, and so on within it.
fn in_force<'a>(claim: &'a mut Claim, scene: &Scene) -> &'a mut Claim {
    let holds =
        |exception: &Claim| exception.condition.as_ref().is_some_and(|condition| scene.holds(condition));
    match claim.exceptions.iter().position(holds) {
        Some(at) => in_force(&mut claim.exceptions[at], scene),
        None => claim,
    }
}

/// The same to read, with its place: which exception at each level.
pub(super) fn path<'a>(claim: &'a Claim, scene: &Scene) -> (Vec<usize>, &'a Claim) {
    let (mut path, mut claim) = (Vec::new(), claim);
    let holds =
        |exception: &Claim| exception.condition.as_ref().is_some_and(|condition| scene.holds(condition));
    while let Some(at) = claim.exceptions.iter().position(holds) {
        path.push(at);
        claim = &claim.exceptions[at];
    }
    (path, claim)
}

/// The conditions of the claim at a place: its own and those of the claims that it is an exception to.
pub(super) fn conditions<'a>(claim: &'a Claim, path: &'a [usize]) -> impl Iterator<Item = &'a Condition> {
    let below = path.iter().scan(claim, |claim, at| {
        *claim = claim.exceptions.get(*at)?;
        Some(*claim)
    });
    below.filter_map(|claim| claim.condition.as_ref())
}

/// The conditions that examples meet, each with those that meet it.
pub(super) type Conditions = BTreeMap<Condition, Column>;

/// The examples of a pool, as its facets need them.
#[derive(Clone, Copy)]
pub(super) struct Examples<'a> {
    pub(super) all: &'a [(std::sync::Arc<Experience>, Scene)],
    pub(super) conditions: &'a Conditions,
    pub(super) of_primitive: &'a BTreeMap<PrimitiveId, Column>,
}

/// The types of what was there before the first experience with observations of `kind`, in order.
fn company(kind: TypeId, examples: &[(std::sync::Arc<Experience>, Scene)]) -> Vec<TypeId> {
    let has = |observations: &[Observation]| !of_kind(observations, kind).is_empty();
    let first = examples.iter().find(|(e, _)| has(&e.before) || has(&e.after));
    let mut company: Vec<_> = first
        .into_iter()
        .flat_map(|(experience, _)| experience.before.iter().map(Observation::kind))
        .collect();
    company.dedup();
    company
}

/// Whether an experience tells if anything of `kind` was there. It does if the type was sensed. It also does if neither the type
/// could be sensed nor some of the `company` that it first came in: then it is held to come with that company, and both to have been
/// absent. Senses are withheld at first so that what is learnt without them stands on its own (paper, II-C).
fn tells(experience: &Experience, kind: TypeId, company: &[TypeId]) -> bool {
    let sensed = |kind: &TypeId| experience.sensed.binary_search(kind).is_ok();
    sensed(&kind) || !company.iter().all(sensed)
}

/// Types that change together, with the claims about them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Facet {
    /// The types, in order.
    pub(super) kinds: Vec<TypeId>,
    /// Of each, the types of what was there before the experience that it first came with, in order.
    company: Vec<Vec<TypeId>>,
    /// The examples that tell whether any of them were there.
    sensed: Column,
    /// The changes seen, in all wordings, each with the examples that it makes.
    pub(super) changes: Vec<(Change, Column)>,
    /// The claims about the action, whatever its parameters.
    pub(super) general: Grown,
    /// The claims about each primitive.
    pub(super) particular: BTreeMap<PrimitiveId, Grown>,
    /// For each primitive how well each view foretold it, each experience before it was learnt from: ln of the probabilities.
    pub(super) scores: BTreeMap<PrimitiveId, [f64; 3]>,
}

impl Facet {
    /// The facet of these types, with claims grown from all examples.
    pub(super) fn new(kinds: Vec<TypeId>, examples: Examples<'_>) -> Self {
        let company = kinds.iter().map(|kind| company(*kind, examples.all)).collect();
        let mut facet = Self { kinds, company, ..Self::default() };
        (0..examples.all.len()).for_each(|at| facet.enter(examples.all, at));
        facet.grow_all(examples);
        facet
    }

    pub(super) fn varies(&self) -> bool {
        self.general.varies()
    }

    pub(super) fn grow_all(&mut self, examples: Examples<'_>) {
        self.grow(examples);
        for primitive in examples.of_primitive.keys().filter(|primitive| **primitive != ANYTHING) {
            self.grow_particular(examples, *primitive);
        }
    }

    /// Enters the example `at` in the columns, anew if it was there.
    pub(super) fn enter(&mut self, examples: &[(std::sync::Arc<Experience>, Scene)], at: usize) {
        let Some((experience, scene)) = examples.get(at) else { return };
        if !self.is_told_by(experience) {
            return;
        }
        self.sensed.insert(at);
        let after = self.part(&experience.after);
        for (change, makes) in &mut self.changes {
            makes.remove(at);
            if scene.after(change, &self.kinds).as_ref() == Some(&after) {
                makes.insert(at);
            }
        }
        for change in scene.changes(&after, &self.kinds) {
            if self.changes.len() == CHANGES_MAX || self.changes.iter().any(|(known, _)| *known == change) {
                continue;
            }
            let mut makes = Column::default();
            for (at, (experience, scene)) in examples.iter().enumerate().take(at + 1) {
                let sensed = self.sensed.contains(at);
                if sensed && scene.after(&change, &self.kinds) == Some(self.part(&experience.after)) {
                    makes.insert(at);
                }
            }
            self.changes.push((change, makes));
        }
    }

    /// Whether an experience tells which observations of its types were there.
    pub(super) fn is_told_by(&self, experience: &Experience) -> bool {
        self.kinds.iter().zip(&self.company).all(|(kind, company)| tells(experience, *kind, company))
    }

    /// What of these observations is of its types.
    pub(super) fn part(&self, observations: &[Observation]) -> Vec<Observation> {
        self.kinds.iter().flat_map(|kind| of_kind(observations, *kind)).cloned().collect()
    }

    /// Counts the example `at`, which is entered, and seeks claims anew where that is called for: the general ones, and those about its
    /// primitive if there are any of a `particular` one.
    pub(super) fn learn(&mut self, examples: Examples<'_>, at: usize, particular: bool) {
        let Some((experience, scene)) = examples.all.get(at).filter(|_| self.sensed.contains(at)) else {
            return;
        };
        let made =
            |change: &Change| self.changes.iter().any(|(known, makes)| known == change && makes.contains(at));
        let other = self.changes.iter().find(|(_, makes)| makes.contains(at)).map(|(change, _)| change);
        self.general.count(scene, made, other);
        let mut stale = false;
        if particular {
            let particular = self.particular.entry(experience.primitive).or_default();
            particular.count(scene, made, other);
            stale = particular.is_stale();
        }
        if self.general.is_stale() {
            self.grow(examples);
        }
        if stale {
            self.grow_particular(examples, experience.primitive);
        }
    }

    pub(super) fn grow(&mut self, examples: Examples<'_>) {
        self.general = self.grown(examples, self.sensed.clone());
    }

    pub(super) fn grow_particular(&mut self, examples: Examples<'_>, primitive: PrimitiveId) {
        let Some(of_primitive) = examples.of_primitive.get(&primitive) else { return };
        let grown = self.grown(examples, self.sensed.both(of_primitive));
        self.particular.insert(primitive, grown);
    }

    fn grown(&self, examples: Examples<'_>, which: Column) -> Grown {
        let mut conditions: Vec<_> = examples.conditions.iter().collect();
        conditions.sort_by_key(|(condition, _)| Tier::of(condition));
        let scene = |at: usize| &examples.all[at].1;
        let ground = Ground { conditions: &conditions, changes: &self.changes, scene: &scene };
        Grown::new(&ground, which, examples.all.len())
    }

    /// How much shorter the outcomes of this facet and another are told together than apart, beyond what their claims say of them: a
    /// logarithm of odds.
    pub(super) fn dependence(&self, other: &Self, examples: Examples<'_>) -> f64 {
        let mut cells: BTreeMap<_, Vec<(usize, usize)>> = BTreeMap::new();
        for at in self.sensed.both(&other.sensed).iter() {
            let Some((_, scene)) = examples.all.get(at) else { continue };
            let ((one, _, a), (two, _, b)) = (self.outcome(scene, at), other.outcome(scene, at));
            cells.entry((one, two)).or_default().push((a, b));
        }
        dependence(cells.into_values())
    }

    /// The place of the claim in force in an example, the claim, and which of its outcomes came; that after its last for any other.
    fn outcome<'a>(&'a self, scene: &Scene, at: usize) -> (Vec<usize>, &'a Claim, usize) {
        let (path, claim) = path(&self.general.claim, scene);
        let came =
            |change: &Change| self.changes.iter().any(|(known, makes)| known == change && makes.contains(at));
        let outcome = claim.outcomes.iter().position(|(change, _)| came(change));
        (path, claim, outcome.unwrap_or(claim.outcomes.len()))
    }

    /// A type that changes by itself: its changes and those of the others are told shorter apart.
    pub(super) fn stranger(&self, examples: Examples<'_>) -> Option<TypeId> {
        if self.kinds.len() < 2 {
            return None;
        }
        let outcomes: Vec<_> = self
            .sensed
            .iter()
            .filter_map(|at| examples.all.get(at).map(|(_, scene)| self.outcome(scene, at)))
            .collect();
        let apart = |kind: &TypeId| {
            let mut cells: BTreeMap<&[usize], Vec<(usize, usize)>> = BTreeMap::new();
            for (path, claim, outcome) in &outcomes {
                // Each outcome as the first of those that do the same to the type, and to the others.
                let first = |of_type: bool| {
                    let part = |at: usize| {
                        let (change, _) = claim.outcomes.get(at)?;
                        let parts = [&change.becomes, &change.vanishes, &change.appears];
                        Some(parts.map(|part| {
                            part.iter().filter(|s| (s.kind == *kind) == of_type).collect::<Vec<_>>()
                        }))
                    };
                    (0..*outcome).find(|at| part(*at) == part(*outcome)).unwrap_or(*outcome)
                };
                cells.entry(path).or_default().push((first(true), first(false)));
            }
            dependence(cells.into_values()) < 0.0
        };
        self.kinds.iter().find(|kind| apart(kind)).copied()
    }
}

/// The outcomes of two facets in one example, by number.
type Pair = (usize, usize);

/// How much shorter pairs of outcomes, apart by the claims in force, are told together than each by itself: their mutual
/// information, less what it costs to say how they depend on each other (the Bayesian information criterion).
fn dependence(cells: impl Iterator<Item = Vec<Pair>>) -> f64 {
    let (mut information, mut freedom, mut all) = (0.0, 0, 0);
    for cell in cells {
        let counts = |of: fn(Pair) -> Pair| {
            let mut counts: BTreeMap<Pair, usize> = BTreeMap::new();
            cell.iter().for_each(|pair| *counts.entry(of(*pair)).or_default() += 1);
            counts
        };
        let told = |counts: &BTreeMap<Pair, usize>| {
            counts.values().map(|count| *count as f64 * libm::log(*count as f64)).sum::<f64>()
        };
        let (a, b) = (counts(|(a, _)| (a, 0)), counts(|(_, b)| (b, 0)));
        let trials = cell.len() as f64;
        information += told(&counts(|pair| pair)) + trials * libm::log(trials) - told(&a) - told(&b);
        freedom += (a.len() - 1) * (b.len() - 1);
        all += cell.len();
    }
    if freedom == 0 { 0.0 } else { information - 0.5 * freedom as f64 * libm::log(all as f64) }
}
