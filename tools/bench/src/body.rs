//! A body of no weight, so that nothing but the daemon is measured: a finger over a row of fields, and a block.

use pschema_protocol::body::{Body, Outcome, Senses};
use pschema_protocol::description::{
    Action, ActionType, Description, ObservationType, Property, Value, ValueKind,
};

const FINGER: u16 = 0;
const OBJECT: u16 = 1;
const TOUCH: u16 = 2;
const FIELDS: i64 = 32;
/// Moves between two places of the block.
const MOVES: u64 = 97;

/// The body.
#[derive(Debug, Default)]
pub(crate) struct RowBody {
    finger: i64,
    block: i64,
    moves: u64,
}

fn field() -> Property {
    let kind = ValueKind::Integer { min: 0, max: FIELDS - 1 };
    Property { name: "field".to_owned(), kind, unit: String::new() }
}

impl Body for RowBody {
    fn describe(&self) -> Description {
        let sense = |name: &str, own, transient, properties| ObservationType {
            name: name.to_owned(),
            own,
            transient,
            properties,
        };
        Description {
            name: "bench".to_owned(),
            kind: "row".to_owned(),
            observation_types: vec![
                sense("finger", true, false, vec![field()]),
                sense("object", false, false, vec![field()]),
                sense("touch", false, true, Vec::new()),
            ],
            actions: vec![ActionType { name: "move".to_owned(), parameters: vec![field()] }],
            repertoire: (0..FIELDS)
                .map(|to| Action { action: 0, parameters: vec![Value::Integer(to)] })
                .collect(),
            scene_commands: Vec::new(),
        }
    }

    fn sense(&mut self, frame: &mut Senses) {
        frame.observe(FINGER, &[Value::Integer(self.finger)]);
        frame.observe(OBJECT, &[Value::Integer(self.block)]);
        if self.moves > 0 && self.finger == self.block {
            frame.observe(TOUCH, &[]);
        }
    }

    fn act(&mut self, action: &Action) -> Outcome {
        let Some(Value::Integer(to)) = action.parameters.first() else { return Outcome::Refused };
        self.finger = *to;
        self.moves += 1;
        if self.moves.is_multiple_of(MOVES) {
            self.block = (self.block + 7) % FIELDS;
        }
        Outcome::Done
    }
}
