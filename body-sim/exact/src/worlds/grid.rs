//! A grid of places with labels that say nothing of where they are.

use fastrand::Rng;

use crate::declaration::{Declaration, Observation, Percept, Primitive, Property, Sense, Value};
use crate::distribution::Distribution;
use crate::world::World;

/// `width` x `height` places with opaque labels in random order. `north`, `south`, `east` and `west` lead to the next place, or nowhere
/// at the edge; with probability `slip` nothing happens.
pub(crate) struct Grid {
    width: usize,
    height: usize,
    slip: f64,
    /// The label of each place.
    labels: Vec<usize>,
}

impl Grid {
    /// A grid whose labels `random` decides.
    pub(crate) fn new(width: usize, height: usize, slip: f64, random: &mut Rng) -> Self {
        let mut labels: Vec<_> = (0..width * height).collect();
        random.shuffle(&mut labels);
        Self { width, height, slip, labels }
    }
}

impl World for Grid {
    /// The place, counted row by row from the north-west corner.
    type State = usize;

    fn declaration(&self) -> Declaration {
        let labels = (0..self.labels.len()).map(|label| format!("p{label}"));
        let declaration = Declaration::sensing([Sense::state("at", [Property::symbol("place", labels)])]);
        ["north", "south", "east", "west"].into_iter().fold(declaration, Declaration::action)
    }

    fn random_state(&self, random: &mut Rng) -> usize {
        random.usize(..self.labels.len())
    }

    fn percept(&self, place: &usize) -> Percept {
        [Observation::new(0, [Value::Symbol(self.labels[*place])])].into()
    }

    fn outcomes(&self, place: &usize, primitive: &Primitive) -> Distribution<usize> {
        let (column, row) = (place % self.width, place / self.width);
        let (column, row) = match primitive.action {
            0 => (column, row.saturating_sub(1)),
            1 => (column, (row + 1).min(self.height - 1)),
            2 => ((column + 1).min(self.width - 1), row),
            _ => (column.saturating_sub(1), row),
        };
        [(row * self.width + column, 1.0 - self.slip), (*place, self.slip)].into_iter().collect()
    }
}
