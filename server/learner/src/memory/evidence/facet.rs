//! A facet: types of observations that change together, with the claims about them.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::memory::evidence::columns::{Column, Conditions};
use crate::memory::evidence::growth::{Ground, Growth, Place};
use crate::memory::evidence::novelty::Surprise;
use crate::memory::evidence::outcomes::Outcomes;
use crate::memory::evidence::scene::{Scene, of_kind};
use crate::nouns::claim::{Change, Claim, Condition, Sketch};
use crate::nouns::experience::Experience;
use crate::nouns::observation::{Observation, TypeId};
use crate::nouns::vocabulary::PrimitiveId;

/// Stands for any primitive, where all are looked at as one.
pub(super) const ANYTHING: PrimitiveId = PrimitiveId(u32::MAX);
/// Different changes that are kept apart; others are outcomes without a form.
pub(super) const CHANGES_MAX: usize = 64;
/// New claims are sought when so many outcomes were not the most frequent one of the claim in force, as a share of those that were
/// not when claims were sought last: a rare surprise is looked into at once, and noise is not looked into again and again.
const UNFORETOLD_SHARE: usize = 8;

/// Claims leave much open when more than one outcome in so many was not the most frequent one of the claim in force.
const OPEN_SHARE: usize = 4;

/// Conditions that are held against 64 examples each, in the claims that are sought in one step; one facet is always sought.
const SOUGHT_MAX: usize = 1 << 17;
/// Conditions that an example meets, about.
const MET: usize = 512;

/// Claims, with the examples that they were grown from: the first so many.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Grown {
    pub(super) claim: Claim,
    /// How many examples there were when they grew.
    pub(super) examples: usize,
    /// How many of these had an outcome that was not the most frequent one of its claim.
    pub(super) exceptional: usize,
    /// How many since then.
    pub(super) unforetold: usize,
}

impl Grown {
    fn new(claim: Claim, examples: usize) -> Self {
        let exceptional =
            |claim: &Claim| claim.trials - claim.outcomes.first().map_or(0, |(_, count)| *count);
        let exceptional: u32 = claim.all().map(exceptional).sum();
        Self { claim, examples, exceptional: exceptional as usize, unforetold: 0 }
    }

    /// Counts a further example, which these of the `changes` make, and returns its place.
    fn count(&mut self, scene: &Scene, changes: &[(Change, Column)], made: &[usize]) -> Place {
        let (number, claim) = in_force(&mut self.claim, scene);
        claim.trials += 1;
        let makes = |(known, _): &(Change, u32)| made.iter().copied().find(|at| changes[*at].0 == *known);
        let known = claim.outcomes.iter().enumerate().find_map(|(at, outcome)| Some((at, makes(outcome)?)));
        self.unforetold += usize::from(known.is_none_or(|(at, _)| at != 0));
        let change = match known {
            Some((mut at, change)) => {
                claim.outcomes[at].1 += 1;
                // It goes before those that came less often.
                while at > 0 && claim.outcomes[at - 1].1 < claim.outcomes[at].1 {
                    claim.outcomes.swap(at - 1, at);
                    at -= 1;
                }
                Some(change)
            }
            None => made.first().copied().inspect(|at| claim.outcomes.push((changes[*at].0.clone(), 1))),
        };
        Place { claim: number, change }
    }

    /// Whether more than one thing follows where one of its claims is in force.
    fn varies(&self) -> bool {
        self.claim.all().any(|claim| claim.outcomes.first().is_none_or(|(_, count)| *count < claim.trials))
    }

    /// How often what followed was not the most frequent outcome of the claim in force.
    pub(super) fn left_open(&self) -> usize {
        self.exceptional + self.unforetold
    }

    /// Whether that was often so.
    fn is_open(&self) -> bool {
        self.left_open() * OPEN_SHARE > self.claim.all().map(|c| c.trials as usize).sum()
    }

    fn is_stale(&self) -> bool {
        self.examples < 2 || self.unforetold > self.exceptional / UNFORETOLD_SHARE
    }
}

/// The claim in force in a scene, with its number: from the top, the first exception whose condition holds, and so on within it.
fn in_force<'a>(claim: &'a mut Claim, scene: &Scene) -> (usize, &'a mut Claim) {
    let holds =
        |exception: &Claim| exception.condition.as_ref().is_some_and(|condition| scene.holds(condition));
    let (mut number, mut claim) = (0, claim);
    while let Some(at) = claim.exceptions.iter().position(holds) {
        number += 1 + claim.exceptions[..at].iter().map(|before| before.all().count()).sum::<usize>();
        claim = &mut claim.exceptions[at];
    }
    (number, claim)
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
pub(super) fn conditions<'a>(claim: &'a Claim, path: &[usize]) -> impl Iterator<Item = &'a Condition> {
    let below = path.iter().scan(claim, |claim, at| {
        *claim = claim.exceptions.get(*at)?;
        Some(*claim)
    });
    below.filter_map(|claim| claim.condition.as_ref())
}

/// The examples of a pool, as its facets need them.
#[derive(Clone, Copy)]
pub(super) struct Examples<'a> {
    pub(super) all: &'a [(Arc<Experience>, Scene)],
    pub(super) conditions: &'a Conditions,
    pub(super) of_primitive: &'a BTreeMap<PrimitiveId, Column>,
    /// Those with each primitive in the very same context; none where they are of single observations.
    pub(super) alike: Option<&'a Alike>,
    /// The type in which it shows how the body is.
    pub(super) key: Option<TypeId>,
}

/// The examples with each primitive in the very same context, in order.
pub(super) type Alike = BTreeMap<PrimitiveId, BTreeMap<Arc<[Observation]>, Vec<usize>>>;

impl<'a> Examples<'a> {
    /// The first of the examples before this one whose scene is the same and that is `like` it besides, among those with the same
    /// primitive. What holds in one holds in the other, and is looked at once.
    pub(super) fn twin(self, at: usize, like: impl Fn(usize) -> bool) -> Option<usize> {
        let (experience, scene) = self.all.get(at)?;
        let alike = self.alike?.get(&experience.primitive)?.get(&experience.before)?;
        let twin = alike.iter().copied().take_while(|other| *other < at).find(|other| like(*other))?;
        self.all.get(twin).filter(|(_, other)| other == scene).map(|_| twin)
    }
}

/// How much more may be sought in one step. Claims that wait for another step are sought then.
pub(super) struct Time {
    /// In conditions that are held against 64 examples.
    left: usize,
    taken: bool,
}

impl Time {
    /// For one step.
    pub(super) fn new() -> Self {
        Self { left: SOUGHT_MAX, taken: false }
    }

    /// Takes the time to seek claims among these of the examples, if there is enough, or none was taken yet.
    fn take(&mut self, examples: Examples<'_>, which: &Column) -> bool {
        let count = which.count();
        let all = examples.conditions.len().saturating_mul(1 + examples.all.len() / 64);
        // Few examples are held only against what they meet.
        let cost = if count > 64 { all } else { all.min(count * MET) };
        let enough = !self.taken || cost <= self.left;
        if enough {
            (self.left, self.taken) = (self.left.saturating_sub(cost), true);
        }
        enough
    }
}

/// The types of what was there before the first experience with observations of `kind`, in order.
pub(super) fn company(kind: TypeId, examples: &[(Arc<Experience>, Scene)]) -> Vec<TypeId> {
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
    pub(super) company: Vec<Vec<TypeId>>,
    /// The examples that tell whether any of them were there.
    pub(super) sensed: Column,
    /// What came in each of these.
    pub(super) outcomes: Outcomes,
    /// The changes seen, in all wordings, each with the examples that it makes.
    pub(super) changes: Vec<(Change, Column)>,
    /// The claims about the action, whatever its parameters.
    pub(super) general: Grown,
    /// The place of each example among them; none where it does not tell of these types.
    pub(super) places: Vec<Option<Place>>,
    /// The claims about each primitive.
    pub(super) particular: BTreeMap<PrimitiveId, Grown>,
    /// For each primitive how well each view foretold it, each experience before it was learnt from: ln of the probabilities.
    pub(super) scores: BTreeMap<PrimitiveId, [f64; 3]>,
    /// How often it surprised.
    pub(super) surprise: Surprise,
    /// Whether each observation of its type is told by itself, and nothing of all of them together.
    pub(super) is_singly: bool,
}

impl Facet {
    /// The facet of this type, with no claims yet.
    pub(super) fn of(kind: TypeId, examples: &[(Arc<Experience>, Scene)]) -> Self {
        Self { kinds: vec![kind], company: vec![company(kind, examples)], ..Self::default() }
    }

    /// The same, of whose type each observation is told by itself.
    pub(super) fn singly(kind: TypeId, examples: &[(Arc<Experience>, Scene)]) -> Self {
        Self { is_singly: true, ..Self::of(kind, examples) }
    }

    /// The facet of these types, with claims grown from all examples.
    pub(super) fn new(kinds: Vec<TypeId>, examples: Examples<'_>) -> Self {
        let company = kinds.iter().map(|kind| company(*kind, examples.all)).collect();
        let mut facet = Self { kinds, company, ..Self::default() };
        (0..examples.all.len()).for_each(|at| facet.enter(examples, at));
        facet.grow_all(examples);
        facet
    }

    /// Whether more than one thing follows where a claim about all of its types is in force.
    pub(super) fn varies(&self) -> bool {
        !self.is_singly && self.general.varies()
    }

    /// Whether the claims about all of its types leave much open.
    pub(super) fn is_open(&self) -> bool {
        !self.is_singly && (self.general.is_open() || self.surprise.is_often())
    }

    /// ln of the probability of what is told by nothing.
    pub(super) fn of_nothing(&self) -> f64 {
        -libm::log((self.changes.len() + 1) as f64)
    }

    pub(super) fn grow_all(&mut self, examples: Examples<'_>) {
        self.grow(examples);
        for primitive in examples.of_primitive.keys().filter(|primitive| **primitive != ANYTHING) {
            self.grow_particular(examples, *primitive);
        }
    }

    /// Whether what it tells says what is recalled, so that it can't be told by that.
    fn is_blind(&self, key: Option<TypeId>) -> bool {
        key.is_some_and(|key| self.kinds.binary_search(&key).is_ok())
    }

    /// Enters the example `at` in the columns, anew if it was there. A change of the type in which it shows how the body is, is not told by
    /// what is recalled.
    pub(super) fn enter(&mut self, examples: Examples<'_>, at: usize) {
        let Some((scene, after)) = self.enter_known(examples, at) else { return };
        let is_blind = self.is_blind(examples.key);
        let may_tell = |change: &Change| !(is_blind && change.sketches().any(Sketch::is_recalled));
        for change in scene.changes(&after, &self.kinds).into_iter().filter(may_tell) {
            if self.changes.len() == CHANGES_MAX || self.changes.iter().any(|(known, _)| *known == change) {
                continue;
            }
            let mut makes = Column::default();
            for (at, (experience, scene)) in examples.all.iter().enumerate() {
                if self.sensed.contains(at) && scene.makes(&change, &self.after(experience), &self.kinds) {
                    makes.insert(at);
                }
            }
            self.changes.push((change, makes));
        }
    }

    /// Enters the example `at` in the columns of the changes that are known. Returns its scene and what was there afterwards, if it
    /// tells of these types and is not the same as one that was entered before.
    pub(super) fn enter_known<'a>(
        &mut self,
        examples: Examples<'a>,
        at: usize,
    ) -> Option<(&'a Scene, Vec<Observation>)> {
        let told = examples.all.get(at).filter(|(experience, _)| self.is_told_by(experience));
        let (experience, scene) = told?;
        let after = self.after(experience);
        let number = self.outcomes.enter(at, &after);
        let is_like = |other: usize| self.sensed.contains(other) && self.outcomes.of(other) == Some(number);
        let twin = examples.twin(at, is_like);
        self.sensed.insert(at);
        for (change, makes) in &mut self.changes {
            makes.remove(at);
            if twin.map_or_else(|| scene.makes(change, &after, &self.kinds), |twin| makes.contains(twin)) {
                makes.insert(at);
            }
        }
        twin.is_none().then_some((scene, after))
    }

    /// Whether it is about whether an episode had ended.
    pub(super) fn is_of_ends(&self) -> bool {
        self.kinds == [TypeId::ENDED]
    }

    /// Whether an experience tells which observations of its types were there: of where an episode had ended nothing else is told.
    pub(super) fn is_told_by(&self, experience: &Experience) -> bool {
        if experience.is_end() || self.is_of_ends() {
            return self.is_of_ends();
        }
        self.kinds.iter().zip(&self.company).all(|(kind, company)| tells(experience, *kind, company))
    }

    /// What was there of its types after an experience that tells of them.
    pub(super) fn after(&self, experience: &Experience) -> Vec<Observation> {
        if experience.is_end() {
            return vec![Observation::new(TypeId::ENDED, [])];
        }
        self.kinds.iter().flat_map(|kind| of_kind(&experience.after, *kind)).cloned().collect()
    }

    /// Counts the example `at`, which is entered: for the general claims, and for those about its primitive if there are any of a
    /// `particular` one.
    pub(super) fn count(&mut self, examples: Examples<'_>, at: usize, particular: bool) {
        let Some((experience, scene)) = examples.all.get(at).filter(|_| self.sensed.contains(at)) else {
            return;
        };
        let made = self.changes.iter().enumerate().filter(|(_, (_, makes))| makes.contains(at));
        let made: Vec<_> = made.map(|(number, _)| number).collect();
        let place = self.general.count(scene, &self.changes, &made);
        if self.places.len() <= at {
            self.places.resize(at + 1, None);
        }
        self.places[at] = Some(place);
        if particular {
            let particular = self.particular.entry(experience.primitive).or_default();
            particular.count(scene, &self.changes, &made);
        }
    }

    /// Seeks claims anew where that is called for and there is time: the general ones, and those about a primitive if there are any.
    pub(super) fn seek(&mut self, examples: Examples<'_>, primitive: PrimitiveId, time: &mut Time) {
        if self.general.is_stale() && time.take(examples, &self.sensed) {
            self.grow(examples);
        }
        let stale = self.particular.get(&primitive).is_some_and(Grown::is_stale);
        let tried = examples.of_primitive.get(&primitive);
        if stale && tried.is_some_and(|tried| time.take(examples, tried)) {
            self.grow_particular(examples, primitive);
        }
    }

    /// Takes account of examples that are named anew: those with this primitive. Each may be an exception now, or none any more.
    pub(super) fn rename(&mut self, examples: Examples<'_>, primitive: PrimitiveId) {
        let Some(of_primitive) = examples.of_primitive.get(&primitive) else { return };
        self.general.unforetold += self.sensed.count_both(of_primitive);
        if self.general.is_stale() {
            self.grow(examples);
        }
        self.grow_particular(examples, primitive);
    }

    pub(super) fn grow(&mut self, examples: Examples<'_>) {
        let Growth { claim, places } = self.grown(examples, self.sensed.clone());
        self.general = Grown::new(claim, examples.all.len());
        self.places = vec![None; examples.all.len()];
        places.into_iter().for_each(|(at, place)| self.places[at] = Some(place));
    }

    pub(super) fn grow_particular(&mut self, examples: Examples<'_>, primitive: PrimitiveId) {
        let Some(of_primitive) = examples.of_primitive.get(&primitive) else { return };
        let grown = self.grown(examples, self.sensed.both(of_primitive));
        self.particular.insert(primitive, Grown::new(grown.claim, examples.all.len()));
    }

    fn grown(&self, examples: Examples<'_>, which: Column) -> Growth {
        let scene = |at: usize| &examples.all[at].1;
        let ground = Ground {
            conditions: examples.conditions,
            changes: &self.changes,
            is_blind: self.is_blind(examples.key),
            scene: &scene,
        };
        ground.grow(which)
    }

    /// How much shorter the outcomes of this facet and another are told together than apart, beyond what their claims say of them: a
    /// logarithm of odds.
    pub(super) fn dependence(&self, other: &Self) -> f64 {
        let both =
            self.places.iter().zip(&other.places).filter_map(|(one, other)| Some(((*one)?, (*other)?)));
        dependence(both.map(|(a, b)| ((a.claim, b.claim), (a.change, b.change))))
    }

    /// A type that changes by itself: its changes and those of the others are told shorter apart.
    pub(super) fn stranger(&self) -> Option<TypeId> {
        if self.kinds.len() < 2 {
            return None;
        }
        let apart = |kind: &TypeId| {
            // Changes that do the same to the type, and to the others, have one number.
            let numbers = |of_type: bool| {
                let mut known = BTreeMap::new();
                let part = |sketches: &'_ [Sketch]| -> Vec<_> {
                    sketches.iter().filter(|sketch| (sketch.kind == *kind) == of_type).cloned().collect()
                };
                let number = |(change, _): &(Change, Column)| {
                    let parts =
                        [&change.becomes, &change.vanishes, &change.appears].map(|sketches| part(sketches));
                    let next = known.len();
                    *known.entry(parts).or_insert(next)
                };
                self.changes.iter().map(number).collect::<Vec<_>>()
            };
            let (of_type, of_others) = (numbers(true), numbers(false));
            let number = |numbers: &[usize], change: Option<usize>| numbers.get(change?).copied();
            let told = self.places.iter().flatten();
            let told = told.map(|p| (p.claim, (number(&of_type, p.change), number(&of_others, p.change))));
            dependence(told) < 0.0
        };
        self.kinds.iter().find(|kind| apart(kind)).copied()
    }
}

/// How much shorter pairs of outcomes, apart by the claims in force, are told together than each by itself: their mutual
/// information, less what it costs to say how they depend on each other (the Bayesian information criterion).
fn dependence<C: Ord, O: Copy + Ord>(told: impl Iterator<Item = (C, (O, O))>) -> f64 {
    let mut cells: BTreeMap<C, Vec<(O, O)>> = BTreeMap::new();
    told.for_each(|(cell, pair)| cells.entry(cell).or_default().push(pair));
    let (mut information, mut freedom, mut all) = (0.0, 0, 0);
    for cell in cells.values_mut() {
        let log = |count: usize| count as f64 * libm::log(count as f64);
        cell.sort_unstable();
        let pairs = cell.chunk_by(|a, b| a == b).map(<[_]>::len);
        let together: f64 = pairs.map(log).sum();
        let (mut one, mut other): (Vec<_>, Vec<_>) = cell.iter().copied().unzip();
        let apart = |outcomes: &mut Vec<O>| {
            outcomes.sort_unstable();
            let counts = outcomes.chunk_by(|a, b| a == b).map(<[_]>::len);
            counts.fold((0, 0.0), |(different, sum), count| (different + 1, sum + log(count)))
        };
        let ((a, of_one), (b, of_other)) = (apart(&mut one), apart(&mut other));
        information += together + log(cell.len()) - of_one - of_other;
        freedom += (a - 1) * (b - 1);
        all += cell.len();
    }
    if freedom == 0 { 0.0 } else { information - 0.5 * freedom as f64 * libm::log(all as f64) }
}
