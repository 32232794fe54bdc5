//! Figure 6 of the paper: how excited the learner is, and what by.

use maud::{Markup, html};

use crate::design::Peak;
use crate::run::{Outcome, Trace, TracedStep};

use super::plot::{Frame, both, curve, drawing, px, steps, x_axis, y_axis};
use super::scale::Scale;
use super::section::Section;

/// Room that the label of a peak needs.
const PEAK_LABEL_PX: f64 = 14.0;

/// The figure, of the first seed of the experiment as it stands; none without a decision.
pub(super) fn figure(section: &Section<'_>) -> Option<Markup> {
    let outcome = section.first()?;
    let steps_shown = shown(section, &outcome.trace);
    let top: Vec<(f64, f64)> = steps_shown.iter().map(|(at, step)| (*at, excitation(step))).collect();
    let highest = top.iter().map(|point| point.1).fold(0.0, f64::max);
    let last = top.last()?.0;
    let touching = |(at, step): &(f64, &TracedStep)| (*at, f64::from(u8::from(step.touching)));
    let touching: Option<Vec<(f64, f64)>> =
        section.design.touching.as_ref().map(|_| steps_shown.iter().map(touching).collect());
    let peaks = peaks(section, &outcome.trace, &steps_shown);
    let heard = steps_shown.iter().filter(|(_, step)| !step.record.heard.is_empty());
    let heard: Vec<f64> = heard.map(|(at, _)| *at).collect();
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

/// The steps that decided something, in the stages that the figure is about; numbered from 0.
fn shown<'a>(section: &Section<'_>, trace: &'a Trace) -> Vec<(f64, &'a TracedStep)> {
    let place = |name: &Option<String>| trace.stage_index(name.as_deref()?);
    let begins = place(&section.design.figure_from).unwrap_or(0);
    let ends = place(&section.design.figure_to).unwrap_or(u32::MAX);
    let steps = trace.steps.iter().filter(|step| (begins..=ends).contains(&step.record.stage));
    let decided = steps.filter(|step| step.record.decision.is_some());
    #[expect(clippy::cast_precision_loss, reason = "numbers of steps")]
    decided.enumerate().map(|(at, step)| (at as f64, step)).collect()
}

fn excitation(step: &TracedStep) -> f64 {
    step.record.decision.as_ref().map_or(0.0, |decision| decision.excitation_top)
}

/// Labels and where they stand.
fn peaks(section: &Section<'_>, trace: &Trace, steps: &[(f64, &TracedStep)]) -> Vec<(String, f64)> {
    let place = |peak: &Peak| {
        let stage = trace.stage_index(&peak.stage)?;
        let is_at = |step: &TracedStep| {
            step.record.stage == stage && peak.trial.is_none_or(|trial| step.record.trial == trial)
        };
        let (at, _) = steps.iter().find(|(_, step)| is_at(step))?;
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
        " Seed " (outcome.results.seed) ", each decision"
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
