//! What was found of experiences is written down, and put back: growing it again takes as long as it took to find it.

use std::sync::Arc;

use crate::memory::evidence::columns::Column;
use crate::memory::evidence::each::{Each, Trial};
use crate::memory::evidence::facet::{Examples, Facet, Grown, company};
use crate::memory::evidence::found::{
    Found, FoundClaim, FoundClaims, FoundEach, FoundFacet, FoundPlace, FoundTrial, OwnEffect,
};
use crate::memory::evidence::growth::{DEPTH_MAX, Place};
use crate::memory::evidence::novelty::Surprise;
use crate::memory::evidence::outcomes::Outcomes;
use crate::memory::evidence::pool::Pool;
use crate::memory::evidence::scene::Scene;
use crate::memory::evidence::values::Values;
use crate::nouns::claim::{Change, Claim};
use crate::nouns::experience::Experience;
use crate::nouns::observation::TypeId;
use crate::nouns::vocabulary::PrimitiveId;

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
            facets: self.all_facets().map(|facet| self.facet_found(facet)).collect(),
        }
    }

    /// The pool of these experiences, of which this was found, where these types are values.
    pub(super) fn restored(experiences: Vec<Experience>, found: Found, values: Values) -> Self {
        let mut pool = Self::default();
        pool.values = values;
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
        for at in 0..pool.examples.len() {
            let twin = pool.examples().twin(at, |_| true);
            let Self { examples, conditions, .. } = &mut pool;
            conditions.enter(at, twin, |at| &examples[at].1);
        }
        pool.conditions.put_in_order();
        found.facets.into_iter().for_each(|facet| pool.restore(facet));
        pool
    }

    fn facet_found(&self, facet: &Facet) -> FoundFacet {
        let kind = facet.kinds.first();
        let each = kind.filter(|_| facet.is_singly).and_then(|kind| self.singly.get(kind));
        let trial = kind.filter(|_| facet.kinds.len() == 1).and_then(|kind| self.trials.get(kind));
        FoundFacet { each: each.map(Each::found), trial: trial.map(Trial::found), ..facet.found() }
    }

    /// Puts back a facet of which this was found.
    fn restore(&mut self, mut found: FoundFacet) {
        let (kind, company) = (found.kinds.first().copied(), companies(&found.kinds, &self.examples));
        let each = found.each.take().map(|each| Each::restored(each, self.examples()));
        let trial = found.trial.take().map(|trial| Trial::restored(trial, self.examples()));
        let mut facet = Facet::restored(found, company, self.examples());
        if each.is_some() {
            // Where each is told by itself nothing is counted of all together.
            (facet.is_singly, facet.sensed, facet.outcomes) = (true, Column::default(), Outcomes::default());
        }
        self.singly.extend(kind.zip(each));
        self.trials.extend(kind.zip(trial));
        let is_value = kind.is_some_and(|kind| self.values.has(kind));
        if is_value { self.values.facets.push(facet) } else { self.facets.push(facet) }
    }
}

fn companies(kinds: &[TypeId], examples: &[(Arc<Experience>, Scene)]) -> Vec<Vec<TypeId>> {
    kinds.iter().map(|kind| company(*kind, examples)).collect()
}

impl Facet {
    fn found(&self) -> FoundFacet {
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
            each: None,
            trial: None,
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

    /// The facet of these examples, of which this was found; the claims about single observations left out.
    fn restored(found: FoundFacet, company: Vec<Vec<TypeId>>, examples: Examples<'_>) -> Self {
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
        (0..examples.all.len()).for_each(|at| drop(facet.enter_known(examples, at)));
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

impl Each {
    /// What was found.
    fn found(&self) -> FoundEach {
        FoundEach { from: self.from, known: self.known.clone(), facet: Box::new(self.facet.found()) }
    }

    /// The claims of which this was found, from the examples of a pool.
    fn restored(found: FoundEach, examples: Examples<'_>) -> Self {
        let FoundEach { from, known, facet } = found;
        let kind = facet.kinds.first().copied().unwrap_or(TypeId(0));
        let mut each = Self::entered(kind, from, known, examples);
        // What came with the type at first is known of all examples of the pool.
        let company = std::mem::take(&mut each.facet.company);
        each.facet = Facet::restored(*facet, company, each.examples());
        each
    }
}

impl Trial {
    /// What was found.
    fn found(&self) -> FoundTrial {
        let ([a, b], [c, d]) = (self.together, self.singly);
        FoundTrial { each: self.each.found(), scores: [a, b, c, d] }
    }

    /// The trial of which this was found.
    fn restored(found: FoundTrial, examples: Examples<'_>) -> Self {
        let [a, b, c, d] = found.scores;
        Self { each: Each::restored(found.each, examples), together: [a, b], singly: [c, d] }
    }
}
