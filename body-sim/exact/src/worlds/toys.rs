//! Four toys side by side: one to learn, one that is known at once, one that is noise, and one that can be learnt only with the first.

use fastrand::Rng;

use crate::declaration::{Declaration, Observation, Percept, Primitive, Property, Sense, Value};
use crate::distribution::Distribution;
use crate::world::World;

/// The position that follows each when the wheel is turned.
const TURNS: [usize; 5] = [1, 3, 0, 2, 2];
/// The positions of the wheel at which the drawer moves.
const UNLOCKED: [usize; 3] = [1, 2, 3];
/// The positions of the drawer.
const DRAWER: usize = 3;

/// `turn` turns a wheel by a rule of its own, `press` does nothing, `flip` shows one of some pictures at random, and `pull` moves a drawer, at some
/// positions of the wheel only.
pub(crate) struct Toys {
    pub(crate) pictures: usize,
}

/// The positions of the wheel and of the drawer, and the picture.
type State = [usize; 3];

impl World for Toys {
    type State = State;

    fn declaration(&self) -> Declaration {
        let toys = [("wheel", "position", TURNS.len()), ("drawer", "drawn", DRAWER)];
        let toys = toys.into_iter().chain([("picture", "number", self.pictures)]);
        let senses =
            toys.map(|(name, property, count)| Sense::state(name, [Property::below(property, count)]));
        let declaration = Declaration::sensing(senses.collect::<Vec<_>>());
        ["turn", "press", "flip", "pull"].into_iter().fold(declaration, Declaration::action)
    }

    fn random_state(&self, random: &mut Rng) -> State {
        [random.usize(..TURNS.len()), random.usize(..DRAWER), random.usize(..self.pictures)]
    }

    fn percept(&self, state: &State) -> Percept {
        let observed = |(sense, position): (usize, &usize)| {
            Observation::new(sense, [Value::Integer(i64::try_from(*position).unwrap_or(i64::MAX))])
        };
        state.iter().enumerate().map(observed).collect()
    }

    fn outcomes(&self, &[wheel, drawer, picture]: &State, primitive: &Primitive) -> Distribution<State> {
        match primitive.action {
            0 => Distribution::certain([TURNS[wheel], drawer, picture]),
            2 => {
                let each = 1.0 / self.pictures as f64;
                (0..self.pictures).map(|picture| ([wheel, drawer, picture], each)).collect()
            }
            3 if UNLOCKED.contains(&wheel) => Distribution::certain([wheel, (drawer + 1) % DRAWER, picture]),
            _ => Distribution::certain([wheel, drawer, picture]),
        }
    }
}
