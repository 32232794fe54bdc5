//! Observations, patterns and schemas as people read and write them: `object{colour=blue, field=4}`.

use std::borrow::{Borrow, Cow};
use std::fmt::{self, Display, Formatter};

use crate::memory::content::Content;
use crate::nouns::experience::NOTHING_DONE;
use crate::nouns::observation::{Observation, Pattern, PropertyId, SymbolId, Term, TypeId, Value, Variable};
use crate::nouns::probability::Count;
use crate::nouns::pursuit::Goal;
use crate::nouns::schema::{Form, Schema};
use crate::nouns::vocabulary::{Parameter, PrimitiveId, ValueKind, Vocabulary, bin, bin_middle};

/// What stands between two commas of `object{colour=blue, field=$x}`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotationPart<'a> {
    /// All of it, as it is written.
    pub text: &'a str,
    /// The words on both sides of its `=`, without spaces around them; none when it has no `=`.
    pub pair: Option<(&'a str, &'a str)>,
}

/// Reads `type{property=value, …}` word by word: the word before the braces, and the parts between the commas in them. Nothing
/// is known yet of the meaning of the words, and they may be empty: who knows what may stand there checks them. None when the
/// text is not of that form.
///
/// ```
/// let (kind, parts) = pschema_learner::notation::words("object{colour=blue, field=$x}").unwrap();
/// let pairs: Vec<_> = parts.filter_map(|part| part.pair).collect();
/// assert_eq!((kind, pairs), ("object", vec![("colour", "blue"), ("field", "$x")]));
/// ```
#[must_use]
pub fn words(text: &str) -> Option<(&str, impl Iterator<Item = NotationPart<'_>>)> {
    let (kind, rest) = text.trim().split_once('{')?;
    let inside = rest.strip_suffix('}')?;
    let parts = inside.split(',').filter(|_| !inside.trim().is_empty());
    let part = |text| NotationPart {
        text,
        pair: str::split_once(text, '=').map(|(property, value)| (property.trim(), value.trim())),
    };
    Some((kind.trim(), parts.map(part)))
}

/// Writes an observation of which just the names are known: the opposite of [`words`].
///
/// ```
/// let written = pschema_learner::notation::by_names("object", [("colour", "blue"), ("field", "4")]);
/// assert_eq!(written, "object{colour=blue, field=4}");
/// ```
#[must_use]
pub fn by_names<N: Display, V: Display>(kind: &str, properties: impl IntoIterator<Item = (N, V)>) -> String {
    let pairs: Vec<_> = properties.into_iter().map(|(name, value)| format!("{name}={value}")).collect();
    format!("{kind}{{{}}}", pairs.join(", "))
}

/// An outcome: an observation as it is, or as it is no longer there.
#[must_use]
pub fn outcome(observation: String, absent: bool) -> String {
    if absent { format!("{NO_LONGER}{observation}") } else { observation }
}

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
        Value::Symbol(known) => symbol(vocabulary, known),
        Value::Bin(bin) => match vocabulary.property_kind(property) {
            Some(ValueKind::Real { resolution }) => real(bin_middle(bin, *resolution), *resolution),
            _ => format!("bin {bin}"),
        },
    }
}

/// A symbol.
#[must_use]
pub fn symbol(vocabulary: &Vocabulary, symbol: SymbolId) -> String {
    vocabulary.symbols().get(symbol.0 as usize).cloned().unwrap_or_else(|| format!("?{}", symbol.0))
}

/// The digits after the first that tell any two doubles apart.
const DIGITS_MAX: usize = 16;
/// Sizes of numbers that a person reads without counting digits.
const READ_AT_SIGHT: std::ops::Range<f64> = 1e-9..1e15;

/// A number as it is, with a power of ten where people would count its digits.
fn number(value: f64) -> String {
    let at_sight = value == 0.0 || READ_AT_SIGHT.contains(&value.abs());
    if at_sight || !value.is_finite() { value.to_string() } else { format!("{value:e}") }
}

/// A real with as many decimals as its resolution calls for, or else the shortest number that reads back as the same bin.
fn real(value: f64, resolution: f64) -> String {
    let is_meant = |text: &str| {
        text.parse()
            .is_ok_and(|read: f64| read.is_finite() && bin(read, resolution) == bin(value, resolution))
    };
    let decimals = (0..9).find(|d| resolution * 10f64.powi(*d) >= 0.999);
    let at_sight = value.abs() < READ_AT_SIGHT.end;
    let plain = at_sight.then(|| format!("{value:.*}", decimals.unwrap_or(9).unsigned_abs() as usize));
    plain.filter(|text| is_meant(text)).unwrap_or_else(|| {
        let shortest =
            (0..=DIGITS_MAX).map(|digits| format!("{value:.digits$e}")).find(|text| is_meant(text));
        number(shortest.and_then(|text| text.parse().ok()).unwrap_or(value))
    })
}

pub(crate) fn type_name(vocabulary: &Vocabulary, kind: TypeId) -> String {
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
    let terms = pattern.terms().iter().map(|(property, term)| {
        let value = match term {
            Term::Constant(constant) => value(vocabulary, *property, *constant),
            Term::Variable(v) => format!("${}", variable(*v)),
        };
        (property_name(vocabulary, *property), value)
    });
    by_names(&type_name(vocabulary, pattern.kind()), terms)
}

/// The patterns of a goal: `object{colour=blue} & touch{}`.
#[must_use]
pub fn goal(vocabulary: &Vocabulary, goal: &Goal) -> String {
    match goal {
        Goal::Observed(wanted) => patterns(vocabulary, wanted),
        Goal::Again(wanted) => format!("{} again", patterns(vocabulary, wanted)),
        Goal::Most(kind) => format!("most {}", type_name(vocabulary, *kind)),
    }
}

/// Patterns that are to be observed together.
fn patterns(vocabulary: &Vocabulary, patterns: &[Pattern]) -> String {
    let patterns: Vec<_> = patterns.iter().map(|wanted| pattern(vocabulary, wanted)).collect();
    patterns.join(" & ")
}

/// A primitive: `move(j1=0.43, j2=0.84)`.
#[must_use]
pub fn primitive(vocabulary: &Vocabulary, id: PrimitiveId) -> String {
    if id == NOTHING_DONE {
        return "(new episode)".to_owned();
    }
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
                (Parameter::Real(value), _) => number(*value),
            };
            format!("{}={shown}", declared.name)
        })
        .collect();
    format!("{}({})", action.name, parameters.join(", "))
}

/// Conditions side by side, as they are written on one side of a schema: `finger{field=4} & touch{}`; nothing is `∅`.
#[must_use]
pub fn side<S: Borrow<str>>(conditions: impl IntoIterator<Item = S>) -> String {
    let conditions: Vec<S> = conditions.into_iter().collect();
    if conditions.is_empty() { "∅".to_owned() } else { conditions.join(" & ") }
}

/// Outcomes side by side, each with the share of executions in which it held; none before the first of them. Those of one type
/// that did not always hold, and whose shares leave room for it, may exclude each other, so that they are not joined as if all
/// were expected: `(finger{field=4} 60 % or finger{field=5} 40 %) & touch{}`. Of one observation, that it is there and that it is no
/// longer there do exclude each other, whatever their shares.
#[must_use]
pub fn outcomes<S: Borrow<str>>(outcomes: impl IntoIterator<Item = (S, Option<f64>)>) -> String {
    let outcomes: Vec<(S, Option<f64>)> = outcomes.into_iter().collect();
    let is_expected = |wanted: &str| outcomes.iter().any(|(outcome, _)| outcome.borrow() == wanted);
    let mut sides: Vec<Alternatives> = Vec::new();
    for (outcome, share) in &outcomes {
        let outcome: &str = outcome.borrow();
        let share = share.filter(|share| *share < 1.0);
        let written =
            share.map_or_else(|| outcome.to_owned(), |share| format!("{outcome} {}", percent(share)));
        // What always held leaves no room beside it.
        let share = share.unwrap_or(1.0);
        // Nothing else is an alternative to both of two opposites.
        let opposites = match outcome.strip_prefix(NO_LONGER) {
            Some(observation) => Some(observation).filter(|observation| is_expected(observation)),
            None => Some(outcome).filter(|_| is_expected(&format!("{NO_LONGER}{outcome}"))),
        };
        let kind = opposites.unwrap_or_else(|| type_of(outcome));
        let fits = |side: &Alternatives| opposites.is_some() || side.share + share <= 1.0 + SHARES_ROUNDED;
        match sides.iter_mut().find(|side| side.kind == kind && fits(side)) {
            Some(side) => {
                side.share += share;
                side.written.push(written);
            }
            None => sides.push(Alternatives { kind: kind.to_owned(), share, written: vec![written] }),
        }
    }
    side(sides.iter().map(|side| match side.written.as_slice() {
        [only] => only.clone(),
        several => format!("({})", several.join(" or ")),
    }))
}

/// Outcomes of one type that may exclude each other, or two of one observation that do.
struct Alternatives {
    /// The type, or the observation.
    kind: String,
    /// The sum of their shares.
    share: f64,
    written: Vec<String>,
}

/// The words before an observation that is no longer there.
const NO_LONGER: &str = "no longer ";
/// Shares that are more than all by this add up to all: each of them is rounded.
const SHARES_ROUNDED: f64 = 1e-9;

/// The part of an outcome that says its type.
fn type_of(outcome: &str) -> &str {
    outcome.split_once('{').map_or(outcome, |(kind, _)| kind)
}

/// A share that is not all; unless it is nothing, it does not look so.
fn percent(share: f64) -> String {
    match (share * 100.0).round() {
        0.0 if share > 0.0 => "<1 %".to_owned(),
        100.0 => ">99 %".to_owned(),
        percent => format!("{percent} %"),
    }
}

/// The share of times in which something happened; none where it never could.
#[must_use]
pub fn share(count: Count) -> Option<f64> {
    (count.trials > 0).then(|| count.ratio())
}

/// A schema as text, in its three parts. It prints as they are written on one line:
/// `object{field=4} / move(j1=0.43, j2=0.84) / finger{field=4} & touch{}`; nothing is `∅`.
#[derive(Clone, Debug, PartialEq)]
pub struct SchemaText {
    /// Its pre-conditions.
    pub pre: Vec<String>,
    /// Its action; of a generalised schema `achieve`, and its target.
    pub action: String,
    /// Its post-conditions.
    pub post: Vec<String>,
    /// The share of executions in which each of them held; none before the first.
    pub post_shares: Vec<Option<f64>>,
}

impl Display for SchemaText {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let shares = self.post_shares.iter().copied().chain(std::iter::repeat(None));
        let post = outcomes(self.post.iter().map(String::as_str).zip(shares));
        write!(f, "{} / {} / {post}", side(self.pre.iter().map(String::as_str)), self.action)
    }
}

/// A schema on one line.
#[must_use]
pub fn schema(content: &Content, schema: &Schema) -> String {
    schema_text(content, schema).to_string()
}

/// A schema in its parts.
#[must_use]
pub fn schema_text(content: &Content, schema: &Schema) -> SchemaText {
    let vocabulary = &content.vocabulary;
    match &schema.form {
        Form::Concrete(concrete) => {
            let show = |id| observation(vocabulary, content.observation(id));
            SchemaText {
                pre: concrete.pre.iter().map(|o| show(*o)).collect(),
                action: primitive(vocabulary, concrete.action),
                post: concrete.post.iter().map(|p| outcome(show(p.what), p.absent)).collect(),
                post_shares: concrete.post.iter().map(|p| share(p.count)).collect(),
            }
        }
        Form::Generalised(generalised) => {
            let show = |what: &Pattern| pattern(vocabulary, what);
            SchemaText {
                pre: generalised.pre.iter().map(show).collect(),
                action: format!("achieve {}", patterns(vocabulary, &generalised.target)),
                post: generalised.post.iter().map(|p| outcome(show(&p.what), p.absent)).collect(),
                post_shares: generalised.post.iter().map(|p| share(p.count)).collect(),
            }
        }
    }
}

/// The longest text that is quoted whole, in characters.
const QUOTED_MAX: usize = 80;

/// A text that somebody gave, as an error quotes it: cut where it is long.
#[must_use]
pub fn brief(text: &str) -> Cow<'_, str> {
    match text.char_indices().nth(QUOTED_MAX) {
        None => Cow::Borrowed(text),
        Some((cut, _)) => Cow::Owned(format!("{}… ({} bytes)", &text[..cut], text.len())),
    }
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
    parse_with(vocabulary, text, &mut Vec::new())
}

/// Reads the patterns of a goal. A variable is the same in all of them.
///
/// # Errors
/// As [`parse_pattern`].
pub fn parse_goal(vocabulary: &Vocabulary, texts: &[String]) -> Result<Vec<Pattern>, PatternError> {
    let mut variables = Vec::new();
    texts.iter().map(|text| parse_with(vocabulary, text, &mut variables)).collect()
}

/// Reads a pattern whose variables are numbered by their place among `variables`.
fn parse_with(
    vocabulary: &Vocabulary,
    text: &str,
    variables: &mut Vec<String>,
) -> Result<Pattern, PatternError> {
    let form = || PatternError::Form(brief(text).into_owned());
    let (name, parts) = words(text).ok_or_else(form)?;
    let properties: Vec<_> = parts.map(|part| part.pair).collect::<Option<_>>().ok_or_else(form)?;
    let list = |names: Vec<&str>| names.join(", ");
    let kind = vocabulary.type_named(name).ok_or_else(|| PatternError::Type {
        name: brief(name).into_owned(),
        known: list(vocabulary.types().iter().map(|t| t.declared.name.as_str()).collect()),
    })?;
    let declared = &vocabulary.types()[usize::from(kind.0)];
    let mut terms = Vec::new();
    for (property, given) in properties {
        let at = declared.declared.properties.iter().position(|p| p.name == property);
        let at = at.ok_or_else(|| PatternError::Property {
            kind: name.to_owned(),
            name: brief(property).into_owned(),
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
    let wrong = |wanted| PatternError::Value {
        property: property.to_owned(),
        value: brief(given).into_owned(),
        wanted,
    };
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

/// Why a text is none of a body's primitives.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PrimitiveError {
    /// Not of the form `action(parameter=value, …)`.
    #[error("{given:?} is not an action; write it as it prints, {example}")]
    Form {
        /// What was given.
        given: String,
        /// One that the body has.
        example: String,
    },
    /// The body can do nothing of that name.
    #[error("the body has no action named {name:?}; it has {known}")]
    Action {
        /// The name given.
        name: String,
        /// The names there are.
        known: String,
    },
    /// The body can do that, but not so.
    #[error("the body can't do {given}; the nearest that it can do: {nearest}")]
    Parameters {
        /// What was given.
        given: String,
        /// Primitives like it.
        nearest: String,
    },
}

/// Primitives like the one given that an error names.
const NEAREST_NAMED: usize = 3;

/// Finds the primitive among `repertoire` that prints like `text`, whatever the spaces, and however its reals are written.
///
/// # Errors
/// What is wrong with it, and what there is instead.
pub fn parse_primitive(
    vocabulary: &Vocabulary,
    repertoire: &[PrimitiveId],
    text: &str,
) -> Result<PrimitiveId, PrimitiveError> {
    let squeeze = |text: &str| text.chars().filter(|c| !c.is_whitespace()).collect::<String>();
    let given = as_printed(vocabulary, squeeze(text));
    let printed: Vec<_> = repertoire.iter().map(|id| (*id, primitive(vocabulary, *id))).collect();
    let form = || {
        let meant = printed
            .iter()
            .find(|(_, printed)| printed.split_once('(').is_some_and(|(name, _)| name == given));
        let example = meant.or(printed.first()).map(|(_, printed)| format!("such as {printed}"));
        let example = example.unwrap_or_else(|| "but the body has none".to_owned());
        PrimitiveError::Form { given: brief(text).into_owned(), example }
    };
    let (name, rest) = given.split_once('(').ok_or_else(form)?;
    let inner = rest.strip_suffix(')').ok_or_else(form)?;
    if let Some((id, _)) = printed.iter().find(|(_, printed)| squeeze(printed) == given) {
        return Ok(*id);
    }
    let mut like: Vec<(f64, &String)> = printed
        .iter()
        .filter_map(|(_, printed)| {
            let (known, rest) = printed.split_once('(')?;
            (known == name).then_some((apart(inner, &squeeze(rest.strip_suffix(')')?)), printed))
        })
        .collect();
    if like.is_empty() {
        let mut known: Vec<_> = printed.iter().filter_map(|(_, p)| Some(p.split_once('(')?.0)).collect();
        known.sort_unstable();
        known.dedup();
        return Err(PrimitiveError::Action { name: brief(name).into_owned(), known: known.join(", ") });
    }
    like.sort_by(|a, b| a.0.total_cmp(&b.0));
    let nearest: Vec<_> = like.iter().take(NEAREST_NAMED).map(|(_, printed)| printed.as_str()).collect();
    Err(PrimitiveError::Parameters { given: brief(text).into_owned(), nearest: nearest.join(", ") })
}

/// An action as a person wrote it, with its reals as they print: `0.0000000002` and `2e-10` are one number.
fn as_printed(vocabulary: &Vocabulary, given: String) -> String {
    let known = given.strip_suffix(')').and_then(|given| given.split_once('('));
    let known = known.and_then(|(name, inner)| {
        Some((name, inner, vocabulary.actions().iter().find(|action| action.name == name)?))
    });
    let Some((name, inner, action)) = known else { return given };
    let part = |part: &str| {
        let (parameter, value) = part.split_once('=')?;
        let declared = action.parameters.iter().find(|declared| declared.name == parameter)?;
        let ValueKind::Real { resolution } = declared.kind else { return None };
        let value = value.parse().ok().filter(|value: &f64| value.is_finite())?;
        Some(format!("{parameter}={}", real(value, resolution)))
    };
    let parts: Vec<_> =
        inner.split(',').map(|given| part(given).unwrap_or_else(|| given.to_owned())).collect();
    format!("{name}({})", parts.join(","))
}

/// How far apart two lists of parameters are, as they print: squares of differences of numbers, and much for
/// anything else that differs.
fn apart(one: &str, other: &str) -> f64 {
    const OTHERWISE: f64 = 1e12;
    let number = |part: &str| part.split_once('=').and_then(|(_, value)| value.parse::<f64>().ok());
    let (one, other): (Vec<_>, Vec<_>) = (one.split(',').collect(), other.split(',').collect());
    let pairs = one.iter().zip(&other).map(|(a, b)| match (number(a), number(b)) {
        (Some(a), Some(b)) => ((a - b) * (a - b)).min(OTHERWISE),
        _ if a == b => 0.0,
        _ => OTHERWISE,
    });
    pairs.sum::<f64>() + OTHERWISE * one.len().abs_diff(other.len()) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nouns::vocabulary::{Declaration, DeclaredAction, DeclaredProperty, DeclaredType};

    /// A body that senses and drives one real of this resolution.
    fn drive(resolution: f64, values: &[f64]) -> Vocabulary {
        let kind = ValueKind::Real { resolution };
        let ampere = DeclaredProperty { name: "ampere".into(), unit: "A".into(), kind };
        let mut vocabulary = Vocabulary::default();
        vocabulary.merge(&Declaration {
            body: "coil".to_owned(),
            observation_types: vec![DeclaredType {
                properties: vec![ampere.clone()],
                ..DeclaredType::state("current")
            }],
            actions: vec![DeclaredAction { name: "drive".to_owned(), parameters: vec![ampere] }],
            repertoire: values.iter().map(|value| (0, vec![Parameter::Real(*value)])).collect(),
        });
        vocabulary
    }

    /// Three currents of some hundred picoampere printed alike, and no way to write them was understood.
    #[test]
    fn small_and_large_reals_print_apart_and_read_back() {
        let cases: [(f64, &[f64], &[&str]); 7] = [
            (1e-11, &[1e-10, 2e-10, 3e-10, 0.0], &["1e-10", "2e-10", "3e-10", "0.000000000"]),
            (1e-11, &[-2.5e-10, 5e-9, 5.01e-9], &["-2.5e-10", "0.000000005", "0.00000000501"]),
            (1e-300, &[1e-300, 7e-299], &["1e-300", "7e-299"]),
            (1e290, &[1e300, -1e300], &["1e300", "-1e300"]),
            // As ever.
            (0.5, &[0.5, -1.5, 1000.0], &["0.5", "-1.5", "1000.0"]),
            (0.001, &[12.25, 0.3, 1_234_567_890.125], &["12.250", "0.300", "1234567890.125"]),
            // The bins of this one are apart by more than a decimal.
            (0.01, &[0.125, 0.124], &["0.125", "0.12"]),
        ];
        for (resolution, values, texts) in cases {
            let vocabulary = drive(resolution, values);
            let kind = vocabulary.type_named("current").unwrap();
            let property = vocabulary.property_named("ampere").unwrap();
            for (value, text) in values.iter().zip(texts) {
                assert_eq!(real(*value, resolution), *text);
                let bin = Value::Bin(bin(*value, resolution));
                let observed =
                    pattern(&vocabulary, &Pattern::new(kind, vec![(property, Term::Constant(bin))]));
                let read = parse_pattern(&vocabulary, &observed).unwrap();
                assert_eq!(read.terms(), [(property, Term::Constant(bin))], "{observed}");
            }
            let repertoire = vocabulary.bodies()[0].repertoire.clone();
            for id in &repertoire {
                let Parameter::Real(value) = vocabulary.primitives()[id.0 as usize].parameters[0] else {
                    panic!()
                };
                for given in [
                    primitive(&vocabulary, *id),
                    format!("drive(ampere={value})"),
                    format!("drive( ampere = {value:e})"),
                ] {
                    assert_eq!(parse_primitive(&vocabulary, &repertoire, &given), Ok(*id), "{given}");
                }
            }
        }
        let vocabulary = drive(1e-11, &[1e-10, 2e-10]);
        let other = parse_primitive(&vocabulary, &vocabulary.bodies()[0].repertoire, "drive(ampere=4e-10)");
        let Err(PrimitiveError::Parameters { nearest, .. }) = other else { panic!("{other:?}") };
        assert_eq!(nearest, "drive(ampere=2e-10), drive(ampere=1e-10)");
    }
}
