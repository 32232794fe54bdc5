//! Curiosity: what drives the learner beside equation 1 when claims are kept. A few schemas may then cover all that can be done, and
//! what claims say of a place where nothing was ever done may be wrong; so an action is tried where that is new, as long as it surprises.

use std::collections::{BTreeMap, BTreeSet};

use crate::cycle::chaining::Access;
use crate::cycle::claims::context;
use crate::memory::Memory;
use crate::nouns::observation::TypeId;
use crate::nouns::terms::{Drive, Role, Weight};
use crate::nouns::vocabulary::{BodyId, PrimitiveId};
use crate::nouns::world_state::WorldState;

/// How much a primitive draws that was never carried out, for that alone; less, the more often it was.
const STALE: f64 = 0.03;

/// After so many executions a primitive draws half as much by equation 1.
const WORN: f64 = 100.0;

/// The part of a context that makes no noise.
pub(crate) fn quiet(context: WorldState, noise: &BTreeSet<TypeId>) -> WorldState {
    if noise.is_empty() { context } else { context.filter(|o| !noise.contains(&o.kind())) }
}

/// How curious a body is in one world state.
#[derive(Debug)]
pub(crate) struct Curiosity {
    /// How much may be learnt of each primitive that the body has, from 0 to 1, by the primitive's number.
    of: Vec<f64>,
    /// The types that make noise.
    pub(crate) noise: BTreeSet<TypeId>,
    /// How much may be learnt of any primitive of the body anywhere, at most; from 0 to 1.
    most: f64,
    /// How well the noise that primitives make was foretold of late, beside the one that makes least; from 0 to 1, and 1 of those that are
    /// not here.
    foretold: BTreeMap<PrimitiveId, f64>,
    /// What equation 1 is multiplied by: 1, or 1 over the number of values that are perceived.
    share: f64,
}

impl Curiosity {
    /// Of a learner without the mechanism: none, and equation 1 as it is.
    pub(crate) const NONE: Self =
        Self { of: Vec::new(), foretold: BTreeMap::new(), noise: BTreeSet::new(), most: 1.0, share: 1.0 };

    pub(crate) fn new(memory: &Memory, body: BodyId, world: &WorldState) -> Self {
        let content = memory.content();
        if !content.mechanisms.is_curious() {
            return Self::NONE;
        }
        let vocabulary = &content.vocabulary;
        let repertoire = vocabulary.bodies().get(usize::from(body.0)).map_or(&[][..], |b| &b.repertoire);
        let noise = content.evidence.noise(vocabulary, repertoire);
        let context = quiet(context(content, world), &noise);
        let found = content.evidence.curiosity(vocabulary, repertoire, context.observations());
        let mut of = vec![0.0; vocabulary.primitives().len()];
        for (primitive, found) in repertoire.iter().zip(found) {
            // What was done seldom draws a little, wherever that is.
            let stale = STALE / (1.0 + f64::from(content.carried_out(*primitive)));
            if let Some(of) = of.get_mut(primitive.0 as usize) {
                *of = found.max(stale);
            }
        }
        let foretold = content.evidence.told_of_noise(&noise);
        let values: usize = world.observations().iter().map(|o| o.properties().len()).sum();
        let values = values.max(1) as f64;
        let mut curiosity = Self { of, foretold, noise, most: 0.0, share: 1.0 / values };
        let learnable = |primitive: &PrimitiveId| {
            curiosity.trust(memory, *primitive) * content.evidence.surprise(vocabulary, *primitive)
        };
        curiosity.most = repertoire.iter().map(learnable).fold(0.0, f64::max);
        curiosity
    }

    /// How much may be learnt of any primitive anywhere, at most; none without the mechanism.
    pub(crate) fn most(&self) -> Option<f64> {
        (!self.of.is_empty()).then_some(self.most)
    }

    /// How far a primitive is to be trusted: its reliability, less where it makes noise. What can't be foretold however often it is tried is
    /// dull.
    #[inline]
    pub(crate) fn trust(&self, memory: &Memory, primitive: PrimitiveId) -> f64 {
        let foretold = self.foretold.get(&primitive).copied().unwrap_or(1.0);
        memory.content().reliability(primitive) * foretold
    }

    /// What the terms of equation 1 are weighted with for a primitive, before that is shared among what is perceived: how far it is to be trusted,
    /// less where it was carried out often, so that no action is repeated for ever while others wait.
    #[inline]
    pub(crate) fn worth(&self, memory: &Memory, primitive: PrimitiveId) -> f64 {
        let trust = self.trust(memory, primitive);
        if self.of.is_empty() {
            return trust;
        }
        trust * WORN / (WORN + f64::from(memory.content().carried_out(primitive)))
    }

    /// The part of that which counts where this must lead there first: its probability, since a chain of schemas may lead nowhere. 1 without
    /// the mechanism, where equation 1 counts the steps only.
    #[inline]
    pub(crate) fn part(&self, access: Option<Access>) -> f64 {
        if self.of.is_empty() { 1.0 } else { access.map_or(1.0, |access| access.probability) }
    }

    /// The weight of a term of equation 1 for an action that is worth so much.
    #[inline]
    pub(crate) fn weight(&self, worth: f64) -> Weight {
        let of = worth * self.share;
        if self.of.is_empty() { Weight::new(of) } else { Weight::worn(of) }
    }

    /// The drive to carry a primitive out here; none without the mechanism.
    pub(crate) fn drive(&self, memory: &Memory, primitive: PrimitiveId) -> Option<Drive> {
        let of = self.of.get(primitive.0 as usize)?;
        let weight = self.trust(memory, primitive) * of;
        let value = memory.parameters().babbling_excitation * weight;
        Some(Drive { role: Role::Curiosity, weight, value })
    }
}
