//! What bodies declare.

use pschema_learner::observation::PropertyId;
use pschema_learner::vocabulary as live;
use serde::{Deserialize, Serialize};

use super::observation::{back, list};
use super::{Impossible, index};

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum ValueKind {
    Integer,
    Symbol,
    Boolean,
    Real { resolution: f64 },
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct DeclaredProperty {
    name: String,
    unit: String,
    kind: ValueKind,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct DeclaredType {
    name: String,
    own: bool,
    transient: bool,
    heard: bool,
    properties: Vec<DeclaredProperty>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct DeclaredAction {
    name: String,
    parameters: Vec<DeclaredProperty>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Parameter {
    Integer(i64),
    Symbol(String),
    Boolean(bool),
    Real(f64),
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Declaration {
    body: String,
    observation_types: Vec<DeclaredType>,
    actions: Vec<DeclaredAction>,
    repertoire: Vec<(u64, Vec<Parameter>)>,
}

/// A whole vocabulary.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Vocabulary {
    types: Vec<(DeclaredType, Vec<u16>)>,
    properties: Vec<String>,
    property_kinds: Vec<ValueKind>,
    pub(super) symbols: Vec<String>,
    actions: Vec<DeclaredAction>,
    primitives: Vec<(u64, Vec<Parameter>)>,
    bodies: Vec<(String, Vec<u32>)>,
}

impl From<&live::ValueKind> for ValueKind {
    fn from(kind: &live::ValueKind) -> Self {
        match kind {
            live::ValueKind::Integer => Self::Integer,
            live::ValueKind::Symbol => Self::Symbol,
            live::ValueKind::Boolean => Self::Boolean,
            live::ValueKind::Real { resolution } => Self::Real { resolution: *resolution },
        }
    }
}

impl From<ValueKind> for live::ValueKind {
    fn from(kind: ValueKind) -> Self {
        match kind {
            ValueKind::Integer => Self::Integer,
            ValueKind::Symbol => Self::Symbol,
            ValueKind::Boolean => Self::Boolean,
            ValueKind::Real { resolution } => Self::Real { resolution },
        }
    }
}

impl From<&live::DeclaredProperty> for DeclaredProperty {
    fn from(property: &live::DeclaredProperty) -> Self {
        let live::DeclaredProperty { name, unit, kind } = property;
        Self { name: name.clone(), unit: unit.clone(), kind: kind.into() }
    }
}

impl From<DeclaredProperty> for live::DeclaredProperty {
    fn from(DeclaredProperty { name, unit, kind }: DeclaredProperty) -> Self {
        Self { name, unit, kind: kind.into() }
    }
}

impl From<&live::DeclaredType> for DeclaredType {
    fn from(declared: &live::DeclaredType) -> Self {
        let live::DeclaredType { name, own, transient, heard, properties } = declared;
        let (own, transient, heard) = (*own, *transient, *heard);
        Self { name: name.clone(), own, transient, heard, properties: list(properties) }
    }
}

impl From<DeclaredType> for live::DeclaredType {
    fn from(DeclaredType { name, own, transient, heard, properties }: DeclaredType) -> Self {
        Self { name, own, transient, heard, properties: back(properties) }
    }
}

impl From<&live::DeclaredAction> for DeclaredAction {
    fn from(live::DeclaredAction { name, parameters }: &live::DeclaredAction) -> Self {
        Self { name: name.clone(), parameters: list(parameters) }
    }
}

impl From<DeclaredAction> for live::DeclaredAction {
    fn from(DeclaredAction { name, parameters }: DeclaredAction) -> Self {
        Self { name, parameters: back(parameters) }
    }
}

impl From<&live::Parameter> for Parameter {
    fn from(parameter: &live::Parameter) -> Self {
        match parameter {
            live::Parameter::Integer(value) => Self::Integer(*value),
            live::Parameter::Symbol(symbol) => Self::Symbol(symbol.clone()),
            live::Parameter::Boolean(value) => Self::Boolean(*value),
            live::Parameter::Real(value) => Self::Real(*value),
        }
    }
}

impl From<Parameter> for live::Parameter {
    fn from(parameter: Parameter) -> Self {
        match parameter {
            Parameter::Integer(value) => Self::Integer(value),
            Parameter::Symbol(symbol) => Self::Symbol(symbol),
            Parameter::Boolean(value) => Self::Boolean(value),
            Parameter::Real(value) => Self::Real(value),
        }
    }
}

impl From<&live::Declaration> for Declaration {
    fn from(declaration: &live::Declaration) -> Self {
        let live::Declaration { body, observation_types, actions, repertoire } = declaration;
        let repertoire = repertoire.iter().map(|(action, values)| (*action as u64, list(values)));
        Self {
            body: body.clone(),
            observation_types: list(observation_types),
            actions: list(actions),
            repertoire: repertoire.collect(),
        }
    }
}

impl From<Declaration> for live::Declaration {
    fn from(Declaration { body, observation_types, actions, repertoire }: Declaration) -> Self {
        let repertoire = repertoire.into_iter().map(|(action, values)| (index(action), back(values)));
        Self {
            body,
            observation_types: back(observation_types),
            actions: back(actions),
            repertoire: repertoire.collect(),
        }
    }
}

impl From<&live::Vocabulary> for Vocabulary {
    fn from(vocabulary: &live::Vocabulary) -> Self {
        let live::Parts { types, properties, property_kinds, symbols, actions, primitives, bodies } =
            vocabulary.parts();
        let types = types.iter().map(|kind| {
            let properties = kind.properties.iter().map(|id| id.0).collect();
            (DeclaredType::from(&kind.declared), properties)
        });
        let primitives = primitives.iter().map(|p| (p.action as u64, list(&p.parameters)));
        let bodies = bodies.into_iter().map(|body| {
            let repertoire = body.repertoire.iter().map(|id| id.0).collect();
            (body.name, repertoire)
        });
        Self {
            types: types.collect(),
            properties,
            property_kinds: list(&property_kinds),
            symbols,
            actions: list(&actions),
            primitives: primitives.collect(),
            bodies: bodies.collect(),
        }
    }
}

impl TryFrom<Vocabulary> for live::Vocabulary {
    type Error = Impossible;

    fn try_from(vocabulary: Vocabulary) -> Result<Self, Impossible> {
        let Vocabulary { types, properties, property_kinds, symbols, actions, primitives, bodies } =
            vocabulary;
        let types = types.into_iter().map(|(declared, properties)| live::ObservationType {
            declared: declared.into(),
            properties: properties.into_iter().map(PropertyId).collect(),
        });
        let primitives = primitives.into_iter().map(|(action, parameters)| live::Primitive {
            action: index(action),
            parameters: back(parameters),
        });
        let bodies = bodies.into_iter().map(|(name, repertoire)| live::KnownBody {
            name,
            repertoire: repertoire.into_iter().map(live::PrimitiveId).collect(),
        });
        live::Vocabulary::from_parts(live::Parts {
            types: types.collect(),
            properties,
            property_kinds: back(property_kinds),
            symbols,
            actions: back(actions),
            primitives: primitives.collect(),
            bodies: bodies.collect(),
        })
        .map_err(Impossible)
    }
}
