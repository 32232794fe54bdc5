//! What ends a trial, as written: `touch{}`, `object{colour=blue, field=4}`.

use pschema_learner::curriculum::{Argument, NamedObservation};
use pschema_learner::notation::{NotationPart, words};

/// Properties that may be asked for.
const PROPERTIES_MAX: usize = 8;

/// Reads `text`.
///
/// # Errors
/// What is wrong with it, and what would be right.
pub(super) fn parse(text: &str) -> Result<NamedObservation, String> {
    let example =
        "write a type and the properties it must have, such as `touch{}` or `object{colour=blue, field=4}`";
    let (kind, parts) = words(text).ok_or_else(|| format!("{text:?} is no observation: {example}"))?;
    let kind = name(kind).ok_or_else(|| format!("{text:?} has no type: {example}"))?;
    let mut properties: Vec<(String, Argument)> = Vec::new();
    for NotationPart { text, pair } in parts {
        let (property, value) =
            pair.ok_or_else(|| format!("{text:?} is no property with a value: {example}"))?;
        let property = name(property).ok_or_else(|| format!("{text:?} has no property name: {example}"))?;
        if properties.iter().any(|(known, _)| *known == property) {
            return Err(format!("property {property} is given twice"));
        }
        let value = argument(value).ok_or_else(|| format!("{text:?} has no value: {example}"))?;
        properties.push((property, value));
    }
    if properties.len() > PROPERTIES_MAX {
        return Err(format!("{} properties, at most {PROPERTIES_MAX} are allowed", properties.len()));
    }
    Ok(NamedObservation { kind, properties })
}

fn name(text: &str) -> Option<String> {
    (!text.is_empty() && !text.contains(['{', '}', '=', ',', '$', '"'])).then(|| text.to_owned())
}

fn argument(text: &str) -> Option<Argument> {
    let text = name(text)?;
    Some(text.parse().map_or(Argument::Symbol(text), Argument::Integer))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn observations_are_read() {
        assert_eq!(parse("touch{}").unwrap(), NamedObservation { kind: "touch".into(), properties: vec![] });
        let object = parse(" object{colour=blue, field=-4} ").unwrap();
        assert_eq!(object.kind, "object");
        let colour = ("colour".to_owned(), Argument::Symbol("blue".to_owned()));
        assert_eq!(object.properties, vec![colour, ("field".to_owned(), Argument::Integer(-4))]);
    }

    #[test]
    fn anything_else_is_refused_with_an_example() {
        for wrong in ["", "touch", "touch{", "{}", "o{field}", "o{=4}", "o{field=}", "o{field=$a}", "o{a=1}}"]
        {
            let error = parse(wrong).unwrap_err();
            assert!(error.contains("such as `touch{}`"), "{wrong:?} gave {error}");
        }
        assert!(parse("o{a=1, a=2}").unwrap_err().contains("twice"));
    }
}
