//! One schema, with its changes since somebody began to look at it.

use pschema_inspect::{Condition, SchemaDetail};
use ratatui::style::Style;

use super::super::state::{FollowedSchema, State};
use super::canvas::Canvas;
use super::text::WrappedText;
use crate::render::schema::capital;
use crate::render::words::{condition, plain, probability, schema_notation, schema_sentence};

pub(super) fn title(state: &State) -> String {
    match &state.followed {
        None => "follow a schema".to_owned(),
        Some(followed) => format!("schema {}, * changed last", followed.id),
    }
}

pub(super) fn text(state: &State, canvas: Canvas) -> WrappedText {
    let theme = canvas.theme;
    let mut text = canvas.text();
    let Some(followed) = &state.followed else {
        text.wrapped("", "Press f and give the number of a schema; page 4 lists some.", theme.quiet());
        return text;
    };
    if let Some(problem) = &followed.problem {
        text.wrapped("! ", &plain(problem), theme.bad());
    }
    let Some(now) = &followed.now else {
        if followed.problem.is_none() {
            text.wrapped("", "asked for", theme.quiet());
        }
        return text;
    };
    text.wrapped("", &capital(&schema_sentence(now)), theme.strong());
    text.wrapped("", &schema_notation(now), Style::new());
    let made = format!("{}, made in step {}{}", now.kind, now.created_step, lineage(now));
    text.wrapped("", &made, Style::new());
    statistics(&mut text, followed, now, canvas);
    text
}

fn lineage(schema: &SchemaDetail) -> String {
    let mut told = String::new();
    if let Some(parent) = schema.parent {
        told.push_str(&format!(", came from {parent}"));
    }
    if let Some(general) = schema.contradicts {
        told.push_str(&format!(", contradicts {general}"));
    }
    for (ids, name) in [(&schema.examples, "examples"), (&schema.counter_examples, "counter-examples")] {
        if !ids.is_empty() {
            told.push_str(&format!(", {} {name}", ids.len()));
        }
    }
    told
}

fn statistics(text: &mut WrappedText, followed: &FollowedSchema, now: &SchemaDetail, canvas: Canvas) {
    let first = followed.first.as_deref();
    let before = followed.before.as_deref();
    let executed = |schema: &SchemaDetail| (schema.successes, schema.executions);
    let told = format!(
        "succeeds {}{}",
        probability(now.probability, now.successes, now.executions, now.low, now.high),
        since(first.map(executed), executed(now))
    );
    let changed = before.is_some_and(|before| executed(before) != executed(now));
    line(text, &told, changed, canvas);
    let conditions = [
        ("post-conditions", &now.post, posts as fn(&SchemaDetail) -> &[Condition]),
        ("associated", &now.associated, associated),
    ];
    for (heading, list, of) in conditions {
        if list.is_empty() {
            continue;
        }
        text.wrapped("", heading, canvas.theme.quiet());
        for one in list {
            let find =
                |schema: &&SchemaDetail| of(schema).iter().find(|other| is_same(other, one)).map(counted);
            let told = format!(
                "{}  {}{}",
                condition(one),
                probability(one.probability, one.occurrences, one.trials, one.low, one.high),
                since(first.as_ref().map(|first| find(first).unwrap_or_default()), counted(one))
            );
            let changed = before.as_ref().is_some_and(|before| find(before) != Some(counted(one)));
            line(text, &told, changed, canvas);
        }
    }
}

fn posts(schema: &SchemaDetail) -> &[Condition] {
    &schema.post
}

fn associated(schema: &SchemaDetail) -> &[Condition] {
    &schema.associated
}

fn is_same(one: &Condition, other: &Condition) -> bool {
    one.absent == other.absent && one.observation == other.observation
}

fn counted(one: &Condition) -> (u32, u32) {
    (one.occurrences, one.trials)
}

/// The growth of two counts since the schema was first shown: `, +2/+3 since you look`.
fn since(first: Option<(u32, u32)>, now: (u32, u32)) -> String {
    match first {
        Some(first) if first != now => {
            let more = |now: u32, first: u32| i64::from(now) - i64::from(first);
            format!(", {:+}/{:+} since you look", more(now.0, first.0), more(now.1, first.1))
        }
        _ => String::new(),
    }
}

fn line(text: &mut WrappedText, told: &str, changed: bool, canvas: Canvas) {
    let (mark, style) = if changed { ("* ", canvas.theme.new_thing()) } else { ("  ", Style::new()) };
    text.wrapped(mark, told, style);
}
