//! The experiences with one action, and the claims that they make.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;

use crate::memory::evidence::columns::{Column, Conditions};
use crate::memory::evidence::each::{Each, Trial};
use crate::memory::evidence::facet::{ANYTHING, Alike, Examples, Facet, Time, path};
use crate::memory::evidence::foretold::{InForce, differs};
use crate::memory::evidence::novelty::{Novelty, newness};
use crate::memory::evidence::scene::{Scene, of_kind};
use crate::memory::evidence::values::Values;
use crate::nouns::claim::Claim;
use crate::nouns::experience::{Experience, Recalled};
use crate::nouns::observation::{Observation, TypeId};
use crate::nouns::vocabulary::PrimitiveId;

/// Experiences with one action that are kept. Beyond it those with which least is lost make room, a quarter at a time.
const EXPERIENCES_MAX: usize = 1_024;
/// How new a context is that is new as a whole, when each pair of its observations is familiar.
const WHOLE: f64 = 0.5;
/// Experiences that are looked at for what came of a context that was met often.
pub(super) const ALIKE_MAX: usize = 64;
/// ln of the odds at which it is held that something differs or belongs together: 20 to 1, as an interval of 95 % says elsewhere.
pub(super) const CERTAIN: f64 = 2.995_732_273_553_991;
/// Primitives whose own effect is looked at again with each experience of another.
const DOUBTS_MAX: usize = 4;
/// What a primitive brings about of itself may change again when it was tried so much more often, as one part in so many.
const EFFECT_CHANGES: usize = 8;
/// Observations that may come about together as a primitive's own effect.
const BROUGHT_MAX: usize = 32;
/// So many experiences are needed until it is tried to tell observations one by one, and then twice as many, or so many more, until it is
/// tried again.
const EACH_MIN: usize = 32;
const EACH_AGAIN: usize = 256;
/// They are where there are several of a type in more than one experience in so many.
const EACH_SHARE: usize = 16;
/// So many experiences are needed until it is asked in which type it shows how the body is, and then always twice as many.
const KEY_MIN: usize = 16;
/// It changes in more than one in so many.
const KEY_CHANGES: usize = 8;
/// It was not the most frequent outcome of the claim in force in less than one in so many.
const KEY_OPEN: usize = 8;
/// The share of a primitive's experiences in which an observation must come about to be an effect of its own.
const EFFECT_SHARE: (usize, usize) = (3, 4);

/// How many experiences a pool keeps that are with so many primitives.
pub(super) fn room(primitives: usize) -> usize {
    EXPERIENCES_MAX.max(2 * primitives)
}

/// Whether an experience began with this context, of these types.
pub(super) fn is_alike(experience: &Experience, context: &[Observation], kinds: &BTreeSet<TypeId>) -> bool {
    let of_kinds = || experience.before.iter().filter(|o| kinds.contains(&o.kind()));
    // Most that differ have more.
    of_kinds().count() == context.len() && of_kinds().eq(context)
}

/// How often it is left open what comes of a context of which so often came this: as often as everywhere, until more is known of it.
pub(super) fn open_there(came: &[(Vec<Observation>, u32)], everywhere: f64) -> f64 {
    let all: u32 = came.iter().map(|(_, count)| count).sum();
    let most = came.iter().map(|(_, count)| *count).max().unwrap_or(0);
    (f64::from(all - most) + everywhere) / (f64::from(all) + 1.0)
}

/// Experiences in which the same claims were in force.
#[derive(Default)]
struct Cell {
    /// By the primitive and the context, the oldest first.
    tried: BTreeMap<(PrimitiveId, Arc<[Observation]>), VecDeque<usize>>,
    count: usize,
}

impl Cell {
    /// How much is lost with one experience of what was tried most often in the same context: of what the claims say, and of what comes of
    /// that context alone. Each is as certain as it was told often, so that of many the next tells less by their square.
    fn loss(&self) -> f64 {
        let most = self.tried.values().map(VecDeque::len).max().unwrap_or(0);
        [self.count, most].map(|told| 1.0 / (told * told) as f64).iter().sum()
    }

    /// Takes the oldest of what was tried most often in the same context.
    fn pop(&mut self) -> Option<usize> {
        self.count = self.count.saturating_sub(1);
        self.tried.values_mut().max_by_key(|tried| tried.len())?.pop_front()
    }
}

/// The experiences with one action, with the claims about each facet of what it changes.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Pool {
    pub(super) examples: Vec<(Arc<Experience>, Scene)>,
    pub(super) conditions: Conditions,
    of_primitive: BTreeMap<PrimitiveId, Column>,
    /// What each primitive brings about of itself, whatever the context.
    pub(super) effects: BTreeMap<PrimitiveId, Vec<Observation>>,
    /// After how many tries of each this was changed last.
    pub(super) changed: BTreeMap<PrimitiveId, usize>,
    /// Those that brought something about once, of which it is not known yet whether that comes anyway.
    pub(super) doubtful: BTreeSet<PrimitiveId>,
    /// After how many of the experiences each lasting observation was there.
    came: BTreeMap<Observation, usize>,
    /// The same for each primitive, with whether it was ever not there before.
    brought: BTreeMap<PrimitiveId, BTreeMap<Observation, (usize, bool)>>,
    /// The experiences with each primitive in the very same context.
    pub(super) alike: Alike,
    pub(super) facets: Vec<Facet>,
    /// What is known of values, apart from all else.
    pub(super) values: Values,
    /// The claims about each observation by itself of a type that is told so.
    pub(super) singly: BTreeMap<TypeId, Each>,
    /// The same of types of which it is not known yet whether that tells more.
    pub(super) trials: BTreeMap<TypeId, Trial>,
    /// The type in which it shows how the action leaves the body: of that there is always one, and it is told.
    pub(super) key: Option<TypeId>,
}

impl Pool {
    /// Takes an experience in. What the pool knows follows from the experiences that it keeps, in their order.
    pub(super) fn experience(&mut self, experience: Arc<Experience>, recalls: bool) {
        if self.examples.len() >= room(self.of_primitive.len()) {
            self.make_room();
        }
        self.learn(experience);
        let count = self.examples.len();
        if recalls && count >= KEY_MIN && count.is_power_of_two() {
            let key = self.found_key();
            if self.key != key {
                let all = std::mem::take(&mut self.examples);
                self.key = key;
                self.settle(all.into_iter().map(|(experience, _)| experience).collect());
            }
        }
    }

    /// The examples with each primitive.
    pub(super) fn of_primitive(&self) -> &BTreeMap<PrimitiveId, Column> {
        &self.of_primitive
    }

    pub(super) fn key(&self) -> Option<TypeId> {
        self.key
    }

    /// The type in which it shows how the action leaves the body: of which one is there before and after, which often changes and is told
    /// well. That which was found before stays while it can.
    fn found_key(&self) -> Option<TypeId> {
        let all = || self.examples.iter().map(|(experience, _)| experience);
        let may_be = |kind: &TypeId| {
            let shows = |e: &Arc<Experience>| {
                e.sensed.binary_search(kind).is_ok()
                    && of_kind(&e.before, *kind).len() == 1
                    && of_kind(&e.after, *kind).len() == 1
            };
            let changes = |e: &&Arc<Experience>| of_kind(&e.before, *kind) != of_kind(&e.after, *kind);
            all().all(shows) && all().filter(changes).count() * KEY_CHANGES > self.examples.len()
        };
        // Where there is nothing else, nothing is to be recalled.
        if self.facets.len() < 2 {
            return None;
        }
        let told = self.facets.iter().filter(|facet| !facet.is_singly);
        let told =
            told.flat_map(|facet| facet.kinds.iter().map(move |kind| (facet.general.left_open(), *kind)));
        let told = told.filter(|(open, kind)| open * KEY_OPEN < self.examples.len() && may_be(kind));
        told.min_by_key(|(open, kind)| (self.key != Some(*kind), *open, *kind)).map(|(_, kind)| kind)
    }

    /// The scene of an experience with an action that has this effect of its own.
    pub(super) fn scene(&self, experience: &Experience, effect: &[Observation]) -> Scene {
        let scene = Scene::new(experience.before.clone(), &experience.parameters, effect);
        let Some(key) = self.key else { return scene };
        let unchanged = of_kind(&experience.before, key) == of_kind(&experience.after, key);
        let there = || Recalled { observations: experience.before.clone(), age: 0 };
        let recalled = if unchanged { Some(there()) } else { experience.recalled.clone() };
        scene.recalling(recalled, key)
    }

    /// Notes which example comes next, and what came with it.
    pub(super) fn note(&mut self, experience: &Experience) {
        let (at, primitive) = (self.examples.len(), experience.primitive);
        self.of_primitive.entry(primitive).or_default().insert(at);
        let alike = self.alike.entry(primitive).or_default();
        alike.entry(experience.before.clone()).or_default().push(at);
        if primitive == ANYTHING {
            return;
        }
        // What comes with a crowd that is new is not what the primitive brings about.
        let new = |o: &&Observation| experience.before.binary_search(o).is_err();
        let after = || experience.after.iter().filter(|o| !self.values.has(o.kind()));
        if after().filter(new).take(BROUGHT_MAX + 1).count() <= BROUGHT_MAX {
            let brought = self.brought.entry(primitive).or_default();
            for observation in after() {
                *self.came.entry(observation.clone()).or_default() += 1;
                let (times, was_new) = brought.entry(observation.clone()).or_default();
                *times += 1;
                *was_new |= new(&observation);
            }
        }
    }

    fn learn(&mut self, experience: Arc<Experience>) {
        let primitive = experience.primitive;
        let particular = primitive != ANYTHING;
        self.score(&experience);
        let at = self.examples.len();
        self.note(&experience);
        let scene = self.scene(&experience, self.effect(primitive));
        self.examples.push((experience, scene));
        let renamed = particular && self.update_effect(primitive);
        let others: Vec<_> = self.doubtful.iter().copied().filter(|other| *other != primitive).collect();
        let others = others.into_iter().take(DOUBTS_MAX).filter(|other| self.update_effect(*other));
        let others: Vec<_> = others.collect();
        if !renamed {
            self.enter(at);
        }
        self.conditions.put_in_order();
        self.add_facets(at);
        let mut time = Time::new();
        // Each facet is the first in its turn.
        let count = self.facets.len();
        for number in (0..count).map(|number| (number + at) % count) {
            let mut facet = std::mem::take(&mut self.facets[number]);
            let examples = self.examples();
            if facet.is_singly {
                self.facets[number] = facet;
                continue;
            }
            if facet.general.examples <= at {
                facet.count(examples, at, particular);
                facet.seek(examples, primitive, &mut time);
            }
            let anew = others.iter().chain(renamed.then_some(&primitive));
            anew.for_each(|primitive| facet.rename(examples, *primitive));
            self.facets[number] = facet;
        }
        let anew: Vec<_> = others.iter().copied().chain(renamed.then_some(primitive)).collect();
        self.learn_values(at, primitive, &anew);
        self.learn_singly(at, &mut time);
        self.part_facets();
        self.join_facets();
        // What was joined with others is told with them.
        let facets = &self.facets;
        self.trials.retain(|kind, _| facets.iter().any(|facet| facet.kinds == [*kind]));
        let count = self.examples.len();
        if count >= EACH_MIN && (count.is_power_of_two() || count.is_multiple_of(EACH_AGAIN)) {
            self.try_singly();
        }
        // Where a quarter may be added, as after forgetting one, all is found anew: so what is known follows from what is kept.
        let room = room(self.of_primitive.len());
        if self.examples.len() == room - room / 4 {
            let all = std::mem::take(&mut self.examples);
            self.settle(all.into_iter().map(|(experience, _)| experience).collect());
        }
    }

    /// Parts a type that changes by itself from those that it was joined with.
    fn part_facets(&mut self) {
        for number in 0..self.facets.len() {
            let (facet, examples) = (&self.facets[number], self.examples());
            if facet.is_singly || facet.general.examples != self.examples.len() {
                continue;
            }
            let Some(stranger) = facet.stranger() else { continue };
            let rest = facet.kinds.iter().copied().filter(|kind| *kind != stranger).collect();
            let (rest, alone) = (Facet::new(rest, examples), Facet::new(vec![stranger], examples));
            self.facets[number] = rest;
            self.facets.push(alone);
        }
    }

    /// Takes the newest example in where observations are told one by one, or that is tried.
    fn learn_singly(&mut self, at: usize, time: &mut Time) {
        let (mut singly, mut trials) = (std::mem::take(&mut self.singly), std::mem::take(&mut self.trials));
        trials.retain(|_, trial| trial.each.learn(self.examples(), at, time));
        singly.retain(|_, each| each.learn(self.examples(), at, time));
        // What has become a crowd is told together again.
        for number in 0..self.facets.len() {
            let facet = &self.facets[number];
            if facet.is_singly && !facet.kinds.iter().any(|kind| singly.contains_key(kind)) {
                self.facets[number] = Facet::new(facet.kinds.clone(), self.examples());
            }
        }
        (self.singly, self.trials) = (singly, trials);
    }

    /// The claims about each observation of the type of a facet, if each is told by itself.
    pub(super) fn each_of(&self, facet: &Facet) -> Option<&Each> {
        if facet.is_singly { self.singly.get(facet.kinds.first()?) } else { None }
    }

    /// Tells the observations of these types one by one.
    fn tell_singly(&mut self, kinds: &[TypeId]) {
        for number in 0..self.facets.len() {
            let &[kind] = &self.facets[number].kinds[..] else { continue };
            let each = kinds.contains(&kind).then(|| Each::new(kind, self.examples(), 0)).flatten();
            if let Some(each) = each {
                self.facets[number] = Facet::singly(kind, &self.examples);
                self.singly.insert(kind, each);
            }
        }
    }

    /// Tries to tell the observations of a type one by one where the claims about all of them leave much open.
    fn try_singly(&mut self) {
        for number in 0..self.facets.len() {
            let (facet, examples) = (&self.facets[number], self.examples());
            let &[kind] = &facet.kinds[..] else { continue };
            let several = |(e, _): &&(Arc<Experience>, Scene)| of_kind(&e.before, kind).len() > 1;
            if facet.is_open()
                && examples.all.iter().filter(several).count() * EACH_SHARE > examples.all.len()
            {
                let each = Each::new(kind, examples, 0);
                self.trials.extend(each.map(|each| (kind, Trial::new(each))));
            }
        }
    }

    pub(super) fn examples(&self) -> Examples<'_> {
        let Self { examples, conditions, of_primitive, alike, key, .. } = self;
        Examples { all: examples, conditions, of_primitive, alike: Some(alike), key: *key }
    }

    pub(super) fn effect(&self, primitive: PrimitiveId) -> &[Observation] {
        self.effects.get(&primitive).map_or(&[], Vec::as_slice)
    }

    /// Enters the example `at` in all columns; conditions are to be put in order before claims are sought.
    fn enter(&mut self, at: usize) {
        let twin = self.examples().twin(at, |_| true);
        let examples = &self.examples;
        self.conditions.enter(at, twin, |at| &examples[at].1);
        let mut facets = std::mem::take(&mut self.facets);
        facets.iter_mut().filter(|facet| !facet.is_singly).for_each(|facet| facet.enter(self.examples(), at));
        self.facets = facets;
        self.enter_values(at);
    }

    /// What a primitive brings about of itself, by its experiences.
    fn own_effect(&self, primitive: PrimitiveId) -> Vec<Observation> {
        let Some(tries) = self.of_primitive.get(&primitive).map(Column::count) else { return Vec::new() };
        let Some(came) = self.brought.get(&primitive) else { return Vec::new() };
        let others = self.examples.len() - tries;
        let price = libm::log(came.values().filter(|(_, new)| *new).count() as f64);
        let own = |observation: &Observation, times: usize| {
            let elsewhere = self.came.get(observation).copied().unwrap_or(0) - times;
            let anyway = (elsewhere as f64 + 0.5) / (others as f64 + 1.0);
            times * EFFECT_SHARE.1 >= tries * EFFECT_SHARE.0 && differs(times, tries, anyway) > price
        };
        let effect = came.iter().filter(|(observation, (times, new))| *new && own(observation, *times));
        effect.map(|(observation, _)| observation.clone()).collect()
    }

    /// Looks again at what a primitive brings about of itself; Then they are named and entered anew.
    fn update_effect(&mut self, primitive: PrimitiveId) -> bool {
        let Some(column) = self.of_primitive.get(&primitive) else { return false };
        let tries = column.count();
        // What comes about in about as many cases as it must is not named anew each time that it does or does not.
        let changed = self.changed.get(&primitive).copied().unwrap_or(0);
        if tries < changed + changed / EFFECT_CHANGES {
            return false;
        }
        let effect = self.own_effect(primitive);
        if effect.is_empty() && tries == 1 {
            self.doubtful.insert(primitive);
        } else {
            self.doubtful.remove(&primitive);
        }
        if self.effect(primitive) == effect {
            return false;
        }
        let renamed: Vec<_> = column.iter().collect();
        self.effects.insert(primitive, effect.clone());
        self.changed.insert(primitive, tries);
        for at in renamed {
            let anew = self.examples.get(at).map(|(experience, _)| self.scene(experience, &effect));
            if let Some(((_, scene), anew)) = self.examples.get_mut(at).zip(anew) {
                *scene = anew;
            }
            self.enter(at);
        }
        true
    }

    /// A facet of its own for each type that is met for the first time.
    fn add_facets(&mut self, at: usize) {
        let Some((experience, _)) = self.examples.get(at) else { return };
        let mut kinds: Vec<_> =
            experience.before.iter().chain(experience.after.iter()).map(Observation::kind).collect();
        kinds.sort_unstable();
        kinds.dedup();
        // What can't be sensed may be asked for, and comes of nothing that is done.
        kinds.retain(|kind| experience.sensed.contains(kind));
        // An end is of no action: one that is kept with an action, as it once was, tells nothing.
        if experience.is_end() {
            kinds = if experience.primitive == ANYTHING { vec![TypeId::ENDED] } else { Vec::new() };
        }
        kinds.retain(|kind| !self.facets.iter().any(|facet| facet.kinds.contains(kind)));
        kinds.retain(|kind| !self.values.has(*kind));
        for kind in kinds {
            let facet = Facet::new(vec![kind], self.examples());
            self.facets.push(facet);
        }
        self.add_values(at);
    }

    /// Joins two facets that depend on each other, if there are any.
    fn join_facets(&mut self) {
        while self.join_two() {}
    }

    fn join_two(&mut self) -> bool {
        let grown = |facet: &Facet| facet.general.examples == self.examples.len();
        let count = self.facets.len();
        let examples = self.examples();
        // Of many pairs some seem to depend on each other by accident.
        let price = libm::log((count * count.saturating_sub(1) / 2).max(1) as f64);
        for one in 0..count {
            for other in one + 1..count {
                let (a, b) = (&self.facets[one], &self.facets[other]);
                if (grown(a) || grown(b)) && a.varies() && b.varies() && a.dependence(b) > price + CERTAIN {
                    let mut kinds = [&a.kinds[..], &b.kinds[..]].concat();
                    kinds.sort_unstable();
                    let joined = Facet::new(kinds, examples);
                    self.facets.remove(other);
                    self.facets[one] = joined;
                    return true;
                }
            }
        }
        false
    }

    /// How much what is new surprises, in the facet of which most may be learnt; from 0 to 1, and 1 of what nothing is known of.
    pub(super) fn surprise(&self) -> f64 {
        self.facets.iter().map(|facet| facet.surprise.of_new()).fold(0.0, f64::max)
    }

    /// A context as it was met.
    pub(super) fn novelty(&self, context: &[Observation]) -> Novelty<'_> {
        Novelty::new(&self.conditions, context)
    }

    /// How often it is left open what comes of these types, at most, with all that claims tell; from 0 to 1.
    pub(super) fn open(&self, is_asked: impl Fn(&TypeId) -> bool) -> f64 {
        let asked = self.facets.iter().filter(|facet| !facet.is_singly && facet.kinds.iter().any(&is_asked));
        let open = |facet: &Facet| facet.general.left_open() as f64 / facet.sensed.count().max(1) as f64;
        asked.map(open).fold(0.0, f64::max).min(1.0)
    }

    /// How new a primitive is there, from 0 to 1, where what comes is left so `open`; or was, if what was tried there counts `already`.
    pub(super) fn newness(
        &self,
        novelty: &Novelty<'_>,
        primitive: PrimitiveId,
        open: f64,
        already: bool,
    ) -> f64 {
        self.of_primitive.get(&primitive).map_or(1.0, |tried| novelty.of(tried, open, already))
    }

    /// The same, where the context counts as a whole too, in which it was `met`: pairs of observations that are all familiar may be together
    /// for the first time, which counts for less.
    pub(super) fn newness_of_all(
        &self,
        novelty: &Novelty<'_>,
        primitive: PrimitiveId,
        met: &Column,
        open: f64,
        already: bool,
    ) -> f64 {
        let whole = newness(met.count().saturating_sub(usize::from(already)), open);
        self.newness(novelty, primitive, open, already).max(WHOLE * whole)
    }

    /// The experiences with a primitive in all of a context together, but for the observations that `matter` not.
    pub(super) fn together(
        &self,
        novelty: &Novelty<'_>,
        primitive: PrimitiveId,
        matter: impl Fn(usize) -> bool,
    ) -> Column {
        let tried = self.of_primitive.get(&primitive);
        tried.map_or_else(Column::default, |tried| novelty.together(tried, matter))
    }

    /// The share of a context in which the primitive was never carried out.
    pub(super) fn unmet(&self, novelty: &Novelty<'_>, primitive: PrimitiveId) -> f64 {
        self.of_primitive.get(&primitive).map_or(1.0, |tried| novelty.unmet(tried))
    }

    /// Forgets a quarter of all experiences, always the oldest of what was tried most often in the same context where least is lost with it;
    /// the newest of each primitive stays. So what was seldom met is not forgotten for what is met all the time. What is known then is what
    /// the rest makes, one after another.
    fn make_room(&mut self) {
        let mut cells: BTreeMap<Vec<Vec<usize>>, Cell> = BTreeMap::new();
        let mut newest: BTreeSet<_> =
            self.of_primitive.values().filter_map(|column| column.iter().last()).collect();
        newest.extend(self.newest_ends());
        for (at, (experience, scene)) in self.examples.iter().enumerate() {
            if newest.contains(&at) {
                continue;
            }
            let paths = self.facets.iter().map(|facet| path(&facet.general.claim, scene).0);
            let cell = cells.entry(paths.collect()).or_default();
            cell.count += 1;
            cell.tried.entry((experience.primitive, experience.before.clone())).or_default().push_back(at);
        }
        let mut forgotten = Column::default();
        for _ in 0..self.examples.len() / 4 {
            let least = cells.values_mut().min_by(|one, other| one.loss().total_cmp(&other.loss()));
            let Some(oldest) = least.and_then(Cell::pop) else { break };
            forgotten.insert(oldest);
        }
        let kept = std::mem::take(&mut self.examples).into_iter().enumerate();
        let kept = kept.filter(|(at, _)| !forgotten.contains(*at)).map(|(_, (experience, _))| experience);
        self.settle(kept.collect());
    }

    /// All that is known is found anew from these experiences together: own effects first, then scenes, facets, claims, and how well
    /// each view would have foretold each of them from the others.
    fn settle(&mut self, experiences: Vec<Arc<Experience>>) {
        let singly: Vec<_> = self.singly.keys().copied().collect();
        *self = Self { key: self.key, values: Values::of(self.values.kinds()), ..Self::default() };
        let particular = experiences.first().is_some_and(|experience| experience.primitive != ANYTHING);
        for experience in experiences {
            self.note(&experience);
            let scene = Scene::new(experience.before.clone(), &experience.parameters, &[]);
            self.examples.push((experience, scene));
        }
        if particular {
            for primitive in self.of_primitive.keys().copied().collect::<Vec<_>>() {
                let effect = self.own_effect(primitive);
                self.effects.insert(primitive, effect);
                let tries = self.of_primitive.get(&primitive).map_or(0, Column::count);
                self.changed.insert(primitive, tries);
            }
        }
        let examples = std::mem::take(&mut self.examples).into_iter();
        self.examples = examples
            .map(|(experience, _)| {
                let scene = self.scene(&experience, self.effect(experience.primitive));
                (experience, scene)
            })
            .collect();
        (0..self.examples.len()).for_each(|at| self.enter(at));
        self.conditions.put_in_order();
        (0..self.examples.len()).for_each(|at| self.add_facets(at));
        self.part_facets();
        self.tell_singly(&singly);
        self.join_facets();
        self.score_anew();
    }

    /// The claims about a facet: those about a primitive alone, or those about the action.
    pub(super) fn claim<'a>(&'a self, facet: &'a Facet, primitive: Option<PrimitiveId>) -> Option<&'a Claim> {
        match (self.each_of(facet), primitive) {
            (Some(each), _) => each.claim(primitive),
            (None, Some(primitive)) => facet.particular.get(&primitive).map(|grown| &grown.claim),
            (None, None) => Some(&facet.general.claim),
        }
    }

    /// The claims about each facet: those about a primitive alone, or those about the action.
    pub(super) fn claims(&self, primitive: Option<PrimitiveId>) -> impl Iterator<Item = (&[TypeId], &Claim)> {
        let facets = self.all_facets();
        facets.filter_map(move |facet| Some((&facet.kinds[..], self.claim(facet, primitive)?)))
    }

    /// Of each facet that an experience tells of, the general claim that was in force in it and which of its outcomes came.
    pub(super) fn in_force(&self, experience: &Experience) -> Vec<InForce<'_>> {
        let effect = self.effect(experience.primitive);
        let scene = self.scene(experience, effect);
        let together = self.facets.iter().filter(|facet| !facet.is_singly);
        let told = together.filter(|facet| facet.is_told_by(experience));
        told.map(|facet| {
            let after = facet.after(experience);
            let (place, claim) = path(&facet.general.claim, &scene);
            let came = claim.outcomes.iter().find(|(change, _)| scene.makes(change, &after, &facet.kinds));
            InForce { kinds: &facet.kinds, claim: place, came: came.map(|(change, _)| change) }
        })
        .collect()
    }

    /// Whether a claim asks for an observation of this type.
    pub(super) fn asks_for(&self, kind: TypeId) -> bool {
        let asks = |claim: &Claim| {
            let mut conditions = claim.all().filter_map(|claim| claim.condition.as_ref());
            conditions.any(|condition| condition.kinds().any(|asked| asked == kind))
        };
        self.facets.iter().any(|facet| {
            self.each_of(facet).is_some_and(|each| each.all().any(asks))
                || asks(&facet.general.claim)
                || facet.particular.values().any(|grown| asks(&grown.claim))
        })
    }

    /// The experiences that are kept, in order.
    pub(super) fn experiences(&self) -> impl Iterator<Item = &Experience> {
        self.examples.iter().map(|(experience, _)| &**experience)
    }

    /// Whether no claims are kept of any one primitive.
    #[cfg(test)]
    pub(super) fn is_background(&self) -> bool {
        self.facets.iter().all(|facet| facet.particular.is_empty())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A claim with one context kept many experiences of it, while a general claim kept one or two of each of its many.
    #[test]
    fn what_was_tried_often_in_one_context_makes_room_first() {
        let cell = |contexts: u32, each: usize| {
            let primitive = |number| (PrimitiveId(number), Arc::<[Observation]>::from([]));
            let tried = (0..contexts).map(|number| (primitive(number), (0..each).collect()));
            Cell { tried: tried.collect(), count: contexts as usize * each }
        };
        assert!(cell(1, 30).loss() < cell(15, 2).loss(), "as many of both claims");
        assert!(cell(50, 1).loss() < cell(5, 1).loss(), "where no context came again, claims with many");
        assert!(!cell(0, 0).loss().is_finite(), "nothing is taken where nothing is");
    }

    #[test]
    fn it_is_as_open_as_everywhere_until_more_is_known() {
        let came = |counts: &[u32]| -> Vec<_> { counts.iter().map(|count| (Vec::new(), *count)).collect() };
        assert_eq!(open_there(&came(&[]), 0.5), 0.5);
        assert_eq!(open_there(&came(&[9]), 0.5), 0.05);
        assert_eq!(open_there(&came(&[2, 1]), 0.0), 0.25);
    }
}
