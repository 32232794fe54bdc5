//! Figure 6 of the paper: how excited the learner is, and what by.

use maud::{Markup, html};

use crate::design::Peak;
use crate::run::{Outcome, StepRecord, Trace};

use super::Section;
use super::plot::{Frame, both, curve, drawing, px, steps, x_axis, y_axis};
use super::scale::Scale;

/// Room that the label of a peak needs.
const PEAK_LABEL_PX: f64 = 14.0;

/// The figure, of the first seed of the experiment as it stands; none without a decision.
pub(super) fn figure(section: &Section<'_>) -> Option<Markup> {
    let outcome = section.groups.first()?.outcomes.first()?;
    let rows = shown(section, &outcome.trace);
    let top: Vec<(f64, f64)> = rows.iter().map(|(at, row)| (*at, excitation(row))).collect();
    let highest = top.iter().map(|point| point.1).fold(0.0, f64::max);
    let last = top.last()?.0;
    let touching: Option<Vec<(f64, f64)>> = section
        .design
        .touching
        .as_ref()
        .map(|_| rows.iter().map(|(at, row)| (*at, f64::from(u8::from(is_touching(row))))).collect());
    let peaks = peaks(section, &outcome.trace, &rows);
    let heard: Vec<f64> = rows.iter().filter(|(_, row)| !row.heard.is_empty()).map(|(at, _)| *at).collect();
    let figure = |width: f64| {
        let upper = Frame { left: 62.0, right: width - 10.0, top: 52.0, bottom: 222.0 };
        let lower = Frame { top: 242.0, bottom: 282.0, ..upper };
        let x = Scale::linear(0.0, last, upper.x());
        let y = Scale::linear(0.0, highest * 1.08, upper.y());
        let base = if touching.is_some() { lower } else { upper };
        let content = html! {
            (y_axis(&upper, &y, "excitation of the most excited schema"))
            (labelled(&peaks, &x, &upper, &base))
            @for at in &heard { (word(x.at(*at), &upper)) }
            (curve(&top, &x, &y, "curve c0"))
            @if let Some(touching) = &touching {
                (states(&lower))
                (steps(touching, &x, &Scale::linear(0.0, 1.0, (lower.bottom - 6.0, lower.top + 6.0)), "curve c1"))
            }
            (x_axis(&base, &x, "step"))
        };
        drawing(width, base.bottom + 42.0, "excitation over steps", &content)
    };
    Some(html! {
        figure {
            (both(figure))
            figcaption { (caption(section, outcome, !heard.is_empty())) }
        }
    })
}

/// The rows that decided something, from the stage that the figure begins with; numbered from 0.
fn shown<'a>(section: &Section<'_>, trace: &'a Trace) -> Vec<(f64, &'a StepRecord)> {
    let from = section.design.figure_from.as_ref();
    let place = |name: &String| trace.stages.iter().position(|stage| stage == name);
    let begins = from.and_then(place).unwrap_or(0);
    let ends = section.design.figure_to.as_ref().and_then(place).unwrap_or(usize::MAX);
    let rows = trace.rows.iter().filter(|row| (begins..=ends).contains(&row.stage) && row.decision.is_some());
    #[expect(clippy::cast_precision_loss, reason = "numbers of steps")]
    rows.enumerate().map(|(at, row)| (at as f64, row)).collect()
}

fn excitation(row: &StepRecord) -> f64 {
    row.decision.as_ref().map_or(0.0, |decision| decision.excitation_top)
}

fn is_touching(row: &StepRecord) -> bool {
    row.decision.as_ref().is_some_and(|decision| decision.touching)
}

/// Labels and where they stand.
fn peaks(section: &Section<'_>, trace: &Trace, rows: &[(f64, &StepRecord)]) -> Vec<(String, f64)> {
    let place = |peak: &Peak| {
        let stage = trace.stages.iter().position(|stage| *stage == peak.stage)?;
        let is_first =
            |row: &StepRecord| row.stage == stage && peak.trial.is_none_or(|trial| row.trial == trial);
        let (at, _) = rows.iter().find(|(_, row)| is_first(row))?;
        Some((peak.label.clone(), *at))
    };
    let mut peaks: Vec<_> = section.design.peaks.iter().filter_map(place).collect();
    peaks.sort_by(|a, b| a.1.total_cmp(&b.1));
    peaks
}

/// Lines at the peaks, and their labels above; pushed apart where they would lie on one another.
fn labelled(peaks: &[(String, f64)], x: &Scale, upper: &Frame, base: &Frame) -> Markup {
    let mut places: Vec<(&str, f64, f64)> = Vec::new();
    for (label, at) in peaks {
        let line = x.at(*at);
        let free = places.last().map_or(f64::NEG_INFINITY, |(_, _, last)| last + PEAK_LABEL_PX);
        places.push((label, line, line.max(free)));
    }
    html! {
        @for (label, line, text) in places {
            path.peak d=(format!(
                "M{} {}L{} {}V{}", px(text), px(upper.top - 13.0), px(line), px(upper.top - 2.0), px(base.bottom)
            )) {}
            text.label.peak.middle x=(px(text)) y=(px(upper.top - 17.0)) { (label) }
        }
    }
}

/// A word heard: a small mark at the top.
fn word(x: f64, frame: &Frame) -> Markup {
    let (left, right, top) = (px(x - 4.0), px(x + 4.0), px(frame.top - 8.0));
    html! { path.word d=(format!("M{left} {top}H{right}L{} {}Z", px(x), px(frame.top - 1.0))) {} }
}

fn states(frame: &Frame) -> Markup {
    html! {
        text.tick.end x=(px(frame.left - 6.0)) y=(px(frame.top + 10.0)) { "touching" }
        text.tick.end x=(px(frame.left - 6.0)) y=(px(frame.bottom - 2.0)) { "other" }
        line.axis x1=(px(frame.left)) x2=(px(frame.left)) y1=(px(frame.top)) y2=(px(frame.bottom)) {}
    }
}

fn caption(section: &Section<'_>, outcome: &Outcome, words: bool) -> Markup {
    let design = section.design;
    html! {
        b { "Excitation (the paper's figure 6)." }
        " Seed " (outcome.figures.seed) ", each decision"
        @if let Some(stage) = &design.figure_from { ", from stage “" (stage) "” on" }
        @if let Some(stage) = &design.figure_to { ", to the end of “" (stage) "”" }
        ". Top: excitation of the most excited schema."
        @if let Some(touching) = &design.touching {
            " Bottom: whether the schema chosen predicts “" (touching) "”."
        }
        @if words { " Triangles: a word is heard." }
        @for peak in &design.peaks {
            " (" (peak.label) ") " (peak.stage)
            @if let Some(trial) = peak.trial { ", trial " (trial) }
            "."
        }
    }
}
