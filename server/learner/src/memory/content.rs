//! The content of memory: what is known, as it is written down, digested and looked at.

use std::sync::Arc;

use crate::memory::chunks::Chunks;
use crate::nouns::execution::Execution;
use crate::nouns::observation::Observation;
use crate::nouns::probability::Count;
use crate::nouns::progress::Progress;
use crate::nouns::pursuit::Pursuit;
use crate::nouns::random::Random;
use crate::nouns::schema::{Concrete, Generalised, ObservationId, Schema, SchemaId};
use crate::nouns::vocabulary::{BodyId, PrimitiveId, Vocabulary};

/// What is known, without the indexes that make it fast to ask. Cheap to clone, for those who inspect it: a clone shares
/// what it is of, and a change after it copies the part that changes.
#[derive(Clone, Debug, Default)]
pub struct Content {
    /// What can be perceived and done; shared, for it seldom changes.
    pub vocabulary: Arc<Vocabulary>,
    /// The schemas, by number.
    pub schemas: Chunks<Schema>,
    /// The observations that schemas refer to or that were attended to, by number.
    pub observations: Chunks<Observation>,
    /// N(x) for each of them.
    pub attention: Chunks<u32>,
    /// For each of them that is an event, before or after how many executions it was perceived.
    pub happened: Chunks<u32>,
    /// For each primitive, how often it was asked for and how often carried out.
    pub attempts: Chunks<Count>,
    /// For each body, the execution under way.
    pub pending: Vec<Option<Arc<Execution>>>,
    /// Where the curriculum stands.
    pub progress: Arc<Progress>,
    /// The goal that is pursued, or was the last to be.
    pub pursuit: Option<Arc<Pursuit>>,
    /// The state of the generator.
    pub random: Random,
    /// Steps taken.
    pub step: u64,
    /// How many of the schemas are generalised.
    pub generalised_count: u32,
}

impl Content {
    /// The schema of this number.
    #[must_use]
    pub fn schema(&self, id: SchemaId) -> Option<&Schema> {
        self.schemas.get(id.index())
    }

    /// The concrete schema of this number; none when there is none, or it is generalised.
    #[must_use]
    pub fn concrete(&self, id: SchemaId) -> Option<&Concrete> {
        self.schema(id)?.concrete()
    }

    /// The generalised schema of this number; none when there is none, or it is concrete.
    #[must_use]
    pub fn generalised(&self, id: SchemaId) -> Option<&Generalised> {
        self.schema(id)?.generalised()
    }

    /// The observation of this number. Numbers come from memory itself, so there always is one.
    #[must_use]
    pub fn observation(&self, id: ObservationId) -> &Observation {
        match self.observations.get(id.index()) {
            Some(observation) => observation,
            None => unreachable!("observation {} was never interned", id.0),
        }
    }

    /// Of times asked for, the share that the body carried the action out, counting one success in advance: exactly 1 while
    /// it never failed. Weighs down what the body refuses or fails to do.
    #[must_use]
    pub(crate) fn reliability(&self, action: PrimitiveId) -> f64 {
        let attempts = self.attempts.get(action.0 as usize).copied().unwrap_or_default();
        (1.0 + f64::from(attempts.occurrences)) / (1.0 + f64::from(attempts.trials))
    }

    /// Drops what is left of the chain under way: it was for something else, or is for nothing any more. Its present schema is
    /// still learnt from.
    pub(super) fn forget_chain(&mut self, body: BodyId) {
        if let Some(Some(execution)) = self.pending.get_mut(usize::from(body.0)) {
            Arc::make_mut(execution).chain.clear();
        }
    }

    /// The goal that `body` pursues.
    pub(crate) fn pursuit_of(&self, body: BodyId) -> Option<&Pursuit> {
        self.pursuit.as_deref().filter(|pursuit| pursuit.under_way() && pursuit.body == body)
    }
}
