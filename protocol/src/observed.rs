//! Observations of a frame that passed every check, read where the daemon copied them to: nothing is allocated for them.

use crate::body::SensedObservation;
use crate::description::Value;
use crate::wire::{Record, kind};

/// What a body senses, in the order reported. Only [`crate::decode::Session`] makes one, of records that it checked.
#[derive(Clone, Copy, Debug)]
pub struct Observed<'a>(&'a [Record]);

impl<'a> Observed<'a> {
    pub(crate) fn of(checked: &'a [Record]) -> Self {
        Self(checked)
    }

    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether nothing is sensed.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// One after the other.
    pub fn iter(&self) -> impl Iterator<Item = One<'a>> + use<'a> {
        self.0.iter().map(One)
    }

    /// All of them copied, for who keeps them.
    #[must_use]
    pub fn to_vec(&self) -> Vec<SensedObservation> {
        let sensed = |one: One<'_>| SensedObservation {
            observation_type: one.observation_type(),
            values: one.values().collect(),
        };
        self.iter().map(sensed).collect()
    }
}

/// One observation.
#[derive(Clone, Copy, Debug)]
pub struct One<'a>(&'a Record);

impl<'a> One<'a> {
    /// Index into [`crate::description::Description::observation_types`].
    #[must_use]
    pub fn observation_type(&self) -> u16 {
        self.0.index
    }

    /// One value a property, in declared order.
    pub fn values(&self) -> impl Iterator<Item = Value> + use<'a> {
        let record = self.0;
        let tags = (0..u32::BITS).step_by(4).map(move |shift| (record.kinds >> shift) & 0xf);
        record.values.iter().take(usize::from(record.count)).zip(tags).map(|(bits, tag)| value(tag, *bits))
    }
}

/// What was checked to be a value of this kind.
fn value(tag: u32, bits: u64) -> Value {
    match tag {
        kind::SYMBOL => Value::Symbol(u32::try_from(bits).unwrap_or(u32::MAX)),
        kind::BOOLEAN => Value::Boolean(bits == 1),
        kind::REAL => Value::Real(f64::from_bits(bits)),
        _ => Value::Integer(bits.cast_signed()),
    }
}
