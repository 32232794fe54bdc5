//! The checks of declarations and of values. Both ends use them: a body before it attaches, the daemon on everything that it
//! receives.

use std::collections::BTreeSet;

use pschema_process::number;

use crate::description::{Action, ActionType, Description, ObservationType, Property, Value, ValueKind};
use crate::limits::{
    ACTIONS_MAX, NAME_BYTES_MAX, OBSERVATION_TYPES_MAX, PRIMITIVES_MAX, PROPERTIES_MAX, SCENE_COMMANDS_MAX,
    SYMBOLS_MAX,
};
use crate::refusal::Refusal;

impl Description {
    /// Checks everything that a body declares of itself, as the daemon does when the body attaches.
    ///
    /// # Errors
    /// The first thing that is not allowed, named with its place and figures.
    pub fn check(&self) -> Result<(), Refusal> {
        name("the body's name", &self.name)?;
        name("the body's kind", &self.kind)?;
        at_most("observation types", self.observation_types.len(), OBSERVATION_TYPES_MAX)?;
        at_most("actions", self.actions.len(), ACTIONS_MAX)?;
        at_most("scene commands", self.scene_commands.len(), SCENE_COMMANDS_MAX)?;
        at_most("primitives in the repertoire", self.repertoire.len(), PRIMITIVES_MAX)?;
        unique("observation types", self.observation_types.iter().map(|one| &one.name))?;
        unique("actions", self.actions.iter().map(|one| &one.name))?;
        unique("scene commands", self.scene_commands.iter().map(|one| &one.name))?;
        for one in &self.observation_types {
            word("name of an observation type", &one.name)?;
            properties(&format!("observation type {}", one.name), &one.properties)?;
            number_of_value(one)?;
        }
        for (sort, declared) in [("action", &self.actions), ("scene command", &self.scene_commands)] {
            for one in declared {
                word(&format!("name of an {sort}"), &one.name)?;
                properties(&format!("{sort} {}", one.name), &one.parameters)?;
            }
        }
        let all = self.observation_types.iter().flat_map(|one| &one.properties);
        let all = all.chain(self.actions.iter().chain(&self.scene_commands).flat_map(|one| &one.parameters));
        at_most("symbols of all properties together", all.map(symbol_count).sum(), SYMBOLS_MAX)?;
        for (number, primitive) in self.repertoire.iter().enumerate() {
            order(&format!("primitive {number}"), primitive, &self.actions)?;
        }
        Ok(())
    }
}

/// Checks that what is declared as a value is one number that comes with a frame.
fn number_of_value(of: &ObservationType) -> Result<(), Refusal> {
    let is_number = |one: &Property| matches!(one.kind, ValueKind::Integer { .. } | ValueKind::Real { .. });
    let problem = match &of.properties[..] {
        _ if !of.value => return Ok(()),
        _ if !of.transient => {
            "it is declared as a value and not as transient: a value is an event, which comes with its frame"
        }
        [one] if is_number(one) => return Ok(()),
        [one] => {
            let problem =
                format!("it is a value, and {} is no number: a value has one integer or real", one.name);
            return Err(Refusal::Declaration { place: format!("observation type {}", of.name), problem });
        }
        _ => "it is a value, and has not just one property: a value has one integer or real",
    };
    Err(Refusal::Declaration { place: format!("observation type {}", of.name), problem: problem.to_owned() })
}

fn symbol_count(of: &Property) -> usize {
    if let ValueKind::Symbol { symbols } = &of.kind { symbols.len() } else { 0 }
}

fn at_most(what: &str, found: usize, limit: usize) -> Result<(), Refusal> {
    if found > limit { Err(Refusal::TooMany { what: what.to_owned(), found, limit }) } else { Ok(()) }
}

/// Checks a name that people write in patterns and in actions: as [`name`], and it can be written there.
fn word(place: &str, text: &str) -> Result<(), Refusal> {
    name(place, text)?;
    match unwritable(text) {
        Some(problem) => Err(Refusal::Name { place: place.to_owned(), problem }),
        None => Ok(()),
    }
}

/// The characters of which patterns, `type{property=value, …}`, and actions, `action(parameter=value, …)`, are built.
const NOTATION: &str = "{}(),=";

/// What keeps a name, a symbol or a word from being written in a pattern or in an action; none if nothing does.
#[must_use]
pub fn unwritable(text: &str) -> Option<String> {
    if let Some(found) = text.chars().find(|c| NOTATION.contains(*c)) {
        return Some(format!(
            "{text:?} holds {found:?}, so that it could not be written in patterns, which are built of {NOTATION}"
        ));
    }
    if text.starts_with('$') {
        return Some(format!("{text:?} begins with a dollar sign, as variables do in patterns"));
    }
    invisible(text)
}

/// What can't be seen in a text, so that nobody could write it again: control characters, marks that join letters or turn the
/// direction of writing, letters and signs that are blank, what chooses another form of the letter before it, and all white space but
/// the space itself.
fn invisible(text: &str) -> Option<String> {
    let is_mark = |c| {
        matches!(c,
            // Unicode's Default_Ignorable_Code_Point, which a renderer leaves out when it does not know better: soft hyphen, joiners,
            // fillers, direction, variation selectors, tags. Its ranges have room for marks to come, so they stay as they are.
            '\u{ad}' | '\u{34f}' | '\u{61c}' | '\u{115f}'..='\u{1160}' | '\u{17b4}'..='\u{17b5}' | '\u{180b}'..='\u{180f}'
            | '\u{200b}'..='\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{3164}' | '\u{fe00}'..='\u{fe0f}'
            | '\u{feff}' | '\u{ffa0}' | '\u{fff0}'..='\u{fff8}' | '\u{1bca0}'..='\u{1bca3}' | '\u{1d173}'..='\u{1d17a}'
            | '\u{e0000}'..='\u{e0fff}'
            // The others that leave no mark: the braille pattern without a dot, the musical null notehead, and the anchors of notes
            // between the lines.
            | '\u{2800}' | '\u{1d159}' | '\u{fff9}'..='\u{fffb}')
    };
    if text.chars().any(char::is_control) {
        return Some(format!("{text:?} holds a control character"));
    }
    let found = text.chars().find(|c| is_mark(*c) || (c.is_whitespace() && *c != ' '))?;
    Some(format!("{text:?} holds U+{:04X}, which can't be seen", u32::from(found)))
}

/// Checks a name that must be given: it is not empty, not too long, holds nothing that can't be seen, and has no space at its
/// ends.
fn name(place: &str, text: &str) -> Result<(), Refusal> {
    if text.is_empty() {
        return Err(Refusal::Name { place: place.to_owned(), problem: "it is empty".to_owned() });
    }
    unit(place, text)
}

/// Checks a unit: as [`name`], but it may be empty.
fn unit(place: &str, text: &str) -> Result<(), Refusal> {
    let problem = if text.len() > NAME_BYTES_MAX {
        format!("{text:?} has {} bytes, at most {NAME_BYTES_MAX} are allowed", text.len())
    } else if let Some(problem) = invisible(text) {
        problem
    } else if text.trim() != text {
        format!("{text:?} begins or ends with a space")
    } else {
        return Ok(());
    };
    Err(Refusal::Name { place: place.to_owned(), problem })
}

fn unique<'a>(place: &str, names: impl Iterator<Item = &'a String>) -> Result<(), Refusal> {
    let mut seen = BTreeSet::new();
    for name in names {
        if !seen.insert(name) {
            return Err(Refusal::DuplicateName { place: place.to_owned(), name: name.clone() });
        }
    }
    Ok(())
}

fn properties(of: &str, declared: &[Property]) -> Result<(), Refusal> {
    at_most(&format!("{of}: properties"), declared.len(), PROPERTIES_MAX)?;
    unique(of, declared.iter().map(|one| &one.name))?;
    for property in declared {
        word(&format!("{of}: name of a property"), &property.name)?;
        let place = format!("{of}: property {}", property.name);
        unit(&format!("{place}: unit"), &property.unit)?;
        value_kind(&place, &property.kind)?;
    }
    Ok(())
}

fn value_kind(place: &str, kind: &ValueKind) -> Result<(), Refusal> {
    let problem = match kind {
        ValueKind::Boolean => return Ok(()),
        ValueKind::Integer { min, max } if min <= max => return Ok(()),
        ValueKind::Integer { min, max } => format!("its minimum {min} is above its maximum {max}"),
        ValueKind::Symbol { symbols } if symbols.is_empty() => "it declares no symbols".to_owned(),
        ValueKind::Symbol { symbols } => {
            at_most(&format!("{place}: symbols"), symbols.len(), SYMBOLS_MAX)?;
            symbols.iter().try_for_each(|symbol| word(&format!("{place}: a symbol"), symbol))?;
            return unique(place, symbols.iter());
        }
        ValueKind::Real { min, max, resolution } => {
            let bins = (max - min) / resolution;
            let (least, most, width) = (number(*min), number(*max), number(*resolution));
            if !(min.is_finite() && max.is_finite() && resolution.is_finite()) {
                format!("its limits {least}..={most} or its resolution {width} are not finite")
            } else if min > max {
                format!("its minimum {least} is above its maximum {most}")
            } else if *resolution <= 0.0 {
                format!("its resolution {width} is not above zero")
            } else if !bins.is_finite() || (min / resolution).abs().max((max / resolution).abs()) > BIN_MAX {
                format!("its resolution {width} is too fine for {least}..={most}")
            } else {
                return Ok(());
            }
        }
    };
    Err(Refusal::Declaration { place: place.to_owned(), problem })
}

/// The largest number of a bin. Every whole number up to here is exact in a double, so that neighbouring bins never merge.
const BIN_MAX: f64 = (1_u64 << 53) as f64;

/// Checks an action against `declared` actions, or a scene command against scene commands. `place` names
/// it in the refusal.
///
/// # Errors
/// The first thing that is not allowed.
pub fn order(place: &str, action: &Action, declared: &[ActionType]) -> Result<(), Refusal> {
    let index = action.id.index();
    let Some(kind) = declared.get(usize::from(index)) else {
        let place = place.to_owned();
        return Err(Refusal::UnknownIndex { place, found: index, declared: declared.len() });
    };
    let place = || format!("{place} ({})", kind.name);
    if action.parameters.len() != kind.parameters.len() {
        let found = u16::try_from(action.parameters.len()).unwrap_or(u16::MAX);
        return Err(Refusal::ValueCount { place: place(), found, declared: kind.parameters.len() });
    }
    kind.parameters
        .iter()
        .zip(&action.parameters)
        .try_for_each(|(property, given)| value(&|| format!("{}: parameter", place()), property, given))
}

/// Checks one value against its property. `place` is called only for a refusal.
///
/// # Errors
/// That it is of another kind, or outside its limits.
pub fn value(place: &dyn Fn() -> String, property: &Property, given: &Value) -> Result<(), Refusal> {
    let outside = |value: String, allowed: String| {
        Err(Refusal::ValueRange { place: format!("{} {}", place(), property.name), value, allowed })
    };
    match (&property.kind, *given) {
        (ValueKind::Integer { min, max }, Value::Integer(number)) => {
            if (*min..=*max).contains(&number) {
                return Ok(());
            }
            outside(number.to_string(), format!("{min}..={max}"))
        }
        (ValueKind::Symbol { symbols }, Value::Symbol(index)) => {
            if usize::try_from(index).is_ok_and(|index| index < symbols.len()) {
                return Ok(());
            }
            outside(format!("symbol {index}"), format!("symbols 0..={}", symbols.len().saturating_sub(1)))
        }
        (ValueKind::Boolean, Value::Boolean(_)) => Ok(()),
        (ValueKind::Real { min, max, .. }, Value::Real(real)) => {
            // NaN and the infinities are in no range of finite ends.
            if (*min..=*max).contains(&real) {
                return Ok(());
            }
            outside(number(real), format!("{}..={}", number(*min), number(*max)))
        }
        (declared, given) => Err(Refusal::ValueKind {
            place: format!("{} {}", place(), property.name),
            found: kind_of(given).to_owned(),
            declared: kind_name(declared),
        }),
    }
}

/// The kind of `value`, for people.
fn kind_of(value: Value) -> &'static str {
    match value {
        Value::Integer(_) => "an integer",
        Value::Symbol(_) => "a symbol",
        Value::Boolean(_) => "a boolean",
        Value::Real(_) => "a real",
    }
}

/// A declared kind, for people.
pub(crate) fn kind_name(kind: &ValueKind) -> &'static str {
    match kind {
        ValueKind::Integer { .. } => "an integer",
        ValueKind::Symbol { .. } => "a symbol",
        ValueKind::Boolean => "a boolean",
        ValueKind::Real { .. } => "a real",
    }
}
