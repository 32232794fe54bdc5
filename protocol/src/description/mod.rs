//! What a body declares of itself when it attaches: its senses, its actions, and what can be arranged
//! around it. Plain values, made with builders, for the author of a body.

mod declaration;
mod property;
mod value;

pub use declaration::{ActionType, Description, ObservationType};
pub use property::{Property, ValueKind};
pub use value::{Action, ActionId, SenseId, Value, Values};
