//! What bodies declare.

use pschema_learner::vocabulary as live;
use serde::{Deserialize, Serialize};

use crate::format::mirror::{Mirror, mirror};

mirror! {
    /// The values that a property or a parameter takes.
    enum ValueKind = live::ValueKind {
        /// Integers.
        Integer,
        /// Symbols.
        Symbol,
        /// Yes and no.
        Boolean,
        /// Reals, in bins as wide as the resolution.
        Real { resolution: f64 },
    }

    /// A property or a parameter.
    struct DeclaredProperty = live::DeclaredProperty {
        /// The name.
        name: String,
        /// The unit; empty if there is none.
        unit: String,
        /// The values that it takes.
        kind: ValueKind,
    }

    /// An observation type.
    struct DeclaredType = live::DeclaredType {
        /// The name.
        name: String,
        /// Whether the body itself causes it.
        own: bool,
        /// Whether it is an event and not a state.
        transient: bool,
        /// Whether it comes from others, and never from an action of this body (a word heard).
        heard: bool,
        /// Its properties.
        properties: Vec<DeclaredProperty>,
        ..value,
    }

    /// An action.
    struct DeclaredAction = live::DeclaredAction {
        /// The name.
        name: String,
        /// Its parameters.
        parameters: Vec<DeclaredProperty>,
    }

    /// The value of a parameter.
    enum Parameter = live::Parameter {
        Integer(number: i64),
        Symbol(symbol: String),
        Boolean(value: bool),
        Real(number: f64),
    }

    /// Everything that a body declares when it attaches.
    struct Declaration = live::Declaration {
        body: String,
        observation_types: Vec<DeclaredType>,
        actions: Vec<DeclaredAction>,
        repertoire: Vec<(u64, Vec<Parameter>)>,
    }

    /// A body and its repertoire.
    struct Body = live::KnownBody {
        /// The name.
        name: String,
        /// The numbers of its primitives.
        repertoire: Vec<u32>,
    }
}

/// A declaration with types that are values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct ValuedDeclaration {
    declaration: Declaration,
    /// Which of the observation types are values, by their places.
    values: Vec<u64>,
}

/// Whether some of the types that are declared are values.
pub(crate) fn has_values(declaration: &live::Declaration) -> bool {
    declaration.observation_types.iter().any(|kind| kind.value)
}

impl Mirror<live::Declaration> for ValuedDeclaration {
    fn of(live: &live::Declaration) -> Self {
        let types = (0..).zip(&live.observation_types);
        let values = types.filter(|(_, kind)| kind.value).map(|(at, _)| at).collect();
        Self { declaration: Mirror::of(live), values }
    }

    fn live(self) -> live::Declaration {
        let mut declaration: live::Declaration = self.declaration.live();
        for (at, kind) in (0..).zip(&mut declaration.observation_types) {
            kind.value = self.values.contains(&at);
        }
        declaration
    }
}
