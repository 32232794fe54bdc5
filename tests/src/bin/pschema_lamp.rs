//! A lamp with three buttons and a bell.

use std::process::ExitCode;

use pschema_protocol::body::{Body, Outcome, Senses, run_from_args};
use pschema_protocol::description::{
    Action, ActionType, Description, ObservationType, Property, Value, ValueKind,
};

const COLOURS: [&str; 3] = ["dark", "red", "green"];
const GREEN: u32 = 2;
// What the body senses, in the order it declares them.
const LAMP: u16 = 0;
const BELL: u16 = 1;

#[derive(Default)]
struct Lamp {
    colour: u32,
    rang: bool,
}

impl Body for Lamp {
    fn describe(&self) -> Description {
        let property = |name: &str, kind| Property { name: name.into(), kind, unit: String::new() };
        let colours = COLOURS.iter().map(|colour| (*colour).to_owned()).collect();
        let sense = |name: &str, transient, properties| ObservationType {
            name: name.into(),
            own: false, // not part of the body itself, so what an action does may depend on it
            transient,  // an event, which holds for one frame only
            properties,
        };
        Description {
            name: "lamp".into(),
            kind: "lamp".into(),
            observation_types: vec![
                sense("lamp", false, vec![property("colour", ValueKind::Symbol { symbols: colours })]),
                sense("bell", true, vec![]),
            ],
            actions: vec![ActionType {
                name: "press".into(),
                parameters: vec![property("button", ValueKind::Integer { min: 1, max: 3 })],
            }],
            // Everything it can do, with the numbers filled in.
            repertoire: (1..=3)
                .map(|button| Action { action: 0, parameters: vec![Value::Integer(button)] })
                .collect(),
            scene_commands: vec![],
        }
    }

    fn sense(&mut self, frame: &mut Senses) {
        frame.observe(LAMP, &[Value::Symbol(self.colour)]);
        if self.rang {
            frame.observe(BELL, &[]);
        }
    }

    fn act(&mut self, action: &Action) -> Outcome {
        self.rang = false;
        match action.parameters.first() {
            Some(Value::Integer(1)) => self.colour = (self.colour + 1) % 3,
            Some(Value::Integer(2)) => self.colour = 0,
            Some(Value::Integer(3)) => self.rang = self.colour == GREEN,
            _ => return Outcome::Refused,
        }
        Outcome::Done
    }
}

fn main() -> ExitCode {
    run_from_args(Lamp::default())
}
