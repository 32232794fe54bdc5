//! Schemas over actions: how memory grows, stage by stage.

use maud::{Markup, html};

use crate::render::statistics::median;
use crate::run::{Outcome, Trace};

use super::plot::{COLOURS, Frame, both, curve, drawing, legend, px, steps, x_axis, y_axis};
use super::scale::Scale;
use super::section::{Group, Section};

/// Places along x at which the median over the seeds is taken.
const MEDIAN_POINTS: u32 = 300;
/// Bands narrower than this have no room for their number.
const BAND_LABEL_PX: f64 = 12.0;

/// A run as (actions, schemas).
type Points = Vec<(f64, f64)>;

/// The figure; none when no run has a step.
pub(super) fn figure(section: &Section<'_>) -> Option<Markup> {
    let runs: Vec<Vec<Points>> =
        section.groups.iter().map(|group| group.outcomes.iter().map(points).collect()).collect();
    let all = || runs.iter().flatten().flatten();
    let actions = all().map(|point| point.0).fold(0.0, f64::max);
    let schemas = all().map(|point| point.1).fold(0.0, f64::max);
    if actions == 0.0 {
        return None;
    }
    let trace = section.first().map(|outcome| &outcome.trace).filter(|_| section.groups.len() == 1);
    let figure = |width: f64| {
        let frame = Frame { left: 52.0, right: width - 10.0, top: 42.0, bottom: 256.0 };
        let x = Scale::linear(0.0, actions, frame.x());
        let y = Scale::linear(0.0, schemas * 1.05, frame.y());
        let content = html! {
            @if let Some(trace) = trace { (bands(trace, &frame, &x)) }
            (y_axis(&frame, &y, "schemas in memory"))
            (x_axis(&frame, &x, "actions carried out"))
            @if let Some(trace) = trace { (placements(trace, &frame, &x)) }
            @for (at, group) in runs.iter().enumerate() { (curves(group, at, runs.len() == 1, &x, &y)) }
        };
        drawing(width, 298.0, "schemas in memory over actions", &content)
    };
    Some(html! {
        figure {
            (both(figure))
            @if section.groups.len() > 1 { (legend(&section.groups.iter().map(Group::name).collect::<Vec<_>>())) }
            figcaption {
                b { "Schemas over actions." }
                @if section.groups.len() > 1 {
                    " Each line is a variant: the median over its seeds."
                } @else if runs.iter().flatten().count() > 1 {
                    " Thin: each seed. Bold: the median of the seeds."
                }
                @if let Some(trace) = trace {
                    " Bands are stages (of the first seed): " (stage_list(trace)) "."
                    " Ticks at the bottom are placements."
                }
            }
        }
    })
}

fn points(outcome: &Outcome) -> Points {
    let records = outcome.trace.steps.iter().map(|step| &step.record);
    #[expect(clippy::cast_precision_loss, reason = "counts far below 2^52")]
    let points = records.map(|record| (record.actions as f64, f64::from(record.schemas_total)));
    // Of several steps at one number of actions the last says what they left.
    let mut kept: Points = Vec::new();
    for point in points {
        match kept.last_mut() {
            Some(last) if (last.0 - point.0).abs() < 0.5 => *last = point,
            _ => kept.push(point),
        }
    }
    kept
}

fn curves(runs: &[Points], at: usize, alone: bool, x: &Scale, y: &Scale) -> Markup {
    let colour = at % COLOURS;
    html! {
        @if alone && runs.len() > 1 {
            @for run in runs { (steps(run, x, y, &format!("curve thin c{colour}"))) }
        }
        (curve(&middle(runs), x, y, &format!("curve bold c{colour}")))
    }
}

/// The median of the runs; the run itself when there is one. It ends where the first of them ends.
fn middle(runs: &[Points]) -> Points {
    let [only] = runs else {
        let end = runs.iter().filter_map(|run| run.last()).map(|last| last.0).fold(f64::INFINITY, f64::min);
        if !end.is_finite() {
            return Vec::new();
        }
        let at = |n: u32| end * f64::from(n) / f64::from(MEDIAN_POINTS);
        let values = |x: f64| runs.iter().filter_map(|run| value_at(run, x)).collect();
        return (0..=MEDIAN_POINTS).filter_map(|n| Some((at(n), median(values(at(n)))?))).collect();
    };
    only.clone()
}

/// What a run had after so many actions.
fn value_at(run: &Points, actions: f64) -> Option<f64> {
    let after = run.partition_point(|point| point.0 <= actions);
    run.get(after.saturating_sub(1)).map(|point| point.1)
}

/// Where each stage begins and ends, in actions.
fn stages(trace: &Trace) -> Vec<(u32, f64, f64)> {
    let mut stages: Vec<(u32, f64, f64)> = Vec::new();
    for record in trace.steps.iter().map(|step| &step.record) {
        #[expect(clippy::cast_precision_loss, reason = "counts far below 2^52")]
        let actions = record.actions as f64;
        match stages.last_mut() {
            Some((stage, _, to)) if *stage == record.stage => *to = actions,
            last => {
                let from = last.map_or(0.0, |(_, _, to)| {
                    *to = actions;
                    actions
                });
                stages.push((record.stage, from, actions));
            }
        }
    }
    stages
}

fn bands(trace: &Trace, frame: &Frame, x: &Scale) -> Markup {
    html! {
        @for (at, (stage, from, to)) in stages(trace).into_iter().enumerate() {
            @let (left, right) = (x.at(from), x.at(to));
            rect class=(if at % 2 == 0 { "band" } else { "band odd" }) x=(px(left)) y=(px(frame.top))
                width=(px(right - left)) height=(px(frame.bottom - frame.top)) {}
            @if right - left >= BAND_LABEL_PX {
                text.tick.middle x=(px(f64::midpoint(left, right))) y=(px(frame.top - 6.0)) { (stage + 1) }
            }
        }
    }
}

fn stage_list(trace: &Trace) -> String {
    let named = trace.stages.iter().enumerate().map(|(at, name)| format!("{} {name}", at + 1));
    named.collect::<Vec<_>>().join(", ")
}

fn placements(trace: &Trace, frame: &Frame, x: &Scale) -> Markup {
    html! {
        @for trial in trace.trials().iter().filter(|trial| !trial.drawn.is_empty()) {
            @let at = {
                #[expect(clippy::cast_precision_loss, reason = "counts far below 2^52")]
                let actions = trial.begun_at as f64;
                px(x.at(actions))
            };
            line.placement x1=(at) x2=(at) y1=(px(frame.bottom)) y2=(px(frame.bottom - 5.0)) {}
        }
    }
}
