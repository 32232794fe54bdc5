//! What was found of experiences, to be written down and put back: growing it again takes as long as it took to find it.

use std::sync::Arc;

use crate::memory::evidence::columns::Column;
use crate::memory::evidence::each::{Each, Trial};
use crate::memory::evidence::facet::{Examples, Facet, Grown, company};
use crate::memory::evidence::growth::{DEPTH_MAX, Place};
use crate::memory::evidence::novelty::Surprise;
use crate::memory::evidence::pool::Pool;
use crate::memory::evidence::scene::Scene;
use crate::nouns::claim::{Change, Claim, Condition};
use crate::nouns::experience::Experience;
use crate::nouns::observation::{Observation, TypeId};
use crate::nouns::vocabulary::PrimitiveId;

/// What was found of the experiences of a pool. All else that a pool knows is seen from its experiences at once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Found {
    /// The type in which it shows how the action leaves a body; none where nothing is recalled.
    pub key: Option<TypeId>,
    /// What is known of the own effects of primitives, in the order of the primitives.
    pub effects: Vec<OwnEffect>,
    /// The facets, in their order.
    pub facets: Vec<FoundFacet>,
}

/// What is known of the own effect of a primitive.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnEffect {
    /// The primitive.
    pub primitive: PrimitiveId,
    /// What it brings about of itself, in canonical order, and after how many tries this was changed last; none while nothing was.
    pub brought: Option<(Vec<Observation>, usize)>,
    /// Whether it is not known yet if what came with it once comes anyway.
    pub doubtful: bool,
}

/// What was found of types that change together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FoundFacet {
    /// The types, in order.
    pub kinds: Vec<TypeId>,
    /// The changes that were seen, in the order in which they are counted.
    pub changes: Vec<Change>,
    /// How much surprised that was new, and how much was; the same of what was familiar.
    pub surprise: [f64; 4],
    /// The claims about the action, then those about each primitive, in the order of the primitives.
    pub grown: Vec<FoundClaims>,
    /// The place of each experience among the claims about the action; none where it does not tell of these types. Where each observation is
    /// told by itself there is one place for each of them.
    pub places: Vec<Option<FoundPlace>>,
    /// The claims about each observation by itself, where that tells more.
    pub each: Option<FoundEach>,
    /// The same, as long as it is not known whether it tells more.
    pub trial: Option<FoundTrial>,
}

/// What was found of each observation of a type by itself.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundEach {
    /// The number of the first experience of the pool that is looked at.
    pub from: usize,
    /// The observations that were met, in canonical order.
    pub known: Vec<Observation>,
    /// The claims.
    pub facet: Box<FoundFacet>,
}

/// What was found of each observation, and how well that told what came since.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundTrial {
    /// What was found.
    pub each: FoundEach,
    /// ln of the probabilities that the claims about the action gave to what came, and those about the primitive: all observations
    /// together, then each by itself.
    pub scores: [f64; 4],
}

/// A tree of claims.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FoundClaims {
    /// The primitive that they are about; none if they are about the action.
    pub primitive: Option<PrimitiveId>,
    /// How well each view foretold the primitive: ln of the probabilities.
    pub scores: Option<[f64; 3]>,
    /// From how many examples they were grown.
    pub examples: usize,
    /// How many of these had an outcome that was not the most frequent one of its claim.
    pub exceptional: usize,
    /// How many since then.
    pub unforetold: usize,
    /// The claims, each before its exceptions; none where nothing was counted.
    pub claims: Vec<FoundClaim>,
}

/// A claim in a tree.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FoundClaim {
    /// To how many claims it is an exception, one within the other.
    pub depth: usize,
    /// The condition; none at the top.
    pub condition: Option<Condition>,
    /// See [`Claim::gain`].
    pub gain: f64,
    /// The numbers of the changes that followed, each with how often.
    pub outcomes: Vec<(usize, u32)>,
    /// How often it was in force.
    pub trials: u32,
}

/// The place of an experience among claims.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FoundPlace {
    /// The number of the claim that was in force.
    pub claim: usize,
    /// The number of the change that came; none where it was none that can be said.
    pub change: Option<usize>,
}

impl Pool {
    /// What was found of its experiences.
    pub(super) fn found(&self) -> Found {
        let known = self.effects.keys().chain(&self.doubtful);
        let mut primitives: Vec<_> = known.copied().collect();
        primitives.sort_unstable();
        primitives.dedup();
        let effect = |primitive: PrimitiveId| OwnEffect {
            primitive,
            brought: self
                .effects
                .get(&primitive)
                .map(|effect| (effect.clone(), self.changed.get(&primitive).copied().unwrap_or_default())),
            doubtful: self.doubtful.contains(&primitive),
        };
        Found {
            key: self.key,
            effects: primitives.into_iter().map(effect).collect(),
            facets: self.facets.iter().map(Facet::found).collect(),
        }
    }

    /// The pool of these experiences, of which this was found.
    pub(super) fn restored(experiences: Vec<Experience>, found: Found) -> Self {
        let mut pool = Self::default();
        pool.key = found.key;
        for OwnEffect { primitive, brought, doubtful } in found.effects {
            if let Some((effect, tries)) = brought {
                pool.effects.insert(primitive, effect);
                pool.changed.insert(primitive, tries);
            }
            if doubtful {
                pool.doubtful.insert(primitive);
            }
        }
        for experience in experiences {
            pool.note(&experience);
            let effect = pool.effect(experience.primitive);
            let scene = pool.scene(&experience, effect);
            pool.examples.push((Arc::new(experience), scene));
        }
        let Self { examples, conditions, .. } = &mut pool;
        (0..examples.len()).for_each(|at| conditions.enter(at, |at| &examples[at].1));
        conditions.put_in_order();
        let facet = |facet| Facet::restored(facet, pool.examples());
        pool.facets = found.facets.into_iter().map(facet).collect();
        pool
    }
}

impl Facet {
    pub(super) fn found(&self) -> FoundFacet {
        let Surprise { new, familiar } = self.surprise;
        let place = |place: &Place| FoundPlace { claim: place.claim, change: place.change };
        let general = self.found_claims(None, Some(&self.general));
        let known = self.particular.keys().chain(self.scores.keys());
        let mut primitives: Vec<_> = known.copied().collect();
        primitives.sort_unstable();
        primitives.dedup();
        let particular = primitives
            .into_iter()
            .map(|primitive| self.found_claims(Some(primitive), self.particular.get(&primitive)));
        FoundFacet {
            kinds: self.kinds.clone(),
            changes: self.changes.iter().map(|(change, _)| change.clone()).collect(),
            surprise: [new.0, new.1, familiar.0, familiar.1],
            grown: std::iter::once(general).chain(particular).collect(),
            places: self.places.iter().map(|known| known.as_ref().map(place)).collect(),
            each: self.each.as_ref().map(|each| each.found()),
            trial: self.trial.as_ref().map(|trial| trial.found()),
        }
    }

    fn found_claims(&self, primitive: Option<PrimitiveId>, grown: Option<&Grown>) -> FoundClaims {
        let scores = primitive.and_then(|primitive| self.scores.get(&primitive).copied());
        let mut found = FoundClaims { primitive, scores, ..FoundClaims::default() };
        if let Some(grown) = grown {
            let Grown { claim, examples, exceptional, unforetold } = grown;
            (found.examples, found.exceptional, found.unforetold) = (*examples, *exceptional, *unforetold);
            self.list(claim, 0, &mut found.claims);
        }
        found
    }

    /// Lists a claim and its exceptions.
    fn list(&self, claim: &Claim, depth: usize, list: &mut Vec<FoundClaim>) {
        let number = |(change, count): &(Change, u32)| {
            Some((self.changes.iter().position(|(known, _)| known == change)?, *count))
        };
        list.push(FoundClaim {
            depth,
            condition: claim.condition.clone(),
            gain: claim.gain,
            outcomes: claim.outcomes.iter().filter_map(number).collect(),
            trials: claim.trials,
        });
        claim.exceptions.iter().for_each(|exception| self.list(exception, depth + 1, list));
    }

    /// The facet of these examples, of which this was found.
    fn restored(found: FoundFacet, examples: Examples<'_>) -> Self {
        let each = found.each.clone();
        let trial = found.trial.clone();
        let company = found.kinds.iter().map(|kind| company(*kind, examples.all)).collect();
        let mut facet = Self::of_found(found, company, examples.all);
        if let Some(each) = each {
            facet.each = Some(Box::new(Each::restored(each, examples)));
            // Where each is told by itself nothing is counted of all together.
            facet.sensed = Column::default();
        }
        facet.trial = trial.map(|trial| Box::new(Trial::restored(trial, examples)));
        facet
    }

    /// The same, but for what was found of each observation by itself.
    pub(super) fn of_found(
        found: FoundFacet,
        company: Vec<Vec<TypeId>>,
        examples: &[(Arc<Experience>, Scene)],
    ) -> Self {
        let FoundFacet { kinds, changes, surprise: [one, of, other, of_other], grown, places, .. } = found;
        let mut facet = Self {
            company,
            kinds,
            changes: changes.into_iter().map(|change| (change, Column::default())).collect(),
            surprise: Surprise { new: (one, of), familiar: (other, of_other) },
            ..Self::default()
        };
        let place = |place: FoundPlace| Place { claim: place.claim, change: place.change };
        facet.places = places.into_iter().map(|known| known.map(place)).collect();
        for FoundClaims { primitive, scores, examples, exceptional, unforetold, claims } in grown {
            let there = !claims.is_empty();
            let grown = Grown { claim: facet.tree(claims), examples, exceptional, unforetold };
            match primitive {
                None => facet.general = grown,
                Some(primitive) => {
                    facet.scores.extend(scores.map(|scores| (primitive, scores)));
                    facet.particular.extend(there.then_some((primitive, grown)));
                }
            }
        }
        (0..examples.len()).for_each(|at| drop(facet.enter_known(examples, at)));
        facet
    }

    /// The claims of a list, each in its place.
    fn tree(&self, list: Vec<FoundClaim>) -> Claim {
        let mut open: Vec<Claim> = Vec::new();
        for FoundClaim { depth, condition, gain, outcomes, trials } in list {
            close(&mut open, depth.clamp(1, DEPTH_MAX));
            let known = |(at, count): (usize, u32)| Some((self.changes.get(at)?.0.clone(), count));
            let outcomes = outcomes.into_iter().filter_map(known).collect();
            open.push(Claim { condition, gain, exceptions: Vec::new(), outcomes, trials });
        }
        close(&mut open, 1);
        open.pop().unwrap_or_default()
    }
}

/// Puts each claim that is deeper than `depth` into the one that it is an exception to.
fn close(open: &mut Vec<Claim>, depth: usize) {
    while open.len() > depth {
        let done = open.pop();
        if let Some(claim) = open.last_mut() {
            claim.exceptions.extend(done);
        }
    }
}
