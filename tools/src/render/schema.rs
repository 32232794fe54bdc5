//! `schemas` and `show` for people.

use pschema_inspect::{Condition, SchemaDetail, SchemaList};
use pschema_learner::notation::side;

use super::claims;
use super::table::{Columns, WIDTH};
use super::words::{
    capitalised, condition, count, notation, plain, probability, schema_sentence, summary_notation,
};

/// A list of schemas, from which the first `offset` were left out.
pub(crate) fn list(list: &SchemaList, offset: u32) -> String {
    if list.schemas.is_empty() {
        return match list.matching {
            0 => "No schema fits.\n".to_owned(),
            n => format!("{} in all: none is left beyond the first {offset}.\n", count(n, "schema")),
        };
    }
    let mut table = Columns::new(&["id", "kind", "schema", "succeeds"]).figures(&[0]);
    for s in &list.schemas {
        let succeeds = probability(s.probability, s.successes, s.executions, s.low, s.high);
        table.row([s.id.to_string(), s.kind.to_string(), summary_notation(s), succeeds]);
    }
    let (from, shown) = (u64::from(offset), list.schemas.len() as u64);
    let (end, all) = (from + shown, count(list.matching, "schema"));
    let more = match (offset, end < u64::from(list.matching)) {
        (0, false) => format!("\n{all}.\n"),
        (0, true) => format!("\n{shown} of {all}; --offset {end} goes on.\n"),
        (_, true) => format!("\n{} to {end} of {all}; --offset {end} goes on.\n", from + 1),
        (_, false) => format!("\n{} to {end} of {all}.\n", from + 1),
    };
    table.text(&[0, 1, 3]) + &more
}

/// One schema whole.
pub(crate) fn detail(s: &SchemaDetail) -> String {
    let mut text = format!("Schema {}, {}, made in step {}\n\n", s.id, s.kind, s.created_step);
    text.push_str(&wrapped(&capital(&schema_sentence(s)), "  "));
    text.push('\n');
    let mut facts = Columns::new(&[]);
    let mut fact = |name: &str, value: String| facts.fact(name, value);
    fact("pre-conditions", side(s.pre.iter().map(notation)));
    if s.target.is_empty() {
        fact("action", plain(&s.action));
    } else {
        fact("target action", side(s.target.iter().map(notation)));
    }
    fact("executed", times(s.executions));
    fact("succeeds", probability(s.probability, s.successes, s.executions, s.low, s.high));
    for (name, ids) in [("examples", &s.examples), ("counter-examples", &s.counter_examples)] {
        if !ids.is_empty() {
            fact(name, numbers(ids));
        }
    }
    if let Some(general) = s.contradicts {
        fact("contradicts", general.to_string());
    }
    if let Some(parent) = s.parent {
        fact("came from", parent.to_string());
    }
    text.push_str(&facts.text(&[0]));
    text.push_str(&conditions("post-condition", &s.post));
    text.push_str(&conditions("associated", &s.associated));
    if !s.claims.is_empty() {
        text.push_str(&format!("\nIt rests on these claims:\n{}", claims::foretold(&s.claims, true)));
    }
    text
}

fn times(n: u32) -> String {
    match n {
        0 => "never".to_owned(),
        1 => "once".to_owned(),
        n => format!("{n} times"),
    }
}

/// Numbers of schemas in one list; the others are only counted.
const NUMBERS_MAX: usize = 24;

fn numbers(ids: &[u32]) -> String {
    let mut shown: Vec<_> = ids.iter().take(NUMBERS_MAX).map(u32::to_string).collect();
    if ids.len() > NUMBERS_MAX {
        shown.push(format!("and {} more", ids.len() - NUMBERS_MAX));
    }
    shown.join(" ")
}

fn conditions(heading: &str, list: &[Condition]) -> String {
    if list.is_empty() {
        return String::new();
    }
    let mut table = Columns::new(&[heading, "holds"]);
    for c in list {
        table.row([condition(c), probability(c.probability, c.occurrences, c.trials, c.low, c.high)]);
    }
    format!("\n{}", table.text(&[1]))
}

/// A sentence broken into lines that fit a terminal.
pub fn wrapped(sentence: &str, indent: &str) -> String {
    let mut text = String::new();
    let mut line = indent.to_owned();
    for word in sentence.split_whitespace() {
        let free = line.len() == indent.len();
        if !free && line.chars().count() + 1 + word.chars().count() > usize::from(WIDTH) {
            text.push_str(&line);
            text.push('\n');
            indent.clone_into(&mut line);
        } else if !free {
            line.push(' ');
        }
        line.push_str(word);
    }
    text + &line + "\n"
}

/// The sentence with a capital letter and a full stop.
pub(crate) fn capital(sentence: &str) -> String {
    if sentence.is_empty() { String::new() } else { capitalised(sentence) + "." }
}
