//! Everything that the author of a body needs: `use pschema_protocol::prelude::*;`.

pub use crate::body::{Body, Outcome, Senses, run_from_args};
pub use crate::description::{
    Action, ActionId, ActionType, Description, ObservationType, Property, SenseId, Value,
};
