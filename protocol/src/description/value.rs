//! Values, the ids of declarations, and actions with their parameters filled in.

/// One value of a property or parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// For [`ValueKind::Integer`](super::ValueKind::Integer).
    Integer(i64),
    /// For [`ValueKind::Symbol`](super::ValueKind::Symbol): the index of one of the declared symbols, from 0.
    Symbol(u32),
    /// For [`ValueKind::Boolean`](super::ValueKind::Boolean).
    Boolean(bool),
    /// For [`ValueKind::Real`](super::ValueKind::Real).
    Real(f64),
}

impl Value {
    /// The symbol at `index` of those declared, from 0.
    #[must_use]
    pub fn symbol(index: usize) -> Self {
        // An index that does not fit is beyond the symbols of every property, and so is the largest that fits.
        Self::Symbol(u32::try_from(index).unwrap_or(u32::MAX))
    }
}

impl From<i64> for Value {
    fn from(number: i64) -> Self {
        Self::Integer(number)
    }
}

impl From<i32> for Value {
    fn from(number: i32) -> Self {
        Self::Integer(number.into())
    }
}

impl From<bool> for Value {
    fn from(truth: bool) -> Self {
        Self::Boolean(truth)
    }
}

impl From<f64> for Value {
    fn from(number: f64) -> Self {
        Self::Real(number)
    }
}

/// Values, one a property or parameter, in declared order: `()` for none, an array, a slice of [`Value`], or a tuple of
/// things that become values, such as `(Value::Symbol(2), 7, true)`.
pub trait Values {
    /// Calls `read` with the values. Nothing is allocated for them.
    fn read<R>(self, read: impl FnOnce(&[Value]) -> R) -> R;
}

impl Values for &[Value] {
    fn read<R>(self, read: impl FnOnce(&[Value]) -> R) -> R {
        read(self)
    }
}

impl<V: Into<Value>, const N: usize> Values for [V; N] {
    fn read<R>(self, read: impl FnOnce(&[Value]) -> R) -> R {
        read(&self.map(Into::into))
    }
}

/// As many as there can be properties: see [`crate::limits::PROPERTIES_MAX`].
macro_rules! tuples {
    ($(($($name:ident)*))+) => {$(
        impl<$($name: Into<Value>),*> Values for ($($name,)*) {
            #[allow(non_snake_case, reason = "the name of a type names its value too")]
            fn read<R>(self, read: impl FnOnce(&[Value]) -> R) -> R {
                let ($($name,)*) = self;
                read(&[$($name.into()),*])
            }
        }
    )+};
}
tuples! { () (A) (A B) (A B C) (A B C D) (A B C D E) (A B C D E F) (A B C D E F G) (A B C D E F G H) }

/// A sense of a body: which of its declared observation types an observation is of.
/// [`Description::observation`](super::Description::observation) gives it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SenseId(u16);

/// Which of its declared actions, or scene commands, a body is asked for.
/// [`Description::action`](super::Description::action) and
/// [`Description::scene_command`](super::Description::scene_command) give it, each for its own list.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ActionId(u16);

macro_rules! index_of_declaration {
    ($($id:ident),+) => {$(
        impl $id {
            /// The id of the declaration at `index`, counted from 0, for programs that read a description which they did
            /// not make. A body takes the id that it was given when it declared.
            #[must_use]
            pub const fn from_index(index: u16) -> Self {
                Self(index)
            }

            /// The place of the declaration in its list, from 0.
            #[must_use]
            pub const fn index(self) -> u16 {
                self.0
            }

            /// The id of what is declared next in a list of so many. Lists are limited to far fewer than fit.
            pub(super) fn after(declared: usize) -> Self {
                Self(u16::try_from(declared).unwrap_or(u16::MAX))
            }
        }
    )+};
}
index_of_declaration!(SenseId, ActionId);

/// An action (or scene command) with its parameters filled in.
#[derive(Clone, Debug, PartialEq)]
pub struct Action {
    /// Which one.
    pub id: ActionId,
    /// One value a parameter, in declared order.
    pub parameters: Vec<Value>,
}

impl Action {
    /// The action `id` with these parameters.
    #[must_use]
    pub fn new(id: ActionId, parameters: impl Values) -> Self {
        Self { id, parameters: parameters.read(<[Value]>::to_vec) }
    }

    /// The parameter at `place`, from 0, that was declared as an integer; none when it was not.
    #[must_use]
    pub fn integer(&self, place: usize) -> Option<i64> {
        if let Some(Value::Integer(number)) = self.parameters.get(place) { Some(*number) } else { None }
    }

    /// The index of the symbol that the parameter at `place` is, of those declared for it; none when it was declared
    /// otherwise.
    #[must_use]
    pub fn symbol(&self, place: usize) -> Option<usize> {
        if let Some(Value::Symbol(index)) = self.parameters.get(place) {
            usize::try_from(*index).ok()
        } else {
            None
        }
    }

    /// The parameter at `place` that was declared as a boolean; none when it was not.
    #[must_use]
    pub fn boolean(&self, place: usize) -> Option<bool> {
        if let Some(Value::Boolean(truth)) = self.parameters.get(place) { Some(*truth) } else { None }
    }

    /// The parameter at `place` that was declared as a real; none when it was not.
    #[must_use]
    pub fn real(&self, place: usize) -> Option<f64> {
        if let Some(Value::Real(number)) = self.parameters.get(place) { Some(*number) } else { None }
    }
}
