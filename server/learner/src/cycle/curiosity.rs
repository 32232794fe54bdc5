//! Curiosity: what drives the learner beside equation 1 when claims are kept. A few schemas may then cover all that can be done, and
//! what claims say of a place where nothing was ever done may be wrong; so an action is tried where that is new, as long as it surprises.

use crate::cycle::claims::context;
use crate::memory::Memory;
use crate::nouns::terms::{Drive, Role, Weight};
use crate::nouns::vocabulary::{BodyId, PrimitiveId};
use crate::nouns::world_state::WorldState;

/// How curious a body is in one world state.
#[derive(Debug)]
pub(crate) struct Curiosity {
    /// How much may be learnt of each primitive that the body has, from 0 to 1, by the primitive's number.
    of: Vec<f64>,
    /// How much may be learnt of any primitive of the body anywhere, at most; from 0 to 1.
    most: f64,
    /// What equation 1 is multiplied by: 1, or 1 over the number of values that are perceived.
    share: f64,
}

impl Curiosity {
    /// Of a learner without the mechanism: none, and equation 1 as it is.
    pub(crate) const NONE: Self = Self { of: Vec::new(), most: 1.0, share: 1.0 };

    pub(crate) fn new(memory: &Memory, body: BodyId, world: &WorldState) -> Self {
        let content = memory.content();
        if !content.mechanisms.is_curious() {
            return Self::NONE;
        }
        let vocabulary = &content.vocabulary;
        let repertoire = vocabulary.bodies().get(usize::from(body.0)).map_or(&[][..], |b| &b.repertoire);
        let context = context(content, world);
        let found = content.evidence.curiosity(vocabulary, repertoire, context.observations());
        let mut of = vec![0.0; vocabulary.primitives().len()];
        for (primitive, found) in repertoire.iter().zip(found) {
            if let Some(of) = of.get_mut(primitive.0 as usize) {
                *of = found;
            }
        }
        let values: usize = world.observations().iter().map(|o| o.properties().len()).sum();
        let learnable = |primitive: &PrimitiveId| {
            content.reliability(*primitive) * content.evidence.surprise(vocabulary, *primitive)
        };
        let most = repertoire.iter().map(learnable).fold(0.0, f64::max);
        Self { of, most, share: 1.0 / values.max(1) as f64 }
    }

    /// How much may be learnt of any primitive anywhere, at most; none without the mechanism.
    pub(crate) fn most(&self) -> Option<f64> {
        (!self.of.is_empty()).then_some(self.most)
    }

    /// The weight of a term of equation 1 for an action of this reliability.
    pub(crate) fn weight(&self, reliability: f64) -> Weight {
        let of = reliability * self.share;
        if self.of.is_empty() { Weight::new(of) } else { Weight::worn(of) }
    }

    /// The drive to carry a primitive out here; none without the mechanism.
    pub(crate) fn drive(&self, memory: &Memory, primitive: PrimitiveId) -> Option<Drive> {
        let of = self.of.get(primitive.0 as usize)?;
        let weight = memory.content().reliability(primitive) * of;
        let value = memory.parameters().babbling_excitation * weight;
        Some(Drive { role: Role::Curiosity, weight, value })
    }
}
