//! What is foretold, and how often what came about had been seen.

use crate::memory::evidence::facet::{Facet, Grown, path};
use crate::memory::evidence::price;
use crate::memory::evidence::scene::Scene;
use crate::nouns::claim::{Change, Condition, Sketch};
use crate::nouns::observation::{Observation, TypeId};

/// The examples that a foretold distribution rests on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum View {
    /// All experiences with the action, whatever its parameters.
    General,
    /// Those with the primitive alone.
    Particular,
    /// Those with the primitive in the very same context.
    Remembered,
}

/// What is foretold of observations that change together.
#[derive(Clone, Debug, PartialEq)]
pub struct Foretold {
    /// Their types, in order.
    pub kinds: Vec<TypeId>,
    /// The observations of these types after the action, in canonical order, each with how often it came to that, the most frequent
    /// first.
    pub outcomes: Vec<(Vec<Observation>, u32)>,
    /// How often the claim was in force; more often than the outcomes add up to where some can't be said here.
    pub trials: u32,
    /// The examples that this rests on.
    pub view: View,
    /// The observations that the claim in force asks for; all of the context where it is remembered.
    pub relied_on: Vec<Observation>,
    /// The conditions of the claim in force with its most frequent change; none where the context is remembered.
    pub claim: Option<(Vec<Condition>, Change)>,
    /// Whether the most frequent outcome is put down to the action: it is foretold better than by what is to be expected whatever is
    /// done.
    pub attributed: bool,
    /// Whether each observation is told by itself, whatever becomes of the others.
    pub is_of_each: bool,
    /// What becomes of single observations then, if it is more likely than that they stay.
    pub parts: Vec<Part>,
}

/// What becomes of some observations, whatever becomes of the others.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Part {
    /// Those that are there afterwards.
    pub observed: Vec<Observation>,
    /// Those that are there no longer.
    pub vanished: Vec<Observation>,
    /// The observations that the claim in force asks for.
    pub relied_on: Vec<Observation>,
    /// How often it came to that.
    pub count: u32,
    /// How often the claim was in force.
    pub trials: u32,
    /// Whether the claim in force says it of each observation of its type, or of all numbers alike by a difference. No schema says as
    /// much.
    pub of_all: bool,
    /// Whether the claim in force names a value of the action.
    pub(crate) names_action: bool,
    /// Whether it is put down to the action.
    pub attributed: bool,
}

/// The general claim about some types that was in force in an experience.
pub(crate) struct InForce<'a> {
    /// The types.
    pub(crate) kinds: &'a [TypeId],
    /// Its place: which exception at each level.
    pub(crate) claim: Vec<usize>,
    /// Which of its outcomes came; none if it was another.
    pub(crate) came: Option<&'a Change>,
}

impl Foretold {
    /// Whether the most frequent outcome is the action's doing. It is if the claim names a value of the action, for then it was shown to
    /// be otherwise with another. Else how often it came is compared with how often it is to be expected whatever is done (marginal
    /// attribution); `among` so many facets.
    pub(super) fn is_attributed(&self, background: &[Self], among: usize) -> bool {
        let Some((after, count)) = self.outcomes.first() else { return false };
        let names = |(conditions, change): &(Vec<Condition>, Change)| {
            conditions.iter().any(Condition::is_of_action) || change.sketches().any(Sketch::is_of_action)
        };
        if self.claim.as_ref().is_some_and(names) {
            return true;
        }
        let anyway: f64 = background.iter().map(|facet| facet.share_with(&self.kinds, after)).product();
        differs(*count as usize, self.trials as usize, anyway) > libm::log(among as f64)
    }

    /// Decides whether what becomes of each single observation is the action's doing, in the same way.
    pub(super) fn attribute_parts(&mut self, background: &[Self], among: usize) {
        for part in &mut self.parts {
            let Some(one) = part.observed.first().or(part.vanished.first()) else { continue };
            let anyway = background.iter().find(|facet| facet.kinds.binary_search(&one.kind()).is_ok());
            let anyway = anyway.map_or(0.5, |facet| facet.share_of(one, part.observed.is_empty()));
            let gain = differs(part.count as usize, part.trials as usize, anyway);
            part.attributed = part.names_action || gain > libm::log(among as f64);
        }
    }

    /// The probability that an observation is there afterwards, or that it is not, with room for what was never seen.
    fn share_of(&self, observation: &Observation, vanishes: bool) -> f64 {
        let agrees = |after: &[Observation]| (after.binary_search(observation).is_ok()) != vanishes;
        let agreeing = self.outcomes.iter().filter(|(after, _)| agrees(after));
        let agreeing: u32 = agreeing.map(|(_, count)| count).sum();
        (f64::from(agreeing) + 0.5) / (f64::from(self.trials) + 1.0)
    }

    /// The probability that what it foretells agrees with `after` in the types `kinds`, with room for what was never seen.
    fn share_with(&self, kinds: &[TypeId], after: &[Observation]) -> f64 {
        let common =
            |kind: TypeId| kinds.binary_search(&kind).is_ok() && self.kinds.binary_search(&kind).is_ok();
        if !self.kinds.iter().any(|kind| common(*kind)) {
            return 1.0;
        }
        let part = |observations: &[Observation]| -> Vec<_> {
            observations.iter().filter(|o| common(o.kind())).cloned().collect()
        };
        let wanted = part(after);
        let agreeing = self.outcomes.iter().filter(|(outcome, _)| part(outcome) == wanted);
        let agreeing: u32 = agreeing.map(|(_, count)| count).sum();
        let share = 1.0 / (self.outcomes.len() + 1) as f64;
        (f64::from(agreeing) + share) / (f64::from(self.trials) + 1.0)
    }
}

/// How often a view has seen what came about.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Seen {
    pub(super) came: u32,
    /// Outcomes of no form.
    formless: u32,
    pub(super) trials: u32,
}

impl Seen {
    /// What the claim in force in a scene has seen of `after`.
    pub(super) fn of_claim(
        grown: &Grown,
        scene: &Scene,
        after: &[Observation],
        facet: &Facet,
    ) -> Option<Self> {
        let (_, claim) = path(&grown.claim, scene);
        let formed: u32 = claim.outcomes.iter().map(|(_, count)| count).sum();
        let makes = |(change, _): &&(Change, u32)| scene.makes(change, after, &facet.kinds);
        let came = claim.outcomes.iter().filter(makes).map(|(_, count)| count).sum();
        let seen = Self { came, formless: claim.trials - formed, trials: claim.trials };
        (seen.trials > 0).then_some(seen)
    }

    /// The same, had it not come once.
    pub(super) fn without_one(self) -> Self {
        let Self { came, formless, trials } = self;
        let formless = if came == 0 { formless.saturating_sub(1) } else { formless };
        Self { came: came.saturating_sub(1), formless, trials: trials.saturating_sub(1) }
    }

    /// The probability of what came about, with room for each of so many `changes` that may come.
    pub(super) fn probability(self, changes: usize) -> f64 {
        let share = 1.0 / (changes + 1) as f64;
        // Where much came that has no form, one more of that kind is to be expected.
        let count = if self.came > 0 { f64::from(self.came) } else { f64::from(self.formless) * share };
        (count + share) / (f64::from(self.trials) + 1.0)
    }
}

/// How much better it is told by a share of its own than by that which it has anyway that something came so many times in so many
/// tries: ln of the odds.
pub(super) fn differs(times: usize, tries: usize, anyway: f64) -> f64 {
    let failed = tries.saturating_sub(times);
    price::of_two(times, failed) - times as f64 * libm::log(anyway) - failed as f64 * libm::log(1.0 - anyway)
}
