//! Observations: a type and a set of properties, each a name with a value; and patterns, observations in
//! which values may be variables. Similarity, matching and binding live here and nowhere else.

/// An observation type: an index into [`crate::vocabulary::Vocabulary`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TypeId(pub u16);

/// A property name, shared by all observation types: `field` of a finger and `field` of an object are
/// one property. An index into [`crate::vocabulary::Vocabulary`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PropertyId(pub u16);

/// A symbol: an index into [`crate::vocabulary::Vocabulary`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SymbolId(pub u32);

/// A value of a property, as it is compared and learnt.
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

/// Something perceived: a type and its properties, ordered by property.
///
/// The order of observations (by type, then by properties) is the canonical order that world states,
/// pre-conditions and post-conditions are kept in.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Observation {
    kind: TypeId,
    properties: Box<[(PropertyId, Value)]>,
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

    /// The type observed.
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
        let mut count = 0;
        let (mut left, mut right) = (self.properties.iter().peekable(), other.properties.iter().peekable());
        while let (Some(a), Some(b)) = (left.peek(), right.peek()) {
            match a.0.cmp(&b.0) {
                std::cmp::Ordering::Less => drop(left.next()),
                std::cmp::Ordering::Greater => drop(right.next()),
                std::cmp::Ordering::Equal => {
                    count += u32::from(a.1 == b.1);
                    left.next();
                    right.next();
                }
            }
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

    /// Matches `observation` under the bindings made so far, and adds the bindings it needs. On a
    /// mismatch (another type, other properties, a constant that differs, a variable bound to another
    /// value) nothing is bound and the result is false.
    #[must_use]
    pub fn bind(&self, observation: &Observation, substitution: &mut Substitution) -> bool {
        if self.kind != observation.kind || self.terms.len() != observation.properties.len() {
            return false;
        }
        let mut extended = substitution.clone();
        for ((property, term), (seen, value)) in self.terms.iter().zip(observation.properties.iter()) {
            let agrees = property == seen
                && match term {
                    Term::Constant(constant) => constant == value,
                    Term::Variable(variable) => extended.bind(*variable, *value),
                };
            if !agrees {
                return false;
            }
        }
        *substitution = extended;
        true
    }

    /// Whether it could match `observation` under some binding, as far as one pair at a time tells.
    fn resembles(&self, observation: &Observation) -> bool {
        self.fits(observation, |_, _| true)
    }

    /// Whether it could match `observation` under an extension of `substitution`, as far as one pair at a time tells.
    fn agrees(&self, observation: &Observation, substitution: &Substitution) -> bool {
        self.fits(observation, |variable, value| {
            substitution.get(variable).is_none_or(|bound| bound == value)
        })
    }

    fn fits(&self, observation: &Observation, variable: impl Fn(Variable, Value) -> bool) -> bool {
        self.kind == observation.kind
            && self.terms.len() == observation.properties.len()
            && self.terms.iter().zip(&observation.properties).all(|((property, term), (seen, value))| {
                property == seen
                    && match term {
                        Term::Constant(constant) => constant == value,
                        Term::Variable(name) => variable(*name, *value),
                    }
            })
    }

    /// Whether it has variables.
    pub(crate) fn has_variables(&self) -> bool {
        self.terms.iter().any(|(_, term)| matches!(term, Term::Variable(_)))
    }

    /// The observation that results from putting in the bound values; `None` while a variable of this
    /// pattern is unbound. Binding never alters the pattern.
    #[must_use]
    pub fn apply(&self, substitution: &Substitution) -> Option<Observation> {
        let properties = self
            .terms
            .iter()
            .map(|(property, term)| match term {
                Term::Constant(value) => Some((*property, *value)),
                Term::Variable(variable) => substitution.get(*variable).map(|value| (*property, value)),
            })
            .collect::<Option<Box<[_]>>>()?;
        Some(Observation { kind: self.kind, properties })
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

    /// The bindings, ordered by variable.
    #[must_use]
    pub fn bindings(&self) -> &[(Variable, Value)] {
        &self.0
    }
}

/// Every substitution under which each of `patterns` matches a different one of `observations`, in
/// canonical order and without duplicates, at most `limit` of them. Two objects that both fit `$x` give
/// two substitutions.
#[must_use]
pub fn bindings(patterns: &[Pattern], observations: &[Observation], limit: usize) -> Vec<Substitution> {
    // Bounds work on hostile worlds (many equal types); ordinary ones never reach it.
    bindings_within(patterns, observations, limit, &mut { MATCH_ATTEMPTS_MAX })
}

/// As [`bindings`], with as many attempts as `budget` still has, of which it takes those that it makes.
pub(crate) fn bindings_within(
    patterns: &[Pattern],
    observations: &[Observation],
    limit: usize,
    budget: &mut usize,
) -> Vec<Substitution> {
    let mut fitting = Vec::with_capacity(patterns.len());
    for pattern in patterns {
        let fits = |at: &usize| observations.get(*at).is_some_and(|one| pattern.resembles(one));
        let places: Vec<_> = (0..observations.len()).filter(fits).collect();
        if places.is_empty() {
            return Vec::new();
        }
        fitting.push((pattern, places));
    }
    // Whatever the order, the same is found; what leaves least choice leaves least to be tried. In a crowded world most
    // patterns are of objects that nothing happened to, and fit just one.
    fitting.sort_by_key(|(_, places)| places.len());
    let mut search = Search {
        observations,
        used: vec![false; observations.len()],
        found: std::collections::BTreeSet::new(),
        budget,
    };
    search.extend(&fitting, &Substitution::new());
    search.found.into_iter().take(limit).collect()
}

/// A search for [`bindings`].
struct Search<'a> {
    observations: &'a [Observation],
    used: Vec<bool>,
    found: std::collections::BTreeSet<Substitution>,
    budget: &'a mut usize,
}

impl Search<'_> {
    fn extend(&mut self, patterns: &[(&Pattern, Vec<usize>)], so_far: &Substitution) {
        let Some(((first, places), rest)) = patterns.split_first() else {
            self.found.insert(so_far.clone());
            return;
        };
        for at in places {
            if *self.budget == 0 {
                return;
            }
            *self.budget -= 1;
            if self.used[*at] || !first.agrees(&self.observations[*at], so_far) {
                continue;
            }
            let mut substitution = so_far.clone();
            if first.bind(&self.observations[*at], &mut substitution) {
                self.used[*at] = true;
                self.extend(rest, &substitution);
                self.used[*at] = false;
            }
        }
    }
}

/// Attempts at matching one pattern with one observation that a single call of [`bindings`] may make.
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

    fn any_object() -> Pattern {
        Pattern::new(OBJECT, [(COLOUR, Term::Variable(Variable(0))), (FIELD, Term::Variable(Variable(1)))])
    }

    #[test]
    fn a_block_in_field_7_resembles_a_finger_in_field_7() {
        let finger = Observation::new(FINGER, [(FIELD, Value::Integer(7))]);
        assert_eq!(object(3, 7).shared(&finger), 1);
        assert_eq!(object(3, 8).shared(&finger), 0);
        assert_eq!(object(3, 7).shared(&object(3, 7)), 2);
    }

    #[test]
    fn two_objects_give_two_bindings_and_the_pattern_stays_as_it_was() {
        let pattern = any_object();
        let found = bindings(std::slice::from_ref(&pattern), &[object(1, 4), object(2, 5)], 8);
        assert_eq!(found.len(), 2);
        assert_eq!(pattern, any_object());
        assert_eq!(pattern.apply(&found[0]), Some(object(1, 4)));
    }

    #[test]
    fn one_object_cannot_stand_for_two_patterns() {
        assert!(bindings(&[any_object(), any_object()], &[object(1, 4)], 8).is_empty());
    }

    #[test]
    fn a_variable_keeps_its_value_and_constants_are_checked() {
        let finger = Pattern::new(FINGER, [(FIELD, Term::Variable(Variable(1)))]);
        let at = |field| Observation::new(FINGER, [(FIELD, Value::Integer(field))]);
        assert_eq!(bindings(&[any_object(), finger.clone()], &[object(1, 4), at(4)], 8).len(), 1);
        assert!(bindings(&[any_object(), finger], &[object(1, 4), at(5)], 8).is_empty());
        let blue = Pattern::new(
            OBJECT,
            [(COLOUR, Term::Constant(Value::Symbol(SymbolId(1)))), (FIELD, Term::Variable(Variable(0)))],
        );
        assert!(bindings(&[blue], &[object(2, 4)], 8).is_empty());
    }
}
