//! Experiences: what an action was done in, and what was there afterwards.

use std::sync::Arc;

use crate::nouns::observation::{Observation, TypeId, Value};
use crate::nouns::vocabulary::PrimitiveId;

/// One action that was carried out, with the world before and after it, as far as it may be part of a claim.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Experience {
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
}
