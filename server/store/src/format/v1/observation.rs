//! Observations, patterns and what is built of them.

use pschema_learner::observation as live;
use pschema_learner::probability;
use pschema_learner::world_state::WorldState;
use serde::{Deserialize, Serialize};

use crate::format::mirror::{Mirror, list, mirror};

mirror! {
    /// The value of a property.
    #[derive(Copy)]
    enum Value = live::Value {
        /// An integer.
        Integer(number: i64),
        /// The number of a symbol.
        Symbol(symbol: u32),
        /// Yes or no.
        Boolean(value: bool),
        /// Of a real: the number of its bin. Times the resolution it is the middle of the bin.
        Bin(bin: i64),
    }

    /// What stands for the value of a property in a pattern.
    #[derive(Copy)]
    enum Term = live::Term {
        /// This value.
        Constant(value: Value),
        /// The variable of this number: the same value wherever it stands.
        Variable(variable: u8),
    }

    /// How often something happened, and how often it could have.
    #[derive(Copy)]
    struct Count = probability::Count {
        /// How often it happened.
        occurrences: u32,
        /// How often it could have.
        trials: u32,
    }
}

/// An observation: its type, and its properties in the order of their numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct Observation {
    /// The number of its observation type.
    kind: u16,
    /// Numbers of properties, with values.
    properties: Vec<(u16, Value)>,
}

/// A pattern: as an observation, with terms for values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct Pattern {
    /// The number of its observation type.
    kind: u16,
    /// Numbers of properties, with terms.
    terms: Vec<(u16, Term)>,
}

/// Values for variables, in the order of the variables.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Substitution(Vec<(u8, Value)>);

impl Mirror<live::Observation> for Observation {
    fn of(live: &live::Observation) -> Self {
        Self { kind: live.kind().0, properties: list(live.properties()) }
    }

    fn live(self) -> live::Observation {
        live::Observation::new(live::TypeId(self.kind), self.properties.into_iter().map(Mirror::live))
    }
}

impl Mirror<live::Pattern> for Pattern {
    fn of(live: &live::Pattern) -> Self {
        Self { kind: live.kind().0, terms: list(live.terms()) }
    }

    fn live(self) -> live::Pattern {
        live::Pattern::new(live::TypeId(self.kind), self.terms.into_iter().map(Mirror::live))
    }
}

impl Mirror<live::Substitution> for Substitution {
    fn of(live: &live::Substitution) -> Self {
        Self(list(live.bindings()))
    }

    fn live(self) -> live::Substitution {
        let mut live = live::Substitution::new();
        for (variable, value) in self.0 {
            // Of two values for one variable the first counts; two are never written.
            live.bind(live::Variable(variable), value.live());
        }
        live
    }
}

impl Mirror<WorldState> for Vec<Observation> {
    fn of(live: &WorldState) -> Self {
        list(live.observations())
    }

    fn live(self) -> WorldState {
        WorldState::new(self.into_iter().map(Mirror::live))
    }
}
