//! Values, observations and patterns as they stand in an export: by name, and in JSON that says what kind they are.

use std::fmt;

use serde::de::{MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Names with values in the order given, as an object; a name that stands twice is refused.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Named<T>(pub(super) Vec<(String, T)>);

impl<T> Default for Named<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T: Serialize> Serialize for Named<T> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(Some(self.0.len()))?;
        for (name, value) in &self.0 {
            map.serialize_entry(name, value)?;
        }
        map.end()
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Named<T> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Names<T>(std::marker::PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for Names<T> {
            type Value = Named<T>;

            fn expecting(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
                to.write_str("names with values")
            }

            fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<Named<T>, M::Error> {
                let mut named: Vec<(String, T)> = Vec::new();
                while let Some((name, value)) = map.next_entry::<String, T>()? {
                    if named.len() >= NAMES_MAX {
                        return Err(serde::de::Error::custom(format!("more than {NAMES_MAX} names")));
                    }
                    if named.iter().any(|(known, _)| *known == name) {
                        return Err(serde::de::Error::custom(format!("the name {name:?} stands twice")));
                    }
                    named.push((name, value));
                }
                Ok(Named(named))
            }
        }
        from.deserialize_map(Names(std::marker::PhantomData))
    }
}

/// Names in one object: far more than a body can declare for one type.
const NAMES_MAX: usize = 1_024;

/// A value. JSON says which kind it is: a whole number, text for a symbol, `true` or `false`, and for the bin of a real
/// an object with the bin and, for those who read it, its middle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub(super) enum Value {
    /// A whole number.
    Integer(i64),
    /// A symbol.
    Symbol(String),
    /// True or false.
    Boolean(bool),
    /// The bin of a real.
    Bin(Bin),
    /// A variable, in patterns alone.
    Variable(Variable),
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Bin {
    /// Its number: what counts.
    pub(super) bin: i64,
    /// The middle of it: what a reader wants to see.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) real: Option<f64>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Variable {
    /// Its name, without the `$`.
    pub(super) var: String,
}

/// An observation, or a pattern.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Observation {
    #[serde(rename = "type")]
    pub(super) kind: String,
    #[serde(default)]
    pub(super) properties: Named<Value>,
}

/// What a property or a parameter takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum KindWord {
    /// Whole numbers.
    Integer,
    /// Symbols.
    Symbol,
    /// True or false.
    Boolean,
    /// Reals, compared as bins.
    Real,
}

/// The value of a parameter of a primitive: a real is exact, and what it is the action's declaration says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub(super) enum Parameter {
    /// A whole number.
    Integer(i64),
    /// A real.
    Real(f64),
    /// A symbol.
    Symbol(String),
    /// True or false.
    Boolean(bool),
}

/// A value for each variable.
pub(super) type Binding = Named<Value>;
