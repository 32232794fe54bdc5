//! The declared limits of observations, laid out so that a record is checked against them in a few nanoseconds. This says only
//! yes or no; [`super::decode`], which reads the declarations as they were given, says why not.

use super::layout::{Record, kind};
use crate::description::{ObservationType, ValueKind};
use crate::limits::PROPERTIES_MAX;

/// The values that one property may take.
#[derive(Clone, Copy, Debug)]
enum Bound {
    /// Whole numbers of which the bits are at most `span` above `base`: integers from their least, symbols and booleans from 0.
    Whole { base: u64, span: u64 },
    /// Reals in `min..=max`.
    Real { min: f64, max: f64 },
}

impl Bound {
    fn of(declared: &ValueKind) -> Self {
        match declared {
            ValueKind::Integer { min, max } => {
                Self::Whole { base: min.cast_unsigned(), span: max.wrapping_sub(*min).cast_unsigned() }
            }
            // A declaration that was checked has at least one symbol.
            ValueKind::Symbol { symbols } => {
                Self::Whole { base: 0, span: symbols.len().saturating_sub(1) as u64 }
            }
            ValueKind::Boolean => Self::Whole { base: 0, span: 1 },
            ValueKind::Real { min, max, .. } => Self::Real { min: *min, max: *max },
        }
    }

    fn holds(&self, bits: u64) -> bool {
        match *self {
            Self::Whole { base, span } => bits.wrapping_sub(base) <= span,
            // NaN and the infinities are in no range of finite ends.
            Self::Real { min, max } => (min..=max).contains(&f64::from_bits(bits)),
        }
    }
}

/// The records that one observation type may have.
#[derive(Clone, Debug)]
struct TypeBounds {
    count: u16,
    /// The kinds of its values, written as in a record, as far as the bits of `mask` are set.
    kinds: u32,
    mask: u32,
    values: Vec<Bound>,
}

impl TypeBounds {
    fn of(declared: &ObservationType) -> Self {
        let (mut kinds, mut mask) = (0, 0);
        for (shift, property) in (0..u32::BITS).step_by(4).zip(&declared.properties) {
            let tag = match property.kind {
                ValueKind::Integer { .. } => kind::INTEGER,
                ValueKind::Symbol { .. } => kind::SYMBOL,
                ValueKind::Boolean => kind::BOOLEAN,
                ValueKind::Real { .. } => kind::REAL,
            };
            kinds |= tag << shift;
            mask |= 0xf << shift;
        }
        // More properties than fit were refused before; should they come here, no record is allowed.
        let count = u16::try_from(declared.properties.len()).unwrap_or(u16::MAX);
        let values = declared.properties.iter().take(PROPERTIES_MAX).map(|one| Bound::of(&one.kind));
        Self { count, kinds, mask, values: values.collect() }
    }
}

/// The records that the observations of one body may be.
#[derive(Clone, Debug)]
pub(crate) struct Bounds(Vec<TypeBounds>);

impl Bounds {
    /// The bounds of observation types that [`crate::description::Description::check`] allows.
    pub(crate) fn of(types: &[ObservationType]) -> Self {
        Self(types.iter().map(TypeBounds::of).collect())
    }

    /// Whether a record is of a type that is declared, with as many values, each of its kind and in its range.
    pub(crate) fn hold(&self, record: &Record) -> bool {
        self.0.get(usize::from(record.index)).is_some_and(|bounds| {
            record.count == bounds.count
                && record.kinds & bounds.mask == bounds.kinds
                && usize::from(record.count) <= record.values.len()
                && bounds.values.iter().zip(&record.values).all(|(bound, bits)| bound.holds(*bits))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::Property;
    use crate::wire::decode;

    fn declared(kinds: &[ValueKind]) -> ObservationType {
        let properties = kinds.iter().map(|kind| Property::new("property", kind.clone()));
        ObservationType { properties: properties.collect(), ..ObservationType::state("type") }
    }

    /// The fast check must allow exactly the records that the careful check allows, at every end of every range.
    #[test]
    fn a_record_holds_exactly_when_no_refusal_can_be_named() {
        let symbols = vec!["red".to_owned(), "green".to_owned()];
        let kinds = [
            ValueKind::Integer { min: -3, max: 459 },
            ValueKind::Integer { min: i64::MIN, max: i64::MAX },
            ValueKind::Integer { min: 7, max: 7 },
            ValueKind::Symbol { symbols },
            ValueKind::Boolean,
            ValueKind::Real { min: -0.5, max: 2.0, resolution: 0.1 },
        ];
        let mut types: Vec<_> = kinds.iter().map(|kind| declared(std::slice::from_ref(kind))).collect();
        types.extend([declared(&[]), declared(&kinds), declared(&vec![ValueKind::Boolean; PROPERTIES_MAX])]);
        let bounds = Bounds::of(&types);
        let whole = [-4, -3, -1, 0, 1, 2, 6, 7, 8, 459, 460, i64::MIN, i64::MAX].map(i64::cast_unsigned);
        let reals = [-0.51, -0.5, 0.0, -0.0, 2.0, 2.1, f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
        let bits = whole.into_iter().chain(reals.map(f64::to_bits)).chain([u64::from(u32::MAX) + 1]);
        let bits: Vec<u64> = bits.collect();
        let sound = |kind: &ValueKind| match kind {
            ValueKind::Integer { min, .. } => (kind::INTEGER, min.cast_unsigned()),
            ValueKind::Symbol { .. } => (kind::SYMBOL, 1),
            ValueKind::Boolean => (kind::BOOLEAN, 0),
            ValueKind::Real { max, .. } => (kind::REAL, max.to_bits()),
        };
        let (mut held, mut refused) = (0, 0);
        let mut compare = |record: &Record| {
            let named = decode::observation(0, record, &types);
            assert_eq!(bounds.hold(record), named.is_ok(), "{record:?}: {named:?}");
            if named.is_ok() { held += 1 } else { refused += 1 }
        };
        for (index, of) in (0..).zip(&types) {
            let mut record = Record { index, ..Record::default() };
            for (at, property) in of.properties.iter().enumerate() {
                let (tag, bits) = sound(&property.kind);
                record.kinds |= tag << (4 * at);
                record.values[at] = bits;
                record.count += 1;
            }
            compare(&record);
            // Each value in turn is everything it might be, of every kind.
            for at in 0..of.properties.len() {
                for tag in 0..16 {
                    for bits in &bits {
                        let mut wrong = record;
                        wrong.kinds = record.kinds & !(0xf << (4 * at)) | tag << (4 * at);
                        wrong.values[at] = *bits;
                        compare(&wrong);
                    }
                }
            }
            for count in [0, 1, record.count.wrapping_sub(1), record.count + 1, 8, 9, u16::MAX] {
                compare(&Record { count, ..record });
            }
            for index in [u16::try_from(types.len()).unwrap(), u16::MAX] {
                compare(&Record { index, ..record });
            }
        }
        assert!(held > 50 && refused > 1_000, "{held} held, {refused} refused");
    }
}
