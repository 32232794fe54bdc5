//! Types that make noise: nobody can say what becomes of them, and nothing depends on them.

use std::collections::{BTreeMap, BTreeSet};

use crate::memory::evidence::facet::Facet;
use crate::memory::evidence::novelty::KNOWN;
use crate::memory::evidence::pool::Pool;
use crate::memory::evidence::shares::probability;
use crate::memory::evidence::{Evidence, action};
use crate::nouns::claim::Claim;
use crate::nouns::observation::TypeId;
use crate::nouns::vocabulary::{PrimitiveId, Vocabulary};

/// What is foretold more often than this is no noise, though it may be what matters: what seldom happens is seldom foretold.
const OFTEN: f64 = 2.0 / 3.0;
/// There must be so many times as many experiences as different outcomes: by then some contexts were met again, and it would show if they
/// told what comes.
const TIMES: f64 = 1.25;
/// What is told no better than this part of what is unknown of it, is not told.
const UNTOLD: f64 = 0.9;
/// The same of what is told with hindsight, which is always a little better.
const UNTOLD_BEFORE: f64 = 0.75;

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
    /// The type that a facet is about, if it is one of which claims tell no more than how often each outcome comes, and that is open.
    fn noise(&self, facet: &Facet) -> Option<TypeId> {
        let &[kind] = &facet.kinds[..] else { return None };
        let claim = &facet.general.claim;
        let most = claim.all().flat_map(|claim| claim.outcomes.first()).map(|(_, count)| *count).sum();
        let trials = claim.all().map(|claim| claim.trials).sum();
        let is_open = probability(most, trials, claim.outcomes.len()) < OFTEN;
        if facet.is_singly || !is_open || (trials as usize) < KNOWN {
            return None;
        }
        let came = facet.outcomes.counted(facet.sensed.iter());
        if f64::from(trials) < came.len() as f64 * TIMES {
            return None;
        }
        let all: f64 = came.iter().map(|(_, count)| f64::from(*count)).sum();
        let unknown: f64 = came.iter().map(|(_, count)| -part(*count, all)).sum();
        if -claimed(claim, came.len()) < UNTOLD_BEFORE * unknown {
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
    fn keep_idle(&self, primitives: &[PrimitiveId], idle: &mut BTreeSet<TypeId>) {
        for facet in self.facets.iter().filter(|facet| self.noise(facet).is_none()) {
            let ground = self.ground(facet, primitives);
            if ground.is_remembered {
                return idle.clear();
            }
            idle.retain(|kind| !ground.kinds().any(|asked| asked == *kind));
        }
    }
}

impl Evidence {
    /// The types that make noise: at least one action changes them, or they change by themselves, into what nobody foretells, and no claim
    /// about these primitives asks for them or names a value of theirs.
    pub(crate) fn idle(&self, vocabulary: &Vocabulary, primitives: &[PrimitiveId]) -> BTreeSet<TypeId> {
        let pools = self.pools.values();
        let noise = pools.flat_map(|pool| pool.facets.iter().filter_map(|facet| pool.noise(facet)));
        let mut idle: BTreeSet<_> = noise.collect();
        for (at, pool) in &self.pools {
            if idle.is_empty() {
                break;
            }
            let of_action =
                primitives.iter().filter(|primitive| action(vocabulary, **primitive) == Some(*at));
            pool.keep_idle(&of_action.copied().collect::<Vec<_>>(), &mut idle);
        }
        idle
    }

    /// How well it was foretold of late what these primitives make of `idle` types: in the facet of which that is worst, the probability that
    /// what came was given, as a part of what it is with the action of which it is best. So noise that there is whatever is done counts
    /// against none.
    pub(crate) fn told_of_noise(&self, primitives: &[PrimitiveId], idle: &BTreeSet<TypeId>) -> Vec<f64> {
        if idle.is_empty() {
            return vec![1.0; primitives.len()];
        }
        let mut best: BTreeMap<&[TypeId], f64> = BTreeMap::new();
        let told: Vec<_> = self.pools.values().flat_map(|pool| pool.told_of_late(idle)).collect();
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
        primitives.iter().map(|primitive| libm::exp(least.get(primitive).copied().unwrap_or(0.0))).collect()
    }
}
