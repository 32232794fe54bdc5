//! Exact worlds for the learner: the only place where their names and values become those of the learner.

use pschema_exact::declaration::{self, Declaration, Percept, Primitive, Property, Range};
use pschema_learner::Learner;
use pschema_learner::observation::{Observation, PropertyId, SymbolId, TypeId, Value};
use pschema_learner::vocabulary::{
    self, DeclaredAction, DeclaredProperty, DeclaredType, Parameter, PrimitiveId, ValueKind,
};
use pschema_learner::world_state::WorldState;

/// The numbers that a learner knows the words of one world by.
#[derive(Clone)]
pub(crate) struct Lexicon {
    senses: Vec<SenseEntry>,
    repertoire: Vec<Primitive>,
}

#[derive(Clone)]
struct SenseEntry {
    name: String,
    kind: TypeId,
    /// The properties, each with the numbers of its symbols.
    properties: Vec<(PropertyId, Vec<SymbolId>)>,
    transient: bool,
    noise: bool,
}

impl Lexicon {
    /// The words of a declaration that `learner` has taken in.
    pub(crate) fn new(declaration: &Declaration, learner: &mut Learner) -> Self {
        let property = |learner: &mut Learner, property: &Property| {
            let symbols = match &property.range {
                Range::Symbol(symbols) => symbols.iter().map(|symbol| learner.symbol(symbol).0).collect(),
                _ => Vec::new(),
            };
            let known = learner.memory().content().vocabulary.property_named(&property.name);
            (known.unwrap_or(PropertyId(u16::MAX)), symbols)
        };
        let senses = declaration.senses.iter().map(|sense| {
            let properties = sense.properties.iter().map(|declared| property(learner, declared)).collect();
            let known = learner.memory().content().vocabulary.type_named(&sense.name);
            let kind = known.unwrap_or(TypeId(u16::MAX));
            let name = sense.name.clone();
            SenseEntry { name, kind, properties, transient: sense.transient, noise: sense.noise }
        });
        Self { senses: senses.collect(), repertoire: declaration.repertoire.clone() }
    }

    /// A percept as the learner perceives it.
    pub(crate) fn world_state(&self, percept: &Percept) -> WorldState {
        WorldState::new(percept.iter().map(|observed| {
            let SenseEntry { kind, properties, .. } = &self.senses[observed.sense];
            let values = properties.iter().zip(&observed.values);
            let values = values.map(|((property, symbols), value)| (*property, value_of(*value, symbols)));
            Observation::new(*kind, values)
        }))
    }

    /// The type of the sense of this name.
    pub(crate) fn sense(&self, name: &str) -> Option<TypeId> {
        self.senses.iter().find(|sense| sense.name == name).map(|sense| sense.kind)
    }

    /// The senses that are measured, each with its type: neither noise nor events.
    pub(crate) fn measured_senses(&self) -> impl Iterator<Item = (String, TypeId)> + '_ {
        let measured = self.senses.iter().filter(|sense| !sense.noise && !sense.transient);
        measured.map(|sense| (sense.name.clone(), sense.kind))
    }

    /// The learner's number of `primitive`; none when it was never declared.
    pub(crate) fn number(&self, primitive: &Primitive) -> Option<PrimitiveId> {
        let at = self.repertoire.iter().position(|known| known == primitive)?;
        u32::try_from(at).ok().map(PrimitiveId)
    }

    /// The primitive of this number.
    pub(crate) fn primitive(&self, number: PrimitiveId) -> Option<&Primitive> {
        self.repertoire.get(number.0 as usize)
    }

    /// The part of `world` that goes on holding unless something changes it: all but events.
    pub(crate) fn lasting(&self, world: &WorldState) -> WorldState {
        world.filter(|observation| !self.is(observation, |sense| sense.transient))
    }

    /// The part of `world` that is sensed and no noise.
    pub(crate) fn measured(&self, world: &WorldState) -> WorldState {
        world.filter(|observation| self.is_measured(observation.kind()))
    }

    /// Whether a type is sensed and no noise.
    pub(crate) fn is_measured(&self, kind: TypeId) -> bool {
        self.senses.iter().any(|sense| sense.kind == kind && !sense.noise)
    }

    fn is(&self, observation: &Observation, flag: impl Fn(&SenseEntry) -> bool) -> bool {
        self.senses.iter().any(|sense| sense.kind == observation.kind() && flag(sense))
    }
}

fn value_of(value: declaration::Value, symbols: &[SymbolId]) -> Value {
    match value {
        declaration::Value::Integer(number) => Value::Integer(number),
        // A symbol that was not declared is none that the learner knows.
        declaration::Value::Symbol(place) => {
            Value::Symbol(symbols.get(place).copied().unwrap_or(SymbolId(u32::MAX)))
        }
        declaration::Value::Boolean(truth) => Value::Boolean(truth),
        declaration::Value::Real(bin) => Value::Bin(bin),
    }
}

/// A declaration for the learner.
pub(crate) fn declared(declaration: &Declaration) -> vocabulary::Declaration {
    let observation_types = declaration.senses.iter().map(|sense| DeclaredType {
        own: sense.own,
        transient: sense.transient,
        properties: sense.properties.iter().map(property_of).collect(),
        ..DeclaredType::state(&sense.name)
    });
    let actions = declaration.actions.iter().map(|action| DeclaredAction {
        name: action.name.clone(),
        parameters: action.parameters.iter().map(property_of).collect(),
    });
    let repertoire = declaration.repertoire.iter().map(|primitive| {
        let parameters = &declaration.actions[primitive.action].parameters;
        let values = primitive.parameters.iter().zip(parameters);
        (primitive.action, values.map(|(value, parameter)| parameter_of(*value, parameter)).collect())
    });
    vocabulary::Declaration {
        body: "exact".to_owned(),
        observation_types: observation_types.collect(),
        actions: actions.collect(),
        repertoire: repertoire.collect(),
    }
}

fn property_of(property: &Property) -> DeclaredProperty {
    let kind = match property.range {
        Range::Integer(..) => ValueKind::Integer,
        Range::Symbol(_) => ValueKind::Symbol,
        Range::Boolean => ValueKind::Boolean,
        Range::Real { resolution, .. } => ValueKind::Real { resolution },
    };
    DeclaredProperty { name: property.name.clone(), unit: String::new(), kind }
}

fn parameter_of(value: declaration::Value, parameter: &Property) -> Parameter {
    match (value, &parameter.range) {
        (declaration::Value::Symbol(place), Range::Symbol(symbols)) => {
            Parameter::Symbol(symbols.get(place).cloned().unwrap_or_default())
        }
        (declaration::Value::Real(bin), Range::Real { resolution, .. }) => {
            Parameter::Real(bin as f64 * resolution)
        }
        (declaration::Value::Boolean(truth), _) => Parameter::Boolean(truth),
        (declaration::Value::Integer(number) | declaration::Value::Real(number), _) => {
            Parameter::Integer(number)
        }
        (declaration::Value::Symbol(place), _) => {
            Parameter::Integer(i64::try_from(place).unwrap_or(i64::MAX))
        }
    }
}
