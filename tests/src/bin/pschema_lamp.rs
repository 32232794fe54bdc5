//! A lamp with three buttons and a bell.

use std::process::ExitCode;

use pschema_protocol::prelude::*;

const COLOURS: [&str; 3] = ["dark", "red", "green"];
const GREEN: usize = 2;

struct Lamp {
    description: Description,
    lamp: SenseId,
    bell: SenseId,
    colour: usize,
    rang: bool,
}

impl Lamp {
    fn new() -> Self {
        let mut description = Description::new("lamp", "lamp");
        // What it senses: a state, which lasts, and an event, which holds for one frame only.
        let colour = Property::symbol("colour", COLOURS);
        let lamp = description.observation(ObservationType::state("lamp").property(colour));
        let bell = description.observation(ObservationType::event("bell"));
        // What it can do: press each of the buttons.
        let button = Property::integer("button", 1..=3);
        description.action_with_primitives(ActionType::new("press").parameter(button));
        Self { description, lamp, bell, colour: 0, rang: false }
    }
}

impl Body for Lamp {
    fn describe(&self) -> Description {
        self.description.clone()
    }

    fn sense(&mut self, frame: &mut Senses) {
        frame.observe(self.lamp, [Value::symbol(self.colour)]);
        if self.rang {
            frame.observe(self.bell, ());
        }
    }

    fn act(&mut self, action: &Action) -> Outcome {
        self.rang = false;
        match action.integer(0) {
            Some(1) => self.colour = (self.colour + 1) % COLOURS.len(),
            Some(2) => self.colour = 0,
            Some(3) => self.rang = self.colour == GREEN,
            _ => return Outcome::refused("there are three buttons"),
        }
        Outcome::Done
    }
}

fn main() -> ExitCode {
    run_from_args(Lamp::new())
}
