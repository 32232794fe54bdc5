//! Excitation over time, as in the paper's figure 6. The curve above is the excitation of the most excited schema at each
//! step. The marks below are the steps in which a touching schema was executed, a touch was felt, a word was heard, or an
//! object was put down.

use pschema_inspect::TraceRecord;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::widgets::{Sparkline, Widget};

use super::super::state::State;
use super::canvas::Canvas;
use super::text::WrappedText;
use crate::render::words::{figure, plain};

/// Columns to the left of the curve, for its scale and the names of the marks.
const GUTTER: u16 = 9;
/// With fewer rows than this, the last kind of mark is left out so that the curve has room.
const ROWS_FOR_ALL: u16 = 8;
/// The curve is drawn in thousandths of its highest excitation, however small that is.
const PARTS: u64 = 1000;

/// One row of marks below the curve.
struct MarkRow {
    label: &'static str,
    mark: &'static str,
    happened: fn(&TraceRecord) -> bool,
}

const ROWS: [MarkRow; 4] = [
    MarkRow { label: "touching", mark: "\u{2580}", happened: predicts_touch },
    MarkRow { label: "touched", mark: "T", happened: touched },
    MarkRow { label: "heard", mark: "w", happened: |step| !step.heard.is_empty() },
    MarkRow { label: "put down", mark: "o", happened: |step| !step.drawn.is_empty() },
];

/// Whether the executed schema predicts a touch: the lower half of figure 6.
fn predicts_touch(step: &TraceRecord) -> bool {
    step.decision.as_ref().is_some_and(|decision| decision.predicts.iter().any(|kind| kind == "touch"))
}

fn touched(step: &TraceRecord) -> bool {
    step.perceived.iter().any(|observation| observation.kind == "touch")
}

fn top(step: &TraceRecord) -> f64 {
    step.decision.as_ref().map_or(0.0, |decision| decision.excitation_top)
}

/// Draws the curve and its marks; returns the title of the pane.
pub(super) fn curve(state: &State, canvas: Canvas, to: &mut Buffer) -> String {
    let Canvas { area, theme } = canvas;
    let width = area.width.saturating_sub(GUTTER);
    let columns = columns(state, usize::from(width));
    let rows = if area.height >= ROWS_FOR_ALL { &ROWS[..] } else { &ROWS[..3] };
    let marks = u16::try_from(rows.len()).unwrap_or(0).min(area.height.saturating_sub(1));
    let curve = Rect { x: area.x + GUTTER.min(area.width), width, height: area.height - marks, ..area };
    let highest = columns.iter().flatten().map(|step| top(step)).fold(0.0, f64::max);
    let heights = columns.iter().map(|steps| {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "not negative, and drawn coarsely"
        )]
        let height = (steps.iter().map(|step| top(step)).fold(0.0, f64::max) / highest * PARTS as f64) as u64;
        height
    });
    Sparkline::default().data(heights.collect::<Vec<_>>()).max(PARTS).style(theme.curve()).render(curve, to);
    let label = |y: u16, text: &str, style: Style, to: &mut Buffer| {
        to.set_stringn(area.x, y, format!("{text:>8} "), usize::from(GUTTER.min(area.width)), style);
    };
    label(curve.y, &figure(highest, 2), Style::new(), to);
    if curve.height > 1 {
        label(curve.bottom() - 1, "0", theme.quiet(), to);
    }
    for (row, y) in rows.iter().zip(curve.bottom()..area.bottom()) {
        label(y, row.label, Style::new(), to);
        for (steps, x) in columns.iter().zip(curve.x..curve.right()) {
            if steps.iter().any(|step| (row.happened)(step))
                && let Some(cell) = to.cell_mut((x, y))
            {
                cell.set_symbol(row.mark).set_style(theme.mark());
            }
        }
    }
    title(state)
}

fn title(state: &State) -> String {
    let now = state.excitation_top().map_or_else(String::new, |top| format!(" {}", figure(top, 2)));
    match state.steps_per_column {
        1 => format!("excitation{now}"),
        many => format!("excitation{now}, {many} steps/column"),
    }
}

/// The last steps, in groups of those that share a column. As time goes on, a step stays in the same group.
fn columns(state: &State, width: usize) -> Vec<Vec<&TraceRecord>> {
    let per_column = state.steps_per_column.max(1);
    let mut columns: Vec<(u64, Vec<&TraceRecord>)> = Vec::new();
    for (number, step) in (state.steps_from..).zip(&state.steps) {
        let column = number / per_column as u64;
        match columns.last_mut() {
            Some((last, steps)) if *last == column => steps.push(step),
            _ => columns.push((column, vec![step])),
        }
    }
    let first = columns.len().saturating_sub(width);
    columns.split_off(first).into_iter().map(|(_, steps)| steps).collect()
}

/// The last steps in words, the newest first.
pub(super) fn steps(state: &State, canvas: Canvas) -> WrappedText {
    let theme = canvas.theme;
    let mut text = canvas.text();
    for step in state.steps.iter().rev().take(200) {
        let mut told = match &step.decision {
            None => "nothing was decided".to_owned(),
            Some(decision) => {
                let schema =
                    decision.schema.map_or_else(|| "no schema yet".to_owned(), |id| format!("schema {id}"));
                let general = if decision.generalised { ", general" } else { "" };
                format!(
                    "E {} of {}  {}  ({schema}{general}, {})",
                    figure(decision.excitation, 2),
                    figure(decision.excitation_top, 2),
                    plain(&decision.action),
                    decision.reason
                )
            }
        };
        if touched(step) {
            told.push_str("  touched");
        }
        if !step.heard.is_empty() {
            told.push_str(&format!("  heard {}", plain(&step.heard.join(" "))));
        }
        match step.trial_met {
            Some(true) => told.push_str("  trial met"),
            Some(false) => told.push_str("  trial over"),
            None => (),
        }
        let style = if step.heard.is_empty() && !touched(step) { Style::new() } else { theme.mark() };
        text.wrapped(&format!("{:>6} ", step.step), &told, style);
    }
    if state.steps.is_empty() {
        text.wrapped("", "no step has been taken yet", theme.quiet());
    }
    text
}
