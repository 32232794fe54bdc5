//! Observations: a type and a set of properties, each a name with a value; and patterns, observations in
//! which values may be variables. Similarity, matching and binding live here and nowhere else.

use std::sync::Arc;

/// An observation type: an index into [`crate::nouns::vocabulary::Vocabulary`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TypeId(pub u16);

impl TypeId {
    /// Of that an episode had ended where something was to be done. Claims tell of it as of what is sensed; no body declares it.
    pub const ENDED: Self = Self(u16::MAX);
}

/// A property name, shared by all observation types: `field` of a finger and `field` of an object are
/// one property. An index into [`crate::nouns::vocabulary::Vocabulary`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PropertyId(pub u16);

/// A symbol: an index into [`crate::nouns::vocabulary::Vocabulary`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SymbolId(pub u32);

/// A value of a property, in the form in which it is compared and learnt.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Value {
    /// A whole number.
    Integer(i64),
    /// A symbol.
    Symbol(SymbolId),
    /// True or false.
    Boolean(bool),
    /// A real, as the index of its bin: `round(value / resolution)` of its property.
    Bin(i64),
}

/// An observation: a type and its properties, ordered by property.
///
/// The order of observations (by type, then by properties) is the canonical order that world states,
/// pre-conditions and post-conditions are kept in.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Observation {
    kind: TypeId,
    /// Shared, for much that is remembered or explained speaks of the same observation.
    properties: Arc<[(PropertyId, Value)]>,
}

impl Observation {
    /// An observation of type `kind`; properties in any order. Of two values for one property the
    /// smaller is kept, so that the result does not depend on the order given.
    #[must_use]
    pub fn new(kind: TypeId, properties: impl IntoIterator<Item = (PropertyId, Value)>) -> Self {
        let mut properties: Vec<_> = properties.into_iter().collect();
        properties.sort_unstable();
        properties.dedup_by_key(|(property, _)| *property);
        Self { kind, properties: properties.into() }
    }

    /// The type of the observation.
    #[must_use]
    pub fn kind(&self) -> TypeId {
        self.kind
    }

    /// The properties, ordered by property.
    #[must_use]
    pub fn properties(&self) -> &[(PropertyId, Value)] {
        &self.properties
    }

    /// |x ∩ y| of equation (1): how many (property, value) pairs the two have in common, whatever their
    /// types. A block in field 7 shares `field=7` with a finger in field 7 (paper, II-C).
    #[must_use]
    pub fn shared(&self, other: &Observation) -> u32 {
        let (mut left, mut right, mut count) = (&self.properties[..], &other.properties[..], 0);
        while let ([a, more @ ..], [b, others @ ..]) = (left, right) {
            if a.0 <= b.0 {
                left = more;
            }
            if b.0 <= a.0 {
                right = others;
            }
            count += u32::from(a == b);
        }
        count
    }
}

/// A variable of a generalised schema: `$a`, `$b`, … numbered from 0 within the schema.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Variable(pub u8);

/// A value or a variable standing for one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Term {
    /// This value and no other.
    Constant(Value),
    /// Any value, the same wherever the variable occurs.
    Variable(Variable),
}

/// An observation in which values may be variables: `object{colour=$a, field=$b}`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Pattern {
    kind: TypeId,
    terms: Box<[(PropertyId, Term)]>,
}

impl Pattern {
    /// A pattern of type `kind`; terms in any order, one a property.
    #[must_use]
    pub fn new(kind: TypeId, terms: impl IntoIterator<Item = (PropertyId, Term)>) -> Self {
        let mut terms: Vec<_> = terms.into_iter().collect();
        terms.sort_unstable();
        terms.dedup_by_key(|(property, _)| *property);
        Self { kind, terms: terms.into() }
    }

    /// The type this pattern matches.
    #[must_use]
    pub fn kind(&self) -> TypeId {
        self.kind
    }

    /// The terms, ordered by property.
    #[must_use]
    pub fn terms(&self) -> &[(PropertyId, Term)] {
        &self.terms
    }

    /// Whether it is of the same type as `observation`, with the same properties.
    pub(crate) fn has_form_of(&self, observation: &Observation) -> bool {
        self.kind == observation.kind
            && self.terms.len() == observation.properties.len()
            && self.terms.iter().zip(observation.properties()).all(|((term, _), (seen, _))| term == seen)
    }

    /// Whether it could match `observation` under some binding, when each pair is looked at by itself.
    pub(crate) fn resembles(&self, observation: &Observation) -> bool {
        self.fits(observation, |_, _| true)
    }

    /// Whether it matches `observation` where `variable` says so of each variable and its value.
    pub(crate) fn fits(&self, observation: &Observation, variable: impl Fn(Variable, Value) -> bool) -> bool {
        self.kind == observation.kind
            && self.terms.len() == observation.properties.len()
            && self.terms.iter().zip(observation.properties()).all(|((property, term), (seen, value))| {
                property == seen
                    && match term {
                        Term::Constant(constant) => constant == value,
                        Term::Variable(name) => variable(*name, *value),
                    }
            })
    }

    /// The observation that results from putting in the bound values; `None` while a variable of this
    /// pattern is unbound. Binding never alters the pattern.
    #[must_use]
    pub fn apply(&self, substitution: &Substitution) -> Option<Observation> {
        let value = |term: Term| match term {
            Term::Constant(value) => Some(value),
            Term::Variable(variable) => substitution.get(variable),
        };
        if self.terms.iter().any(|(_, term)| value(*term).is_none()) {
            return None;
        }
        // None is left out, so that the length is known and all is written once.
        let bound =
            |(property, term): &(PropertyId, Term)| (*property, value(*term).unwrap_or(Value::Integer(0)));
        Some(Observation { kind: self.kind, properties: self.terms.iter().map(bound).collect() })
    }
}

impl From<&Observation> for Pattern {
    fn from(observation: &Observation) -> Self {
        Self {
            kind: observation.kind,
            terms: observation.properties.iter().map(|(p, v)| (*p, Term::Constant(*v))).collect(),
        }
    }
}

/// Values for variables, ordered by variable. A value of its own: binding never changes a schema.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Substitution(Vec<(Variable, Value)>);

impl Substitution {
    /// No bindings.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The value bound to `variable`.
    #[must_use]
    pub fn get(&self, variable: Variable) -> Option<Value> {
        self.0.binary_search_by_key(&variable, |(v, _)| *v).ok().map(|at| self.0[at].1)
    }

    /// Binds `variable` to `value`; false, and no change, if it is bound to another value.
    pub fn bind(&mut self, variable: Variable, value: Value) -> bool {
        match self.0.binary_search_by_key(&variable, |(v, _)| *v) {
            Ok(at) => self.0[at].1 == value,
            Err(at) => {
                self.0.insert(at, (variable, value));
                true
            }
        }
    }

    /// Of `count` variables in their order, each once.
    pub(crate) fn of(count: usize, bound: impl Iterator<Item = (Variable, Value)>) -> Self {
        let mut bindings = Vec::with_capacity(count);
        bindings.extend(bound);
        debug_assert!(bindings.is_sorted_by(|a, b| a.0 < b.0));
        Self(bindings)
    }

    /// The bindings, ordered by variable.
    #[must_use]
    pub fn bindings(&self) -> &[(Variable, Value)] {
        &self.0
    }
}

/// Attempts at matching one pattern with one observation that a single search may make.
pub const MATCH_ATTEMPTS_MAX: usize = 100_000;

#[cfg(test)]
mod tests {
    use super::*;

    const OBJECT: TypeId = TypeId(0);
    const FINGER: TypeId = TypeId(1);
    const COLOUR: PropertyId = PropertyId(0);
    const FIELD: PropertyId = PropertyId(1);

    fn object(colour: u32, field: i64) -> Observation {
        Observation::new(OBJECT, [(COLOUR, Value::Symbol(SymbolId(colour))), (FIELD, Value::Integer(field))])
    }

    #[test]
    fn a_block_in_field_7_resembles_a_finger_in_field_7() {
        let finger = Observation::new(FINGER, [(FIELD, Value::Integer(7))]);
        assert_eq!(object(3, 7).shared(&finger), 1);
        assert_eq!(object(3, 8).shared(&finger), 0);
        assert_eq!(object(3, 7).shared(&object(3, 7)), 2);
    }
}
