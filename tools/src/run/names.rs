//! The names in a curriculum's `[experiment]` table, compared with those that the body of a run declared. A misspelt one would be
//! obeyed in silence: a sense that nobody has is never felt, and its share of 0 % would look like a finding.

use pschema_inspect::PlanQuery;
use pschema_learner::notation::{by_names, words};

use crate::design::{Design, Measure};
use crate::failure::Failure;
use crate::learner::Asks;

/// A failure at the first name that stands for nothing: the file, the key, the name, and the names that there are. A body must have
/// attached.
pub(super) fn check(design: &Design, asked: &mut impl Asks) -> Result<(), Failure> {
    for (key, pattern) in patterns(design) {
        // A goal is read as any pattern is; the plan itself is of no interest.
        asked
            .ask(PlanQuery { goal: vec![pattern], ..PlanQuery::default() })
            .map_err(|failure| at(design, &key, failure))?;
    }
    Ok(())
}

/// A failure to answer a question, as that of the key of the table which made it be asked.
pub(super) fn at(design: &Design, key: &str, failure: Failure) -> Failure {
    match failure {
        Failure::Failed(problem) => {
            Failure::Failed(format!("{}: [experiment] {key}: {problem}", design.curriculum))
        }
        other => other,
    }
}

/// The conditions on schemas that a measure names, with their keys.
pub(super) fn conditions(measure: &Measure) -> impl Iterator<Item = (String, &String)> {
    let named = [("pre", &measure.pre), ("post", &measure.post), ("except_post", &measure.except_post)];
    named.into_iter().filter_map(|(key, pattern)| {
        pattern.as_ref().map(|pattern| (format!("measure {:?}, {key}", measure.name), pattern))
    })
}

/// All that the table names of what a body declares, as patterns, with their keys.
fn patterns(design: &Design) -> Vec<(String, String)> {
    let mut all = Vec::new();
    let mut add = |key: &str, kind: &str, place: Option<&String>| {
        all.push((key.to_owned(), by_names(kind, place.map(|place| (place, "$x")))));
    };
    if let Some(touching) = &design.touching {
        add("touching", touching, None);
    }
    if let Some(map) = &design.map {
        add("map.object", &map.object, Some(&map.place));
        add("map.effector", &map.effector, Some(&map.place));
        if let Some(reached) = &map.reached {
            add("map.reached", reached, None);
        }
    }
    for measure in &design.measures {
        if let Some(value) = &measure.value {
            add(&format!("measure {:?}, value", measure.name), value, None);
        }
    }
    let measured = design.measures.iter().flat_map(conditions);
    all.extend(measured.map(|(key, pattern)| (key, without_values(pattern))));
    all
}

/// A pattern with a variable for each value: words are values that nobody knows before they are heard.
fn without_values(pattern: &str) -> String {
    match words(pattern) {
        Some((kind, parts)) => {
            let properties = parts.map(|part| part.pair.map_or(part.text, |(property, _)| property));
            by_names(kind, properties.zip(1..).map(|(property, number)| (property, format!("${number}"))))
        }
        // It is no pattern, which whoever reads it says.
        None => pattern.to_owned(),
    }
}
