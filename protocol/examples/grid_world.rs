//! A body that is no robot: an agent on a grid of 5 by 5 that sees where it stands, food beside it and
//! walls, and can step in four directions. Eating makes the food grow somewhere else.
//!
//! `cargo run --release -p pschema-protocol --example grid_world -- --name demo`

use std::process::ExitCode;

use pschema_protocol::body::{Body, Outcome, Senses, run_from_args};
use pschema_protocol::description::{
    Action, ActionType, Description, ObservationType, Property, Value, ValueKind,
};

const SIDE: i64 = 5;
const DIRECTIONS: [(&str, i64, i64); 4] =
    [("north", 0, -1), ("east", 1, 0), ("south", 0, 1), ("west", -1, 0)];
/// Where food grows, one place after the other.
const GARDEN: [(i64, i64); 4] = [(4, 4), (0, 4), (2, 2), (4, 0)];

// What the body senses, in the order it declares them.
const PLACE: u16 = 0;
const FOOD: u16 = 1;
const WALL: u16 = 2;
const TASTE: u16 = 3;

#[derive(Default)]
pub(crate) struct GridWorld {
    x: i64,
    y: i64,
    meals: usize,
    just_ate: bool,
}

impl GridWorld {
    fn food(&self) -> (i64, i64) {
        GARDEN[self.meals % GARDEN.len()]
    }
}

impl Body for GridWorld {
    fn describe(&self) -> Description {
        let property = |name: &str, kind| Property { name: name.into(), kind, unit: String::new() };
        let along = || ValueKind::Integer { min: 0, max: SIDE - 1 };
        let names = DIRECTIONS.iter().map(|(name, ..)| (*name).to_owned()).collect();
        let direction = property("direction", ValueKind::Symbol { symbols: names });
        let place = vec![property("x", along()), property("y", along())];
        let sense = |name: &str, own, transient, properties| ObservationType {
            name: name.into(),
            own,
            transient,
            properties,
        };
        Description {
            name: "grid-world".into(),
            kind: "grid-world".into(),
            observation_types: vec![
                // Not the body's own, though it is where the body stands: what a step does depends on it, and
                // what is the body's own is never a pre-condition.
                sense("place", false, false, place.clone()),
                sense("food", false, false, place),
                sense("wall", false, false, vec![direction.clone()]),
                sense("taste", false, true, vec![]),
            ],
            actions: vec![ActionType { name: "step".into(), parameters: vec![direction] }],
            repertoire: (0..4)
                .map(|one| Action { action: 0, parameters: vec![Value::Symbol(one)] })
                .collect(),
            scene_commands: vec![],
        }
    }

    fn sense(&mut self, frame: &mut Senses) {
        frame.observe(PLACE, &[Value::Integer(self.x), Value::Integer(self.y)]);
        let (x, y) = self.food();
        frame.observe(FOOD, &[Value::Integer(x), Value::Integer(y)]);
        for (direction, (_, dx, dy)) in (0..).zip(DIRECTIONS) {
            if !is_inside(self.x + dx, self.y + dy) {
                frame.observe(WALL, &[Value::Symbol(direction)]);
            }
        }
        if self.just_ate {
            frame.observe(TASTE, &[]);
        }
    }

    fn act(&mut self, action: &Action) -> Outcome {
        let Some(Value::Symbol(direction)) = action.parameters.first() else { return Outcome::Refused };
        let Some((_, dx, dy)) = DIRECTIONS.get(*direction as usize) else { return Outcome::Refused };
        self.just_ate = false;
        if is_inside(self.x + dx, self.y + dy) {
            (self.x, self.y) = (self.x + dx, self.y + dy);
        }
        // Bumping into a wall is a step carried out: it changes nothing, which can be learnt.
        if (self.x, self.y) == self.food() {
            self.meals += 1;
            self.just_ate = true;
        }
        Outcome::Done
    }
}

fn is_inside(x: i64, y: i64) -> bool {
    (0..SIDE).contains(&x) && (0..SIDE).contains(&y)
}

pub(crate) fn main() -> ExitCode {
    run_from_args(GridWorld::default())
}
