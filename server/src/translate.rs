//! Between the wire and the learner: declarations and observations of a body in the learner's numbers, and the learner's
//! requests in the body's. The tables of a translation are made once, when the body attaches.

use std::collections::BTreeMap;

use pschema_learner::curriculum::{Argument, SceneCommand};
use pschema_learner::observation::{Observation, PropertyId, SymbolId, TypeId, Value as Learnt};
use pschema_learner::vocabulary::{
    BodyId, Declaration, DeclaredAction, DeclaredProperty, DeclaredType, Parameter, PrimitiveId,
    ValueKind as LearntKind, Vocabulary, bin, value_of,
};
use pschema_protocol::description::{Action, ActionId, ActionType, Description, Property, Value, ValueKind};
use pschema_protocol::refusal::Refusal;
use pschema_protocol::wire::check;
use pschema_protocol::wire::{ObservationRecord, Observations};

/// The sense of hearing, which the daemon adds to every body: `word{text=touch}`.
pub const HEARING: &str = "word";
/// Its only property.
pub const HEARING_TEXT: &str = "text";

/// Why something can't be translated for the other side.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TranslateError {
    /// The body declares the sense of hearing, which is the daemon's own.
    #[error("observation type {HEARING} is the learner's own sense of hearing: give the body's another name")]
    OwnSense,
    /// The learner does not know something that the body declared.
    #[error("{what} {name} is declared, but the learner does not know it")]
    Undeclared {
        /// What sort of thing it is.
        what: &'static str,
        /// Its name.
        name: String,
    },
    /// The primitive is not in this body's repertoire.
    #[error("primitive {0} is not in this body's repertoire")]
    Primitive(u32),
    /// The body declared no such scene command.
    #[error("the body has no scene command {command}; it has: {known}")]
    Command {
        /// The command.
        command: String,
        /// Those it has.
        known: String,
    },
    /// A parameter of a scene command is missing, unknown, or has a wrong value.
    #[error("scene command {command}: {problem}")]
    Parameter {
        /// The command.
        command: String,
        /// What is wrong.
        problem: String,
    },
    /// A value is not one that the body declared.
    #[error(transparent)]
    Value(#[from] Refusal),
}

/// What a body declares, in the learner's terms, with the sense of hearing added.
///
/// # Errors
/// [`TranslateError::OwnSense`] when the body declares hearing itself.
pub fn declaration(description: &Description) -> Result<Declaration, TranslateError> {
    if description.observation_types.iter().any(|declared| declared.name == HEARING) {
        return Err(TranslateError::OwnSense);
    }
    let types = description.observation_types.iter().map(|declared| DeclaredType {
        name: declared.name.clone(),
        own: declared.own,
        transient: declared.transient,
        heard: false,
        value: declared.value,
        properties: declared.properties.iter().map(property).collect(),
    });
    let text =
        DeclaredProperty { name: HEARING_TEXT.to_owned(), unit: String::new(), kind: LearntKind::Symbol };
    let hearing = DeclaredType {
        name: HEARING.to_owned(),
        own: false,
        transient: true,
        heard: true,
        value: false,
        properties: vec![text],
    };
    let actions = description.actions.iter().map(|declared| DeclaredAction {
        name: declared.name.clone(),
        parameters: declared.parameters.iter().map(property).collect(),
    });
    Ok(Declaration {
        body: description.name.clone(),
        observation_types: types.chain([hearing]).collect(),
        actions: actions.collect(),
        repertoire: description
            .repertoire
            .iter()
            .map(|one| (usize::from(one.id.index()), parameters(one, &description.actions)))
            .collect(),
    })
}

fn property(declared: &Property) -> DeclaredProperty {
    let kind = match &declared.kind {
        ValueKind::Integer { .. } => LearntKind::Integer,
        ValueKind::Symbol { .. } => LearntKind::Symbol,
        ValueKind::Boolean => LearntKind::Boolean,
        ValueKind::Real { resolution, .. } => LearntKind::Real { resolution: *resolution },
    };
    DeclaredProperty { name: declared.name.clone(), unit: declared.unit.clone(), kind }
}

/// The values of a checked primitive. They are empty if the primitive does not fit its action; the learner then refuses
/// it.
fn parameters(action: &Action, declared: &[ActionType]) -> Vec<Parameter> {
    let Some(kind) = declared.get(usize::from(action.id.index())) else { return Vec::new() };
    let values = action.parameters.iter().zip(&kind.parameters);
    values.filter_map(|(value, property)| parameter(*value, &property.kind)).collect()
}

fn parameter(value: Value, kind: &ValueKind) -> Option<Parameter> {
    Some(match (value, kind) {
        (Value::Integer(number), _) => Parameter::Integer(number),
        (Value::Boolean(truth), _) => Parameter::Boolean(truth),
        (Value::Real(number), _) => Parameter::Real(number),
        (Value::Symbol(index), ValueKind::Symbol { symbols }) => {
            Parameter::Symbol(symbols.get(usize::try_from(index).ok()?)?.clone())
        }
        (Value::Symbol(_), _) => return None,
    })
}

/// The translation for one attached body.
#[derive(Clone, Debug)]
pub struct Translation {
    types: Vec<TypeTable>,
    hearing: (TypeId, PropertyId),
    /// The body's own action for each primitive. It has the body's exact values, even where another body declared the
    /// primitive first.
    primitives: BTreeMap<PrimitiveId, Action>,
    scene_commands: Vec<ActionType>,
}

#[derive(Clone, Debug)]
struct TypeTable {
    kind: TypeId,
    properties: Vec<(PropertyId, ValueTable)>,
}

#[derive(Clone, Debug)]
enum ValueTable {
    AsIs,
    Symbols(Vec<SymbolId>),
    Bins { resolution: f64 },
}

impl Translation {
    /// The translation for `body`, whose [`declaration`] and symbols the learner of `vocabulary` has taken.
    ///
    /// # Errors
    /// [`TranslateError::Undeclared`] when it has not.
    pub fn new(
        description: &Description,
        body: BodyId,
        vocabulary: &Vocabulary,
    ) -> Result<Self, TranslateError> {
        let kind =
            |name: &str| vocabulary.type_named(name).ok_or_else(|| undeclared("observation type", name));
        let known = |name: &str| vocabulary.property_named(name).ok_or_else(|| undeclared("property", name));
        let mut types = Vec::with_capacity(description.observation_types.len());
        for declared in &description.observation_types {
            let mut properties = Vec::with_capacity(declared.properties.len());
            for property in &declared.properties {
                let values = match &property.kind {
                    ValueKind::Integer { .. } | ValueKind::Boolean => ValueTable::AsIs,
                    ValueKind::Symbol { symbols } => {
                        let known = |name: &String| {
                            vocabulary.symbol_named(name).ok_or_else(|| undeclared("symbol", name))
                        };
                        ValueTable::Symbols(symbols.iter().map(known).collect::<Result<_, _>>()?)
                    }
                    ValueKind::Real { resolution, .. } => ValueTable::Bins { resolution: *resolution },
                };
                properties.push((known(&property.name)?, values));
            }
            types.push(TypeTable { kind: kind(&declared.name)?, properties });
        }
        Ok(Self {
            types,
            hearing: (kind(HEARING)?, known(HEARING_TEXT)?),
            primitives: primitives(description, body, vocabulary)?,
            scene_commands: description.scene_commands.clone(),
        })
    }

    /// Checked observations in the learner's numbers, and one more observation for each of the `words` that are heard.
    #[must_use]
    pub fn observations(&self, sensed: Observations<'_>, words: &[SymbolId]) -> Vec<Observation> {
        let (hearing, text) = self.hearing;
        let heard = words.iter().map(|word| Observation::new(hearing, [(text, Learnt::Symbol(*word))]));
        sensed.iter().filter_map(|one| self.observation(one)).chain(heard).collect()
    }

    fn observation(&self, sensed: ObservationRecord<'_>) -> Option<Observation> {
        // A checked frame holds only declared types, so the table has this one.
        let table = self.types.get(usize::from(sensed.sense().index()))?;
        let values = sensed.values().zip(&table.properties);
        let properties = values.map(|(value, (property, values))| Some((*property, learnt(value, values)?)));
        Some(Observation::new(table.kind, properties.collect::<Option<Vec<_>>>()?))
    }

    /// The body's action for a primitive.
    ///
    /// # Errors
    /// [`TranslateError::Primitive`] when it is not in the body's repertoire.
    pub fn action(&self, primitive: PrimitiveId) -> Result<&Action, TranslateError> {
        self.primitives.get(&primitive).ok_or(TranslateError::Primitive(primitive.0))
    }

    /// The body's action for a scene command of the curriculum.
    ///
    /// # Errors
    /// When the body has no such command, it has other parameters, or a value is not allowed.
    pub fn scene_command(&self, command: &SceneCommand) -> Result<Action, TranslateError> {
        let at = self.scene_commands.iter().position(|known| known.name == command.command);
        let Some((at, declared)) = at.and_then(|at| Some((at, self.scene_commands.get(at)?))) else {
            let known = listed(self.scene_commands.iter().map(|known| known.name.as_str()));
            return Err(TranslateError::Command { command: command.command.clone(), known });
        };
        let wrong = |problem: String| TranslateError::Parameter { command: command.command.clone(), problem };
        let takes = |name: &str| declared.parameters.iter().any(|parameter| parameter.name == *name);
        if let Some((name, _)) = command.arguments.iter().find(|(name, _)| !takes(name)) {
            let known = listed(declared.parameters.iter().map(|known| known.name.as_str()));
            return Err(wrong(format!("it has no parameter {name}; it has: {known}")));
        }
        let value = |property: &Property| {
            let given = command.arguments.iter().find(|(name, _)| *name == property.name);
            let (name, argument) =
                given.ok_or_else(|| wrong(format!("parameter {} is not given", property.name)))?;
            scene_value(argument, &property.kind)
                .map_err(|problem| wrong(format!("parameter {name} {problem}")))
        };
        let parameters = declared.parameters.iter().map(value).collect::<Result<_, _>>()?;
        let action = Action { id: ActionId::from_index(u16::try_from(at).unwrap_or(u16::MAX)), parameters };
        check::order("the curriculum", &action, &self.scene_commands)?;
        Ok(action)
    }
}

/// Names as an error lists them.
pub(crate) fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<_> = names.collect();
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

fn undeclared(what: &'static str, name: &str) -> TranslateError {
    TranslateError::Undeclared { what, name: name.to_owned() }
}

fn learnt(value: Value, table: &ValueTable) -> Option<Learnt> {
    Some(match (value, table) {
        (Value::Integer(number), ValueTable::AsIs) => Learnt::Integer(number),
        (Value::Boolean(truth), ValueTable::AsIs) => Learnt::Boolean(truth),
        (Value::Symbol(index), ValueTable::Symbols(symbols)) => {
            Learnt::Symbol(*symbols.get(usize::try_from(index).ok()?)?)
        }
        (Value::Real(number), ValueTable::Bins { resolution }) => Learnt::Bin(bin(number, *resolution)),
        _ => return None,
    })
}

/// An argument of a curriculum as a value of `kind`; the error says what it should be.
fn scene_value(argument: &Argument, kind: &ValueKind) -> Result<Value, String> {
    match (argument, kind) {
        (Argument::Integer(number), ValueKind::Integer { .. }) => Ok(Value::Integer(*number)),
        // The conversion is exact below 2^53, and no body has a use for greater numbers.
        (Argument::Integer(number), ValueKind::Real { .. }) => Ok(Value::Real(*number as f64)),
        (Argument::Symbol(name), ValueKind::Symbol { symbols }) => {
            let at = symbols.iter().position(|symbol| symbol == name).and_then(|at| u32::try_from(at).ok());
            at.map(Value::Symbol).ok_or_else(|| format!("= {name} is none of: {}", symbols.join(", ")))
        }
        (Argument::Symbol(word), ValueKind::Boolean) if word == "true" || word == "false" => {
            Ok(Value::Boolean(word == "true"))
        }
        (argument, kind) => {
            let wanted = match kind {
                ValueKind::Integer { .. } | ValueKind::Real { .. } => "a number",
                ValueKind::Symbol { .. } => "a symbol",
                ValueKind::Boolean => "\"true\" or \"false\"",
            };
            Err(format!("= {argument:?} should be {wanted}"))
        }
    }
}

/// A primitive's identity: its action, and its values as the learner compares them. Two primitives of the same identity
/// are the same.
type Identity = (usize, Vec<Learnt>);

fn primitives(
    description: &Description,
    body: BodyId,
    vocabulary: &Vocabulary,
) -> Result<BTreeMap<PrimitiveId, Action>, TranslateError> {
    let mut own: BTreeMap<Identity, &Action> = BTreeMap::new();
    for action in &description.repertoire {
        let declared = description.actions.get(usize::from(action.id.index()));
        let name = declared.map_or("", |declared| declared.name.as_str());
        let at = vocabulary.actions().iter().position(|known| known.name == name);
        let at = at.ok_or_else(|| undeclared("action", name))?;
        let key = identity(at, &parameters(action, &description.actions), vocabulary);
        // Of two actions whose values are in the same bins the first stands for both, as in the learner.
        own.entry(key).or_insert(action);
    }
    let known = vocabulary.bodies().get(usize::from(body.0)).map(|known| known.repertoire.as_slice());
    let mut table = BTreeMap::new();
    for id in known.unwrap_or_default() {
        let index = usize::try_from(id.0).unwrap_or(usize::MAX);
        let primitive = vocabulary.primitives().get(index).ok_or(TranslateError::Primitive(id.0))?;
        let key = identity(primitive.action, &primitive.parameters, vocabulary);
        let action = own.get(&key).ok_or(TranslateError::Primitive(id.0))?;
        table.insert(*id, (*action).clone());
    }
    Ok(table)
}

fn identity(action: usize, parameters: &[Parameter], vocabulary: &Vocabulary) -> Identity {
    let kinds = vocabulary.actions().get(action).map(|known| known.parameters.as_slice()).unwrap_or_default();
    let values = parameters.iter().zip(kinds);
    (action, values.filter_map(|(parameter, kind)| value_of(parameter, &kind.kind, vocabulary)).collect())
}
