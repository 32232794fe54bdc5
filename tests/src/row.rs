//! A body small enough to reason about: a finger over a row of fields with a block on one of them.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use pschema_protocol::body::{Body, Outcome, Senses};
use pschema_protocol::description::{
    Action, ActionType, Description, ObservationType, Property, Value, ValueKind,
};

/// Fields of the row.
pub const FIELDS: i64 = 8;
/// The field with the block.
const BLOCK: i64 = 5;

/// The body. Equal orders lead to equal frames.
#[derive(Clone, Debug)]
pub struct Row {
    name: String,
    finger: i64,
    /// Orders carried out: every one of them was acknowledged to this body.
    pub acts: Arc<AtomicU64>,
}

impl Row {
    /// A body of that name, its finger over the first field.
    #[must_use]
    pub fn new(name: &str) -> Self {
        Self { name: name.to_owned(), finger: 0, acts: Arc::default() }
    }
}

fn field() -> Property {
    let kind = ValueKind::Integer { min: 0, max: FIELDS - 1 };
    Property { name: "field".to_owned(), kind, unit: String::new() }
}

impl Body for Row {
    fn describe(&self) -> Description {
        let sense = |name: &str, own, transient, properties| ObservationType {
            name: name.to_owned(),
            own,
            transient,
            properties,
        };
        let symbols = ["red", "blue"].map(str::to_owned).to_vec();
        let colour =
            Property { name: "colour".to_owned(), kind: ValueKind::Symbol { symbols }, unit: String::new() };
        let reach = Property {
            name: "reach".to_owned(),
            kind: ValueKind::Real { min: 0.0, max: 1.0, resolution: 0.01 },
            unit: String::new(),
        };
        Description {
            name: self.name.clone(),
            kind: "row".to_owned(),
            observation_types: vec![
                sense("finger", true, false, vec![field()]),
                sense("object", false, false, vec![colour, field()]),
                sense("extent", false, false, vec![reach.clone()]),
                sense("touch", false, true, Vec::new()),
            ],
            actions: vec![ActionType { name: "move".to_owned(), parameters: vec![field()] }],
            repertoire: (0..FIELDS)
                .map(|field| Action { action: 0, parameters: vec![Value::Integer(field)] })
                .collect(),
            scene_commands: Vec::new(),
        }
    }

    fn sense(&mut self, frame: &mut Senses) {
        frame.observe(0, &[Value::Integer(self.finger)]);
        frame.observe(1, &[Value::Symbol(1), Value::Integer(BLOCK)]);
        frame.observe(2, &[Value::Real(0.5)]);
        if self.finger == BLOCK {
            frame.observe(3, &[]);
        }
    }

    fn act(&mut self, action: &Action) -> Outcome {
        let Some(Value::Integer(field)) = action.parameters.first() else { return Outcome::Refused };
        self.finger = *field;
        self.acts.fetch_add(1, Ordering::SeqCst);
        Outcome::Done
    }
}
