//! The vocabulary of a learner: the observation types and the actions of its bodies, which bodies declare as they attach. It is
//! merged by name and never taken back. Everything else in memory refers to it by number.

use std::collections::BTreeSet;
use std::fmt;

use rustc_hash::FxHashMap;

use crate::nouns::observation::{Observation, Pattern, PropertyId, SymbolId, Term, TypeId, Value};

/// The property of a synthetic item that says whether it is supposed to be so.
const SUPPOSED: &str = "supposed";

/// A primitive: an action with its parameters filled in, as it stands in some body's repertoire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PrimitiveId(pub u32);

/// A body that has declared itself; a body of the same name is the same body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BodyId(pub u16);

/// The declaration of one body, by name: its senses and its actions. The daemon's own senses (hearing) are declared the same way.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Declaration {
    /// The body's name.
    pub body: String,
    /// Its observation types.
    pub observation_types: Vec<DeclaredType>,
    /// Its actions.
    pub actions: Vec<DeclaredAction>,
    /// Its repertoire: primitives, each an index into `actions` and one value for each parameter, in order.
    pub repertoire: Vec<(usize, Vec<Parameter>)>,
}

/// An observation type as declared.
#[derive(Clone, Debug, PartialEq)]
pub struct DeclaredType {
    /// Its name.
    pub name: String,
    /// Whether the body itself causes it; then it is no pre-condition by default.
    pub own: bool,
    /// Whether it is an event and not a state; then it is no pre-condition by default.
    pub transient: bool,
    /// Whether it comes from others and never from an action of this body (a word heard); then it is no condition of either kind by
    /// default, so that it can only become an associated observation (II-B).
    pub heard: bool,
    /// Whether it is a number that comes with a frame and may be wanted (a reward). The learner does not live by it: it is no condition
    /// of either kind, and neither attended to nor associated. Claims foretell it, so that who wants it can be helped. A value is an
    /// event, and has one property, which is a number.
    pub value: bool,
    /// Its properties, in the order in which they were declared.
    pub properties: Vec<DeclaredProperty>,
}

impl DeclaredType {
    /// A state of the world by this name, without properties: neither the body's own, nor an event, nor heard, nor a value.
    #[must_use]
    pub fn state(name: impl Into<String>) -> Self {
        let (own, transient, heard, value) = (false, false, false, false);
        Self { name: name.into(), own, transient, heard, value, properties: Vec::new() }
    }

    /// Whether it is what a value must be, if it is declared to be one: an event with one property, which is a number.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        let is_number =
            |one: &DeclaredProperty| matches!(one.kind, ValueKind::Integer | ValueKind::Real { .. });
        let is_value =
            self.transient && !self.heard && matches!(&self.properties[..], [one] if is_number(one));
        !self.value || is_value
    }
}

/// A property or parameter as declared.
#[derive(Clone, Debug, PartialEq)]
pub struct DeclaredProperty {
    /// Its name.
    pub name: String,
    /// The unit of its values, for people (`mm`, `rad`); empty when they have none.
    pub unit: String,
    /// The kind of its values.
    pub kind: ValueKind,
}

/// The kinds of values that a property or a parameter takes.
#[derive(Clone, Debug, PartialEq)]
pub enum ValueKind {
    /// Whole numbers.
    Integer,
    /// Symbols.
    Symbol,
    /// True or false.
    Boolean,
    /// Reals, compared as bins of this width.
    Real {
        /// The width of a bin, in the unit of the property; finite and above 0.
        resolution: f64,
    },
}

impl ValueKind {
    /// Whether a parameter of this kind can have this value.
    #[must_use]
    pub fn takes(&self, value: &Parameter) -> bool {
        match (self, value) {
            (Self::Integer, Parameter::Integer(_))
            | (Self::Symbol, Parameter::Symbol(_))
            | (Self::Boolean, Parameter::Boolean(_)) => true,
            (Self::Real { .. }, Parameter::Real(value)) => value.is_finite(),
            _ => false,
        }
    }
}

impl fmt::Display for ValueKind {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Integer => to.write_str("an integer"),
            Self::Symbol => to.write_str("a symbol"),
            Self::Boolean => to.write_str("a boolean"),
            // As Rust writes it, which is short however small it is.
            Self::Real { resolution } => write!(to, "a real in bins of {resolution:?}"),
        }
    }
}

impl fmt::Display for DeclaredType {
    /// Its flags, and what each of its properties takes: `an event of the body's own {field: an integer, reach: a real in bins of 0.01 m}`.
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match (self.value, self.transient) {
            (true, _) => "a value",
            (false, true) => "an event",
            (false, false) => "a state",
        };
        to.write_str(what)?;
        to.write_str(if self.own { " of the body's own {" } else { " {" })?;
        for (number, property) in self.properties.iter().enumerate() {
            let comma = if number == 0 { "" } else { ", " };
            let unit = if property.unit.is_empty() { String::new() } else { format!(" {}", property.unit) };
            write!(to, "{comma}{}: {}{unit}", property.name, property.kind)?;
        }
        to.write_str("}")
    }
}

/// An action as declared.
#[derive(Clone, Debug, PartialEq)]
pub struct DeclaredAction {
    /// Its name.
    pub name: String,
    /// Its parameters, in order.
    pub parameters: Vec<DeclaredProperty>,
}

/// The value of one parameter of a primitive.
#[derive(Clone, Debug, PartialEq)]
pub enum Parameter {
    /// A whole number.
    Integer(i64),
    /// A symbol, by name.
    Symbol(String),
    /// True or false.
    Boolean(bool),
    /// A real, in the unit of the parameter: the exact value that the body gave, which is sent back to it.
    Real(f64),
}

/// Why a declaration can't be merged with what memory already knows.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DeclarationError {
    /// A type was learnt under another meaning.
    #[error(
        "observation type {name} is already known with other flags or properties: it is {known}; declare it the same, \
         or give it another name"
    )]
    TypeDiffers {
        /// The type's name.
        name: String,
        /// What memory knows.
        known: String,
    },
    /// A property was learnt with values of another kind, so that equal values would not mean the same.
    #[error(
        "property {name} of {kind} is {declared}, and the property of that name of {other} is {known}: give both the same kind and \
         resolution, or one of them another name"
    )]
    PropertyDiffers {
        /// The property's name.
        name: String,
        /// The observation type that declares it.
        kind: String,
        /// What it takes.
        declared: ValueKind,
        /// The observation type whose property of that name came first.
        other: String,
        /// What that takes.
        known: ValueKind,
    },
    /// A value is something else than one number that comes with a frame.
    #[error(
        "{name} is declared as a value: a value is an event (transient), and has just one property, which is an integer or a real; declare \
         it so, or without the flag for values"
    )]
    Value {
        /// The type's name.
        name: String,
    },
    /// Values could not be told apart.
    #[error("the resolution of {name} is {resolution}; it must be finite and above 0")]
    Resolution {
        /// The property's or parameter's name.
        name: String,
        /// Its resolution.
        resolution: f64,
    },
    /// An action was learnt under another meaning.
    #[error(
        "action {name} is already known with other parameters; declare it the same, or give it another name"
    )]
    ActionDiffers {
        /// The action's name.
        name: String,
    },
    /// A repertoire entry does not fit the action it names.
    #[error("repertoire entry {index} does not fit its action: {reason}")]
    Repertoire {
        /// Which entry, from 0.
        index: usize,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// More than the numbers of memory can hold.
    #[error("{what}: {count} are more than the limit of {limit}")]
    TooMany {
        /// What there are too many of.
        what: &'static str,
        /// How many there would be.
        count: usize,
        /// The limit.
        limit: usize,
    },
}

/// An observation type in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct ObservationType {
    /// As declared.
    pub declared: DeclaredType,
    /// Its properties' numbers, in declared order.
    pub properties: Vec<PropertyId>,
}

/// A primitive in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Primitive {
    /// Index into [`Vocabulary::actions`].
    pub action: usize,
    /// One value a parameter, in declared order.
    pub parameters: Vec<Parameter>,
}

/// A body in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownBody {
    /// Its name.
    pub name: String,
    /// The primitives that it can carry out, ordered by number.
    pub repertoire: Vec<PrimitiveId>,
}

/// Limits on the declarations in the life of one memory.
pub mod limits {
    /// How many observation types there may be.
    pub const TYPES_MAX: usize = 1_024;
    /// How many property names there may be.
    pub const PROPERTIES_MAX: usize = 4_096;
    /// How many symbols there may be, words included.
    pub const SYMBOLS_MAX: usize = 1_000_000;
    /// How many actions there may be.
    pub const ACTIONS_MAX: usize = 1_024;
    /// How many primitives all bodies together may have.
    pub const PRIMITIVES_MAX: usize = 1_000_000;
    /// How many bodies may ever attach.
    pub const BODIES_MAX: usize = 1_024;
    /// The longest description of a body, in bytes.
    pub const DESCRIPTION_BYTES_MAX: usize = 256 * 1024;
}

/// Everything declared so far.
#[derive(Clone, Debug, Default)]
pub struct Vocabulary {
    lists: VocabularyLists,
    symbol_ids: FxHashMap<String, SymbolId>,
}

/// The lists of a vocabulary, in which everything has its number by its place.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VocabularyLists {
    /// Observation types, by number.
    pub types: Vec<ObservationType>,
    /// Property names, by number.
    pub properties: Vec<String>,
    /// What each property takes.
    pub property_kinds: Vec<ValueKind>,
    /// Symbols, by number.
    pub symbols: Vec<String>,
    /// Actions.
    pub actions: Vec<DeclaredAction>,
    /// Primitives, by number.
    pub primitives: Vec<Primitive>,
    /// Bodies, by number.
    pub bodies: Vec<KnownBody>,
}

impl Vocabulary {
    /// The vocabulary that these lists are.
    ///
    /// # Errors
    /// Which list refers to something that is not in the others, or is longer than its limit.
    pub fn from_lists(lists: VocabularyLists) -> Result<Self, &'static str> {
        let types = lists.types.iter().all(|kind| {
            let known = kind.properties.iter().all(|id| usize::from(id.0) < lists.properties.len());
            known && kind.properties.len() == kind.declared.properties.len() && kind.declared.is_sound()
        });
        let primitives = lists.primitives.iter().all(|primitive| {
            let action = lists.actions.get(primitive.action);
            action.is_some_and(|action| action.parameters.len() == primitive.parameters.len())
        });
        let mut repertoires = lists.bodies.iter().flat_map(|body| &body.repertoire);
        let bodies = repertoires.all(|id| (id.0 as usize) < lists.primitives.len());
        let properties = lists.properties.len() == lists.property_kinds.len();
        let checks = [
            (types, lists.types.len(), limits::TYPES_MAX, "observation types"),
            (properties, lists.properties.len(), limits::PROPERTIES_MAX, "properties"),
            (true, lists.actions.len(), limits::ACTIONS_MAX, "actions"),
            (primitives, lists.primitives.len(), limits::PRIMITIVES_MAX, "primitives"),
            (bodies, lists.bodies.len(), limits::BODIES_MAX, "bodies"),
        ];
        if let Some((.., what)) = checks.iter().find(|(sound, count, limit, _)| !sound || count > limit) {
            return Err(what);
        }
        let numbered = (0..).map(SymbolId).zip(&lists.symbols);
        let symbol_ids: FxHashMap<_, _> = numbered.map(|(id, symbol)| (symbol.clone(), id)).collect();
        // A symbol that stands twice would have two numbers.
        if symbol_ids.len() == lists.symbols.len() { Ok(Self { lists, symbol_ids }) } else { Err("symbols") }
    }

    /// Says of a type of these lists that it is a value; false, and nothing is changed, if it is none that can be one.
    #[must_use]
    pub fn make_value(&mut self, kind: TypeId) -> bool {
        let Some(known) = self.lists.types.get_mut(usize::from(kind.0)) else { return false };
        let declared = DeclaredType { value: true, ..known.declared.clone() };
        let is_sound = declared.is_sound();
        if is_sound {
            known.declared = declared;
        }
        is_sound
    }

    /// Says whether `declaration` can be merged; what is wrong with it is wrong before anything is changed.
    ///
    /// # Errors
    /// The first thing in it that contradicts what is known, or exceeds a limit.
    pub fn check(&self, declaration: &Declaration) -> Result<(), DeclarationError> {
        for declared in &declaration.observation_types {
            if !declared.is_sound() {
                return Err(DeclarationError::Value { name: declared.name.clone() });
            }
            if let Some(known) = self.lists.types.iter().find(|t| t.declared.name == declared.name)
                && known.declared != *declared
            {
                return Err(DeclarationError::TypeDiffers {
                    name: declared.name.clone(),
                    known: known.declared.to_string(),
                });
            }
        }
        self.check_properties(declaration)?;
        self.check_resolutions(declaration)?;
        for declared in &declaration.actions {
            if self.lists.actions.iter().any(|known| known.name == declared.name && known != declared) {
                return Err(DeclarationError::ActionDiffers { name: declared.name.clone() });
            }
        }
        for (index, (action, parameters)) in declaration.repertoire.iter().enumerate() {
            let wrong = |reason| Err(DeclarationError::Repertoire { index, reason });
            let Some(action) = declaration.actions.get(*action) else { return wrong("no such action") };
            if action.parameters.len() != parameters.len() {
                return wrong("another number of parameters");
            }
            if !action.parameters.iter().zip(parameters).all(|(declared, given)| declared.kind.takes(given)) {
                return wrong("a value of another kind");
            }
        }
        let counts = [
            (
                "observation types",
                self.lists.types.len() + self.new_types(declaration).count(),
                limits::TYPES_MAX,
            ),
            (
                "properties",
                self.lists.properties.len() + self.new_properties(declaration),
                limits::PROPERTIES_MAX,
            ),
            ("actions", self.lists.actions.len() + self.new_actions(declaration), limits::ACTIONS_MAX),
            (
                "primitives",
                self.lists.primitives.len() + self.new_primitives(declaration),
                limits::PRIMITIVES_MAX,
            ),
            ("symbols", self.lists.symbols.len() + self.new_symbols(declaration), limits::SYMBOLS_MAX),
            (
                "bodies",
                self.lists.bodies.len() + usize::from(self.is_new_body(declaration)),
                limits::BODIES_MAX,
            ),
        ];
        match counts.into_iter().find(|(_, count, limit)| count > limit) {
            Some((what, count, limit)) => Err(DeclarationError::TooMany { what, count, limit }),
            None => Ok(()),
        }
    }

    /// Properties of one name are comparable, so they must take the same kind of values, in memory and within
    /// the declaration.
    fn check_properties(&self, declaration: &Declaration) -> Result<(), DeclarationError> {
        let mut met: FxHashMap<&str, (&DeclaredType, &ValueKind)> = FxHashMap::default();
        for declared in &declaration.observation_types {
            for property in &declared.properties {
                let known = self.property_named(&property.name).and_then(|id| self.property_kind(id));
                let (first, kind) = met.entry(&property.name).or_insert((declared, &property.kind));
                let known = known.unwrap_or(kind);
                if *known != property.kind {
                    let other = self.first_with(&property.name).unwrap_or(first);
                    return Err(DeclarationError::PropertyDiffers {
                        name: property.name.clone(),
                        kind: declared.name.clone(),
                        declared: property.kind.clone(),
                        other: other.name.clone(),
                        known: known.clone(),
                    });
                }
            }
        }
        Ok(())
    }

    /// The type that brought a property of this name.
    fn first_with(&self, property: &str) -> Option<&DeclaredType> {
        let mut types = self.lists.types.iter().map(|known| &known.declared);
        types.find(|known| known.properties.iter().any(|declared| declared.name == property))
    }

    /// A bin without a width holds nothing.
    fn check_resolutions(&self, declaration: &Declaration) -> Result<(), DeclarationError> {
        let properties = declaration.observation_types.iter().flat_map(|declared| &declared.properties);
        let parameters = declaration.actions.iter().flat_map(|declared| &declared.parameters);
        for declared in properties.chain(parameters) {
            match declared.kind {
                ValueKind::Real { resolution } if !(resolution.is_finite() && resolution > 0.0) => {
                    return Err(DeclarationError::Resolution { name: declared.name.clone(), resolution });
                }
                _ => (),
            }
        }
        Ok(())
    }

    // What is new in a declaration. Only that counts towards the limits, so that a body that is known can come back
    // however full memory is.

    fn new_types<'a>(&self, declaration: &'a Declaration) -> impl Iterator<Item = &'a DeclaredType> {
        let types = declaration.observation_types.iter();
        types.filter(|declared| self.type_named(&declared.name).is_none())
    }

    fn new_properties(&self, declaration: &Declaration) -> usize {
        let names = self.new_types(declaration).flat_map(|declared| &declared.properties).map(|p| &p.name);
        let new: BTreeSet<_> = names.filter(|name| self.property_named(name).is_none()).collect();
        new.len()
    }

    fn new_actions(&self, declaration: &Declaration) -> usize {
        declaration.actions.iter().filter(|declared| self.action_named(&declared.name).is_none()).count()
    }

    fn new_symbols(&self, declaration: &Declaration) -> usize {
        let parameters = declaration.repertoire.iter().flat_map(|(_, parameters)| parameters);
        let symbols = parameters.filter_map(|parameter| match parameter {
            Parameter::Symbol(symbol) if !self.symbol_ids.contains_key(symbol) => Some(symbol),
            _ => None,
        });
        symbols.collect::<BTreeSet<_>>().len()
    }

    fn is_new_body(&self, declaration: &Declaration) -> bool {
        self.body_named(&declaration.body).is_none()
    }

    /// At most as many, and exactly where it matters: finding out which are known takes time.
    fn new_primitives(&self, declaration: &Declaration) -> usize {
        let claimed = declaration.repertoire.len();
        if self.lists.primitives.len() + claimed <= limits::PRIMITIVES_MAX {
            return claimed;
        }
        let known = self.primitive_ids();
        let is_known = |action: usize, parameters: &[Parameter]| {
            let name = declaration.actions.get(action).map_or("", |declared| declared.name.as_str());
            let met = |parameter: &Parameter| match parameter {
                Parameter::Symbol(symbol) => self.symbol_ids.contains_key(symbol),
                _ => true,
            };
            self.action_named(name).is_some_and(|action| {
                parameters.iter().all(met)
                    && known
                        .contains_key(&self.identity(&Primitive { action, parameters: parameters.to_vec() }))
            })
        };
        declaration.repertoire.iter().filter(|(action, parameters)| !is_known(*action, parameters)).count()
    }

    fn action_named(&self, name: &str) -> Option<usize> {
        self.lists.actions.iter().position(|known| known.name == name)
    }

    fn primitive_ids(&self) -> FxHashMap<Vec<u64>, PrimitiveId> {
        let numbered = self.lists.primitives.iter().enumerate();
        numbered
            .map(|(at, p)| (self.identity(p), PrimitiveId(u32::try_from(at).unwrap_or(u32::MAX))))
            .collect()
    }

    /// Takes over what is new in `declaration`, if all of it can be.
    ///
    /// # Errors
    /// As [`Vocabulary::check`]; nothing is taken over then.
    pub fn declare(&mut self, declaration: &Declaration) -> Result<(), DeclarationError> {
        self.check(declaration)?;
        self.merge(declaration);
        Ok(())
    }

    /// Takes over what is new in a declaration that was checked.
    pub(crate) fn merge(&mut self, declaration: &Declaration) {
        for declared in &declaration.observation_types {
            if !self.lists.types.iter().any(|known| known.declared.name == declared.name) {
                let properties = declared.properties.iter().map(|p| self.intern_property(p)).collect();
                self.lists.types.push(ObservationType { declared: declared.clone(), properties });
            }
        }
        let actions: Vec<usize> = declaration
            .actions
            .iter()
            .map(|declared| match self.action_named(&declared.name) {
                Some(at) => at,
                None => {
                    self.lists.actions.push(declared.clone());
                    self.lists.actions.len() - 1
                }
            })
            .collect();
        let mut known = self.primitive_ids();
        let mut repertoire = Vec::with_capacity(declaration.repertoire.len());
        for (action, parameters) in &declaration.repertoire {
            for parameter in parameters {
                if let Parameter::Symbol(symbol) = parameter {
                    self.intern_symbol(symbol);
                }
            }
            let primitive = Primitive { action: actions[*action], parameters: parameters.clone() };
            let id = *known.entry(self.identity(&primitive)).or_insert_with(|| {
                self.lists.primitives.push(primitive);
                PrimitiveId(u32::try_from(self.lists.primitives.len() - 1).unwrap_or(u32::MAX))
            });
            repertoire.push(id);
        }
        repertoire.sort_unstable();
        repertoire.dedup();
        match self.lists.bodies.iter_mut().find(|body| body.name == declaration.body) {
            Some(body) => body.repertoire = repertoire,
            None => self.lists.bodies.push(KnownBody { name: declaration.body.clone(), repertoire }),
        }
    }

    /// The action and the bins of its parameters: primitives that agree in these are one.
    fn identity(&self, primitive: &Primitive) -> Vec<u64> {
        let kinds = &self.lists.actions[primitive.action].parameters;
        let values = primitive.parameters.iter().zip(kinds).map(|(parameter, declared)| {
            match (parameter, &declared.kind) {
                (Parameter::Real(value), ValueKind::Real { resolution }) => {
                    bin(*value, *resolution).cast_unsigned()
                }
                (Parameter::Real(value), _) => value.to_bits(),
                (Parameter::Integer(value), _) => value.cast_unsigned(),
                (Parameter::Boolean(value), _) => u64::from(*value),
                (Parameter::Symbol(symbol), _) => {
                    self.symbol_ids.get(symbol).map_or(u64::MAX, |id| u64::from(id.0))
                }
            }
        });
        std::iter::once(primitive.action as u64).chain(values).collect()
    }

    fn intern_property(&mut self, declared: &DeclaredProperty) -> PropertyId {
        let at =
            self.lists.properties.iter().position(|known| *known == declared.name).unwrap_or_else(|| {
                self.lists.properties.push(declared.name.clone());
                self.lists.property_kinds.push(declared.kind.clone());
                self.lists.properties.len() - 1
            });
        PropertyId(u16::try_from(at).unwrap_or(u16::MAX))
    }

    /// The name of the type by which the item of this number is perceived; items are counted from 0.
    fn item_name(number: usize) -> String {
        format!("item-{}", number + 1)
    }

    /// Whether there is room for the type of a synthetic item of this number, and nobody declared one like it.
    pub(crate) fn may_suppose(&self, number: usize) -> bool {
        let property = self.property_named(SUPPOSED);
        let taken = property.is_some_and(|known| {
            self.lists.property_kinds.get(usize::from(known.0)) != Some(&ValueKind::Boolean)
        });
        let room = self.lists.types.len() < limits::TYPES_MAX
            && (property.is_some() || self.lists.properties.len() < limits::PROPERTIES_MAX);
        room && !taken && self.type_named(&Self::item_name(number)).is_none()
    }

    /// Takes in the type by which a synthetic item is perceived.
    pub(crate) fn suppose(&mut self, number: usize) -> (TypeId, PropertyId) {
        let property =
            DeclaredProperty { name: SUPPOSED.to_owned(), unit: String::new(), kind: ValueKind::Boolean };
        let declared = DeclaredType {
            name: Self::item_name(number),
            own: false,
            transient: false,
            heard: false,
            value: false,
            properties: vec![property],
        };
        let properties: Vec<_> = declared.properties.iter().map(|p| self.intern_property(p)).collect();
        let id = properties.first().copied().unwrap_or(PropertyId(u16::MAX));
        self.lists.types.push(ObservationType { declared, properties });
        (TypeId(u16::try_from(self.lists.types.len() - 1).unwrap_or(u16::MAX)), id)
    }

    /// Takes over those of `symbols` that are new. The limit on symbols is the caller's to keep.
    pub fn meet(&mut self, symbols: &[String]) {
        symbols.iter().for_each(|symbol| self.intern_symbol(symbol));
    }

    fn intern_symbol(&mut self, symbol: &str) {
        if !self.symbol_ids.contains_key(symbol) {
            let id = SymbolId(u32::try_from(self.lists.symbols.len()).unwrap_or(u32::MAX));
            self.lists.symbols.push(symbol.to_owned());
            self.symbol_ids.insert(symbol.to_owned(), id);
        }
    }

    /// The observation types, by number.
    #[must_use]
    pub fn types(&self) -> &[ObservationType] {
        &self.lists.types
    }

    /// The observation type of this name.
    #[must_use]
    pub fn type_named(&self, name: &str) -> Option<TypeId> {
        let at = self.lists.types.iter().position(|t| t.declared.name == name)?;
        u16::try_from(at).ok().map(TypeId)
    }

    /// Whether a type is a value: a number that comes with a frame and may be wanted.
    #[must_use]
    pub fn is_value(&self, kind: TypeId) -> bool {
        self.lists.types.get(usize::from(kind.0)).is_some_and(|known| known.declared.value)
    }

    /// The types that are values, in order.
    pub(crate) fn values(&self) -> impl Iterator<Item = TypeId> + '_ {
        (0..=u16::MAX)
            .map(TypeId)
            .zip(&self.lists.types)
            .filter(|(_, known)| known.declared.value)
            .map(|(id, _)| id)
    }

    /// The types that are none, in order.
    pub(crate) fn sensed_types(&self) -> impl Iterator<Item = TypeId> + '_ {
        (0..=u16::MAX)
            .map(TypeId)
            .zip(&self.lists.types)
            .filter(|(_, known)| !known.declared.value)
            .map(|(id, _)| id)
    }

    /// How much comes with these observations of a type that is a value: the sum of its numbers, a real counted as the middle of its
    /// bin, and 0 where there are none. What is beyond 1e100 counts as that, so that sums of many stay finite.
    #[must_use]
    pub fn sum_of<'a>(&self, kind: TypeId, observations: impl IntoIterator<Item = &'a Observation>) -> f64 {
        let of_kind = observations.into_iter().filter(|o| o.kind() == kind);
        let number = |(property, value): &(PropertyId, Value)| match (value, self.property_kind(*property)) {
            (Value::Bin(bin), Some(ValueKind::Real { resolution })) => bin_middle(*bin, *resolution),
            (Value::Integer(number), _) => *number as f64,
            _ => 0.0,
        };
        let all = of_kind.flat_map(|o| o.properties()).map(number);
        let sum: f64 = all.map(|one| one.clamp(-VALUE_MAX, VALUE_MAX)).sum();
        sum.clamp(-VALUE_MAX, VALUE_MAX)
    }

    /// The property names, by number.
    #[must_use]
    pub fn properties(&self) -> &[String] {
        &self.lists.properties
    }

    /// The property of this name.
    #[must_use]
    pub fn property_named(&self, name: &str) -> Option<PropertyId> {
        let at = self.lists.properties.iter().position(|known| known == name)?;
        u16::try_from(at).ok().map(PropertyId)
    }

    /// The values that the property takes, as first declared.
    #[must_use]
    pub fn property_kind(&self, property: PropertyId) -> Option<&ValueKind> {
        self.lists.property_kinds.get(usize::from(property.0))
    }

    /// The symbols, by number.
    #[must_use]
    pub fn symbols(&self) -> &[String] {
        &self.lists.symbols
    }

    /// The number of a symbol that is known.
    #[must_use]
    pub fn symbol_named(&self, symbol: &str) -> Option<SymbolId> {
        self.symbol_ids.get(symbol).copied()
    }

    /// The actions.
    #[must_use]
    pub fn actions(&self) -> &[DeclaredAction] {
        &self.lists.actions
    }

    /// The primitives, by number.
    #[must_use]
    pub fn primitives(&self) -> &[Primitive] {
        &self.lists.primitives
    }

    /// The bodies, by number.
    #[must_use]
    pub fn bodies(&self) -> &[KnownBody] {
        &self.lists.bodies
    }

    /// Whether `value`, if it is a symbol, was ever met.
    #[must_use]
    pub fn knows_value(&self, value: Value) -> bool {
        !matches!(value, Value::Symbol(symbol) if symbol.0 as usize >= self.lists.symbols.len())
    }

    /// Whether the type of `observation`, its properties and its symbols are all known.
    #[must_use]
    pub fn knows(&self, observation: &Observation) -> bool {
        let pairs = observation.properties().iter();
        self.knows_type(observation.kind(), pairs.map(|(property, value)| (*property, Some(*value))))
    }

    /// The same of a pattern, whose variables stand for any value.
    #[must_use]
    pub fn knows_pattern(&self, pattern: &Pattern) -> bool {
        let value = |term: &Term| match term {
            Term::Constant(value) => Some(*value),
            Term::Variable(_) => None,
        };
        self.knows_type(
            pattern.kind(),
            pattern.terms().iter().map(|(property, term)| (*property, value(term))),
        )
    }

    fn knows_type(&self, kind: TypeId, mut pairs: impl Iterator<Item = (PropertyId, Option<Value>)>) -> bool {
        usize::from(kind.0) < self.lists.types.len()
            && pairs.all(|(property, value)| {
                usize::from(property.0) < self.lists.properties.len()
                    && value.is_none_or(|value| self.knows_value(value))
            })
    }

    /// Whether `body` has the primitive in its repertoire.
    #[must_use]
    pub fn can_do(&self, body: BodyId, primitive: PrimitiveId) -> bool {
        let known = self.lists.bodies.get(usize::from(body.0));
        known.is_some_and(|known| known.repertoire.binary_search(&primitive).is_ok())
    }

    /// The body of this name.
    #[must_use]
    pub fn body_named(&self, name: &str) -> Option<BodyId> {
        let at = self.lists.bodies.iter().position(|body| body.name == name)?;
        u16::try_from(at).ok().map(BodyId)
    }
}

/// The bin of a real value: values in one bin are one value to the learner. Halves round away from zero;
/// bins saturate at the ends of `i64`.
#[must_use]
pub fn bin(value: f64, resolution: f64) -> i64 {
    // `as` saturates, and NaN (refused before it gets here) would be bin 0.
    (value / resolution).round() as i64
}

/// A real [`Value`] for display: the middle of its bin.
#[must_use]
pub fn bin_middle(bin: i64, resolution: f64) -> f64 {
    bin as f64 * resolution
}

/// A number that comes with a frame counts as this at most, whatever its sign.
const VALUE_MAX: f64 = 1e100;

/// The value of a parameter as it would be compared, for those kinds that are also observed.
#[must_use]
pub fn value_of(parameter: &Parameter, kind: &ValueKind, vocabulary: &Vocabulary) -> Option<Value> {
    match (parameter, kind) {
        (Parameter::Integer(value), ValueKind::Integer) => Some(Value::Integer(*value)),
        (Parameter::Boolean(value), ValueKind::Boolean) => Some(Value::Boolean(*value)),
        (Parameter::Real(value), ValueKind::Real { resolution }) => {
            Some(Value::Bin(bin(*value, *resolution)))
        }
        (Parameter::Symbol(symbol), ValueKind::Symbol) => vocabulary.symbol_named(symbol).map(Value::Symbol),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(name: &str) -> Declaration {
        let number =
            DeclaredProperty { name: "number".into(), unit: String::new(), kind: ValueKind::Integer };
        Declaration {
            body: name.to_owned(),
            observation_types: vec![DeclaredType {
                name: format!("seen by {name}"),
                own: false,
                transient: false,
                heard: false,
                value: false,
                properties: vec![number.clone()],
            }],
            actions: vec![DeclaredAction { name: "go".to_owned(), parameters: vec![number] }],
            repertoire: vec![(0, vec![Parameter::Integer(0)])],
        }
    }

    /// Limits counted everything declared, known or not: bodies that came once and never again could shut those
    /// out for good that memory is about.
    #[test]
    fn a_known_body_comes_back_however_full_memory_is() {
        let mut full = Vocabulary::default();
        let numbers = 0..i64::try_from(limits::PRIMITIVES_MAX).unwrap();
        let repertoire = numbers.map(|number| (0, vec![Parameter::Integer(number)])).collect();
        full.merge(&Declaration { repertoire, ..named("greedy") });
        for number in 1..limits::TYPES_MAX.max(limits::BODIES_MAX) {
            full.lists.types.push(ObservationType { properties: Vec::new(), ..full.lists.types[0].clone() });
            full.lists.types[number].declared.name = format!("type {number}");
            full.lists.bodies.push(KnownBody { name: format!("body {number}"), repertoire: Vec::new() });
        }
        assert_eq!(full.check(&named("greedy")), Ok(()));
        let too_many = |declaration: &Declaration| match full.check(declaration) {
            Err(DeclarationError::TooMany { what, .. }) => what,
            other => panic!("{other:?}"),
        };
        let known = Declaration { body: "body 7".to_owned(), ..named("greedy") };
        assert_eq!(full.check(&known), Ok(()));
        assert_eq!(
            too_many(&Declaration { body: "body 7".to_owned(), ..named("another") }),
            "observation types"
        );
        assert_eq!(too_many(&Declaration { body: "another".to_owned(), ..named("greedy") }), "bodies");
        let more = vec![(0, vec![Parameter::Integer(1)]), (0, vec![Parameter::Integer(-1)])];
        assert_eq!(too_many(&Declaration { repertoire: more, ..named("greedy") }), "primitives");
    }
}
