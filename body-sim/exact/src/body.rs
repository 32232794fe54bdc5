//! A world as a body of the protocol: the only place where its names and values become those of the wire.

use pschema_protocol::body::{Body, Outcome, Senses};
use pschema_protocol::description::{
    Action, ActionId, ActionType, Description, ObservationType, Property, SenseId, Value, ValueKind,
};

use crate::catalogue::{self, WorldError};
use crate::declaration::{self, Declaration, Primitive, Range};
use crate::world::Situation;

/// A body that lives in an exact world.
///
/// An episode that is over ends, and the next begins with the action after it. When others change the world, which they do in some worlds
/// after every few actions, that cuts the episode off: the action of that moment is not carried out, and the senses show the changed world.
///
/// ```
/// use pschema_exact::ExactBody;
/// use pschema_protocol::body::{Body, Outcome, Senses};
///
/// let mut body = ExactBody::new("toy", "gripper:blocks=3", 7)?;
/// let description = body.describe();
/// assert_eq!((description.name.as_str(), description.kind.as_str()), ("toy", "exact@gripper:3"));
/// let mut senses = Senses::default();
/// body.sense(&mut senses);
/// assert!(senses.observations().len() >= 3);
/// // An action that may not be carried out changes nothing, which can be learnt.
/// assert_eq!(body.act(&description.repertoire[0]), Outcome::Done);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct ExactBody {
    situation: Box<dyn Situation>,
    description: Description,
    senses: Vec<SenseId>,
    actions: Vec<ActionId>,
    /// Actions since others changed the world.
    since: usize,
}

impl ExactBody {
    /// A body of this name in the world that `world` names, such as `flip` or `gripper:blocks=7`. `seed` decides all chances.
    ///
    /// # Errors
    /// When there is no such world.
    pub fn new(name: &str, world: &str, seed: u64) -> Result<Self, WorldError> {
        let situation = catalogue::open(world, seed)?;
        let Declaration { senses, actions, repertoire } = situation.declaration();
        let mut description = Description::new(name, "exact").in_world(&catalogue::identity(world)?);
        let senses = senses.iter().map(|sense| description.observation(observation_type(sense))).collect();
        let actions: Vec<_> = actions
            .iter()
            .map(|action| {
                let declared = ActionType::new(&action.name);
                let parameters = action.parameters.iter().map(property);
                description.action(parameters.fold(declared, ActionType::parameter))
            })
            .collect();
        for primitive in repertoire {
            let parameters = &situation.declaration().actions[primitive.action].parameters;
            let values = primitive.parameters.iter().zip(parameters);
            let values: Vec<_> = values.map(|(given, declared)| value(*given, declared)).collect();
            description.primitive(actions[primitive.action], &values[..]);
        }
        Ok(Self { situation, description, senses, actions, since: 0 })
    }

    /// The primitive that `action` is; none if it is none of this world.
    fn primitive(&self, action: &Action) -> Option<Primitive> {
        let at = self.actions.iter().position(|id| *id == action.id)?;
        let declaration = self.situation.declaration();
        let declared = &declaration.actions[at].parameters;
        let parameters = action.parameters.iter().zip(declared).map(|(given, declared)| match *given {
            Value::Integer(number) => declaration::Value::Integer(number),
            Value::Symbol(place) => declaration::Value::Symbol(usize::try_from(place).unwrap_or(usize::MAX)),
            Value::Boolean(truth) => declaration::Value::Boolean(truth),
            Value::Real(number) => declaration::Value::Real((number / resolution(declared)).round() as i64),
        });
        let primitive = Primitive { action: at, parameters: parameters.collect() };
        declaration.repertoire.contains(&primitive).then_some(primitive)
    }
}

impl Body for ExactBody {
    fn describe(&self) -> Description {
        self.description.clone()
    }

    fn sense(&mut self, frame: &mut Senses) {
        for observation in self.situation.percept() {
            let properties = &self.situation.declaration().senses[observation.sense].properties;
            let values = observation.values.iter().zip(properties);
            let values: Vec<_> = values.map(|(given, declared)| value(*given, declared)).collect();
            frame.observe(self.senses[observation.sense], &values[..]);
        }
    }

    fn act(&mut self, action: &Action) -> Outcome {
        let Some(primitive) = self.primitive(action) else {
            return Outcome::refused("no such action is in the repertoire");
        };
        if self.situation.is_over() {
            self.situation.renew();
            return Outcome::EpisodeEnded;
        }
        if self.situation.spell().is_some_and(|spell| self.since >= spell) {
            self.since = 0;
            self.situation.renew();
            return Outcome::EpisodeCut;
        }
        self.since += 1;
        self.situation.act(&primitive);
        Outcome::Done
    }
}

fn observation_type(sense: &declaration::Sense) -> ObservationType {
    let named = match sense.transient {
        true => ObservationType::event(&sense.name),
        false => ObservationType::state(&sense.name),
    };
    let named = if sense.own { named.own() } else { named };
    sense.properties.iter().map(property).fold(named, ObservationType::property)
}

fn property(declared: &declaration::Property) -> Property {
    let kind = match &declared.range {
        Range::Integer(min, max) => ValueKind::Integer { min: *min, max: *max },
        Range::Symbol(symbols) => ValueKind::Symbol { symbols: symbols.clone() },
        Range::Boolean => ValueKind::Boolean,
        Range::Real { first, last, resolution } => ValueKind::Real {
            min: *first as f64 * resolution,
            max: *last as f64 * resolution,
            resolution: *resolution,
        },
    };
    Property::new(&declared.name, kind)
}

fn value(given: declaration::Value, declared: &declaration::Property) -> Value {
    match given {
        declaration::Value::Integer(number) => Value::Integer(number),
        declaration::Value::Symbol(place) => Value::symbol(place),
        declaration::Value::Boolean(truth) => Value::Boolean(truth),
        declaration::Value::Real(bin) => Value::Real(bin as f64 * resolution(declared)),
    }
}

/// The width of a bin of `declared`; 1 of everything that is no real.
fn resolution(declared: &declaration::Property) -> f64 {
    if let Range::Real { resolution, .. } = declared.range { resolution } else { 1.0 }
}
