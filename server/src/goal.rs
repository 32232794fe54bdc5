//! The patterns of a goal as people write them, checked by what the body declares that is to pursue it. Memory knows which values were
//! met and no ranges, so a value that the body can never sense would be pursued in vain.

use pschema_learner::notation::{self, PatternError};
use pschema_learner::observation::{Pattern, PropertyId, Term, Value};
use pschema_learner::pursuit::Goal;
use pschema_learner::vocabulary::{Vocabulary, bin};
use pschema_process::number;
use pschema_protocol::description::{Description, ValueKind};

use crate::translate::listed;

/// So many symbols are listed where one is given that the body does not have.
const SYMBOLS_LISTED: usize = 12;

/// Why texts are no goal.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GoalTextError {
    /// One of the patterns can't be read.
    #[error(transparent)]
    Pattern(#[from] PatternError),
    /// Patterns are given beside the value of which most is wanted.
    #[error(
        "most of {most} is wanted, which goes on and holds never: give patterns, or the value, and `again` with patterns only"
    )]
    Both {
        /// The value.
        most: String,
    },
    /// Most is wanted of what is none.
    #[error(
        "{most} is no value of which there could be most: a value is a number that comes with the frames of a body, which declares it so; \
         {known}"
    )]
    NoValue {
        /// What was given.
        most: String,
        /// The values that there are.
        known: String,
    },
    /// A value is none that the body can sense.
    #[error(
        "{kind}{{{property}={value}}} will never be so: body {body} declares {property} of {kind} as {declared}; give one of these, or a \
         variable such as $x"
    )]
    Outside {
        /// The observation type.
        kind: String,
        /// Its property.
        property: String,
        /// The value given, as it prints.
        value: String,
        /// The body's name.
        body: String,
        /// The values that it declares.
        declared: String,
    },
}

/// What is asked for, as people write it.
#[derive(Clone, Copy, Debug)]
pub struct Asked<'a> {
    /// Patterns.
    pub goal: &'a [String],
    /// Whether it is wanted though it may hold.
    pub again: bool,
    /// The value of which most is wanted.
    pub most: Option<&'a str>,
}

/// Reads what is wanted: patterns, as [`read`] does, or most of a value.
///
/// # Errors
/// As [`read`]; and when patterns are given beside the value of which most is wanted, or there is no such type.
pub fn wanted(
    vocabulary: &Vocabulary,
    body: Option<&Description>,
    Asked { goal, again, most }: Asked<'_>,
) -> Result<Goal, GoalTextError> {
    let Some(most) = most else {
        let patterns = read(vocabulary, body, goal)?;
        return Ok(if again { Goal::Again(patterns) } else { Goal::Observed(patterns) });
    };
    if !goal.is_empty() || again {
        return Err(GoalTextError::Both { most: most.to_owned() });
    }
    let values = || vocabulary.types().iter().map(|known| &known.declared).filter(|known| known.value);
    let named = vocabulary.type_named(most).filter(|kind| vocabulary.is_value(*kind));
    named.map(Goal::Most).ok_or_else(|| GoalTextError::NoValue {
        most: most.to_owned(),
        known: match values().count() {
            0 => "no body that is known declares any".to_owned(),
            _ => format!("there are: {}", listed(values().map(|known| known.name.as_str()))),
        },
    })
}

/// Reads the patterns of a goal, in which a variable is the same everywhere. `body` is what the body declares that is to pursue it, where
/// that is known: a type of another body, or the word that is heard, may have any value.
///
/// # Errors
/// What can't be read, or is out of the body's ranges, with what there is instead.
pub fn read(
    vocabulary: &Vocabulary,
    body: Option<&Description>,
    texts: &[String],
) -> Result<Vec<Pattern>, GoalTextError> {
    let patterns = notation::parse_goal(vocabulary, texts)?;
    let outside =
        body.and_then(|body| patterns.iter().find_map(|pattern| outside(vocabulary, body, pattern)));
    outside.map_or(Ok(patterns), Err)
}

/// The first value of a pattern that the body can never sense.
fn outside(vocabulary: &Vocabulary, body: &Description, pattern: &Pattern) -> Option<GoalTextError> {
    let kind = &vocabulary.types().get(usize::from(pattern.kind().0))?.declared.name;
    let declared = body.observation_types.iter().find(|declared| declared.name == *kind)?;
    let value_of = |&(property, term): &(PropertyId, Term)| match term {
        Term::Constant(value) => Some((property, value)),
        Term::Variable(_) => None,
    };
    pattern.terms().iter().filter_map(value_of).find_map(|(id, value)| {
        let name = vocabulary.properties().get(usize::from(id.0))?;
        let property = declared.properties.iter().find(|property| property.name == *name)?;
        let allowed = allowed(vocabulary, &property.kind, value)?;
        let unit = if property.unit.is_empty() { String::new() } else { format!(" {}", property.unit) };
        Some(GoalTextError::Outside {
            kind: kind.clone(),
            property: name.clone(),
            value: notation::value(vocabulary, id, value),
            body: body.name.clone(),
            declared: format!("{allowed}{unit}"),
        })
    })
}

/// The values that are declared, if this one is none of them. A real stands for its bin, as it prints and is compared.
fn allowed(vocabulary: &Vocabulary, declared: &ValueKind, value: Value) -> Option<String> {
    match (declared, value) {
        (ValueKind::Integer { min, max }, Value::Integer(value)) => {
            (!(*min..=*max).contains(&value)).then(|| format!("{min}..={max}"))
        }
        (ValueKind::Real { min, max, resolution }, Value::Bin(value)) => {
            let bins = bin(*min, *resolution)..=bin(*max, *resolution);
            (!bins.contains(&value)).then(|| format!("{}..={}", number(*min), number(*max)))
        }
        (ValueKind::Symbol { symbols }, Value::Symbol(value)) => {
            let text = notation::symbol(vocabulary, value);
            let more = if symbols.len() > SYMBOLS_LISTED { ", …" } else { "" };
            let known = || listed(symbols.iter().take(SYMBOLS_LISTED).map(String::as_str));
            (!symbols.contains(&text)).then(|| format!("{}{more}", known()))
        }
        // A boolean has both values. What is of another kind was refused when the body attached.
        _ => None,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // A test panics to fail.
mod tests {
    use pschema_protocol::description::{ObservationType, Property};

    use super::*;
    use crate::translate::declaration;

    fn body() -> Description {
        let mut body = Description::new("cart", "cart");
        let place = ObservationType::state("place")
            .property(Property::integer("row", -2..=5))
            .property(Property::real("x", 0.0..=1.0, 0.3).unit("m"))
            .property(Property::symbol("side", ["left", "right"]))
            .property(Property::boolean("lit"));
        let _sense = body.observation(place);
        body
    }

    fn vocabulary(body: &Description) -> Vocabulary {
        let mut vocabulary = Vocabulary::default();
        vocabulary.declare(&declaration(body).unwrap()).unwrap();
        vocabulary.meet(&["left", "right", "up"].map(str::to_owned));
        vocabulary
    }

    /// `achieve place{row=99}` was taken up once, and pursued until its actions were used up.
    #[test]
    fn a_value_that_the_body_can_never_sense_is_refused_by_name() {
        let body = body();
        let vocabulary = vocabulary(&body);
        let read = |text: &str| read(&vocabulary, Some(&body), &[text.to_owned()]).map(drop);
        for (text, told) in [
            (
                "place{row=6}",
                "place{row=6} will never be so: body cart declares row of place as -2..=5; give",
            ),
            ("place{lit=true, row=-3}", "place{row=-3}"),
            ("place{x=-1}", "x of place as 0..=1 m;"),
            ("place{x=1.4}", "x of place as 0..=1 m;"),
            ("place{side=up}", "side of place as left, right;"),
        ] {
            let problem = read(text).unwrap_err().to_string();
            assert!(problem.contains(told), "{text}: {problem}");
        }
        // What is sensed at the end of a range prints as the middle of its bin, which may be beyond.
        for text in [
            "place{row=-2}",
            "place{row=5, x=0.9}",
            "place{x=1.0}",
            "place{side=left, lit=false}",
            "place{row=$x}",
        ] {
            assert_eq!(read(text), Ok(()), "{text}");
        }
        // Any word may be heard.
        assert_eq!(read("word{text=up}"), Ok(()));
    }

    #[test]
    fn most_is_wanted_of_a_value() {
        let mut body = body();
        let _score = body.observation(ObservationType::value("score", Property::integer("points", -1..=1)));
        let vocabulary = vocabulary(&body);
        let goal = |goal: &[&str], again, most| {
            let goal: Vec<_> = goal.iter().map(|text| (*text).to_owned()).collect();
            wanted(&vocabulary, Some(&body), Asked { goal: &goal, again, most })
        };
        let score = vocabulary.type_named("score").unwrap();
        assert_eq!(goal(&[], false, Some("score")), Ok(Goal::Most(score)));
        assert!(matches!(goal(&["place{row=1}"], true, None), Ok(Goal::Again(one)) if one.len() == 1));
        let problem = goal(&[], false, Some("place")).unwrap_err().to_string();
        assert!(problem.contains("place is no value") && problem.contains("there are: score"), "{problem}");
        assert!(goal(&["place{row=1}"], false, Some("score")).is_err());
        assert!(goal(&[], true, Some("score")).is_err());
    }

    #[test]
    fn without_a_body_nothing_is_known_of_ranges() {
        let vocabulary = vocabulary(&body());
        assert!(read(&vocabulary, None, &["place{row=99}".to_owned()]).is_ok());
        let problem = read(&vocabulary, None, &["lamp{}".to_owned()]).unwrap_err();
        assert!(matches!(problem, GoalTextError::Pattern(PatternError::Type { .. })), "{problem}");
    }
}
