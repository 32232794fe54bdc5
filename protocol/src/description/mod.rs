//! The description of a body: its senses, its actions, and what a curriculum can arrange around it. These are plain values
//! with builders, for the author of a body.

mod declaration;
mod property;
mod value;

pub use declaration::{ActionType, Description, ObservationType, WORLD_MARK};
pub use property::{Property, ValueKind};
pub use value::{Action, ActionId, SenseId, Value, Values};
