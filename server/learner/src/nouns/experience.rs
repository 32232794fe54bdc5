//! Experiences: what an action was done in, and what was there afterwards.

use std::sync::Arc;

use crate::nouns::observation::{Observation, TypeId, Value};
use crate::nouns::vocabulary::{BodyId, PrimitiveId};

/// What was done where a new episode begins: nothing, and no primitive has this number.
pub const NOTHING_DONE: PrimitiveId = PrimitiveId(u32::MAX);

/// One action that was carried out, with the world before and after it, as far as it may be part of a claim.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Experience {
    /// The body that it is an experience of.
    pub body: BodyId,
    /// The action.
    pub primitive: PrimitiveId,
    /// The values of its parameters, in order, as they are compared with what is observed; none where nothing can be the same.
    pub parameters: Arc<[Option<Value>]>,
    /// The lasting observations before it, in canonical order.
    pub before: Arc<[Observation]>,
    /// The observations after it, events included, in canonical order.
    pub after: Arc<[Observation]>,
    /// The types that were sensed, in order: of the others it is not known whether anything was there.
    pub sensed: Arc<[TypeId]>,
    /// What was there when the body was last as it was afterwards; none where that is not known. How it is shows in one type, which
    /// the action changes.
    pub recalled: Option<Recalled>,
}

impl Experience {
    /// That a new episode of a body begins. Nothing was done, and nothing is told of what is there.
    #[must_use]
    pub fn beginning(body: BodyId) -> Self {
        let (parameters, nothing, sensed) = ([].into(), Arc::default(), [].into());
        let (before, after) = (Arc::clone(&nothing), nothing);
        Self { body, primitive: NOTHING_DONE, parameters, before, after, sensed, recalled: None }
    }

    /// Whether it is that a new episode begins.
    #[must_use]
    pub fn is_beginning(&self) -> bool {
        let nothing = self.before.is_empty() && self.after.is_empty() && self.sensed.is_empty();
        self.primitive == NOTHING_DONE && nothing && self.recalled.is_none()
    }

    /// Whether it is that an episode ended in what was there before: the action was not carried out, for nothing leads on from there.
    /// What is recalled is then what is there, at age 0, which is so of no other experience.
    #[must_use]
    pub fn is_end(&self) -> bool {
        self.recalled.as_ref().is_some_and(|recalled| recalled.age == 0)
    }
}

/// What was there at another time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recalled {
    /// The observations, in canonical order.
    pub observations: Arc<[Observation]>,
    /// How many experiences of the body ago; 0 of what is there now.
    pub age: u32,
}
