//! Observations, patterns and what is built of them.

use pschema_learner::observation as live;
use pschema_learner::probability;
use serde::{Deserialize, Serialize};

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Value {
    Integer(i64),
    Symbol(u32),
    Boolean(bool),
    Bin(i64),
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Observation {
    pub(crate) kind: u16,
    pub(crate) properties: Vec<(u16, Value)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Term {
    Constant(Value),
    Variable(u8),
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Pattern {
    pub(crate) kind: u16,
    pub(crate) terms: Vec<(u16, Term)>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Substitution(pub(crate) Vec<(u8, Value)>);

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Count {
    pub(crate) occurrences: u32,
    pub(crate) trials: u32,
}

impl From<live::Value> for Value {
    fn from(value: live::Value) -> Self {
        match value {
            live::Value::Integer(value) => Self::Integer(value),
            live::Value::Symbol(symbol) => Self::Symbol(symbol.0),
            live::Value::Boolean(value) => Self::Boolean(value),
            live::Value::Bin(bin) => Self::Bin(bin),
        }
    }
}

impl From<Value> for live::Value {
    fn from(value: Value) -> Self {
        match value {
            Value::Integer(value) => Self::Integer(value),
            Value::Symbol(symbol) => Self::Symbol(live::SymbolId(symbol)),
            Value::Boolean(value) => Self::Boolean(value),
            Value::Bin(bin) => Self::Bin(bin),
        }
    }
}

impl From<&live::Observation> for Observation {
    fn from(observation: &live::Observation) -> Self {
        let properties = observation.properties().iter();
        let properties = properties.map(|(property, value)| (property.0, (*value).into())).collect();
        Self { kind: observation.kind().0, properties }
    }
}

impl From<Observation> for live::Observation {
    fn from(observation: Observation) -> Self {
        let properties = observation.properties.into_iter();
        let properties = properties.map(|(property, value)| (live::PropertyId(property), value.into()));
        Self::new(live::TypeId(observation.kind), properties)
    }
}

impl From<&live::Pattern> for Pattern {
    fn from(pattern: &live::Pattern) -> Self {
        let terms = pattern.terms().iter().map(|(property, term)| {
            let term = match term {
                live::Term::Constant(value) => Term::Constant((*value).into()),
                live::Term::Variable(variable) => Term::Variable(variable.0),
            };
            (property.0, term)
        });
        Self { kind: pattern.kind().0, terms: terms.collect() }
    }
}

impl From<Pattern> for live::Pattern {
    fn from(pattern: Pattern) -> Self {
        let terms = pattern.terms.into_iter().map(|(property, term)| {
            let term = match term {
                Term::Constant(value) => live::Term::Constant(value.into()),
                Term::Variable(variable) => live::Term::Variable(live::Variable(variable)),
            };
            (live::PropertyId(property), term)
        });
        Self::new(live::TypeId(pattern.kind), terms)
    }
}

impl From<&live::Substitution> for Substitution {
    fn from(substitution: &live::Substitution) -> Self {
        Self(substitution.bindings().iter().map(|(variable, value)| (variable.0, (*value).into())).collect())
    }
}

impl From<Substitution> for live::Substitution {
    fn from(substitution: Substitution) -> Self {
        let mut live = Self::new();
        for (variable, value) in substitution.0 {
            // Of two values for one variable the first counts; none is ever written.
            live.bind(live::Variable(variable), value.into());
        }
        live
    }
}

impl From<probability::Count> for Count {
    fn from(count: probability::Count) -> Self {
        Self { occurrences: count.occurrences, trials: count.trials }
    }
}

impl From<Count> for probability::Count {
    fn from(count: Count) -> Self {
        Self { occurrences: count.occurrences, trials: count.trials }
    }
}

/// A list converted, item by item.
pub(super) fn list<'a, A: 'a, B: From<&'a A>>(items: impl IntoIterator<Item = &'a A>) -> Vec<B> {
    items.into_iter().map(B::from).collect()
}

/// A list converted back.
pub(super) fn back<C: FromIterator<B>, A, B: From<A>>(items: Vec<A>) -> C {
    items.into_iter().map(B::from).collect()
}
