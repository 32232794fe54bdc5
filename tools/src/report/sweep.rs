//! Measures over a value that was swept.

use maud::{Markup, html};

use crate::render::statistics::{Summary, interval};
use crate::run::{Reading, Unit};

use super::plot::{COLOURS, Frame, both, curve, drawing, legend, px, x_axis, y_axis};
use super::scale::Scale;
use super::section::{Group, Section};

/// One measure over the value swept.
struct SweptMeasure {
    name: String,
    unit: Unit,
    points: Vec<(f64, Summary)>,
}

/// The figures: shares on one, everything else on one each; none when nothing was swept.
pub(super) fn figures(section: &Section<'_>) -> Option<Markup> {
    let (swept_value, _) = section.design.sweep.first_key_value()?;
    let swept = |(at, measure): (usize, &Reading)| {
        let point = |group: &Group<'_>| Some((group.condition.swept?, group.measured(at)?));
        let mut points: Vec<_> = section.groups.iter().filter_map(point).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        SweptMeasure { name: measure.name.clone(), unit: measure.unit, points }
    };
    let all = section.measures().iter().enumerate().map(swept).filter(|measure| !measure.points.is_empty());
    let (shares, others): (Vec<_>, Vec<_>) = all.partition(|measure| measure.unit == Unit::Share);
    let drawn = [shares].into_iter().chain(others.into_iter().map(|measure| vec![measure]));
    let drawn = drawn.filter(|measures| !measures.is_empty());
    Some(html! { @for measures in drawn { (figure(swept_value, &measures, section.seeds())) } })
}

fn figure(swept: &str, measures: &[SweptMeasure], seeds: usize) -> Markup {
    let points = || measures.iter().flat_map(|measure| &measure.points);
    let (low, high) = points()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (at, _)| (low.min(*at), high.max(*at)));
    let is_share = measures.iter().all(|measure| measure.unit == Unit::Share);
    let highest = points().map(|(_, summary)| summary.high).fold(if is_share { 1.0 } else { 1e-9 }, f64::max);
    let draw = |width: f64| {
        let frame = Frame { left: 52.0, right: width - 14.0, top: 36.0, bottom: 226.0 };
        let x = Scale::linear(low, high, frame.x());
        let y = Scale::linear(0.0, highest * 1.02, frame.y());
        let content = html! {
            (y_axis(&frame, &y, if is_share { "share" } else { "" }))
            (x_axis(&frame, &x, swept))
            @for (at, measure) in measures.iter().enumerate() {
                @let colour = at % COLOURS;
                @for (value, summary) in &measure.points { (bar(x.at(*value), summary, &y, colour)) }
                (curve(&measure.points.iter().map(|(v, s)| (*v, s.median)).collect::<Vec<_>>(), &x, &y, &format!("curve bold c{colour}")))
            }
        };
        drawing(width, 268.0, &format!("measures over {swept}"), &content)
    };
    let entries: Vec<_> = measures.iter().map(|measure| measure.name.as_str()).collect();
    html! {
        figure {
            (both(draw))
            (legend(&entries))
            figcaption {
                b { "Measures over " (swept) "." }
                " Median of " (seeds) " seeds; bars: " (interval(seeds)) "."
            }
        }
    }
}

fn bar(x: f64, summary: &Summary, y: &Scale, colour: usize) -> Markup {
    let class = format!("curve c{colour}");
    html! {
        line class=(class) x1=(px(x)) x2=(px(x)) y1=(px(y.at(summary.low))) y2=(px(y.at(summary.high))) {}
        circle class=(format!("dot c{colour}")) cx=(px(x)) cy=(px(y.at(summary.median))) r="3.5" {}
    }
}
