//! Measures over a value that was swept.

use maud::{Markup, html};

use crate::render::statistics::{Summary, interval, summary};
use crate::run::{Reading, Unit};

use super::plot::{COLOURS, Frame, both, curve, drawing, legend, px, x_axis, y_axis};
use super::scale::Scale;
use super::{Group, Section};

/// One measure over the value swept.
struct Line {
    name: String,
    unit: Unit,
    points: Vec<(f64, Summary)>,
}

/// The figures: shares on one, everything else on one each; none when nothing was swept.
pub(super) fn figures(section: &Section<'_>) -> Option<Markup> {
    let sweep = section.design.sweep.as_ref()?;
    let measures = &section.groups.first()?.figures.first()?.measures;
    let line = |at: usize, measure: &Reading| {
        let point = |group: &Group<'_>| {
            let values = group.figures.iter().filter_map(|figures| figures.measures.get(at)?.value).collect();
            Some((group.condition.swept?, summary(values)?))
        };
        let mut points: Vec<_> = section.groups.iter().filter_map(point).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        Line { name: measure.name.clone(), unit: measure.unit, points }
    };
    let numbered = || measures.iter().enumerate();
    let shares = numbered().filter(|(_, m)| m.unit == Unit::Share).map(|(at, m)| line(at, m));
    let shares: Vec<_> = shares.filter(|line| !line.points.is_empty()).collect();
    let others = numbered().filter(|(_, m)| m.unit != Unit::Share).map(|(at, m)| vec![line(at, m)]);
    let drawn = [shares].into_iter().chain(others).filter(|lines| lines.iter().any(|l| !l.points.is_empty()));
    let seeds = section.groups.iter().map(|group| group.figures.len()).max().unwrap_or(0);
    Some(html! { @for lines in drawn { (figure(&sweep.name, &lines, seeds)) } })
}

fn figure(swept: &str, lines: &[Line], seeds: usize) -> Markup {
    let points = || lines.iter().flat_map(|line| &line.points);
    let (low, high) = points()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (at, _)| (low.min(*at), high.max(*at)));
    let is_share = lines.iter().all(|line| line.unit == Unit::Share);
    let highest = points().map(|(_, summary)| summary.high).fold(if is_share { 1.0 } else { 1e-9 }, f64::max);
    let draw = |width: f64| {
        let frame = Frame { left: 52.0, right: width - 14.0, top: 36.0, bottom: 226.0 };
        let x = Scale::linear(low, high, frame.x());
        let y = Scale::linear(0.0, highest * 1.02, frame.y());
        let content = html! {
            (y_axis(&frame, &y, if is_share { "share" } else { "" }))
            (x_axis(&frame, &x, swept))
            @for (at, line) in lines.iter().enumerate() {
                @let colour = at % COLOURS;
                @for (value, summary) in &line.points { (bar(x.at(*value), summary, &y, colour)) }
                (curve(&line.points.iter().map(|(v, s)| (*v, s.median)).collect::<Vec<_>>(), &x, &y, &format!("curve bold c{colour}")))
            }
        };
        drawing(width, 268.0, &format!("measures over {swept}"), &content)
    };
    let entries: Vec<_> = lines
        .iter()
        .enumerate()
        .map(|(at, line)| (format!("curve bold c{}", at % COLOURS), line.name.clone()))
        .collect();
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
