//! What a body declares of itself when it attaches: its senses, its actions, and what can be arranged
//! around it. Plain values for the author of a body; [`crate::wire`] has the form that crosses.

/// Everything the daemon learns of a body before its first frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// Which body this is; a body that comes back under the same name continues. At most
    /// [`crate::limits::NAME_BYTES_MAX`] bytes, like every name here.
    pub name: String,
    /// What kind of body, for people: `sim-arm`, `adept`, `grid-world`.
    pub kind: String,
    /// The observation types its frames may hold. Observations refer to them by index.
    pub observation_types: Vec<ObservationType>,
    /// The actions it can carry out. Actions refer to them by index.
    pub actions: Vec<ActionType>,
    /// The primitives that motor babbling draws from: actions with every parameter filled in, each
    /// within the limits declared for it. An arm offers its taught postures, a grid world its moves.
    pub repertoire: Vec<Action>,
    /// What a curriculum may ask of the body's surroundings (place a block, take it away). Commands
    /// refer to them by index. A body without scene control declares none.
    pub scene_commands: Vec<ActionType>,
}

/// A sense: one type of observation.
#[derive(Clone, Debug, PartialEq)]
pub struct ObservationType {
    /// The type's name: `finger`, `object`, `touch`.
    pub name: String,
    /// Caused by the body itself (where its finger is seen, its joint angles): never a pre-condition
    /// by default.
    pub own: bool,
    /// An event that holds for the frame it came in (touch, a word), not a state: never a
    /// pre-condition by default.
    pub transient: bool,
    /// What an observation of this type says, in the order its values are given.
    pub properties: Vec<Property>,
}

/// A named value with its kind: a property of an observation, or a parameter of an action.
#[derive(Clone, Debug, PartialEq)]
pub struct Property {
    /// The property's name. Properties of the same name are comparable across types: a block in
    /// `field` 7 resembles a finger in `field` 7.
    pub name: String,
    /// What values it takes.
    pub kind: ValueKind,
    /// The unit of the value (`rad`, `mm`), empty when it has none.
    pub unit: String,
}

/// The values a property may take.
#[derive(Clone, Debug, PartialEq)]
pub enum ValueKind {
    /// A whole number in `min..=max`.
    Integer {
        /// Smallest value allowed.
        min: i64,
        /// Largest value allowed.
        max: i64,
    },
    /// One of these symbols; a [`Value::Symbol`] is an index into them.
    Symbol {
        /// The symbols, in the order that indexes refer to.
        symbols: Vec<String>,
    },
    /// True or false.
    Boolean,
    /// A finite real in `min..=max`, compared and learnt as the bin `round(value / resolution)`.
    Real {
        /// Smallest value allowed.
        min: f64,
        /// Largest value allowed.
        max: f64,
        /// Width of a bin, above zero.
        resolution: f64,
    },
}

/// An action the body can carry out, or a scene command it can obey.
#[derive(Clone, Debug, PartialEq)]
pub struct ActionType {
    /// The action's name: `move`, `place`.
    pub name: String,
    /// Its parameters, in the order values are given. Their kinds carry the limits.
    pub parameters: Vec<Property>,
}

/// One value of a property or parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// For [`ValueKind::Integer`].
    Integer(i64),
    /// For [`ValueKind::Symbol`]: an index into the declared symbols.
    Symbol(u32),
    /// For [`ValueKind::Boolean`].
    Boolean(bool),
    /// For [`ValueKind::Real`].
    Real(f64),
}

/// An action (or scene command) with its parameters filled in.
#[derive(Clone, Debug, PartialEq)]
pub struct Action {
    /// Index into [`Description::actions`] (or [`Description::scene_commands`]).
    pub action: u16,
    /// One value a parameter, in declared order.
    pub parameters: Vec<Value>,
}
