//! Observations, patterns and schemas part by part.

use serde::de::{self, MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

use crate::number;

/// An observation or a pattern: `{"type": "object", "properties": {"colour": "blue", "field": 4}}`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ObservationText {
    /// The name of its type.
    #[serde(rename = "type")]
    pub kind: String,
    /// Its properties.
    pub properties: NamedValues,
}

/// Names with values, in their order; in JSON an object.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NamedValues(pub Vec<(String, ValueText)>);

impl NamedValues {
    /// The value of this name.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&ValueText> {
        self.0.iter().find_map(|(known, value)| (known == name).then_some(value))
    }

    /// The names with their values.
    pub fn iter(&self) -> std::slice::Iter<'_, (String, ValueText)> {
        self.0.iter()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl<'a> IntoIterator for &'a NamedValues {
    type Item = &'a (String, ValueText);
    type IntoIter = std::slice::Iter<'a, (String, ValueText)>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl FromIterator<(String, ValueText)> for NamedValues {
    fn from_iter<I: IntoIterator<Item = (String, ValueText)>>(pairs: I) -> Self {
        Self(pairs.into_iter().collect())
    }
}

impl Serialize for NamedValues {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_map(self.0.iter().map(|(name, value)| (name, value)))
    }
}

impl<'de> Deserialize<'de> for NamedValues {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Pairs;

        impl<'de> Visitor<'de> for Pairs {
            type Value = NamedValues;

            fn expecting(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
                to.write_str("an object of names with values")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<NamedValues, A::Error> {
                let mut pairs = Vec::new();
                while let Some(pair) = map.next_entry()? {
                    pairs.push(pair);
                }
                Ok(NamedValues(pairs))
            }
        }

        from.deserialize_map(Pairs)
    }
}

/// A value, a variable that stands for one, or in a claim a value that is named by its part in the action.
///
/// In JSON a number, a string, `true`, `false`; for a variable `{"var": "a"}`, and for a value that is named `{"named": …}`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(untagged))]
pub enum ValueText {
    /// A whole number.
    Integer(i64),
    /// A symbol.
    Symbol(String),
    /// True or false.
    Boolean(bool),
    /// The middle of a real's bin; `null` where that is beyond a 64-bit float.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    Real(f64),
    /// A variable.
    Variable {
        /// Its name, without the `$`.
        var: String,
    },
    /// A value that is named.
    Named {
        /// By what.
        named: Box<NamedValue>,
    },
}

/// A value that is named by its part in an action: the one that the reference names, or so much more.
///
/// It prints as its reference does, with the difference behind it: `only(object).field(+1)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct NamedValue {
    /// What names it.
    #[serde(flatten)]
    pub reference: Reference,
    /// How much more it is than the value named; left out where it is that value.
    #[serde(default, skip_serializing_if = "is_nothing")]
    pub more: f64,
}

fn is_nothing(more: &f64) -> bool {
    *more == 0.0
}

/// What names a value in a claim. No name holds a bracket or `=`, so that what is printed means one reference only, and never a
/// symbol.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "by", rename_all = "kebab-case")]
pub enum Reference {
    /// The action's parameter of this name. It prints as `param(field)`.
    Parameter {
        /// Its name.
        parameter: String,
    },
    /// The value that the action brings about of itself, whatever the context. It prints as `effect(finger).field`.
    Effect {
        /// In an observation of this type.
        #[serde(rename = "type")]
        kind: String,
        /// In this property.
        property: String,
    },
    /// The value in the only observation of a type that there is. It prints as `only(object).colour`.
    Only {
        /// The type.
        #[serde(rename = "type")]
        kind: String,
        /// The property.
        property: String,
    },
    /// The value in the observation that a claim about each of its type is about. It prints as `its(dx)`.
    Itself {
        /// The property.
        property: String,
    },
    /// The value in the only observation of a type that is recalled: that was there when the body was last as the action makes it. It
    /// prints as `recalled(fovea).thing`.
    Recalled {
        /// The type.
        #[serde(rename = "type")]
        kind: String,
        /// The property.
        property: String,
    },
    /// How many experiences of the body ago it was that is recalled; 0 of what is there now. It prints as `age(recalled)`.
    Age,
    /// The value in the only observation of a type that has another named value. It prints as `on(above=param(block)).below`.
    Tied {
        /// The type.
        #[serde(rename = "type")]
        kind: String,
        /// The property that has the other value.
        at: String,
        /// What names the other value.
        from: Box<Reference>,
        /// The property whose value is meant.
        property: String,
    },
}

impl fmt::Display for Reference {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Parameter { parameter } => write!(to, "param({parameter})"),
            Self::Effect { kind, property } => write!(to, "effect({kind}).{property}"),
            Self::Only { kind, property } => write!(to, "only({kind}).{property}"),
            Self::Itself { property } => write!(to, "its({property})"),
            Self::Recalled { kind, property } => write!(to, "recalled({kind}).{property}"),
            Self::Age => write!(to, "age(recalled)"),
            Self::Tied { kind, at, from, property } => write!(to, "{kind}({at}={from}).{property}"),
        }
    }
}

impl fmt::Display for NamedValue {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "{}", self.reference)?;
        if is_nothing(&self.more) { Ok(()) } else { write!(to, "({})", number::signed(self.more)) }
    }
}

impl ValueText {
    /// The variable of this name, given without its `$`.
    #[must_use]
    pub fn variable(name: &str) -> Self {
        Self::Variable { var: name.to_owned() }
    }
}

impl Serialize for ValueText {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Integer(number) => to.serialize_i64(*number),
            Self::Symbol(symbol) => to.serialize_str(symbol),
            Self::Boolean(truth) => to.serialize_bool(*truth),
            Self::Real(number) => to.serialize_f64(*number),
            Self::Variable { var } => {
                let mut map = to.serialize_map(Some(1))?;
                map.serialize_entry("var", var)?;
                map.end()
            }
            Self::Named { named } => {
                let mut map = to.serialize_map(Some(1))?;
                map.serialize_entry("named", named)?;
                map.end()
            }
        }
    }
}

impl<'de> Deserialize<'de> for ValueText {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Any;

        impl<'de> Visitor<'de> for Any {
            type Value = ValueText;

            fn expecting(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
                to.write_str("a number, a string, true, false, {\"var\": name}, or {\"named\": …}")
            }

            fn visit_i64<E>(self, number: i64) -> Result<ValueText, E> {
                Ok(ValueText::Integer(number))
            }

            fn visit_u64<E: de::Error>(self, number: u64) -> Result<ValueText, E> {
                i64::try_from(number).map(ValueText::Integer).map_err(E::custom)
            }

            fn visit_f64<E>(self, number: f64) -> Result<ValueText, E> {
                Ok(ValueText::Real(number))
            }

            fn visit_unit<E>(self) -> Result<ValueText, E> {
                Ok(ValueText::Real(f64::NAN))
            }

            fn visit_bool<E>(self, truth: bool) -> Result<ValueText, E> {
                Ok(ValueText::Boolean(truth))
            }

            fn visit_str<E>(self, symbol: &str) -> Result<ValueText, E> {
                Ok(ValueText::Symbol(symbol.to_owned()))
            }

            fn visit_string<E>(self, symbol: String) -> Result<ValueText, E> {
                Ok(ValueText::Symbol(symbol))
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<ValueText, A::Error> {
                let value = match map.next_key::<String>()?.as_deref() {
                    Some("var") => Some(ValueText::Variable { var: map.next_value()? }),
                    Some("named") => Some(ValueText::Named { named: map.next_value()? }),
                    _ => None,
                };
                value.filter(|_| matches!(map.next_key::<String>(), Ok(None))).ok_or_else(|| {
                    de::Error::custom("an object that is no value: its only name is not `var` or `named`")
                })
            }
        }

        from.deserialize_any(Any)
    }
}

/// An observation or a pattern with its statistics.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Condition {
    /// What is observed.
    pub observation: ObservationText,
    /// True where the condition is that it is no longer observed; left out where it is false.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub absent: bool,
    /// How often it held.
    pub occurrences: u32,
    /// Of how often it could have.
    pub trials: u32,
    /// Their ratio.
    pub probability: f64,
    /// Lower end of its 95 % interval.
    pub low: f64,
    /// Upper end of its 95 % interval.
    pub high: f64,
}

/// What a schema expects to be observed, or to be observed no longer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Expectation {
    /// What is observed.
    pub observation: ObservationText,
    /// True where it is no longer observed; left out where it is false.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub absent: bool,
    /// The share of executions in which it held, in 0..=1; none before the first. Outcomes that exclude each other share them.
    pub share: Option<f64>,
}

/// The parts of a schema, its variables not yet bound. Of a primitive that no schema covers, the action alone.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SchemaForm {
    /// Pre-conditions.
    pub pre: Vec<ObservationText>,
    /// The primitive as it prints; of a generalised schema, its target.
    pub action: String,
    /// The target of a generalised schema: what its action is to bring about.
    pub target: Vec<ObservationText>,
    /// Post-conditions.
    pub post: Vec<Expectation>,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each reference prints in a way of its own, and is read as it was written.
    #[test]
    fn a_value_that_is_named_prints_as_its_reference() {
        let named = |reference, more| ValueText::Named { named: Box::new(NamedValue { reference, more }) };
        let parameter = || Reference::Parameter { parameter: "block".to_owned() };
        let tied = Reference::Tied {
            kind: "on".to_owned(),
            at: "above".to_owned(),
            from: Box::new(parameter()),
            property: "below".to_owned(),
        };
        let only = Reference::Only { kind: "cart".to_owned(), property: "x".to_owned() };
        let itself = Reference::Itself { property: "dx".to_owned() };
        let recalled = Reference::Recalled { kind: "fovea".to_owned(), property: "thing".to_owned() };
        for (value, text, json) in [
            (named(itself, 1.0), "its(dx)(+1)", r#"{"named":{"by":"itself","property":"dx","more":1.0}}"#),
            (
                named(recalled, 0.0),
                "recalled(fovea).thing",
                r#"{"named":{"by":"recalled","type":"fovea","property":"thing"}}"#,
            ),
            (named(Reference::Age, 0.0), "age(recalled)", r#"{"named":{"by":"age"}}"#),
            (named(parameter(), 0.0), "param(block)", r#"{"named":{"by":"parameter","parameter":"block"}}"#),
            (
                named(only, -0.5),
                "only(cart).x(-0.5)",
                r#"{"named":{"by":"only","type":"cart","property":"x","more":-0.5}}"#,
            ),
            (
                named(tied, 0.0),
                "on(above=param(block)).below",
                r#"{"named":{"by":"tied","type":"on","at":"above","from":{"by":"parameter","parameter":"block"},"property":"below"}}"#,
            ),
        ] {
            assert_eq!(serde_json::to_string(&value).unwrap(), json);
            assert_eq!(serde_json::from_str::<ValueText>(json).unwrap(), value);
            assert!(matches!(value, ValueText::Named { named } if named.to_string() == text));
        }
    }

    #[test]
    fn an_observation_is_an_object_whose_order_is_kept() {
        let text = r#"{"type":"object","properties":{"field":4,"colour":"blue","seen":true,"x":0.5,"by":{"var":"a"}}}"#;
        let read: ObservationText = serde_json::from_str(text).unwrap();
        assert_eq!(read.properties.get("by"), Some(&ValueText::variable("a")));
        assert_eq!(serde_json::to_string(&read).unwrap(), text);
        for wrong in [r#"{"var":1}"#, r#"{"name":"a"}"#, r#"{"var":"a","more":"b"}"#, "{}", "[]", "1e999"] {
            assert!(serde_json::from_str::<ValueText>(wrong).is_err(), "{wrong}");
        }
    }
}
