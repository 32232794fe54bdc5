//! A world in which the outcome of an action depends on the body's own posture.

use fastrand::Rng;

use crate::declaration::{Declaration, Observation, Percept, Primitive, Property, Sense, Value};
use crate::distribution::Distribution;
use crate::world::World;

/// An arm that can take one of some heights, and a switch at height 0. `take` leads to a height. `press` turns the light on or off at
/// height 0, and changes nothing at any other. The height is the body's own observation.
pub(crate) struct Posture {
    pub(crate) heights: usize,
}

impl World for Posture {
    /// The height, and whether the light is on.
    type State = (usize, bool);

    fn declaration(&self) -> Declaration {
        let height = || Property::below("height", self.heights);
        Declaration::sensing([
            Sense::state("arm", [height()]).own(),
            Sense::state("light", [Property::boolean("on")]),
        ])
        .action_for_each("take", height())
        .action("press")
    }

    fn random_state(&self, random: &mut Rng) -> (usize, bool) {
        (random.usize(..self.heights), random.bool())
    }

    fn percept(&self, (height, on): &(usize, bool)) -> Percept {
        let height = i64::try_from(*height).unwrap_or(i64::MAX);
        [Observation::new(0, [Value::Integer(height)]), Observation::new(1, [Value::Boolean(*on)])].into()
    }

    fn outcomes(&self, (height, on): &(usize, bool), primitive: &Primitive) -> Distribution<(usize, bool)> {
        Distribution::certain(match primitive.action {
            0 => (primitive.number(), *on),
            _ => (*height, *on != (*height == 0)),
        })
    }
}
