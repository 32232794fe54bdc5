//! A body that senses as many objects as are asked for, all in no time.

use pschema_protocol::prelude::*;

const COLOURS: u32 = 8;
const FIELDS: i64 = 460;

/// The body.
#[derive(Debug)]
pub(super) struct CrowdBody {
    description: Description,
    object: SenseId,
    objects: usize,
    moves: i64,
}

impl CrowdBody {
    pub(super) fn new(objects: usize) -> Self {
        let mut description = Description::new("bench", "watched");
        let colour = Property::symbol("colour", (0..COLOURS).map(|colour| format!("colour {colour}")));
        let field = || Property::integer("field", 0..=FIELDS - 1);
        let object = ObservationType::state("object").property(colour).property(field());
        let object = description.observation(object);
        description.action_with_primitives(ActionType::new("move").parameter(field()));
        Self { description, object, objects, moves: 0 }
    }
}

impl Body for CrowdBody {
    fn describe(&self) -> Description {
        self.description.clone()
    }

    fn sense(&mut self, frame: &mut Senses) {
        for (number, colour) in (0..self.objects).zip((0..COLOURS).cycle()) {
            let place = self.moves.wrapping_add(i64::try_from(number).unwrap_or(0)).rem_euclid(FIELDS);
            frame.observe(self.object, (Value::Symbol(colour), place));
        }
    }

    fn act(&mut self, action: &Action) -> Outcome {
        if action.integer(0).is_none() {
            return Outcome::refused("no field to move to");
        }
        self.moves = self.moves.wrapping_add(1);
        Outcome::Done
    }
}
