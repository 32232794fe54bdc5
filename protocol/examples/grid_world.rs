//! A body that is no robot: an agent on a grid that senses its place, food and walls, and steps in four directions.
//! `cargo run --release -p pschema-protocol --example grid_world -- --name demo`

use pschema_protocol::prelude::*;

const SIDE: i64 = 5;
const STEPS: [(&str, i64, i64); 4] = [("north", 0, -1), ("east", 1, 0), ("south", 0, 1), ("west", -1, 0)];
/// Where food grows: once it is eaten, at the next of these places.
const GARDEN: [(i64, i64); 4] = [(4, 4), (0, 4), (2, 2), (4, 0)];

pub(crate) struct GridWorld {
    description: Description,
    senses: [SenseId; 4],
    place: (i64, i64),
    meals: usize,
    just_ate: bool,
}

impl GridWorld {
    pub(crate) fn new() -> Self {
        let mut description = Description::new("grid-world", "grid-world");
        let along = |axis| Property::integer(axis, 0..=SIDE - 1);
        let somewhere = |name| ObservationType::state(name).property(along("x")).property(along("y"));
        let direction = Property::symbol("direction", STEPS.map(|(name, ..)| name));
        let wall = ObservationType::state("wall").property(direction.clone());
        // Its place is not its own: what a step does depends on it, and what is the body's own is no pre-condition.
        let senses = [somewhere("place"), somewhere("food"), wall, ObservationType::event("taste")];
        let senses = senses.map(|sense| description.observation(sense));
        description.action_with_primitives(ActionType::new("step").parameter(direction));
        Self { description, senses, place: (0, 0), meals: 0, just_ate: false }
    }

    /// Where a step leads: nowhere else when there is a wall.
    fn after_step(&self, direction: usize) -> (i64, i64) {
        let (_, dx, dy) = STEPS[direction];
        ((self.place.0 + dx).clamp(0, SIDE - 1), (self.place.1 + dy).clamp(0, SIDE - 1))
    }
}

impl Body for GridWorld {
    fn describe(&self) -> Description {
        self.description.clone()
    }

    fn sense(&mut self, frame: &mut Senses) {
        let [place, food, wall, taste] = self.senses;
        frame.observe(place, self.place);
        frame.observe(food, GARDEN[self.meals % GARDEN.len()]);
        for direction in (0..STEPS.len()).filter(|direction| self.after_step(*direction) == self.place) {
            frame.observe(wall, [Value::symbol(direction)]);
        }
        if self.just_ate {
            frame.observe(taste, ());
        }
    }

    fn act(&mut self, action: &Action) -> Outcome {
        let Some(direction) = action.symbol(0) else { return Outcome::refused("a step has a direction") };
        // Bumping into a wall is a step carried out: it changes nothing, which can be learnt.
        self.place = self.after_step(direction);
        self.just_ate = self.place == GARDEN[self.meals % GARDEN.len()];
        self.meals += usize::from(self.just_ate);
        Outcome::Done
    }
}

pub(crate) fn main() -> std::process::ExitCode {
    run_from_args(GridWorld::new())
}
