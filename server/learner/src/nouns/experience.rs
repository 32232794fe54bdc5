//! Experiences: what an action was done in, and what was there afterwards.

use std::sync::Arc;

use crate::nouns::observation::{Observation, TypeId, Value};
use crate::nouns::vocabulary::{BodyId, PrimitiveId};

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

/// What was there at another time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recalled {
    /// The observations, in canonical order.
    pub observations: Arc<[Observation]>,
    /// How many experiences of the body ago; 0 of what is there now.
    pub age: u32,
}
