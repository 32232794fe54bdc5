//! What bodies declare.

use pschema_learner::vocabulary as live;

use crate::format::mirror::mirror;

mirror! {
    /// The values that a property or a parameter takes.
    enum ValueKind = live::ValueKind {
        Integer,
        Symbol,
        Boolean,
        Real { resolution: f64 },
    }

    /// A property or a parameter.
    struct DeclaredProperty = live::DeclaredProperty {
        name: String,
        unit: String,
        kind: ValueKind,
    }

    /// An observation type.
    struct DeclaredType = live::DeclaredType {
        name: String,
        own: bool,
        transient: bool,
        heard: bool,
        properties: Vec<DeclaredProperty>,
    }

    /// An action.
    struct DeclaredAction = live::DeclaredAction {
        name: String,
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
        name: String,
        repertoire: Vec<u32>,
    }
}
