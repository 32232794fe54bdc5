//! What claims foretell to who looks ahead: of the types that matter alone, each outcome with its probability.

use std::collections::{BTreeMap, BTreeSet};

use crate::memory::evidence::columns::Column;
use crate::memory::evidence::facet::{ANYTHING, Facet};
use crate::memory::evidence::foretold::{Foretold, View};
use crate::memory::evidence::novelty::{Novelty, met};
use crate::memory::evidence::pool::{ALIKE_MAX, Pool, is_alike, open_there};
use crate::memory::evidence::prospect::{Foreseen, Outlook, Prospect};
use crate::memory::evidence::shares::{Share, odds, probability, shares};
use crate::memory::evidence::telling::relied;
use crate::memory::evidence::{Evidence, action};
use crate::nouns::claim::{Change, Claim, Condition, Sketch};
use crate::nouns::observation::{Observation, TypeId};
use crate::nouns::vocabulary::{BodyId, PrimitiveId, Vocabulary};

/// Joint outcomes of one action that are looked at: the most probable.
const OUTCOMES_MAX: usize = 32;

/// An outcome that is surer than this is all that is looked at.
const CLEAR: f64 = 0.98;

/// What comes of itself and is less certain than this is left to chance.
const SURE: f64 = 0.9;

/// What claims about a facet rest on.
pub(super) struct Ground<'a> {
    claims: Vec<&'a Claim>,
    /// Whether the memory of the very same context is relied on.
    pub(super) is_remembered: bool,
}

impl Ground<'_> {
    fn conditions(&self) -> impl Iterator<Item = &Condition> {
        self.claims.iter().flat_map(|claim| claim.all()).filter_map(|claim| claim.condition.as_ref())
    }

    fn changes(&self) -> impl Iterator<Item = &Change> {
        self.claims.iter().flat_map(|claim| claim.all()).flat_map(|claim| &claim.outcomes).map(|(c, _)| c)
    }

    /// The types of what the conditions ask for, and of what has the values that conditions and changes name.
    pub(super) fn kinds(&self) -> impl Iterator<Item = TypeId> {
        let named = self.changes().flat_map(Change::sketches).flat_map(Sketch::named_kinds);
        self.conditions().flat_map(Condition::kinds).chain(named)
    }

    fn recalls(&self) -> bool {
        self.conditions().any(Condition::rests_on_recall)
            || self.changes().flat_map(Change::sketches).any(Sketch::is_recalled)
    }

    /// The highest probability with which something comes about that was seen to come, where that may be a change.
    fn surest(&self) -> f64 {
        if self.is_remembered {
            return 1.0;
        }
        let changes =
            |claim: &&Claim| claim.outcomes.iter().any(|(change, _)| change.sketches().next().is_some());
        let seen = |claim: &Claim| -> f64 {
            let ways = claim.outcomes.len();
            claim.outcomes.iter().map(|(_, count)| probability(*count, claim.trials, ways)).sum()
        };
        self.claims.iter().flat_map(|claim| claim.all()).filter(changes).map(seen).fold(0.0, f64::max)
    }
}

impl Pool {
    pub(super) fn ground<'a>(&'a self, facet: &'a Facet, primitives: &[PrimitiveId]) -> Ground<'a> {
        let mut ground = Ground { claims: Vec::new(), is_remembered: false };
        ground.claims.extend(self.claim(facet, None));
        for primitive in primitives {
            let scores = facet.scores.get(primitive).copied().unwrap_or_default();
            match relied(scores, Some) {
                Some(View::Particular) => ground.claims.extend(self.claim(facet, Some(*primitive))),
                Some(View::Remembered) => ground.is_remembered |= !facet.is_singly,
                Some(View::General) | None => (),
            }
        }
        ground
    }
}

impl Evidence {
    /// The actions of these primitives that were ever carried out, each with those of it.
    fn pools<'a>(
        &'a self,
        vocabulary: &Vocabulary,
        primitives: &[PrimitiveId],
    ) -> Vec<(&'a Pool, Vec<PrimitiveId>)> {
        let of_action = |at: usize| {
            primitives.iter().copied().filter(move |primitive| action(vocabulary, *primitive) == Some(at))
        };
        self.pools.iter().map(|(at, pool)| (&**pool, of_action(*at).collect())).collect()
    }

    /// The types on which it depends what becomes of these types when these primitives are carried out, themselves included; none if it
    /// depends on all that is there.
    pub(crate) fn depends_on(
        &self,
        vocabulary: &Vocabulary,
        primitives: &[PrimitiveId],
        mut kinds: BTreeSet<TypeId>,
    ) -> Option<BTreeSet<TypeId>> {
        let pools = self.pools(vocabulary, primitives);
        loop {
            let before = kinds.len();
            for (pool, primitives) in &pools {
                for facet in pool.all_facets() {
                    if !facet.kinds.iter().any(|kind| kinds.contains(kind)) {
                        continue;
                    }
                    let ground = pool.ground(facet, primitives);
                    if ground.is_remembered {
                        return None;
                    }
                    kinds.extend(facet.kinds.iter().copied().chain(ground.kinds()));
                    kinds.extend(pool.key().filter(|_| ground.recalls()));
                }
            }
            if kinds.len() == before {
                return Some(kinds);
            }
        }
    }

    /// The types on which it depends whether an episode has ended; none if that depends on all that is there.
    pub(crate) fn ends_depend_on(&self) -> Option<BTreeSet<TypeId>> {
        let Some(facet) = self.background.of_ends() else { return Some(BTreeSet::new()) };
        let ground = self.background.ground(facet, &[ANYTHING]);
        // As long as no claim tells where they are, it may be anything.
        let is_told = !ground.is_remembered && ground.conditions().next().is_some();
        is_told.then(|| ground.kinds().filter(|kind| *kind != TypeId::ENDED).collect())
    }

    /// Whether any action was carried out where this was, among the experiences that are kept.
    pub(crate) fn is_met(&self, observation: &Observation) -> bool {
        let pools = self.pools.values().chain([&self.background]);
        pools.into_iter().any(|pool| met(&pool.conditions, observation).is_some_and(|met| !met.is_empty()))
    }

    /// At most so probable is it, whatever the context, that one of these primitives makes of these types what is wanted, repeated as often
    /// as it takes.
    pub(crate) fn surest(
        &self,
        vocabulary: &Vocabulary,
        primitives: &[PrimitiveId],
        kinds: &BTreeSet<TypeId>,
    ) -> f64 {
        let pools = self.pools(vocabulary, primitives).into_iter();
        let of_pool = |(pool, primitives): (&Pool, Vec<PrimitiveId>)| {
            let facets = pool.all_facets().filter(|f| f.kinds.iter().any(|kind| kinds.contains(kind)));
            let surest = facets
                .map(|facet| if facet.is_singly { 1.0 } else { pool.ground(facet, &primitives).surest() });
            surest.fold(0.0, f64::max)
        };
        pools.map(of_pool).fold(0.0, f64::max)
    }

    /// What each of a body's primitives makes of a context of lasting observations in canonical order: of the types `kinds`, and of those
    /// that change with them. The goal speaks of the types `goal`. What is foretold of different types is taken as independent. What was
    /// `foreseen` of that context before is found anew only where more is known by now.
    pub(super) fn outlook(
        &self,
        vocabulary: &Vocabulary,
        (body, primitives): (BodyId, &[PrimitiveId]),
        context: &[Observation],
        (kinds, goal): (&BTreeSet<TypeId>, &BTreeSet<TypeId>),
        foreseen: &mut Vec<Foreseen>,
    ) -> Outlook {
        let wanted = |of_facet: &[TypeId]| of_facet.iter().any(|kind| kinds.contains(kind));
        foreseen.resize_with(primitives.len(), Foreseen::default);
        for (primitive, foreseen) in primitives.iter().zip(&mut *foreseen) {
            let pool = action(vocabulary, *primitive).and_then(|action| self.pools.get(&action));
            if !foreseen.is_of(pool) {
                let foretold = self.foretell_of(vocabulary, Some(body), *primitive, context, &wanted);
                *foreseen = Foreseen::new(pool, foretold);
            }
        }
        let chance = self.chance(context, foreseen, goal);
        let steady: BTreeSet<_> = kinds.iter().filter(|kind| !chance.contains(kind)).copied().collect();
        let plain: Vec<_> = context.iter().filter(|o| steady.contains(&o.kind())).cloned().collect();
        let around = Around { context, chance: &chance, steady: &steady, plain: &plain };
        let mut novelties = BTreeMap::new();
        let prospects = primitives.iter().zip(foreseen).map(|(primitive, foreseen)| {
            let action = action(vocabulary, *primitive);
            let pool = action.and_then(|action| self.pools.get(&action));
            foreseen.prospect(&chance, |foretold| match pool {
                None => around.unknown(),
                Some(pool) => {
                    let novelty = novelties.entry(action).or_insert_with(|| pool.novelty(&plain));
                    around.prospect(pool, novelty, *primitive, foretold)
                }
            })
        });
        let prospects = prospects.collect();
        Outlook { prospects, ending: self.ending(context, Some(&steady)), chance }
    }

    /// The types of which no action is the cause in a context, and nobody can say what becomes of them.
    fn chance(&self, context: &[Observation], foreseen: &[Foreseen], goal: &BTreeSet<TypeId>) -> Vec<TypeId> {
        let all = || foreseen.iter().map(|foreseen| &foreseen.foretold);
        let is_open = |facet: &&Foretold| {
            let most = facet.outcomes.first().map_or(0, |(_, count)| *count);
            probability(most, facet.trials, facet.outcomes.len()) < SURE
                && !facet.kinds.iter().any(|kind| goal.contains(kind))
        };
        let open = all().flat_map(|facets| facets.iter()).filter(is_open);
        let open: BTreeSet<_> = open.flat_map(|facet| &facet.kinds).collect();
        if open.is_empty() {
            return Vec::new();
        }
        let anyway = self.background.foretell(ANYTHING, &[], context, &|_| None, &|_| true);
        let is_caused = |kind: &TypeId| {
            all().any(|facets| {
                let mut of_kind = facets.iter().filter(|facet| facet.kinds.contains(kind));
                of_kind.any(|facet| facet.is_attributed(&anyway, facets.len()))
            })
        };
        open.into_iter().copied().filter(|kind| !is_caused(kind)).collect()
    }
}

/// A context that is looked ahead from.
struct Around<'a> {
    context: &'a [Observation],
    /// The types that are left to chance.
    chance: &'a [TypeId],
    /// Those that are looked at, but for these.
    steady: &'a BTreeSet<TypeId>,
    /// The observations of these.
    plain: &'a [Observation],
}

impl Around<'_> {
    /// Of a primitive whose action was never carried out: everything may be learnt.
    fn unknown(&self) -> Prospect {
        Prospect { outcomes: vec![(self.context.to_vec(), 1.0)], open: 0.0, learnable: 1.0 }
    }

    /// Of a primitive, of which this is foretold here.
    fn prospect(
        &self,
        pool: &Pool,
        novelty: &Novelty<'_>,
        primitive: PrimitiveId,
        foretold: &[Foretold],
    ) -> Prospect {
        let Self { context, chance, steady, plain } = *self;
        let met = pool.together(novelty, primitive, |_| true);
        let unmet = pool.unmet(novelty, primitive);
        let is_told = |facet: &&Foretold| !facet.kinds.iter().any(|kind| chance.contains(kind));
        let of_facet = |facet: &Foretold| pool.all_facets().find(|known| known.kinds == facet.kinds);
        let told = || foretold.iter().filter(is_told);
        let trust = |facet: &Foretold| Some(1.0 - of_facet(facet)?.surprise.of_new() * unmet);
        let trusted: f64 = told().filter_map(trust).product();
        let alike = |facet: &Foretold| {
            let known = of_facet(facet).filter(|_| facet.view != View::Remembered);
            known.map_or_else(Vec::new, |known| pool.alike_in(known, &met, plain, steady))
        };
        let everywhere = pool.open(|kind| steady.contains(kind));
        let (mut weighed, mut open) = (Vec::new(), 0.0_f64);
        for facet in told() {
            let alike = alike(facet);
            let came = if facet.view == View::Remembered { &facet.outcomes } else { &alike };
            open = open.max(open_there(came, everywhere));
            weighed.push((facet, shares(facet, alike)));
        }
        let learnable = pool.surprise() * pool.newness_of_all(novelty, primitive, &met, open, false);
        let mut outcomes = together(context, &weighed, trusted);
        // Most are foretold for certain, and nothing can be added.
        if outcomes.len() > 1 && outcomes.first().is_some_and(|(_, share)| *share < CLEAR) {
            let told: BTreeSet<_> = told().flat_map(|facet| &facet.kinds).copied().collect();
            recall_together(&mut outcomes, &self.came_together(pool, &met, &told));
        }
        Prospect { outcomes, open: 1.0 - trusted, learnable }
    }

    /// What came of this very context as a whole, of those types that are told, each with how often; among the experiences `met`.
    fn came_together(
        &self,
        pool: &Pool,
        met: &Column,
        told: &BTreeSet<TypeId>,
    ) -> Vec<(Vec<Observation>, u32)> {
        let stays = || self.context.iter().filter(|o| !told.contains(&o.kind()));
        let mut came: Vec<(Vec<Observation>, u32)> = Vec::new();
        for (experience, _) in met.iter().take(ALIKE_MAX).filter_map(|at| pool.examples.get(at)) {
            if !is_alike(experience, self.plain, self.steady) {
                continue;
            }
            let after = experience.after.iter().filter(|o| told.contains(&o.kind()));
            let mut after: Vec<_> = stays().chain(after).cloned().collect();
            after.sort_unstable();
            match came.iter_mut().find(|(known, _)| *known == after) {
                Some((_, count)) => *count += 1,
                None => came.push((after, 1)),
            }
        }
        came
    }
}

/// Weighs what is foretold of a context, each type by itself, with what came of it as a whole, as [`shares`] does for one facet: so what never
/// came together is not expected for ever.
fn recall_together(outcomes: &mut Vec<Share>, came: &[(Vec<Observation>, u32)]) {
    if came.is_empty() {
        return;
    }
    outcomes.iter_mut().for_each(|(after, _)| after.sort_unstable());
    let rest = 1.0 - outcomes.iter().map(|(_, share)| share).sum::<f64>();
    let untold = rest.max(1.0 - SURE) / (OUTCOMES_MAX + 1) as f64;
    let (by_claim, by_itself) = odds(outcomes, untold, came);
    let itself = 1.0 / (1.0 + libm::exp(by_claim - by_itself));
    let all = f64::from(came.iter().map(|(_, count)| count).sum::<u32>()) + 1.0;
    outcomes.iter_mut().for_each(|(_, share)| *share *= 1.0 - itself + itself / all);
    for (after, count) in came {
        let share = itself * f64::from(*count) / all;
        match outcomes.iter_mut().find(|(known, _)| known == after) {
            Some((_, known)) => *known += share,
            None => outcomes.push((after.clone(), share)),
        }
    }
    outcomes.sort_by(|a, b| b.1.total_cmp(&a.1));
}

/// What comes of a context when all of this is foretold of it, and is to be trusted so much.
fn together(context: &[Observation], foretold: &[(&Foretold, Vec<Share>)], trusted: f64) -> Vec<Share> {
    let told = |kind: TypeId| foretold.iter().any(|(facet, _)| facet.kinds.binary_search(&kind).is_ok());
    let stays: Vec<_> = context.iter().filter(|o| !told(o.kind())).cloned().collect();
    let mut outcomes = vec![(stays, trusted)];
    for (_, shares) in foretold {
        let mut split: Vec<Share> = Vec::with_capacity(outcomes.len() * shares.len());
        for (before, likely) in &outcomes {
            for (after, share) in shares {
                let both: Vec<_> = before.iter().chain(after).cloned().collect();
                split.push((both, likely * share));
            }
        }
        split.sort_by(|a, b| b.1.total_cmp(&a.1));
        split.truncate(OUTCOMES_MAX);
        outcomes = split;
    }
    outcomes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Types that are foretold one by one make combinations that never come; they fade with what does come.
    #[test]
    fn what_never_came_together_fades_and_nothing_is_lost() {
        let combination = |number: u16| vec![Observation::new(TypeId(number), [])];
        let share = |outcomes: &[Share], number: u16| {
            outcomes.iter().find(|(known, _)| *known == combination(number)).map_or(0.0, |(_, share)| *share)
        };
        for times in [1, 4, 16, 64] {
            let mut outcomes: Vec<Share> =
                vec![(combination(0), 0.4), (combination(1), 0.4), (combination(2), 0.2)];
            recall_together(&mut outcomes, &[(combination(2), times)]);
            let all: f64 = outcomes.iter().map(|(_, share)| share).sum();
            assert!((all - 1.0).abs() < 1e-9, "{times}: {all}");
            assert!(share(&outcomes, 2) >= f64::from(times) / f64::from(times + 2), "{times}: {outcomes:?}");
            assert!(outcomes.is_sorted_by(|a, b| a.1 >= b.1), "{times}: {outcomes:?}");
        }
        let mut outcomes = vec![(combination(0), 1.0)];
        recall_together(&mut outcomes, &[]);
        assert_eq!(outcomes, [(combination(0), 1.0)]);
    }
}
