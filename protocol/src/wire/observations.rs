//! Observations read from their records, where those lie: nothing is allocated for them.

use super::layout::{Record, kind};
use crate::description::{SenseId, Value};

/// What a body senses in one frame, in the order reported. A frame's come from [`super::decode::SessionChecks`], which has
/// checked the records.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observations<'a>(&'a [Record]);

impl<'a> Observations<'a> {
    pub(crate) fn of(records: &'a [Record]) -> Self {
        Self(records)
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
    pub fn iter(&self) -> impl Iterator<Item = ObservationRecord<'a>> + use<'a> {
        self.0.iter().map(ObservationRecord)
    }
}

/// One observation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObservationRecord<'a>(&'a Record);

impl<'a> ObservationRecord<'a> {
    /// The observation type that it is of.
    #[must_use]
    pub fn sense(&self) -> SenseId {
        SenseId::from_index(self.0.index)
    }

    /// One value a property, in declared order.
    pub fn values(&self) -> impl Iterator<Item = Value> + use<'a> {
        let record = self.0;
        let tags = (0..u32::BITS).step_by(4).map(move |shift| (record.kinds >> shift) & 0xf);
        record.values.iter().take(usize::from(record.count)).zip(tags).map(|(bits, tag)| value(tag, *bits))
    }
}

/// The value of kind `tag` that `bits` stand for, in a record that was checked.
fn value(tag: u32, bits: u64) -> Value {
    match tag {
        kind::SYMBOL => Value::Symbol(u32::try_from(bits).unwrap_or(u32::MAX)),
        kind::BOOLEAN => Value::Boolean(bits == 1),
        kind::REAL => Value::Real(f64::from_bits(bits)),
        _ => Value::Integer(bits.cast_signed()),
    }
}
