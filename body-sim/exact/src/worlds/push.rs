//! An object that a push moves one field on.

use fastrand::Rng;

use crate::declaration::{Declaration, Observation, Percept, Primitive, Property, Sense, Value};
use crate::distribution::Distribution;
use crate::world::World;

/// Fields in a row, numbered, with one object. A push at its field moves it to the next field, or nowhere from the last; a push at
/// another field changes nothing. Every four actions others put it into a random field.
pub(crate) struct Push {
    pub(crate) fields: usize,
}

impl World for Push {
    /// The field of the object.
    type State = usize;

    fn declaration(&self) -> Declaration {
        let field = || Property::below("field", self.fields);
        Declaration::sensing([Sense::state("object", [field()])]).action_for_each("push", field())
    }

    fn random_state(&self, random: &mut Rng) -> usize {
        random.usize(..self.fields)
    }

    fn percept(&self, object: &usize) -> Percept {
        let field = i64::try_from(*object).unwrap_or(i64::MAX);
        [Observation::new(0, [Value::Integer(field)])].into()
    }

    fn outcomes(&self, object: &usize, primitive: &Primitive) -> Distribution<usize> {
        let pushed = primitive.number() == *object && object + 1 < self.fields;
        Distribution::certain(object + usize::from(pushed))
    }

    fn spell(&self) -> Option<usize> {
        Some(4)
    }
}
