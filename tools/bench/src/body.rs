//! A body of no weight, so that nothing but the daemon is measured: a finger over a row of fields, and a block.

use pschema_protocol::prelude::*;

const FIELDS: i64 = 32;
/// Moves between two places of the block.
const MOVES: u64 = 97;

/// The body.
#[derive(Debug)]
pub(crate) struct RowBody {
    description: Description,
    senses: [SenseId; 3],
    finger: i64,
    block: i64,
    moves: u64,
}

impl RowBody {
    pub(crate) fn new() -> Self {
        let mut description = Description::new("bench", "row");
        let field = || Property::integer("field", 0..=FIELDS - 1);
        let senses = [
            ObservationType::state("finger").own().property(field()),
            ObservationType::state("object").property(field()),
            ObservationType::event("touch"),
        ]
        .map(|sense| description.observation(sense));
        description.action_with_primitives(ActionType::new("move").parameter(field()));
        Self { description, senses, finger: 0, block: 0, moves: 0 }
    }
}

impl Body for RowBody {
    fn describe(&self) -> Description {
        self.description.clone()
    }

    fn sense(&mut self, frame: &mut Senses) {
        let [finger, object, touch] = self.senses;
        frame.observe(finger, [self.finger]);
        frame.observe(object, [self.block]);
        if self.moves > 0 && self.finger == self.block {
            frame.observe(touch, ());
        }
    }

    fn act(&mut self, action: &Action) -> Outcome {
        let Some(to) = action.integer(0) else { return Outcome::refused("no field to move to") };
        self.finger = to;
        self.moves += 1;
        if self.moves.is_multiple_of(MOVES) {
            self.block = (self.block + 7) % FIELDS;
        }
        Outcome::Done
    }
}
