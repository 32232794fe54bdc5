//! Properties of observations and parameters of actions: a name, the values it takes, a unit.

use std::ops::RangeInclusive;

use super::Value;

/// A named value with its kind: a property of an observation, or a parameter of an action.
///
/// ```
/// use pschema_protocol::description::Property;
///
/// let reach = Property::real("reach", 0.0..=0.8, 0.01).unit("m");
/// let colour = Property::symbol("colour", ["red", "green"]);
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
#[must_use]
pub struct Property {
    /// The property's name. Properties of the same name are comparable across types: a block in
    /// `field` 7 resembles a finger in `field` 7.
    pub name: String,
    /// The values that it takes.
    pub kind: ValueKind,
    /// The unit of the value (`rad`, `mm`), empty when it has none.
    pub unit: String,
}

/// The values a property may take.
#[derive(Clone, Debug, PartialEq)]
pub enum ValueKind {
    /// A whole number in `min..=max`.
    Integer {
        /// Smallest value allowed.
        min: i64,
        /// Largest value allowed.
        max: i64,
    },
    /// One of these symbols; a [`Value::Symbol`] is an index into them.
    Symbol {
        /// The symbols, in the order that indexes refer to.
        symbols: Vec<String>,
    },
    /// True or false.
    Boolean,
    /// A finite real in `min..=max`, compared and learnt as the bin `round(value / resolution)`.
    Real {
        /// Smallest value allowed.
        min: f64,
        /// Largest value allowed.
        max: f64,
        /// Width of a bin, above zero.
        resolution: f64,
    },
}

impl Property {
    /// A property whose values are of `kind`.
    pub fn new(name: impl Into<String>, kind: ValueKind) -> Self {
        Self { name: name.into(), kind, unit: String::new() }
    }

    /// A whole number in `range`.
    pub fn integer(name: impl Into<String>, range: RangeInclusive<i64>) -> Self {
        Self::new(name, ValueKind::Integer { min: *range.start(), max: *range.end() })
    }

    /// One of `symbols`.
    pub fn symbol(name: impl Into<String>, symbols: impl IntoIterator<Item = impl Into<String>>) -> Self {
        Self::new(name, ValueKind::Symbol { symbols: symbols.into_iter().map(Into::into).collect() })
    }

    /// True or false.
    pub fn boolean(name: impl Into<String>) -> Self {
        Self::new(name, ValueKind::Boolean)
    }

    /// A real in `range`. Reals less than about one `resolution` apart are the same to the learner.
    pub fn real(name: impl Into<String>, range: RangeInclusive<f64>, resolution: f64) -> Self {
        Self::new(name, ValueKind::Real { min: *range.start(), max: *range.end(), resolution })
    }

    /// The same property, with its values in this unit (`rad`, `mm`).
    pub fn unit(mut self, unit: impl Into<String>) -> Self {
        self.unit = unit.into();
        self
    }
}

impl ValueKind {
    /// Every value that the learner tells apart, from the smallest on. For a real this is the middle of each bin, or the limit
    /// that is nearest to it.
    pub(super) fn every(&self) -> Box<dyn Iterator<Item = Value> + '_> {
        match *self {
            Self::Integer { min, max } => Box::new((min..=max).map(Value::Integer)),
            Self::Symbol { ref symbols } => {
                Box::new((0..).zip(symbols).map(|(index, _)| Value::Symbol(index)))
            }
            Self::Boolean => Box::new([false, true].into_iter().map(Value::Boolean)),
            Self::Real { min, max, resolution } => {
                let bin = |value: f64| (value / resolution).round() as i64;
                // Limits that contradict each other are refused elsewhere: `clamp` would panic on them.
                let within = move |value: f64| Value::Real(value.min(max).max(min));
                Box::new((bin(min)..=bin(max)).map(move |bin| within(bin as f64 * resolution)))
            }
        }
    }
}
