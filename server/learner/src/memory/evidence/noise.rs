//! Types that make noise: nobody can say what becomes of them, and nothing depends on them.

use std::collections::{BTreeMap, BTreeSet};

use crate::memory::evidence::facet::Facet;
use crate::memory::evidence::novelty::KNOWN;
use crate::memory::evidence::pool::Pool;
use crate::memory::evidence::{Evidence, action};
use crate::nouns::claim::Claim;
use crate::nouns::observation::TypeId;
use crate::nouns::vocabulary::{PrimitiveId, Vocabulary};

/// Less than one in so many that are not foretold is no noise, though it may be what matters: what seldom happens is seldom foretold.
const OPEN: usize = 3;
/// There must be so many times as many experiences as different outcomes: by then some contexts were met again, and it would show if they
/// told what comes.
const TIMES: f64 = 1.25;
/// What is told no better than this part of what is unknown of it, is not told.
const UNTOLD: f64 = 0.9;
/// The same of what is told with hindsight, which is always a little better.
const UNTOLD_IN_HINDSIGHT: f64 = 0.75;

/// So often came this of so many: what that adds to ln of the probability of all.
fn part(count: u32, all: f64) -> f64 {
    if count == 0 { 0.0 } else { f64::from(count) * libm::log(f64::from(count) / all) }
}

/// ln of the probability of all that came by the shares that a claim and its exceptions have seen, where there are so many different outcomes.
fn claimed(claim: &Claim, outcomes: usize) -> f64 {
    let of = |claim: &Claim| {
        let known: u32 = claim.outcomes.iter().map(|(_, count)| count).sum();
        let (all, others) = (f64::from(claim.trials), claim.trials.saturating_sub(known));
        let told: f64 = claim.outcomes.iter().map(|(_, count)| part(*count, all)).sum();
        // What follows no form may be any outcome.
        told + part(others, all) - f64::from(others) * libm::log(outcomes as f64)
    };
    claim.all().map(of).sum()
}

impl Pool {
    /// The type that a facet is about, if it is one, it often comes to something else, and claims tell no more of it than how often each outcome
    /// comes.
    fn noise_of(&self, facet: &Facet) -> Option<TypeId> {
        let &[kind] = &facet.kinds[..] else { return None };
        let all = facet.sensed.count();
        if facet.is_singly || all < KNOWN || facet.general.left_open() * OPEN < all {
            return None;
        }
        let came = facet.outcomes.counted(facet.sensed.iter());
        let usual = came.iter().map(|(_, count)| *count as usize).max().unwrap_or(0);
        let all_others = all.saturating_sub(usual);
        if all_others * OPEN < all || (all as f64) < came.len() as f64 * TIMES {
            return None;
        }
        let all = all as f64;
        let unknown: f64 = came.iter().map(|(_, count)| -part(*count, all)).sum();
        if -claimed(&facet.general.claim, came.len()) < UNTOLD_IN_HINDSIGHT * unknown {
            return None;
        }
        let (mut told, mut weight) = (0.0, 0.0);
        for (_, of, count) in self.told_in(facet) {
            (told, weight) = (told + of, weight + count);
        }
        let unknown = (unknown / all).min(-facet.of_nothing());
        (-told >= UNTOLD * unknown * weight).then_some(kind)
    }

    /// Takes the types away on which it depends what becomes of others.
    fn keep_noise(&self, primitives: &[PrimitiveId], noise: &mut BTreeSet<TypeId>) {
        for facet in self.facets.iter().filter(|facet| self.noise_of(facet).is_none()) {
            let ground = self.ground(facet, primitives);
            if ground.is_remembered {
                return noise.clear();
            }
            noise.retain(|kind| !ground.kinds().any(|asked| asked == *kind));
        }
    }
}

impl Evidence {
    /// The types that make noise: at least one action changes them, or they change by themselves, into what nobody foretells, and no claim
    /// about these primitives asks for them or names a value of theirs.
    pub(crate) fn noise(&self, vocabulary: &Vocabulary, primitives: &[PrimitiveId]) -> BTreeSet<TypeId> {
        let pools = self.pools.values();
        let found = pools.flat_map(|pool| pool.facets.iter().filter_map(|facet| pool.noise_of(facet)));
        let mut noise: BTreeSet<_> = found.collect();
        for (at, pool) in &self.pools {
            if noise.is_empty() {
                break;
            }
            let of_action =
                primitives.iter().filter(|primitive| action(vocabulary, **primitive) == Some(*at));
            pool.keep_noise(&of_action.copied().collect::<Vec<_>>(), &mut noise);
        }
        noise
    }

    /// How well it was foretold of late what primitives make of types that are `noise`: in the facet of which that is worst, the probability
    /// that what came was given, as a part of what it is with the primitive of which it is best. So noise that there is whatever is done
    /// counts against none.
    pub(crate) fn told_of_noise(&self, noise: &BTreeSet<TypeId>) -> BTreeMap<PrimitiveId, f64> {
        if noise.is_empty() {
            return BTreeMap::new();
        }
        let mut best: BTreeMap<&[TypeId], f64> = BTreeMap::new();
        let told: Vec<_> = self.pools.values().flat_map(|pool| pool.told_of_late(noise)).collect();
        for (kinds, _, told) in &told {
            let best = best.entry(kinds).or_insert(f64::NEG_INFINITY);
            *best = best.max(*told);
        }
        let mut least: BTreeMap<PrimitiveId, f64> = BTreeMap::new();
        for (kinds, primitive, told) in &told {
            let beside = told - best.get(kinds).copied().unwrap_or(0.0);
            let least = least.entry(*primitive).or_insert(0.0);
            *least = least.min(beside);
        }
        least.values_mut().for_each(|told| *told = libm::exp(*told));
        least
    }
}
