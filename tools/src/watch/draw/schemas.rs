//! Lists of schemas: the newest, and the most used.

use pschema_inspect::{SchemaKind, SchemaSummary};
use ratatui::style::Style;

use super::super::state::State;
use super::super::theme::Theme;
use super::canvas::Canvas;
use super::text::WrappedText;
use crate::render::words::summary_notation;

/// A schema is marked as new for this many steps after it was made.
const NEW_FOR: usize = 1;

pub(super) fn newest(state: &State, canvas: Canvas) -> WrappedText {
    let newest = state.live.as_ref().map(|live| live.newest.as_slice()).unwrap_or_default();
    let before = schemas_before(state);
    list(newest, canvas, |schema| before.is_some_and(|before| schema.id >= before))
}

/// The number of schemas before the last step, from the trace.
fn schemas_before(state: &State) -> Option<u32> {
    state.steps.iter().rev().nth(NEW_FOR).map(|step| step.schemas_total)
}

pub(super) fn most_used_title(state: &State) -> String {
    let total = state.most_used.as_ref().map(|list| format!(" of {}", list.matching)).unwrap_or_default();
    format!("most used{total}, successes/executions")
}

pub(super) fn most_used(state: &State, canvas: Canvas) -> WrappedText {
    let Some(all) = &state.most_used else {
        let mut text = canvas.text();
        text.wrapped("", "not asked for yet", canvas.theme.quiet());
        return text;
    };
    list(&all.schemas, canvas, |_| false)
}

fn list(schemas: &[SchemaSummary], canvas: Canvas, is_new: impl Fn(&SchemaSummary) -> bool) -> WrappedText {
    let mut text = canvas.text();
    for schema in schemas {
        one(&mut text, schema, is_new(schema), canvas.theme);
    }
    if schemas.is_empty() {
        text.wrapped("", "none", canvas.theme.quiet());
    }
    text
}

/// Successes and executions, `14/15`. The interval of the probability is shown where one schema is followed.
fn succeeded(s: &SchemaSummary) -> String {
    format!("{}/{}", s.successes, s.executions)
}

fn one(text: &mut WrappedText, s: &SchemaSummary, new: bool, theme: Theme) {
    let kind = match s.kind {
        SchemaKind::Concrete => String::new(),
        other => format!("{other}: "),
    };
    let told = format!("{kind}{}  {}", summary_notation(s), succeeded(s));
    let (mark, style) = if new { ("*", theme.new_thing()) } else { (" ", Style::new()) };
    text.wrapped(&format!("{mark}{:>5} ", s.id), &told, style);
}
