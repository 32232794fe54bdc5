//! The content of memory: all that a learner knows, as it is written down, digested and looked at.

use std::sync::Arc;

use crate::memory::chunks::Chunks;
use crate::memory::evidence::Evidence;
use crate::nouns::execution::Execution;
use crate::nouns::item::Items;
use crate::nouns::mechanisms::Mechanisms;
use crate::nouns::observation::Observation;
use crate::nouns::probability::Count;
use crate::nouns::progress::Progress;
use crate::nouns::pursuit::Pursuit;
use crate::nouns::random::Random;
use crate::nouns::schema::{Concrete, Generalised, ObservationId, Schema, SchemaId};
use crate::nouns::vocabulary::{BodyId, PrimitiveId, Vocabulary};
use crate::nouns::world_state::WorldState;

/// All that a learner knows, without the indexes that make it fast to ask. It is cheap to clone, for those who inspect it: a clone
/// shares its parts with the original, and a change after it copies the part that changes.
#[derive(Clone, Debug, Default)]
pub struct Content {
    /// The observation types and the actions that bodies declared; shared, for they seldom change.
    pub vocabulary: Arc<Vocabulary>,
    /// The schemas, by number.
    pub schemas: Chunks<Schema>,
    /// The observations that schemas refer to or that were attended to, by number.
    pub observations: Chunks<Observation>,
    /// N(x) for each of these observations (II-C).
    pub attention: Chunks<u32>,
    /// For each of them that is an event: before or after how many executions it was perceived.
    pub happened: Chunks<u32>,
    /// For each primitive: how often it was carried out (occurrences), and how often it was asked for (trials); with curiosity the trials
    /// at which it was not are halved whenever it is.
    pub attempts: Chunks<Count>,
    /// For each body, by number, the execution under way.
    pub pending: Vec<Option<Arc<Execution>>>,
    /// Where the curriculum stands.
    pub progress: Arc<Progress>,
    /// The goal that is pursued, or was the last to be.
    pub pursuit: Option<Arc<Pursuit>>,
    /// The state of the generator.
    pub random: Random,
    /// The number of steps taken.
    pub step: u64,
    /// The number of generalised schemas, retired ones included.
    pub generalised_count: u32,
    /// For each body, by number, how it described itself when it attached last, as text; none where nobody kept that. It is for
    /// the host to compare, and decides nothing.
    pub descriptions: Vec<Option<Arc<str>>>,
    /// Whether memory has come to the limit that its host sets: then nothing new is taken in.
    pub full: bool,
    /// The mechanisms that are on.
    pub mechanisms: Mechanisms,
    /// The experiences that claims grow from, and the claims.
    pub evidence: Evidence,
    /// What is supposed though no sense shows it.
    pub items: Items,
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

    /// How the body of this number described itself when it attached last, if somebody kept that.
    #[must_use]
    pub fn description(&self, body: BodyId) -> Option<&str> {
        self.descriptions.get(usize::from(body.0))?.as_deref()
    }

    /// What `body` perceives with `seen`: what it supposes besides, while items are supposed at all. Nobody follows them else, and what
    /// was supposed once would stand for ever.
    #[must_use]
    pub fn perceived(&self, body: BodyId, seen: &WorldState) -> WorldState {
        self.items.with(self.items.on(usize::from(body.0)).filter(|_| self.mechanisms.supposes()), seen)
    }

    /// w of equation (1), in 0..=1: the share of attempts at which the body carried the action out, counting one success in advance,
    /// so that it is exactly 1 while the action never failed. It weighs down actions that the body refuses or fails to do, with curiosity
    /// as far as that was not made good since.
    #[must_use]
    pub(crate) fn reliability(&self, action: PrimitiveId) -> f64 {
        let attempts = self.attempts.get(action.0 as usize).copied().unwrap_or_default();
        (1.0 + f64::from(attempts.occurrences)) / (1.0 + f64::from(attempts.trials))
    }

    /// How often an action was carried out.
    pub(crate) fn carried_out(&self, action: PrimitiveId) -> u32 {
        self.attempts.get(action.0 as usize).map_or(0, |attempts| attempts.occurrences)
    }

    /// Drops the rest of the chain under way, which was for something else, or is for nothing any more. Its present schema is still
    /// learnt from.
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
