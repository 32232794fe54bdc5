//! How long a step takes as memory grows.

use maud::{Markup, html};

use crate::render::statistics::percentile;

use super::plot::{Frame, both, curve, drawing, legend, px, x_axis, y_axis};
use super::scale::Scale;
use super::section::Section;

/// Sizes of memory told apart.
const BINS: usize = 24;
/// Steps of a bin that are enough for a 99th percentile.
const STEPS_MIN: usize = 100;
/// What the goal is, in µs.
const GOAL_US: f64 = 1_000.0;

/// Steps at about one size of memory.
struct Bin {
    schemas: f64,
    p50_us: f64,
    p99_us: f64,
}

/// The figure, of all seeds of the experiment as it stands; none when too few steps were taken.
pub(super) fn figure(section: &Section<'_>) -> Option<Markup> {
    let group = section.groups.first()?;
    let records = group.outcomes.iter().flat_map(|outcome| &outcome.trace.steps).map(|step| &step.record);
    let decided = records.filter(|record| record.decision.is_some());
    let bins = bins(decided.map(|record| (record.schemas_total, record.latency_us)).collect());
    if bins.len() < 2 {
        return None;
    }
    let most = bins.iter().map(|bin| bin.schemas).fold(1.0, f64::max);
    let slowest = bins.iter().map(|bin| bin.p99_us).fold(GOAL_US, f64::max);
    let quickest = bins.iter().map(|bin| bin.p50_us).fold(GOAL_US, f64::min);
    let points = |of: fn(&Bin) -> f64| -> Vec<_> { bins.iter().map(|bin| (bin.schemas, of(bin))).collect() };
    let figure = |width: f64| {
        let frame = Frame { left: 52.0, right: width - 10.0, top: 36.0, bottom: 226.0 };
        let x = Scale::linear(0.0, most, frame.x());
        let y = Scale::logarithmic(quickest / 1.5, slowest * 1.5, frame.y());
        let goal = px(y.at(GOAL_US));
        let content = html! {
            (y_axis(&frame, &y, "time of a step (µs, logarithmic)"))
            (x_axis(&frame, &x, "schemas in memory"))
            line.goal x1=(px(frame.left)) x2=(px(frame.right)) y1=(goal) y2=(goal) {}
            text.tick.end x=(px(frame.right)) y=(px(y.at(GOAL_US) - 4.0)) { "1 ms" }
            (curve(&points(|bin| bin.p50_us), &x, &y, "curve bold c0"))
            (curve(&points(|bin| bin.p99_us), &x, &y, "curve bold c1"))
        };
        drawing(width, 268.0, "time of a step over schemas in memory", &content)
    };
    Some(html! {
        figure {
            (both(figure))
            (legend(&["median", "99th percentile"]))
            figcaption {
                b { "Time of a step." }
                " From the frame decoded to the reply sent, over the number of schemas in memory, all seeds together; \
                 up to " (BINS) " ranges of it, each with at least " (STEPS_MIN) " steps."
            }
        }
    })
}

/// As many bins as there are steps for. Steps at one size of memory are never divided.
fn bins(mut steps: Vec<(u32, f64)>) -> Vec<Bin> {
    steps.sort_by_key(|step| step.0);
    let size = steps.len().div_ceil(BINS).max(STEPS_MIN);
    let mut bins = Vec::new();
    let mut open: Vec<(u32, f64)> = Vec::new();
    for alike in steps.chunk_by(|a, b| a.0 == b.0) {
        open.extend(alike);
        if open.len() >= size {
            bins.extend(bin(&std::mem::take(&mut open)));
        }
    }
    bins
}

fn bin(steps: &[(u32, f64)]) -> Option<Bin> {
    let mut times: Vec<f64> = steps.iter().map(|step| step.1).collect();
    times.sort_by(f64::total_cmp);
    let schemas = steps.get(steps.len() / 2)?.0;
    Some(Bin { schemas: schemas.into(), p50_us: percentile(&times, 0.5)?, p99_us: percentile(&times, 0.99)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_are_full_and_in_order() {
        let steps = (0..10_000_u32).rev().map(|n| (n, f64::from(n % 10))).collect();
        let bins = bins(steps);
        assert_eq!(bins.len(), BINS - 1, "the last, which is not full, is left out");
        assert!(bins.is_sorted_by(|a, b| a.schemas < b.schemas));
        assert!(bins.iter().all(|bin| bin.p50_us <= bin.p99_us && bin.p99_us <= 9.0));
        assert!(super::bins(vec![(1, 1.0); STEPS_MIN - 1]).is_empty());
        assert_eq!(super::bins(vec![(1, 1.0); 10_000]).len(), 1, "one size is one bin");
    }
}
