//! Worlds with hidden states (Holmes & Isbell 2006): flip, float/reset, and float/reset modified.

use fastrand::Rng;

use crate::declaration::{Declaration, Observation, Percept, Primitive, Property, Sense, Value};
use crate::distribution::Distribution;
use crate::world::World;

/// A hidden place, and what the sensor said of the last action.
type State = (usize, bool);

fn sensor(actions: &[&str]) -> Declaration {
    let declaration = Declaration::sensing([Sense::state("sensor", [Property::boolean("on")])]);
    actions.iter().fold(declaration, |declaration, name| declaration.action(name))
}

fn sensed((_, on): &State) -> Percept {
    [Observation::new(0, [Value::Boolean(*on)])].into()
}

/// Two hidden states. `left` leads to the left one, `right` to the right one, `stay` stays. The sensor is on when the last action
/// changed the state. It is deterministic, and no one observation tells what comes.
pub(crate) struct Flip;

impl World for Flip {
    type State = State;

    fn declaration(&self) -> Declaration {
        sensor(&["left", "right", "stay"])
    }

    fn random_state(&self, random: &mut Rng) -> State {
        (random.usize(..2), false)
    }

    fn percept(&self, state: &State) -> Percept {
        sensed(state)
    }

    fn outcomes(&self, (place, _): &State, primitive: &Primitive) -> Distribution<State> {
        let next = [0, 1, *place][primitive.action];
        Distribution::certain((next, next != *place))
    }

    fn prior(&self) -> Option<Distribution<State>> {
        Some(Distribution::even([(0, false), (1, false)]))
    }
}

/// The rightmost of the five hidden states of float/reset.
const RIGHT_END: usize = 4;

/// Five hidden states in a row. `float` moves left or right, each as likely, and stays at an end that it would leave; `reset` leads to the right
/// end. The sensor is on when `reset` was carried out at the right end. Modified: `float` in the two rightmost states moves left.
pub(crate) struct FloatReset {
    pub(crate) modified: bool,
}

impl World for FloatReset {
    type State = State;

    fn declaration(&self) -> Declaration {
        sensor(&["float", "reset"])
    }

    /// The right end, as after a reset.
    fn random_state(&self, _random: &mut Rng) -> State {
        (RIGHT_END, false)
    }

    fn percept(&self, state: &State) -> Percept {
        sensed(state)
    }

    fn outcomes(&self, (place, _): &State, primitive: &Primitive) -> Distribution<State> {
        let (left, right) = (place.saturating_sub(1), (place + 1).min(RIGHT_END));
        match primitive.action {
            0 if self.modified && *place + 1 >= RIGHT_END => Distribution::certain((left, false)),
            0 => Distribution::even([(left, false), (right, false)]),
            _ => Distribution::certain((RIGHT_END, *place == RIGHT_END)),
        }
    }

    fn prior(&self) -> Option<Distribution<State>> {
        Some(Distribution::certain((RIGHT_END, false)))
    }
}
