//! Switches that turn on in one order only, beside lamps that blink.

use fastrand::Rng;

use crate::declaration::{Declaration, Observation, Percept, Primitive, Property, Sense, Value};
use crate::distribution::Distribution;
use crate::world::World;

/// `press` turns a switch on if it is the next in an order that nothing shows; else all go off. Lamps beside them blink.
pub(crate) struct Puzzle {
    /// The switches in the order in which they turn on.
    order: Vec<usize>,
    lamps: usize,
}

impl Puzzle {
    /// A puzzle with an order of its own.
    pub(crate) fn new(switches: usize, lamps: usize, random: &mut Rng) -> Self {
        let mut order: Vec<_> = (0..switches).collect();
        random.shuffle(&mut order);
        Self { order, lamps }
    }

    fn all_lamps(&self) -> Vec<Vec<bool>> {
        (0..1_u32 << self.lamps)
            .map(|lit| (0..self.lamps).map(|lamp| lit >> lamp & 1 == 1).collect())
            .collect()
    }
}

impl World for Puzzle {
    /// How many switches are on, and which lamps.
    type State = (usize, Vec<bool>);

    fn declaration(&self) -> Declaration {
        let switch = || Property::below("switch", self.order.len());
        let lamps =
            (0..self.lamps).map(|lamp| Sense::state(&format!("lamp-{lamp}"), [Property::boolean("lit")]));
        let senses: Vec<_> =
            [Sense::state("on", [switch()])].into_iter().chain(lamps.map(Sense::noise)).collect();
        Declaration::sensing(senses).action_for_each("press", switch())
    }

    fn random_state(&self, random: &mut Rng) -> (usize, Vec<bool>) {
        (random.usize(..=self.order.len()), (0..self.lamps).map(|_| random.bool()).collect())
    }

    fn percept(&self, (on, lamps): &(usize, Vec<bool>)) -> Percept {
        let switch = |switch: &usize| Value::Integer(i64::try_from(*switch).unwrap_or(i64::MAX));
        let switches = self.order.iter().take(*on).map(|each| Observation::new(0, [switch(each)]));
        let lamps =
            lamps.iter().enumerate().map(|(lamp, lit)| Observation::new(lamp + 1, [Value::Boolean(*lit)]));
        switches.chain(lamps).collect()
    }

    fn outcomes(
        &self,
        (on, _): &(usize, Vec<bool>),
        primitive: &Primitive,
    ) -> Distribution<(usize, Vec<bool>)> {
        let on = if self.order.get(*on) == Some(&primitive.number()) { on + 1 } else { 0 };
        let lamps = self.all_lamps();
        let each = 1.0 / lamps.len() as f64;
        lamps.into_iter().map(|lamps| ((on, lamps), each)).collect()
    }
}
