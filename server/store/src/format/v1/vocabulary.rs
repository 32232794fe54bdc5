//! What bodies declare.

use pschema_learner::observation::PropertyId;
use pschema_learner::vocabulary as live;
use serde::{Deserialize, Serialize};

use super::observation::{Count, back, list};
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

/// A vocabulary without its symbols, primitives and bodies, which are blocks of their own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Vocabulary {
    types: Vec<(DeclaredType, Vec<u16>)>,
    properties: Vec<(String, ValueKind)>,
    actions: Vec<DeclaredAction>,
}

/// A primitive, with how often it was asked for and carried out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Primitive {
    action: u64,
    parameters: Vec<Parameter>,
    pub(super) attempts: Count,
}

/// A body and what it can do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Body {
    name: String,
    repertoire: Vec<u32>,
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
        let types = vocabulary.types().iter().map(|kind| {
            let properties = kind.properties.iter().map(|id| id.0).collect();
            (DeclaredType::from(&kind.declared), properties)
        });
        let properties = (0..)
            .zip(vocabulary.properties())
            .filter_map(|(at, name)| Some((name.clone(), vocabulary.property_kind(PropertyId(at))?.into())));
        Self { types: types.collect(), properties: properties.collect(), actions: list(vocabulary.actions()) }
    }
}

impl From<&live::KnownBody> for Body {
    fn from(live::KnownBody { name, repertoire }: &live::KnownBody) -> Self {
        Self { name: name.clone(), repertoire: repertoire.iter().map(|id| id.0).collect() }
    }
}

impl Primitive {
    /// A primitive and how it went.
    pub(super) fn new(live::Primitive { action, parameters }: &live::Primitive, attempts: Count) -> Self {
        Self { action: *action as u64, parameters: list(parameters), attempts }
    }
}

/// The vocabulary of these parts.
pub(super) fn whole(
    vocabulary: Vocabulary,
    symbols: Vec<String>,
    primitives: Vec<Primitive>,
    bodies: Vec<Body>,
) -> Result<live::Vocabulary, Impossible> {
    let types = vocabulary.types.into_iter().map(|(declared, properties)| live::ObservationType {
        declared: declared.into(),
        properties: properties.into_iter().map(PropertyId).collect(),
    });
    let primitives = primitives.into_iter().map(|primitive| live::Primitive {
        action: index(primitive.action),
        parameters: back(primitive.parameters),
    });
    let bodies = bodies.into_iter().map(|body| live::KnownBody {
        name: body.name,
        repertoire: body.repertoire.into_iter().map(live::PrimitiveId).collect(),
    });
    let (properties, kinds): (Vec<_>, Vec<_>) = vocabulary.properties.into_iter().unzip();
    live::Vocabulary::from_lists(live::VocabularyLists {
        types: types.collect(),
        properties,
        property_kinds: back(kinds),
        symbols,
        actions: back(vocabulary.actions),
        primitives: primitives.collect(),
        bodies: bodies.collect(),
    })
    .map_err(Impossible)
}
