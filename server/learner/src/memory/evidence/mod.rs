//! Evidence: the experiences that claims grow from, and the claims. One rule says which claim is in force where, and what it
//! foretells.

mod apart;
mod beginnings;
mod columns;
mod each;
mod ends;
mod facet;
mod foresight;
mod foretold;
mod found;
mod growth;
mod noise;
mod novelty;
mod outcomes;
mod outlook;
mod pool;
pub(crate) mod price;
mod prospect;
mod recollections;
mod restoring;
mod scene;
mod scoring;
mod shares;
mod telling;
#[cfg(test)]
mod tests;
mod values;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

pub use beginnings::Beginnings;
pub(crate) use foresight::Foresight;
pub(crate) use foretold::InForce;
pub use foretold::{Foretold, Part, View};
pub use found::{Found, FoundClaim, FoundClaims, FoundEach, FoundFacet, FoundPlace, FoundTrial, OwnEffect};
use novelty::Novelty;
use pool::Pool;
pub(crate) use prospect::{Ending, Outlook, Prospect};
pub use recollections::{Recollection, Recollections};
use scene::of_kind;
use values::Values;

use crate::memory::evidence::facet::ANYTHING;
use crate::nouns::claim::Claim;
use crate::nouns::experience::{Experience, Recalled};
use crate::nouns::observation::{Observation, TypeId, Value};
use crate::nouns::vocabulary::{BodyId, PrimitiveId, Vocabulary, value_of};

/// What claims are made of, at most.
pub mod limits {
    /// Changes that the claims of a facet speak of.
    pub const CHANGES_MAX: usize = super::facet::CHANGES_MAX;
    /// Exceptions within exceptions.
    pub const DEPTH_MAX: usize = super::growth::DEPTH_MAX;
    /// Observations of a type of which each is told by itself.
    pub const KNOWN_MAX: usize = super::each::KNOWN_MAX;
    /// Examples of single observations.
    pub const EXAMPLES_MAX: usize = super::each::EXAMPLES_MAX + super::each::KNOWN_MAX;
    /// Ways to be of which a body recalls what was there.
    pub const RECOLLECTIONS_MAX: usize = super::recollections::RECOLLECTIONS_MAX;
    /// Beginnings that are counted, the earlier ones less.
    pub const BEGINNINGS_MAX: f64 = super::beginnings::BEGINNINGS_MAX;
}

/// The experiences with each action, by its number in the vocabulary, and the claims that they make. A clone shares all of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Evidence {
    pools: BTreeMap<usize, Arc<Pool>>,
    /// The same experiences, as if all had been with one action: what is to be expected whatever is done.
    background: Arc<Pool>,
    /// What each body recalls.
    recollections: BTreeMap<BodyId, Recollections>,
    /// What was to be learnt where episodes of each body began.
    beginnings: BTreeMap<BodyId, Beginnings>,
}

/// What is done where claims hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum About {
    /// The action of this number in the vocabulary, whatever its parameters.
    Action(usize),
    /// This primitive alone.
    Primitive(PrimitiveId),
    /// Anything: what is to be expected whatever is done.
    Anything,
}

/// The number of the action that a primitive is one of.
fn action(vocabulary: &Vocabulary, primitive: PrimitiveId) -> Option<usize> {
    Some(vocabulary.primitives().get(primitive.0 as usize)?.action)
}

/// The values of a primitive's parameters, as they are compared with what is observed.
pub(crate) fn parameters(vocabulary: &Vocabulary, primitive: PrimitiveId) -> Arc<[Option<Value>]> {
    let known = vocabulary.primitives().get(primitive.0 as usize);
    let declared = known.and_then(|known| vocabulary.actions().get(known.action));
    let values = known.into_iter().flat_map(|known| &known.parameters);
    let kinds = declared.into_iter().flat_map(|declared| &declared.parameters);
    values.zip(kinds).map(|(given, declared)| value_of(given, &declared.kind, vocabulary)).collect()
}

impl Evidence {
    /// Takes an experience in.
    pub fn experience(&mut self, vocabulary: &Vocabulary, experience: &Experience, recalls: bool) {
        if experience.is_beginning() {
            self.recollections.remove(&experience.body);
            self.beginnings.entry(experience.body).or_default().is_next = true;
        }
        let Some(action) = action(vocabulary, experience.primitive) else { return };
        let is_end = experience.is_end();
        self.note_beginning(vocabulary, experience);
        // Where an episode had ended the action was not carried out: it says nothing of the action.
        if !is_end {
            let pool = Arc::make_mut(self.pools.entry(action).or_default());
            pool.values.know(vocabulary);
            pool.experience(Arc::new(experience.clone()), recalls);
        }
        let recalled = experience.recalled.clone().filter(|_| is_end);
        let anything =
            Experience { primitive: ANYTHING, parameters: [].into(), recalled, ..experience.clone() };
        let background = Arc::make_mut(&mut self.background);
        background.values.know(vocabulary);
        background.experience(Arc::new(anything), false);
        if recalls && !is_end {
            let keys: BTreeSet<_> = self.pools.values().filter_map(|pool| pool.key()).collect();
            let recollections = self.recollections.entry(experience.body).or_default();
            let is_value = |o: &Observation| vocabulary.is_value(o.kind());
            let there: Vec<_> = experience.after.iter().filter(|o| !is_value(o)).cloned().collect();
            recollections.note(keys, &there.into());
        }
    }

    /// What was to be learnt where episodes began, of each body in the order of the bodies.
    pub fn beginnings(&self) -> impl Iterator<Item = (BodyId, &Beginnings)> {
        self.beginnings.iter().map(|(body, beginnings)| (*body, beginnings))
    }

    /// Puts back what was to be learnt where the episodes of a body began.
    pub fn begin(&mut self, body: BodyId, beginnings: Beginnings) {
        self.beginnings.insert(body, beginnings);
    }

    /// What each body recalls, in the order of the bodies.
    pub fn recollections(&self) -> impl Iterator<Item = (BodyId, &Recollections)> {
        self.recollections.iter().map(|(body, recollections)| (*body, recollections))
    }

    /// Forgets what bodies recall.
    pub(crate) fn forget_recollections(&mut self) {
        self.recollections.clear();
    }

    /// Puts back what a body recalls.
    pub fn recall(&mut self, body: BodyId, recollections: Recollections) {
        self.recollections.insert(body, recollections);
    }

    /// What was there when a body was last as an action leaves it, after which these observations are there; none where that is not
    /// known.
    #[must_use]
    pub fn recalled(
        &self,
        vocabulary: &Vocabulary,
        body: BodyId,
        primitive: PrimitiveId,
        after: &[Observation],
    ) -> Option<Recalled> {
        let key = self.pools.get(&action(vocabulary, primitive)?)?.key()?;
        let [one] = of_kind(after, key) else { return None };
        self.recollections.get(&body)?.of(one)
    }

    /// The experiences that are kept, pool by pool in the order in which they were made, each with the action whose pool it is in; none
    /// is the background.
    pub fn kept(&self) -> impl Iterator<Item = (Option<usize>, &Experience)> {
        let of_actions = self.pools.iter().map(|(action, pool)| (Some(*action), pool));
        let pools = of_actions.chain([(None, &self.background)]);
        pools.flat_map(|(action, pool)| pool.experiences().map(move |experience| (action, experience)))
    }

    /// Whether an experience can be in this pool: in that of its action, or in the background, where all experiences are as if with one.
    #[must_use]
    pub fn belongs(vocabulary: &Vocabulary, pool: Option<usize>, experience: &Experience) -> bool {
        match pool {
            Some(_) => action(vocabulary, experience.primitive) == pool,
            None => experience.primitive == ANYTHING && experience.parameters.is_empty(),
        }
    }

    /// How many experiences a pool has room for.
    #[must_use]
    pub fn room(vocabulary: &Vocabulary) -> usize {
        pool::room(vocabulary.primitives().len())
    }

    /// What was found of the experiences that are kept, pool by pool as in [`Evidence::kept`].
    pub fn found(&self) -> impl Iterator<Item = (Option<usize>, Found)> {
        let of_actions = self.pools.iter().map(|(action, pool)| (Some(*action), pool));
        let pools = of_actions.chain([(None, &self.background)]);
        let known = pools.filter(|(_, pool)| pool.experiences().next().is_some());
        known.map(|(action, pool)| (action, pool.found()))
    }

    /// Puts a pool back: its experiences in their order, and what was found of them.
    pub fn restore(
        &mut self,
        vocabulary: &Vocabulary,
        pool: Option<usize>,
        experiences: Vec<Experience>,
        found: Found,
    ) {
        let mut values = Values::default();
        values.know(vocabulary);
        let restored = Arc::new(Pool::restored(experiences, found, values));
        match pool {
            Some(action) => drop(self.pools.insert(action, restored)),
            None => self.background = restored,
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.pools.is_empty() && self.background.examples.is_empty()
    }

    /// The claims about each facet, with the types that it is of.
    #[must_use]
    pub fn claims(&self, vocabulary: &Vocabulary, about: About) -> Vec<(&[TypeId], &Claim)> {
        let (pool, primitive) = match about {
            About::Action(action) => (self.pools.get(&action), None),
            About::Primitive(primitive) => {
                let action = action(vocabulary, primitive);
                (action.and_then(|action| self.pools.get(&action)), Some(primitive))
            }
            About::Anything => (Some(&self.background), None),
        };
        pool.into_iter().flat_map(|pool| pool.claims(primitive)).collect()
    }

    /// Of each facet that an experience tells of, the general claim that was in force in it and which of its outcomes came.
    pub(crate) fn in_force(&self, vocabulary: &Vocabulary, experience: &Experience) -> Vec<InForce<'_>> {
        let pool = action(vocabulary, experience.primitive).and_then(|action| self.pools.get(&action));
        pool.map_or_else(Vec::new, |pool| pool.in_force(experience))
    }

    /// Whether any claim asks for an observation of this type.
    pub(crate) fn asks_for(&self, kind: TypeId) -> bool {
        self.pools.values().any(|pool| pool.asks_for(kind))
    }

    /// What a primitive brings about of itself, whatever the context, in canonical order; none while it was never carried out.
    #[must_use]
    pub fn effect(&self, vocabulary: &Vocabulary, primitive: PrimitiveId) -> Option<&[Observation]> {
        let pool = self.pools.get(&action(vocabulary, primitive)?)?;
        Some(pool.effect(primitive))
    }

    /// How much may be learnt of each of these primitives in a context of lasting observations in canonical order: how often its action
    /// surprised of late, times how new the primitive is there; from 0 to 1, and 1 of an action that was never carried out.
    #[must_use]
    pub fn curiosity(
        &self,
        vocabulary: &Vocabulary,
        primitives: &[PrimitiveId],
        context: &[Observation],
    ) -> Vec<f64> {
        let mut of_actions = BTreeMap::new();
        let curiosity = |primitive: &PrimitiveId| {
            let action = action(vocabulary, *primitive)?;
            let pool = self.pools.get(&action)?;
            let novelty = of_actions.entry(action).or_insert_with(|| pool.novelty(context));
            Some(pool.surprise() * pool.newness(novelty, *primitive, 0.0, false))
        };
        let mut curiosity = curiosity;
        // Whatever is done, it shows whether an episode has ended here.
        let of_ends = self.ending(context, None).learnable;
        primitives.iter().map(|primitive| curiosity(primitive).unwrap_or(1.0).max(of_ends)).collect()
    }

    /// Whether a primitive was ever carried out where all of these observations were, among the experiences that are kept.
    pub(crate) fn was_tried_with(
        &self,
        vocabulary: &Vocabulary,
        primitive: PrimitiveId,
        there: &[Observation],
    ) -> bool {
        let pool = action(vocabulary, primitive).and_then(|action| self.pools.get(&action));
        pool.is_some_and(|pool| {
            !pool.together(&Novelty::of_each(&pool.conditions, there), primitive, |_| true).is_empty()
        })
    }

    /// How often what is new surprises where this primitive is carried out, from 0 to 1: of what may be learnt of it there is no more anywhere.
    pub(crate) fn surprise(&self, vocabulary: &Vocabulary, primitive: PrimitiveId) -> f64 {
        let pool = action(vocabulary, primitive).and_then(|action| self.pools.get(&action));
        let of_ends = self.background.of_ends().map_or(0.0, |facet| facet.surprise.of_new());
        pool.map_or(1.0, |pool| pool.surprise()).max(of_ends)
    }

    /// What a primitive will bring about in a context of lasting observations in canonical order, by what a body recalls, if it is one's;
    /// nothing where nothing is known of its action.
    #[must_use]
    pub fn foretell(
        &self,
        vocabulary: &Vocabulary,
        body: Option<BodyId>,
        primitive: PrimitiveId,
        context: &[Observation],
    ) -> Vec<Foretold> {
        let mut foretold = self.foretell_of(vocabulary, body, primitive, context, &|_| true);
        // What always happens to who can do one thing only is put down to that.
        if !foretold.is_empty() && vocabulary.primitives().len() > 1 {
            let background = self.background.foretell(ANYTHING, &[], context, &|_| None, &|_| true);
            // How much else there is does not depend on what comes of values.
            let is_value = |facet: &&Foretold| facet.kinds.iter().any(|kind| vocabulary.is_value(*kind));
            let among = foretold.iter().filter(|facet| !is_value(facet)).count().max(1);
            for facet in &mut foretold {
                facet.attributed = facet.is_attributed(&background, among);
                facet.attribute_parts(&background, among);
            }
        }
        foretold
    }

    /// The same of the types that are wanted, whether it is the action's doing or not.
    fn foretell_of(
        &self,
        vocabulary: &Vocabulary,
        body: Option<BodyId>,
        primitive: PrimitiveId,
        context: &[Observation],
        is_wanted: &dyn Fn(&[TypeId]) -> bool,
    ) -> Vec<Foretold> {
        let recollections = body.and_then(|body| self.recollections.get(&body));
        let recall = |one: &Observation| recollections?.of(one);
        let pool = action(vocabulary, primitive).and_then(|action| self.pools.get(&action));
        let Some(pool) = pool else { return Vec::new() };
        pool.foretell(primitive, &parameters(vocabulary, primitive), context, &recall, is_wanted)
    }
}
