//! A body's declaration as text, by which a body that comes back is compared with itself. Memory has no ranges and no
//! repertoire of its own; yet field 4 of a small table is another place than field 4 of a large one.

use std::collections::BTreeSet;
use std::fmt::Write;

use pschema_learner::vocabulary::bin;
use pschema_process::readable;
use pschema_protocol::description::{Action, ActionType, Description, Property, Value, ValueKind};

/// So many differences are told.
const DIFFERENCES_TOLD: usize = 3;
/// The longest text of a line that is kept or told whole, in characters.
const LINE_CHARS_MAX: usize = 400;
const TOLD_CHARS_MAX: usize = 70;

/// The line of the kind of body. It is for people and is not compared: a memory that was learnt in a simulated arm may go on in
/// a real one that senses and does the same.
const KIND: &str = "kind: ";
/// The line of the world, where the body says one. It is compared between bodies of one kind that both say theirs: an arm and its
/// simulation are in two worlds, and are meant to be alike.
const WORLD: &str = "world: ";
/// The beginning of the line of a sense.
const SENSE: &str = "sense ";

/// The declaration, a line for the kind of body, its world, each sense, action and scene command, and for the repertoire.
pub(crate) fn text(description: &Description) -> String {
    let (kind, world) = description.kind_and_world();
    let mut lines = vec![format!("{KIND}{kind}")];
    lines.extend(world.map(|world| format!("{WORLD}{world}")));
    for sense in &description.observation_types {
        let own = if sense.own { "own " } else { "" };
        let event = match (sense.value, sense.transient) {
            (true, _) => "value ",
            (false, true) => "event ",
            (false, false) => "",
        };
        lines.push(format!("{SENSE}{}: {own}{event}{{{}}}", sense.name, properties(&sense.properties)));
    }
    let command = |sort: &str, declared: &ActionType| {
        format!("{sort} {}: ({})", declared.name, properties(&declared.parameters))
    };
    lines.extend(description.actions.iter().map(|action| command("action", action)));
    lines.extend(description.scene_commands.iter().map(|one| command("scene command", one)));
    lines.push(format!("repertoire: {}", repertoire(description)));
    lines.iter().map(|line| shortened(line) + "\n").collect()
}

/// What `now` says otherwise than `before`, or no longer: each line that differs, as it was and as it is. What is new beside
/// that contradicts nothing.
pub(crate) fn differences(before: &str, now: &str) -> Vec<String> {
    let told = |line: LineDifference<'_>| {
        format!("{} was {}, is {}", line.name, cut(line.one), cut(line.other.unwrap_or("nothing")))
    };
    let worlds = two_worlds(before, now).map(|(was, is)| format!("world was {was}, is {is}"));
    let mut differences: Vec<_> = compared(before, now).map(told).chain(worlds).collect();
    differences.sort_unstable();
    differences
}

/// The world of another body of the same memory, which has the text `of_another`, and the own one, if they are two and a sense of
/// the one is a sense of the other: what was learnt in one world would be used in the other.
pub(crate) fn mixed_worlds<'a>(of_another: &'a str, own: &'a str) -> Option<(&'a str, &'a str)> {
    two_worlds(of_another, own).filter(|_| {
        let senses: BTreeSet<_> = sense_names(own).collect();
        sense_names(of_another).any(|name| senses.contains(name))
    })
}

/// The worlds of two bodies of one kind, if both say theirs and they differ.
fn two_worlds<'a>(one: &'a str, other: &'a str) -> Option<(&'a str, &'a str)> {
    let said = |text: &'a str, key| text.lines().find_map(|line| line.strip_prefix(key));
    let worlds = (said(one, WORLD)?, said(other, WORLD)?);
    (said(one, KIND) == said(other, KIND) && worlds.0 != worlds.1).then_some(worlds)
}

fn sense_names(text: &str) -> impl Iterator<Item = &str> {
    text.lines().filter_map(|line| line.strip_prefix(SENSE)?.split_once(": ")).map(|(name, _)| name)
}

/// The senses that a body declares otherwise than another body of the same memory, which has the text `of_another`: a value of
/// them stands for something else in each. Actions are a body's own.
pub(crate) fn other_senses(of_another: &str, own: &str) -> Vec<String> {
    let senses = compared(of_another, own).filter(|line| line.name.starts_with(SENSE));
    let told = |line: LineDifference<'_>| {
        Some(format!("{} is {} there, {} here", line.name, cut(line.one), cut(line.other?)))
    };
    senses.filter_map(told).collect()
}

/// A line of one text that another does not have, and the declaration that stands under its name there, if any.
struct LineDifference<'a> {
    name: &'a str,
    one: &'a str,
    other: Option<&'a str>,
}

fn compared<'a>(one: &'a str, other: &'a str) -> impl Iterator<Item = LineDifference<'a>> {
    let lines: BTreeSet<&str> = other.lines().collect();
    // Whole lines are compared: a name may hold what stands between a name and its declaration.
    let of_its_own = |line: &str| line.starts_with(KIND) || line.starts_with(WORLD);
    let differ = one.lines().filter(move |line| !of_its_own(line) && !lines.contains(line));
    differ.filter_map(|line| {
        let (name, one) = line.split_once(": ")?;
        let same_name = other.lines().filter_map(|line| line.split_once(": "));
        let other = same_name.into_iter().find_map(|(known, told)| (known == name).then_some(told));
        Some(LineDifference { name, one, other })
    })
}

/// Differences in one sentence.
pub(crate) fn told(differences: &[String]) -> String {
    let mut told: Vec<_> = differences.iter().take(DIFFERENCES_TOLD).cloned().collect();
    if let Some(more) = differences.len().checked_sub(DIFFERENCES_TOLD).filter(|more| *more > 0) {
        told.push(format!("and {more} more"));
    }
    told.join("; ")
}

fn properties(declared: &[Property]) -> String {
    let one = |property: &Property| {
        let values = match &property.kind {
            ValueKind::Integer { min, max } => format!("{min}..={max}"),
            ValueKind::Symbol { symbols } => symbols.join("|"),
            ValueKind::Boolean => "true|false".to_owned(),
            ValueKind::Real { min, max, resolution } => format!("{min}..={max} by {resolution}"),
        };
        let unit = if property.unit.is_empty() { String::new() } else { format!(" {}", property.unit) };
        format!("{} {values}{unit}", property.name)
    };
    declared.iter().map(one).collect::<Vec<_>>().join(", ")
}

/// How many primitives there are, and a digest of them all in any order, with reals as the learner compares them.
fn repertoire(description: &Description) -> String {
    let one = |action: &Action| {
        let declared = description.actions.get(usize::from(action.id.index()));
        let mut text = declared.map_or("", |declared| declared.name.as_str()).to_owned();
        let kinds = declared.map(|declared| declared.parameters.as_slice()).unwrap_or_default();
        for (value, property) in action.parameters.iter().zip(kinds) {
            let written = match (value, &property.kind) {
                (Value::Real(number), ValueKind::Real { resolution, .. }) => {
                    write!(text, " {}", bin(*number, *resolution))
                }
                (Value::Symbol(at), ValueKind::Symbol { symbols }) => {
                    let symbol = usize::try_from(*at).ok().and_then(|at| symbols.get(at));
                    write!(text, " {}", symbol.map_or("", String::as_str))
                }
                (value, _) => write!(text, " {value:?}"),
            };
            // A string takes all that is written.
            debug_assert!(written.is_ok());
        }
        text
    };
    let mut all: Vec<_> = description.repertoire.iter().map(one).collect();
    all.sort_unstable();
    all.dedup();
    let digest = blake3::hash(all.join("\n").as_bytes()).to_hex();
    format!("{} primitives, digest {}", all.len(), digest.get(..16).unwrap_or_default())
}

/// A line that is not too long to be kept: of a longer one the beginning and a digest.
fn shortened(line: &str) -> String {
    match line.char_indices().nth(LINE_CHARS_MAX) {
        None => line.to_owned(),
        Some((at, _)) => {
            let digest = blake3::hash(line.as_bytes()).to_hex();
            format!(
                "{}… (digest {})",
                line.get(..at).unwrap_or_default(),
                digest.get(..16).unwrap_or_default()
            )
        }
    }
}

/// A declaration as it is told. The text that is kept has each number with all its digits, for it is compared.
fn cut(text: &str) -> String {
    let text = readable(text);
    match text.char_indices().nth(TOLD_CHARS_MAX) {
        None => text.into_owned(),
        Some((at, _)) => format!("{}…", text.get(..at).unwrap_or_default()),
    }
}

#[cfg(test)]
mod tests {
    use pschema_protocol::description::ObservationType;

    use super::*;

    fn body(fields: i64) -> Description {
        let mut body = Description::new("arm", "row");
        let field = || Property::integer("field", 0..=fields).unit("cm");
        body.observation_types.push(ObservationType::state("finger").own().property(field()));
        body.observation_types.push(ObservationType::event("touch"));
        body.action_with_primitives(ActionType::new("move").parameter(field()));
        body
    }

    #[test]
    fn a_declaration_is_told_line_by_line() {
        let text = text(&body(2));
        let digest = text.rsplit_once("digest ").map_or("", |(_, digest)| digest.trim_end());
        assert_eq!(digest.len(), 16, "{text}");
        let told = format!(
            "kind: row\nsense finger: own {{field 0..=2 cm}}\nsense touch: event {{}}\naction move: (field 0..=2 cm)\n\
             repertoire: 3 primitives, digest {digest}\n"
        );
        assert_eq!(text, told);
    }

    /// A limit of 300 digits left no room for all that differed.
    #[test]
    fn of_a_number_of_hundreds_of_digits_the_first_are_told() {
        let with = |max: f64| {
            let mut body = body(2);
            let charge = Property::real("charge", -1e300..=max, 1e290);
            body.observation_types.push(ObservationType::state("cell").property(charge));
            text(&body)
        };
        let told = differences(&with(1e300), &with(2e300));
        assert_eq!(told.len(), 1, "{told:?}");
        assert!(told[0].contains("..=1000000000… (") && told[0].contains("..=2000000000… ("), "{told:?}");
    }

    #[test]
    fn another_range_and_a_lost_sense_are_differences_and_a_new_sense_is_none() {
        let before = text(&body(2));
        assert_eq!(differences(&before, &before), Vec::<String>::new());
        let mut more = body(2);
        more.observation_types.push(ObservationType::event("sound"));
        assert_eq!(differences(&before, &text(&more)), Vec::<String>::new());
        assert_eq!(
            differences(&text(&more), &before),
            ["sense sound was event {}, is nothing"],
            "it has lost a sense"
        );
        let larger = differences(&before, &text(&body(3)));
        assert_eq!(larger.len(), 3, "{larger:?}");
        assert_eq!(larger[2], "sense finger was own {field 0..=2 cm}, is own {field 0..=3 cm}");
        // Names that look like the beginning of a declaration hide nothing.
        let alike = |fields: i64| {
            let mut body = Description::new("arm", "row");
            for (name, max) in [("a: x", fields), ("a: y", 2)] {
                let sense = ObservationType::state(name).property(Property::integer("field", 0..=max));
                body.observation_types.push(sense);
            }
            text(&body)
        };
        assert_eq!(differences(&alike(2), &alike(3)).len(), 1);
        // The order of a repertoire says nothing.
        let mut reversed = body(2);
        reversed.repertoire.reverse();
        assert_eq!(text(&reversed), before);
    }

    #[test]
    fn senses_of_one_name_that_two_bodies_declare_otherwise_are_told() {
        let (small, large) = (text(&body(2)), text(&body(3)));
        assert_eq!(other_senses(&small, &small), Vec::<String>::new());
        assert_eq!(
            other_senses(&small, &large),
            ["sense finger is own {field 0..=2 cm} there, own {field 0..=3 cm} here"]
        );
        let mut deaf = body(2);
        deaf.observation_types.pop();
        assert_eq!(other_senses(&small, &text(&deaf)), Vec::<String>::new(), "a body may have fewer senses");
    }

    #[test]
    fn worlds_are_compared_between_bodies_of_one_kind_that_say_theirs() {
        let of = |kind: &str| {
            let mut body = body(2);
            body.kind = kind.to_owned();
            text(&body)
        };
        assert!(of("row@wide").starts_with("kind: row\nworld: wide\nsense "), "{}", of("row@wide"));
        assert_eq!(differences(&of("row@wide"), &of("row@narrow")), ["world was wide, is narrow"]);
        assert_eq!(mixed_worlds(&of("row@wide"), &of("row@narrow")), Some(("wide", "narrow")));
        // Who says no world, and a body of another kind, is not compared.
        for alike in ["row@wide", "row", "row@", "other@narrow", "other"] {
            assert_eq!(differences(&of("row@wide"), &of(alike)), Vec::<String>::new(), "{alike}");
            assert_eq!(differences(&of(alike), &of("row@wide")), Vec::<String>::new(), "{alike}");
            assert_eq!(mixed_worlds(&of("row@wide"), &of(alike)), None, "{alike}");
        }
        // Where no sense has the name of another's, nothing mixes.
        let mut other = Description::new("eye", "row@narrow");
        other.observation_types.push(ObservationType::event("sound"));
        assert_eq!(mixed_worlds(&of("row@wide"), &text(&other)), None);
    }

    #[test]
    fn a_very_long_line_is_kept_by_its_digest() {
        let symbols = |last: &str| {
            let mut body = Description::new("arm", "row");
            let all = (0..200).map(|at| format!("symbol{at}")).chain([last.to_owned()]);
            body.observation_types
                .push(ObservationType::state("object").property(Property::symbol("colour", all)));
            text(&body)
        };
        assert!(symbols("red").lines().all(|line| line.chars().count() < LINE_CHARS_MAX + 40));
        assert_eq!(differences(&symbols("red"), &symbols("red")), Vec::<String>::new());
        assert_eq!(differences(&symbols("red"), &symbols("blue")).len(), 1);
    }
}
