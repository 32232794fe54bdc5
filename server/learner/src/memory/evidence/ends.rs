//! Ends of episodes. An end belongs to where it came about, whatever was to be done there: it is told with what is to be expected whatever
//! is done, in a facet of its own.

use std::collections::{BTreeMap, BTreeSet};

use crate::memory::evidence::Evidence;
use crate::memory::evidence::beginnings::Beginnings;
use crate::memory::evidence::facet::{ANYTHING, Facet};
use crate::memory::evidence::foretold::View;
use crate::memory::evidence::novelty::{Novelty, newness};
use crate::memory::evidence::pool::{Pool, room};
use crate::memory::evidence::prospect::Ending;
use crate::memory::evidence::scene::Scene;
use crate::memory::evidence::shares::shares;
use crate::nouns::experience::Experience;
use crate::nouns::observation::{Observation, TypeId};
use crate::nouns::vocabulary::{BodyId, Vocabulary};

impl Pool {
    /// The facet that tells of ends; none as long as no episode ended.
    pub(super) fn of_ends(&self) -> Option<&Facet> {
        self.facets.iter().find(|facet| facet.is_of_ends())
    }

    /// The newest end in each context, as far as they take half of the room: where it is known that nothing leads on, one never stays for long.
    pub(super) fn newest_ends(&self) -> Vec<usize> {
        let ends = self.examples.iter().enumerate().filter(|(_, (experience, _))| experience.is_end());
        let newest: BTreeMap<_, _> = ends.map(|(at, (experience, _))| (&experience.before, at)).collect();
        let mut newest: Vec<_> = newest.into_values().collect();
        newest.sort_unstable_by(|a, b| b.cmp(a));
        newest.truncate(room(self.of_primitive().len()) / 2);
        newest
    }

    /// Whether anything was done in this very context.
    pub(super) fn is_met(&self, context: &[Observation]) -> bool {
        self.alike.get(&ANYTHING).is_some_and(|alike| alike.contains_key(context))
    }

    /// What is foretold of a context, in which observations of some types alone may matter.
    fn ending(&self, context: &[Observation], kinds: Option<&BTreeSet<TypeId>>) -> Ending {
        let Some(facet) = self.of_ends() else { return Ending::default() };
        let matters = |o: &Observation| kinds.is_none_or(|kinds| kinds.contains(&o.kind()));
        let alike = match kinds {
            Some(kinds) if !context.iter().all(matters) => {
                let novelty = Novelty::of_each(&self.conditions, context);
                let met = self.together(&novelty, ANYTHING, |at| context.get(at).is_some_and(matters));
                let plain: Vec<_> = context.iter().filter(|o| matters(o)).cloned().collect();
                self.alike_in(facet, &met, &plain, kinds)
            }
            _ => self.alike(facet, ANYTHING, context),
        };
        let met: u32 = alike.iter().map(|(_, count)| count).sum();
        let learnable = facet.surprise.of_new() * newness(met as usize, 0.0);
        let ended = |after: &[Observation]| !after.is_empty();
        // One end in the very same context is enough, as long as it was never otherwise: to fall into the same hole again teaches nothing.
        if met > 0 && alike.iter().all(|(after, _)| ended(after)) {
            return Ending { probability: 1.0, learnable: 0.0 };
        }
        let scene = Scene::new(context, &[], &[]);
        let Some(foretold) = self.foretold(facet, ANYTHING, &scene) else { return Ending::default() };
        let alike = if foretold.view == View::Remembered { Vec::new() } else { alike };
        let ends = shares(&foretold, alike).into_iter().filter(|(after, _)| ended(after));
        Ending { probability: ends.map(|(_, share)| share).sum::<f64>().min(1.0), learnable }
    }
}

impl Evidence {
    /// What is foretold of whether an episode has ended in a context of lasting observations in canonical order; where those of some
    /// types alone matter, if these are given.
    pub(crate) fn ending(&self, context: &[Observation], kinds: Option<&BTreeSet<TypeId>>) -> Ending {
        self.background.ending(context, kinds)
    }

    /// Takes in how much is to be learnt where an episode begins, with the first experience in it.
    pub(super) fn note_beginning(&mut self, vocabulary: &Vocabulary, experience: &Experience) {
        let Some(beginnings) = self.beginnings.get(&experience.body).copied().filter(|known| known.is_next)
        else {
            return;
        };
        let body = vocabulary.bodies().get(usize::from(experience.body.0));
        let repertoire = body.map_or(&[][..], |body| &body.repertoire);
        // For what was met before no episode need end.
        let learnable = match self.background.is_met(&experience.before) {
            true => 0.0,
            false => {
                self.curiosity(vocabulary, repertoire, &experience.before).into_iter().fold(0.0, f64::max)
            }
        };
        let mut beginnings = beginnings;
        beginnings.note(learnable);
        self.beginnings.insert(experience.body, beginnings);
    }

    /// How much may be learnt where the next episode of a body begins, from 0 to 1.
    pub(crate) fn beginning(&self, body: BodyId) -> f64 {
        self.beginnings.get(&body).map_or(0.0, Beginnings::next)
    }

    /// How often an episode had ended in this very context, and how often something was done there or that was so, among the experiences
    /// that are kept.
    pub(crate) fn ended(&self, context: &[Observation]) -> (u32, u32) {
        let Some(facet) = self.background.of_ends() else { return (0, 0) };
        let alike = self.background.alike(facet, ANYTHING, context);
        let ends = alike.iter().filter(|(after, _)| !after.is_empty());
        (ends.map(|(_, count)| count).sum(), alike.iter().map(|(_, count)| count).sum())
    }
}
