//! Observations, patterns and schemas as people read and write them: `object{colour=blue, field=4}`.

use crate::memory::Content;
use crate::observation::{Observation, Pattern, PropertyId, Term, TypeId, Value, Variable};
use crate::schema::{Form, Schema};
use crate::vocabulary::{Parameter, PrimitiveId, ValueKind, Vocabulary, bin, bin_middle};

/// The name of a variable, without its `$`: `a` to `z`, then `a1`, `b1`, …
#[must_use]
pub fn variable(variable: Variable) -> String {
    let letter = char::from(b'a' + variable.0 % 26);
    match variable.0 / 26 {
        0 => letter.to_string(),
        round => format!("{letter}{round}"),
    }
}

/// A value of `property`.
#[must_use]
pub fn value(vocabulary: &Vocabulary, property: PropertyId, value: Value) -> String {
    match value {
        Value::Integer(value) => value.to_string(),
        Value::Boolean(value) => value.to_string(),
        Value::Symbol(symbol) => {
            vocabulary.symbols().get(symbol.0 as usize).cloned().unwrap_or_else(|| format!("?{}", symbol.0))
        }
        Value::Bin(bin) => match vocabulary.property_kind(property) {
            Some(ValueKind::Real { resolution }) => real(bin_middle(bin, *resolution), *resolution),
            _ => format!("bin {bin}"),
        },
    }
}

/// A real with as many decimals as its resolution calls for.
fn real(value: f64, resolution: f64) -> String {
    let decimals = (0..9).find(|d| resolution * 10f64.powi(*d) >= 0.999).unwrap_or(9);
    format!("{value:.*}", decimals.unsigned_abs() as usize)
}

fn type_name(vocabulary: &Vocabulary, kind: TypeId) -> String {
    let known = vocabulary.types().get(usize::from(kind.0));
    known.map_or_else(|| format!("type{}", kind.0), |t| t.declared.name.clone())
}

fn property_name(vocabulary: &Vocabulary, property: PropertyId) -> &str {
    vocabulary.properties().get(usize::from(property.0)).map_or("?", String::as_str)
}

/// An observation: `object{colour=blue, field=4}`, `touch{}`.
#[must_use]
pub fn observation(vocabulary: &Vocabulary, observation: &Observation) -> String {
    pattern(vocabulary, &Pattern::from(observation))
}

/// A pattern: `object{colour=$a, field=4}`.
#[must_use]
pub fn pattern(vocabulary: &Vocabulary, pattern: &Pattern) -> String {
    let terms: Vec<_> = pattern
        .terms()
        .iter()
        .map(|(property, term)| {
            let shown = match term {
                Term::Constant(constant) => value(vocabulary, *property, *constant),
                Term::Variable(v) => format!("${}", variable(*v)),
            };
            format!("{}={shown}", property_name(vocabulary, *property))
        })
        .collect();
    format!("{}{{{}}}", type_name(vocabulary, pattern.kind()), terms.join(", "))
}

/// A primitive: `move(j1=0.43, j2=0.84)`.
#[must_use]
pub fn primitive(vocabulary: &Vocabulary, id: PrimitiveId) -> String {
    let Some(primitive) = vocabulary.primitives().get(id.0 as usize) else {
        return format!("primitive{}", id.0);
    };
    let Some(action) = vocabulary.actions().get(primitive.action) else {
        return format!("primitive{}", id.0);
    };
    let parameters: Vec<_> = action
        .parameters
        .iter()
        .zip(&primitive.parameters)
        .map(|(declared, parameter)| {
            let shown = match (parameter, &declared.kind) {
                (Parameter::Integer(value), _) => value.to_string(),
                (Parameter::Symbol(symbol), _) => symbol.clone(),
                (Parameter::Boolean(value), _) => value.to_string(),
                (Parameter::Real(value), ValueKind::Real { resolution }) => real(*value, *resolution),
                (Parameter::Real(value), _) => value.to_string(),
            };
            format!("{}={shown}", declared.name)
        })
        .collect();
    format!("{}({})", action.name, parameters.join(", "))
}

/// Pre-conditions, action and post-conditions of a schema, each as it prints.
#[must_use]
pub fn parts(content: &Content, schema: &Schema) -> (Vec<String>, String, Vec<String>) {
    let vocabulary = &content.vocabulary;
    let outcome = |text: String, absent: bool| if absent { format!("no longer {text}") } else { text };
    match &schema.form {
        Form::Concrete(concrete) => {
            let show = |id| observation(vocabulary, content.observation(id));
            (
                concrete.pre.iter().map(|o| show(*o)).collect(),
                primitive(vocabulary, concrete.action),
                concrete.post.iter().map(|p| outcome(show(p.what), p.absent)).collect(),
            )
        }
        Form::Generalised(generalised) => {
            let target: Vec<_> = generalised.target.iter().map(|p| pattern(vocabulary, p)).collect();
            (
                generalised.pre.iter().map(|p| pattern(vocabulary, p)).collect(),
                format!("achieve {}", target.join(" & ")),
                generalised.post.iter().map(|p| outcome(pattern(vocabulary, &p.what), p.absent)).collect(),
            )
        }
    }
}

/// A schema: `object{field=4} / move(j1=0.43, j2=0.84) / finger{field=4} & touch{}`; nothing is `∅`.
#[must_use]
pub fn schema(content: &Content, schema: &Schema) -> String {
    let (pre, action, post) = parts(content, schema);
    let side = |conditions: Vec<String>| match conditions.len() {
        0 => "∅".to_owned(),
        _ => conditions.join(" & "),
    };
    format!("{} / {action} / {}", side(pre), side(post))
}

/// Why a text is not a pattern.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PatternError {
    /// Not of the form `type{property=value, …}`.
    #[error("{0:?} is not a pattern; write it as it prints, such as object{{colour=blue, field=$x}}")]
    Form(String),
    /// No such observation type.
    #[error("no observation type is named {name:?}; there are {known}")]
    Type {
        /// The name given.
        name: String,
        /// The names there are.
        known: String,
    },
    /// The type has no such property.
    #[error("{kind} has no property {name:?}; it has {known}")]
    Property {
        /// The type.
        kind: String,
        /// The name given.
        name: String,
        /// The names there are.
        known: String,
    },
    /// The property takes other values.
    #[error("{property}={value}: {wanted}")]
    Value {
        /// The property.
        property: String,
        /// The value given.
        value: String,
        /// What it takes.
        wanted: &'static str,
    },
}

/// Reads a pattern as it prints. Properties may be left out: any value will do. Variables (`$x`) are
/// numbered in the order of first occurrence.
///
/// # Errors
/// What is wrong with it, and what there is instead. A symbol that was never met is not an error of form but
/// matches nothing that is known; it is reported too.
pub fn parse_pattern(vocabulary: &Vocabulary, text: &str) -> Result<Pattern, PatternError> {
    let form = || PatternError::Form(text.to_owned());
    let (name, rest) = text.trim().split_once('{').ok_or_else(form)?;
    let inner = rest.trim_end().strip_suffix('}').ok_or_else(form)?;
    let name = name.trim();
    let list = |names: Vec<&str>| names.join(", ");
    let kind = vocabulary.type_named(name).ok_or_else(|| PatternError::Type {
        name: name.to_owned(),
        known: list(vocabulary.types().iter().map(|t| t.declared.name.as_str()).collect()),
    })?;
    let declared = &vocabulary.types()[usize::from(kind.0)];
    let mut variables: Vec<String> = Vec::new();
    let mut terms = Vec::new();
    for part in inner.split(',').map(str::trim).filter(|part| !part.is_empty()) {
        let (property, given) = part.split_once('=').ok_or_else(form)?;
        let (property, given) = (property.trim(), given.trim());
        let at = declared.declared.properties.iter().position(|p| p.name == property);
        let at = at.ok_or_else(|| PatternError::Property {
            kind: name.to_owned(),
            name: property.to_owned(),
            known: list(declared.declared.properties.iter().map(|p| p.name.as_str()).collect()),
        })?;
        let term = match given.strip_prefix('$') {
            Some(variable) => {
                let at = variables.iter().position(|known| known == variable).unwrap_or_else(|| {
                    variables.push(variable.to_owned());
                    variables.len() - 1
                });
                Term::Variable(Variable(u8::try_from(at).map_err(|_| form())?))
            }
            None => {
                let kind = &declared.declared.properties[at].kind;
                Term::Constant(parse_value(vocabulary, property, kind, given)?)
            }
        };
        terms.push((declared.properties[at], term));
    }
    Ok(Pattern::new(kind, terms))
}

fn parse_value(
    vocabulary: &Vocabulary,
    property: &str,
    kind: &ValueKind,
    given: &str,
) -> Result<Value, PatternError> {
    let wrong =
        |wanted| PatternError::Value { property: property.to_owned(), value: given.to_owned(), wanted };
    match kind {
        ValueKind::Integer => given
            .parse()
            .map(Value::Integer)
            .map_err(|_| wrong("it takes whole numbers, or a variable such as $x")),
        ValueKind::Boolean => given.parse().map(Value::Boolean).map_err(|_| wrong("it takes true or false")),
        ValueKind::Symbol => vocabulary
            .symbol_named(given)
            .map(Value::Symbol)
            .ok_or_else(|| wrong("no such symbol was ever met")),
        ValueKind::Real { resolution } => match given.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(Value::Bin(bin(value, *resolution))),
            _ => Err(wrong("it takes a finite number")),
        },
    }
}

/// Whether `pattern` matches `candidate` when properties that it leaves out may be anything. Variables match
/// constants and variables alike, the same one always the same term.
#[must_use]
pub fn matches(pattern: &Pattern, candidate: &Pattern) -> bool {
    let mut bound: Vec<(Variable, Term)> = Vec::new();
    pattern.kind() == candidate.kind()
        && pattern.terms().iter().all(|(property, term)| {
            let Some((_, other)) = candidate.terms().iter().find(|(known, _)| known == property) else {
                return false;
            };
            match term {
                Term::Constant(_) => term == other,
                Term::Variable(variable) => match bound.iter().find(|(known, _)| known == variable) {
                    Some((_, before)) => before == other,
                    None => {
                        bound.push((*variable, *other));
                        true
                    }
                },
            }
        })
}
