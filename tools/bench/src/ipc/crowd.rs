//! A body that senses as many objects as are asked for, all in no time.

use pschema_protocol::body::{Body, Outcome, Senses};
use pschema_protocol::description::{
    Action, ActionType, Description, ObservationType, Property, Value, ValueKind,
};

const COLOURS: u32 = 8;
const FIELDS: i64 = 460;

/// The body.
#[derive(Debug)]
pub(super) struct CrowdBody {
    objects: usize,
    moves: i64,
}

impl CrowdBody {
    pub(super) fn new(objects: usize) -> Self {
        Self { objects, moves: 0 }
    }
}

fn field() -> Property {
    let kind = ValueKind::Integer { min: 0, max: FIELDS - 1 };
    Property { name: "field".to_owned(), kind, unit: String::new() }
}

impl Body for CrowdBody {
    fn describe(&self) -> Description {
        let symbols = (0..COLOURS).map(|colour| format!("colour {colour}")).collect();
        let colour =
            Property { name: "colour".to_owned(), kind: ValueKind::Symbol { symbols }, unit: String::new() };
        Description {
            name: "bench".to_owned(),
            kind: "watched".to_owned(),
            observation_types: vec![ObservationType {
                name: "object".to_owned(),
                own: false,
                transient: false,
                properties: vec![colour, field()],
            }],
            actions: vec![ActionType { name: "move".to_owned(), parameters: vec![field()] }],
            repertoire: (0..FIELDS)
                .map(|to| Action { action: 0, parameters: vec![Value::Integer(to)] })
                .collect(),
            scene_commands: Vec::new(),
        }
    }

    fn sense(&mut self, frame: &mut Senses) {
        for (number, colour) in (0..self.objects).zip((0..COLOURS).cycle()) {
            let place = self.moves.wrapping_add(i64::try_from(number).unwrap_or(0)).rem_euclid(FIELDS);
            frame.observe(0, &[Value::Symbol(colour), Value::Integer(place)]);
        }
    }

    fn act(&mut self, action: &Action) -> Outcome {
        let Some(Value::Integer(_)) = action.parameters.first() else { return Outcome::Refused };
        self.moves = self.moves.wrapping_add(1);
        Outcome::Done
    }
}
