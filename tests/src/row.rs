//! A body small enough to reason about: a finger over a row of fields with a block on one of them.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use pschema_protocol::prelude::*;

/// Fields of the row.
pub const FIELDS: i64 = 8;
/// The field with the block.
const BLOCK: i64 = 5;

/// The body. Equal orders lead to equal frames.
#[derive(Clone, Debug)]
pub struct Row {
    description: Description,
    senses: [SenseId; 4],
    finger: i64,
    /// Orders carried out: every one of them was acknowledged to this body.
    pub acts: Arc<AtomicU64>,
}

impl Row {
    /// A body of that name, its finger over the first field.
    #[must_use]
    pub fn new(name: &str) -> Self {
        let mut description = Description::new(name, "row");
        let field = || Property::integer("field", 0..=FIELDS - 1);
        let colour = Property::symbol("colour", ["red", "blue"]);
        let senses = [
            ObservationType::state("finger").own().property(field()),
            ObservationType::state("object").property(colour).property(field()),
            ObservationType::state("extent").property(Property::real("reach", 0.0..=1.0, 0.01)),
            ObservationType::event("touch"),
        ]
        .map(|sense| description.observation(sense));
        description.action_with_primitives(ActionType::new("move").parameter(field()));
        Self { description, senses, finger: 0, acts: Arc::default() }
    }
}

impl Body for Row {
    fn describe(&self) -> Description {
        self.description.clone()
    }

    fn sense(&mut self, frame: &mut Senses) {
        let [finger, object, extent, touch] = self.senses;
        frame.observe(finger, [self.finger]);
        frame.observe(object, (Value::Symbol(1), BLOCK));
        frame.observe(extent, [0.5]);
        if self.finger == BLOCK {
            frame.observe(touch, ());
        }
    }

    fn act(&mut self, action: &Action) -> Outcome {
        let Some(field) = action.integer(0) else { return Outcome::refused("no field to move to") };
        self.finger = field;
        self.acts.fetch_add(1, Ordering::SeqCst);
        Outcome::Done
    }
}
