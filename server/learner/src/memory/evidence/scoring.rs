//! How well each view of what was experienced foretells what comes.

use std::collections::{BTreeMap, BTreeSet};

use crate::memory::evidence::columns::Column;
use crate::memory::evidence::facet::{ANYTHING, Facet, Grown};
use crate::memory::evidence::foretold::{Seen, View};
use crate::memory::evidence::novelty::Novelty;
use crate::memory::evidence::pool::{CERTAIN, Pool};
use crate::memory::evidence::scene::Scene;
use crate::memory::evidence::telling::relied;
use crate::nouns::experience::Experience;
use crate::nouns::observation::{Observation, TypeId};
use crate::nouns::vocabulary::PrimitiveId;

/// How far an earlier success of a view at foretelling counts, at each experience since.
const SCORE_KEPT: f64 = 0.97;
/// So many experiences that were foretold for certain are added before it is said how well a primitive is foretold: what surprised a few times
/// may be learnt.
const FORETOLD: f64 = 8.0;
/// Contexts of which it is kept how new they are, while all that is known is scored.
const NOVELTIES_MAX: usize = 32;

impl Pool {
    /// Each view of each facet is scored by what it foretold of this experience, before it is learnt from; and what is tried out.
    pub(super) fn score(&mut self, experience: &Experience) {
        let scene = self.scene(experience, self.effect(experience.primitive));
        self.score_trials(&scene, experience);
        if experience.primitive != ANYTHING || self.of_ends().is_some() {
            let mut facets = std::mem::take(&mut self.facets);
            let mut values = std::mem::take(&mut self.values.facets);
            let novelty = self.novelty(&scene.context);
            self.score_in(&mut facets, &novelty, &scene, experience, false);
            self.score_in(&mut values, &novelty, &scene, experience, false);
            (self.facets, self.values.facets) = (facets, values);
        }
    }

    /// How well each facet that is about some of these types was foretold of late of each primitive: the mean of ln of the probability that what
    /// came was given, as if it had been foretold for certain so often before.
    pub(super) fn told_of_late(&self, kinds: &BTreeSet<TypeId>) -> Vec<(&[TypeId], PrimitiveId, f64)> {
        let of_facet = |facet: &'_ Facet| -> Vec<(PrimitiveId, f64)> {
            self.told_in(facet)
                .map(|(primitive, told, weight)| (primitive, told / (weight + FORETOLD)))
                .collect()
        };
        let asked = self.facets.iter().filter(|facet| facet.kinds.iter().any(|kind| kinds.contains(kind)));
        let told = asked.map(|facet| (&facet.kinds[..], of_facet(facet)));
        told.flat_map(|(kinds, of)| of.into_iter().map(move |(primitive, told)| (kinds, primitive, told)))
            .collect()
    }

    /// How well a facet was foretold of late of each primitive: ln of the probabilities that what came was given, and how much they count, an
    /// earlier one less.
    pub(super) fn told_in(&self, facet: &Facet) -> impl Iterator<Item = (PrimitiveId, f64, f64)> {
        facet.scores.iter().filter_map(|(primitive, scores)| {
            let tries = self.of_primitive().get(primitive).map_or(0, Column::count);
            let weight = (1.0 - libm::pow(SCORE_KEPT, tries as f64)) / (1.0 - SCORE_KEPT);
            let told = relied(*scores, |view| Some(scores[view as usize]))?;
            Some((*primitive, told, weight))
        })
    }

    /// Compares what is foretold of each observation by itself with what is foretold of all together, where both are.
    fn score_trials(&mut self, scene: &Scene, experience: &Experience) {
        for number in 0..self.facets.len() {
            let facet = &self.facets[number];
            let &[kind] = &facet.kinds[..] else { continue };
            if !facet.is_told_by(experience) {
                continue;
            }
            let Some(mut trial) = self.trials.remove(&kind) else { continue };
            let after = facet.after(experience);
            let [general, particular, _] = self.told(facet, experience.primitive, scene, &after, false);
            let together = [general, particular].map(|told| told.unwrap_or_else(|| facet.of_nothing()));
            trial.score(together, experience.primitive, scene, &after);
            match trial.verdict(CERTAIN) {
                None => drop(self.trials.insert(kind, trial)),
                Some(false) => (),
                Some(true) => {
                    self.facets[number] = Facet::singly(kind, &self.examples);
                    self.singly.insert(kind, trial.each);
                }
            }
        }
    }

    /// Each view is scored by what it would have foretold of each example if that had not been among those that it was learnt from.
    pub(super) fn score_anew(&mut self) {
        let mut facets = std::mem::take(&mut self.facets);
        let mut values = std::mem::take(&mut self.values.facets);
        let mut novelties = BTreeMap::new();
        let is_scored = |one: &Experience| one.primitive != ANYTHING || self.of_ends().is_some();
        let scored: Vec<_> = self.examples.iter().filter(|(one, _)| is_scored(one)).collect();
        for (experience, scene) in scored {
            if novelties.len() == NOVELTIES_MAX && !novelties.contains_key(&experience.before) {
                novelties.clear();
            }
            let novelty =
                novelties.entry(&experience.before).or_insert_with(|| self.novelty(&experience.before));
            self.score_in(&mut facets, novelty, scene, experience, true);
            self.score_in(&mut values, novelty, scene, experience, true);
        }
        drop(novelties);
        (self.facets, self.values.facets) = (facets, values);
    }

    /// Scores what facets foretell in a scene, which is so new, by what came, which was learnt from `already` or not.
    fn score_in(
        &self,
        facets: &mut [Facet],
        novelty: &Novelty<'_>,
        scene: &Scene,
        experience: &Experience,
        already: bool,
    ) {
        let met = self.together(novelty, experience.primitive, |_| true);
        let newness = self.newness_of_all(novelty, experience.primitive, &met, 0.0, already);
        // What is to be expected whatever is done is not scored, but for ends, which are of no action.
        let is_scored = |facet: &Facet| experience.primitive != ANYTHING || facet.is_of_ends();
        for facet in facets.iter_mut().filter(|facet| is_scored(facet) && facet.is_told_by(experience)) {
            let after = facet.after(experience);
            let views = self.told(facet, experience.primitive, scene, &after, already);
            // Where a view says nothing, it is as if it had said anything alike.
            let nothing = facet.of_nothing();
            let scores = facet.scores.entry(experience.primitive).or_default();
            let relied_on = relied(*scores, |view| views[view as usize]);
            let surprise = relied_on.is_none_or(|told| told < nothing);
            facet.surprise.note(newness, surprise);
            for (score, told) in scores.iter_mut().zip(views) {
                *score = *score * SCORE_KEPT + told.unwrap_or(nothing);
            }
        }
    }

    /// ln of the probability that each view gave what came, which was learnt from `already` or not.
    fn told(
        &self,
        facet: &Facet,
        primitive: PrimitiveId,
        scene: &Scene,
        after: &[Observation],
        already: bool,
    ) -> [Option<f64>; 3] {
        let told = |seen: Seen| {
            let seen = if already { seen.without_one() } else { seen };
            (seen.trials > 0).then(|| libm::log(seen.probability(facet.changes.len())))
        };
        let claimed = |grown: &Grown| Seen::of_claim(grown, scene, after, facet).and_then(told);
        let (general, particular) = match self.each_of(facet) {
            Some(each) => {
                let told = |view: View| each.told(view, primitive, scene, after, already);
                (told(View::General), told(View::Particular))
            }
            None => (claimed(&facet.general), facet.particular.get(&primitive).and_then(claimed)),
        };
        let remembered = self.seen_alike(facet, primitive, scene, after).and_then(told);
        [general, particular, remembered.or(particular)]
    }

    /// How often `after` came of a primitive in the very same context.
    fn seen_alike(
        &self,
        facet: &Facet,
        primitive: PrimitiveId,
        scene: &Scene,
        after: &[Observation],
    ) -> Option<Seen> {
        if facet.is_singly {
            return None;
        }
        let alike = self.alike.get(&primitive)?.get(&scene.context[..])?;
        let (came, mut seen) = (facet.outcomes.number(after), Seen::default());
        for at in alike.iter().copied().filter(|at| facet.sensed.contains(*at)) {
            seen.trials += 1;
            seen.came += u32::from(came.is_some() && facet.outcomes.of(at) == came);
        }
        (seen.trials > 0).then_some(seen)
    }
}
