//! The declaration of a body: its senses, its actions, and the scene commands that it obeys.

use super::{Action, ActionId, Property, SenseId, Value, Values};
use crate::limits::PRIMITIVES_MAX;

/// Between the kind of a body and the world that it says it is in.
pub const WORLD_MARK: char = '@';

/// Everything the daemon learns of a body before its first frame.
///
/// Declaring a sense or an action gives its id, by which the body later reports observations and knows the actions that it
/// is asked for. Mistakes are found when the body is run, before anything is sent, and named with their place; a test of
/// the body can ask for them with [`Description::check`].
///
/// ```
/// use pschema_protocol::description::{ActionType, Description, ObservationType, Property};
///
/// let mut description = Description::new("cart", "wheels");
/// let place = description.observation(
///     ObservationType::state("place").property(Property::integer("x", 0..=9).unit("cm")),
/// );
/// let bump = description.observation(ObservationType::event("bump"));
/// let go = ActionType::new("go").parameter(Property::integer("by", -1..=1));
/// let go = description.action_with_primitives(go);
/// assert_eq!(description.repertoire.len(), 3);
/// description.check()?;
/// # Ok::<_, pschema_protocol::refusal::Refusal>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Description {
    /// The body's name. A body that comes back under the same name continues. A name has at most
    /// [`crate::limits::NAME_BYTES_MAX`] bytes, like every name here.
    pub name: String,
    /// The kind of body, for people: `sim-arm`, `adept`, `grid-world`. A body that knows its world says it after a [`WORLD_MARK`]:
    /// see [`Description::in_world`].
    pub kind: String,
    /// The types of the observations that its frames may hold, in the order of their [`SenseId`]s.
    pub observation_types: Vec<ObservationType>,
    /// The actions it can carry out, in the order of their [`ActionId`]s.
    pub actions: Vec<ActionType>,
    /// The primitives: actions with every parameter filled in, each within its declared limits. Motor babbling draws from
    /// them. An arm offers its taught postures, a grid world its moves.
    pub repertoire: Vec<Action>,
    /// The scene commands, by which a curriculum may change the body's surroundings (place a block, take it away), in the
    /// order of their [`ActionId`]s. A body that has no control of the scene declares none.
    pub scene_commands: Vec<ActionType>,
}

impl Description {
    /// A description without senses and actions, of the body `name`, which is of this `kind`.
    #[must_use]
    pub fn new(name: impl Into<String>, kind: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            kind: kind.into(),
            observation_types: Vec::new(),
            actions: Vec::new(),
            repertoire: Vec::new(),
            scene_commands: Vec::new(),
        }
    }

    /// Says which world the body is in, by what tells it from other worlds that look alike: `sim-arm` in `narrow` is
    /// `sim-arm@narrow`. A daemon refuses bodies of one kind in two worlds, for what is learnt in one is not true in the
    /// other, unless it was told to take them.
    ///
    /// ```
    /// use pschema_protocol::description::Description;
    ///
    /// let described = Description::new("cart", "wheels").in_world("hall");
    /// assert_eq!(described.kind, "wheels@hall");
    /// assert_eq!(described.kind_and_world(), ("wheels", Some("hall")));
    /// ```
    #[must_use]
    pub fn in_world(mut self, world: &str) -> Self {
        self.kind = format!("{}{WORLD_MARK}{world}", self.kind);
        self
    }

    /// The kind of body, and the world that it says it is in, if it says one.
    #[must_use]
    pub fn kind_and_world(&self) -> (&str, Option<&str>) {
        match self.kind.split_once(WORLD_MARK) {
            Some((kind, world)) => (kind, Some(world).filter(|world| !world.is_empty())),
            None => (&self.kind, None),
        }
    }

    /// Declares a sense. Observations of it are reported by the id:
    /// [`Senses::observe`](crate::body::Senses::observe).
    #[must_use = "observations are reported by this id"]
    pub fn observation(&mut self, declared: ObservationType) -> SenseId {
        self.observation_types.push(declared);
        SenseId::after(self.observation_types.len() - 1)
    }

    /// Declares an action. The learner asks for it only as the repertoire has it: see [`Description::primitive`].
    pub fn action(&mut self, declared: ActionType) -> ActionId {
        self.actions.push(declared);
        ActionId::after(self.actions.len() - 1)
    }

    /// Declares an action and adds it to the repertoire with all combinations of values that the learner tells apart: of
    /// reals, one for each bin. More of them than a repertoire holds are refused, like every other mistake in a
    /// declaration.
    pub fn action_with_primitives(&mut self, declared: ActionType) -> ActionId {
        let mut all = vec![Vec::new()];
        for parameter in &declared.parameters {
            let with = |begun: &Vec<Value>, value| [begun.as_slice(), &[value]].concat();
            let longer =
                all.iter().flat_map(|begun| parameter.kind.every().map(move |value| with(begun, value)));
            // One too many is refused just as all of them would be, and all of them may not fit into memory.
            all = longer.take(PRIMITIVES_MAX + 1).collect();
        }
        let id = self.action(declared);
        self.repertoire.extend(all.into_iter().map(|parameters| Action { id, parameters }));
        id
    }

    /// Declares a scene command, for [`Body::arrange`](crate::body::Body::arrange).
    pub fn scene_command(&mut self, declared: ActionType) -> ActionId {
        self.scene_commands.push(declared);
        ActionId::after(self.scene_commands.len() - 1)
    }

    /// Adds `action` with these parameters to the repertoire.
    pub fn primitive(&mut self, action: ActionId, parameters: impl Values) {
        self.repertoire.push(Action::new(action, parameters));
    }
}

/// A sense of a body: one type of observation.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
#[must_use]
pub struct ObservationType {
    /// The type's name: `finger`, `object`, `touch`.
    pub name: String,
    /// Whether the body itself causes the observation (where its finger is seen, its joint angles). Such an observation is never
    /// a pre-condition by default.
    pub own: bool,
    /// Whether the observation is an event, which holds for the one frame that reports it (a touch, a sound), and not a state.
    /// An event is never a pre-condition by default.
    pub transient: bool,
    /// Whether the observation is a number that comes with the frame and may be wanted: a reward, a cost, a score. The learner does not
    /// live by it, but foretells it, and brings most of it if it is asked to. A value is an event, and has one property, which is an
    /// integer or a real.
    pub value: bool,
    /// The properties of an observation of this type, in the order in which its values are given.
    pub properties: Vec<Property>,
}

impl ObservationType {
    /// A state, which holds until it changes: where something is, what colour it has.
    pub fn state(name: impl Into<String>) -> Self {
        Self { name: name.into(), own: false, transient: false, value: false, properties: Vec::new() }
    }

    /// An event, which holds for the one frame that reports it: a touch, a sound.
    pub fn event(name: impl Into<String>) -> Self {
        Self { transient: true, ..Self::state(name) }
    }

    /// A value, which comes as this number: a reward, a cost, a score. Its property is an integer or a real.
    ///
    /// ```
    /// use pschema_protocol::description::{Description, ObservationType, Property};
    ///
    /// let mut description = Description::new("cart", "wheels");
    /// let reward = ObservationType::value("reward", Property::real("reward", -1.0..=1.0, 0.1));
    /// let reward = description.observation(reward);
    /// description.check()?;
    /// # Ok::<_, pschema_protocol::refusal::Refusal>(())
    /// ```
    pub fn value(name: impl Into<String>, property: Property) -> Self {
        Self { value: true, ..Self::event(name).property(property) }
    }

    /// The same, caused by the body itself: where its own finger is seen, its joint angles.
    pub fn own(mut self) -> Self {
        self.own = true;
        self
    }

    /// The same, with one more property.
    pub fn property(mut self, property: Property) -> Self {
        self.properties.push(property);
        self
    }
}

/// An action that a body can carry out, or a scene command that it can obey.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
#[must_use]
pub struct ActionType {
    /// The action's name: `move`, `place`.
    pub name: String,
    /// Its parameters, in the order in which their values are given. Their kinds have the limits.
    pub parameters: Vec<Property>,
}

impl ActionType {
    /// An action without parameters.
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), parameters: Vec::new() }
    }

    /// The same, with one more parameter.
    pub fn parameter(mut self, parameter: Property) -> Self {
        self.parameters.push(parameter);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::refusal::Refusal;

    fn repertoire(parameters: impl IntoIterator<Item = Property>) -> Description {
        let mut description = Description::new("body", "test");
        let declared = parameters.into_iter().fold(ActionType::new("do"), ActionType::parameter);
        description.action_with_primitives(declared);
        description
    }

    #[test]
    fn primitives_are_each_combination_of_what_is_told_apart() {
        let of = |parameters: &[Property]| -> Vec<Vec<Value>> {
            let description = repertoire(parameters.iter().cloned());
            assert_eq!(description.check(), Ok(()));
            description.repertoire.into_iter().map(|action| action.parameters).collect()
        };
        assert_eq!(of(&[]), [vec![]]);
        let real = Property::real("reach", 0.0..=0.5, 0.2);
        let bins = [0.0, 0.2, 0.4, 0.5].map(|middle| vec![Value::Real(middle)]);
        let near = |one: &[Value], other: &[Value]| match (one, other) {
            ([Value::Real(one)], [Value::Real(other)]) => (one - other).abs() < 1e-12,
            _ => false,
        };
        assert!(of(&[real]).iter().zip(&bins).all(|(one, other)| near(one, other)));
        let both = of(&[Property::boolean("lit"), Property::symbol("to", ["a", "b", "c"])]);
        assert_eq!(both.len(), 6);
        assert_eq!(both[4], [Value::Boolean(true), Value::Symbol(1)]);
    }

    #[test]
    fn more_primitives_than_there_may_be_are_refused_and_not_made() {
        let number = || Property::integer("number", i64::MIN..=i64::MAX);
        let description = repertoire([number(), Property { name: "other".to_owned(), ..number() }]);
        let expected = Refusal::TooMany {
            what: "primitives in the repertoire".to_owned(),
            found: PRIMITIVES_MAX + 1,
            limit: PRIMITIVES_MAX,
        };
        assert_eq!(description.check(), Err(expected));
    }
}
