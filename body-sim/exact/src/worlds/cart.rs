//! A cart on a line, its position known as finely as one likes, beside sensors that only make noise.

use fastrand::Rng;

use crate::declaration::{Declaration, Observation, Percept, Primitive, Property, Sense, Value};
use crate::distribution::Distribution;
use crate::world::World;

/// Values of a sensor that only makes noise: 0 to 1 in steps of .1.
const READINGS: i64 = 11;

/// A cart at x in [0, 1], known to 1 / `bins`. `left` and `right` move it by .1, and the ends hold it. Every 20 actions others put it at a
/// random x. Each of `sensors` shows one of 11 values, drawn anew with every action.
pub(crate) struct Cart {
    /// A multiple of 10.
    pub(crate) bins: i64,
    pub(crate) sensors: usize,
}

#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct State {
    x: i64,
    readings: Vec<i64>,
}

impl World for Cart {
    type State = State;

    fn declaration(&self) -> Declaration {
        let cart = Sense::state("cart", [Property::unit_real("x", self.bins)]);
        let sensor = |number| {
            let reading = Property::unit_real(&format!("reading-{number}"), READINGS - 1);
            Sense::state(&format!("sensor-{number}"), [reading]).noise()
        };
        let senses: Vec<_> = [cart].into_iter().chain((1..=self.sensors).map(sensor)).collect();
        Declaration::sensing(senses).action("left").action("right")
    }

    fn random_state(&self, random: &mut Rng) -> State {
        let readings = (0..self.sensors).map(|_| random.i64(0..READINGS)).collect();
        State { x: random.i64(0..=self.bins), readings }
    }

    fn percept(&self, state: &State) -> Percept {
        let values = [&state.x].into_iter().chain(&state.readings).enumerate();
        values.map(|(sense, value)| Observation::new(sense, [Value::Real(*value)])).collect()
    }

    fn outcomes(&self, state: &State, primitive: &Primitive) -> Distribution<State> {
        let way = if primitive.action == 0 { -self.bins / 10 } else { self.bins / 10 };
        let moved = State { x: (state.x + way).clamp(0, self.bins), ..state.clone() };
        (0..self.sensors).fold(Distribution::certain(moved), |all, sensor| {
            all.then(|state| {
                Distribution::from_iter((0..READINGS).map(|reading| {
                    let mut next = state.clone();
                    next.readings[sensor] = reading;
                    (next, 1.0 / READINGS as f64)
                }))
            })
        })
    }

    fn spell(&self) -> Option<usize> {
        Some(20)
    }
}
