//! What a world lets a body sense and do: plain names and values.

use std::collections::BTreeSet;

/// A value of a property or of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Value {
    /// A whole number.
    Integer(i64),
    /// A symbol, by its place among those that are declared.
    Symbol(usize),
    /// True or false.
    Boolean(bool),
    /// A real, by its bin: the middle of the bin is so many resolutions.
    Real(i64),
}

/// The values that a property or a parameter takes.
#[derive(Clone, Debug, PartialEq)]
pub enum Range {
    /// Whole numbers from the first to the last.
    Integer(i64, i64),
    /// One of these symbols.
    Symbol(Vec<String>),
    /// True or false.
    Boolean,
    /// Reals by their bins.
    Real {
        /// The first bin.
        first: i64,
        /// The last bin.
        last: i64,
        /// The width of a bin.
        resolution: f64,
    },
}

/// A property of a sense, or a parameter of an action.
#[derive(Clone, Debug, PartialEq)]
pub struct Property {
    /// Its name. Properties of one name are comparable, whatever the sense.
    pub name: String,
    /// Its values.
    pub range: Range,
}

impl Property {
    /// A whole number below `count`.
    #[must_use]
    pub fn below(name: &str, count: usize) -> Self {
        let last = i64::try_from(count).unwrap_or(i64::MAX) - 1;
        Self { name: name.to_owned(), range: Range::Integer(0, last) }
    }

    /// One of `symbols`.
    #[must_use]
    pub fn symbol(name: &str, symbols: impl IntoIterator<Item = impl Into<String>>) -> Self {
        let symbols = symbols.into_iter().map(Into::into).collect();
        Self { name: name.to_owned(), range: Range::Symbol(symbols) }
    }

    /// True or false.
    #[must_use]
    pub fn boolean(name: &str) -> Self {
        Self { name: name.to_owned(), range: Range::Boolean }
    }

    /// A real from 0 to 1 in bins of 1 / `bins`.
    #[must_use]
    pub fn unit_real(name: &str, bins: i64) -> Self {
        let range = Range::Real { first: 0, last: bins, resolution: 1.0 / bins as f64 };
        Self { name: name.to_owned(), range }
    }
}

/// A type of observation.
#[derive(Clone, Debug, PartialEq)]
pub struct Sense {
    /// Its name.
    pub name: String,
    /// Whether the body itself causes it.
    pub own: bool,
    /// Whether it is an event, which holds for one frame only.
    pub transient: bool,
    /// Whether it is noise: no action has any part in it, and nobody can foretell it.
    pub noise: bool,
    /// Its properties, in the order of their values.
    pub properties: Vec<Property>,
}

impl Sense {
    /// A state of the world.
    #[must_use]
    pub fn state(name: &str, properties: impl Into<Vec<Property>>) -> Self {
        let (own, transient, noise) = (false, false, false);
        Self { name: name.to_owned(), own, transient, noise, properties: properties.into() }
    }

    /// An event.
    #[must_use]
    pub fn event(name: &str, properties: impl Into<Vec<Property>>) -> Self {
        Self { transient: true, ..Self::state(name, properties) }
    }

    /// The same, caused by the body itself.
    #[must_use]
    pub fn own(self) -> Self {
        Self { own: true, ..self }
    }

    /// The same, as noise.
    #[must_use]
    pub fn noise(self) -> Self {
        Self { noise: true, ..self }
    }
}

/// An action.
#[derive(Clone, Debug, PartialEq)]
pub struct Action {
    /// Its name.
    pub name: String,
    /// Its parameters, in the order of their values.
    pub parameters: Vec<Property>,
}

/// An action with its parameters filled in.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Primitive {
    /// The place of the action among those that are declared.
    pub action: usize,
    /// One value a parameter.
    pub parameters: Vec<Value>,
}

impl Primitive {
    /// The first parameter as a number from 0: a whole number, or the place of a symbol. 0 of an action without parameters.
    #[must_use]
    pub fn number(&self) -> usize {
        match self.parameters.first() {
            Some(Value::Integer(number)) => usize::try_from(*number).unwrap_or(0),
            Some(Value::Symbol(place)) => *place,
            _ => 0,
        }
    }
}

/// An observation.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Observation {
    /// The place of its sense among those that are declared.
    pub sense: usize,
    /// One value a property.
    pub values: Vec<Value>,
}

impl Observation {
    /// An observation of `sense`.
    #[must_use]
    pub fn new(sense: usize, values: impl Into<Vec<Value>>) -> Self {
        Self { sense, values: values.into() }
    }
}

/// Everything that is perceived in one frame.
pub type Percept = BTreeSet<Observation>;

/// What a body in a world senses and does.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Declaration {
    /// The types of its observations.
    pub senses: Vec<Sense>,
    /// Its actions.
    pub actions: Vec<Action>,
    /// Everything that it can do.
    pub repertoire: Vec<Primitive>,
}

impl Declaration {
    /// A declaration with these senses, and no action yet.
    #[must_use]
    pub fn sensing(senses: impl Into<Vec<Sense>>) -> Self {
        Self { senses: senses.into(), ..Self::default() }
    }

    /// The same with an action without parameters.
    #[must_use]
    pub fn action(mut self, name: &str) -> Self {
        let primitive = Primitive { action: self.actions.len(), parameters: Vec::new() };
        self.repertoire.push(primitive);
        self.actions.push(Action { name: name.to_owned(), parameters: Vec::new() });
        self
    }

    /// The same with an action of one parameter, and in the repertoire a primitive for each value of it.
    #[must_use]
    pub fn action_for_each(mut self, name: &str, parameter: Property) -> Self {
        let values: Vec<_> = match &parameter.range {
            Range::Integer(first, last) => (*first..=*last).map(Value::Integer).collect(),
            Range::Symbol(symbols) => (0..symbols.len()).map(Value::Symbol).collect(),
            Range::Boolean => [false, true].map(Value::Boolean).into(),
            Range::Real { first, last, .. } => (*first..=*last).map(Value::Real).collect(),
        };
        let action = self.actions.len();
        self.repertoire.extend(values.into_iter().map(|value| Primitive { action, parameters: vec![value] }));
        self.actions.push(Action { name: name.to_owned(), parameters: vec![parameter] });
        self
    }
}
