//! Figures of runs, beside the published ones, for people.

use crate::run::Figures;

use super::table::Columns;
use super::words::{count, duration};

/// One run.
pub(crate) fn one(f: &Figures) -> String {
    let mut table = Columns::new(&["", "this run", "published"]).figures(&[1, 2]);
    let published = |get: fn(&crate::run::Published) -> u32| f.published.as_ref().map(get);
    let or_dash = |n: Option<u32>| n.map_or_else(|| "-".to_owned(), |n| n.to_string());
    let mut row =
        |what: &str, ours: String, theirs: Option<u32>| table.row([what.to_owned(), ours, or_dash(theirs)]);
    row("schemas", f.schemas_total.to_string(), published(|p| p.schemas_total));
    row("  generalised", f.schemas_generalised.to_string(), None);
    row("  counter-examples", f.counter_examples.to_string(), None);
    let placements = match f.generalised_after_placement {
        Some(_) => "placements until it generalised",
        None => "placements, never generalised",
    };
    row(placements, f.placements.to_string(), published(|p| p.placements));
    if f.probe.placements_tried > 0 {
        let share = |n: u32| format!("{n} of {}", f.probe.placements_tried);
        row("touched afterwards, learning frozen", share(f.probe.touched), None);
        row("  with the first action", share(f.probe.touched_first_try), None);
    }
    row("actions", f.actions_total.to_string(), None);
    row("a step takes, median", format!("{:.0} us", f.step_latency_us_p50), None);
    row("  99th percentile", format!("{:.0} us", f.step_latency_us_p99), None);
    row("time", duration(f.wall_s), None);
    format!("{}\nmemory digest {}\n", table.text(&[0, 1, 2]), f.memory_digest)
}

/// Several runs that differ in their seeds.
pub(crate) fn several(runs: &[Figures]) -> String {
    let headings = ["seed", "schemas", "placements", "tried", "1st try", "touched", "actions", "p99 us", "s"];
    let mut table = Columns::new(&headings).figures(&[0, 1, 2, 3, 4, 5, 6, 7, 8]);
    let measures: [fn(&Figures) -> Option<f64>; 8] = [
        |f| Some(f.schemas_total.into()),
        |f| Some(f.placements.into()),
        |f| Some(f.probe.placements_tried.into()),
        |f| Some(f.probe.touched_first_try.into()),
        |f| Some(f.probe.touched.into()),
        #[expect(clippy::cast_precision_loss, reason = "shown, and far below 2^52")]
        |f| Some(f.actions_total as f64),
        |f| Some(f.step_latency_us_p99),
        |f| Some(f.wall_s),
    ];
    let decimals = [0, 0, 0, 0, 0, 0, 0, 1];
    let cell = |value: Option<f64>, decimals: usize| {
        value.map_or_else(|| "-".to_owned(), |value| format!("{value:.decimals$}"))
    };
    for run in runs {
        let figures = measures.iter().zip(decimals).map(|(measure, decimals)| cell(measure(run), decimals));
        table.row([run.seed.to_string()].into_iter().chain(figures));
    }
    let all: Vec<_> =
        measures.iter().map(|measure| summary(runs.iter().filter_map(measure).collect())).collect();
    for (end, name) in ["median", "from", "to"].into_iter().enumerate() {
        let figures = all.iter().zip(decimals);
        let figures = figures.map(|(summary, decimals)| cell(summary.map(|s| s.ends()[end]), decimals));
        table.row([name.to_owned()].into_iter().chain(figures));
    }
    let interval = match order_statistic(runs.len()) {
        Some(_) => "from, to: the 95 % interval of the median",
        None => "from, to: the smallest and the largest (fewer than 6 runs give no 95 % interval)",
    };
    let published = runs.first().and_then(|run| run.published).map_or_else(String::new, |published| {
        let (schemas, placements) = (published.schemas_total, count(published.placements, "placement"));
        format!("published: {schemas} schemas, {placements}\n")
    });
    format!("{}\n{interval}\n{published}", table.text(&[0, 1, 2, 3, 4, 5, 6, 7, 8]))
}

/// The middle of some figures, and how sure it is.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Summary {
    median: f64,
    low: f64,
    high: f64,
}

impl Summary {
    fn ends(self) -> [f64; 3] {
        [self.median, self.low, self.high]
    }
}

/// `None` for no figures.
fn summary(mut figures: Vec<f64>) -> Option<Summary> {
    figures.sort_by(f64::total_cmp);
    let (n, first, last) = (figures.len(), *figures.first()?, *figures.last()?);
    let median = (figures[(n - 1) / 2] + figures[n / 2]) / 2.0;
    let (low, high) = order_statistic(n).map_or((first, last), |at| (figures[at], figures[n - 1 - at]));
    Some(Summary { median, low, high })
}

/// How many of `n` figures to leave out at each end so that the rest still covers the median of what they were
/// drawn from with at least 95 %, whatever its distribution; `None` when even all of them do not.
fn order_statistic(n: usize) -> Option<usize> {
    // P(at most k of n below the median) for k = 0, 1, …: the binomial distribution with p = 1/2.
    let mut term = 0.5_f64.powi(i32::try_from(n).ok()?);
    let (mut tail, mut out) = (0.0, None);
    for k in 0..n / 2 {
        tail += term;
        if tail > 0.025 {
            break;
        }
        out = Some(k);
        #[expect(clippy::cast_precision_loss, reason = "numbers of runs")]
        let ratio = (n - k) as f64 / (k + 1) as f64;
        term *= ratio;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_of_the_median_is_the_textbooks() {
        // Tables of the sign test: 6 figures, the extremes; 10, the 2nd and 9th; 20, the 6th and 15th; 5 none.
        assert_eq!([5, 6, 10, 20].map(order_statistic), [None, Some(0), Some(1), Some(5)]);
        assert_eq!(order_statistic(0), None);
    }

    #[test]
    fn a_summary_has_the_middle_and_the_ends() {
        assert_eq!(summary(Vec::new()), None);
        assert_eq!(summary(vec![3.0, 1.0]), Some(Summary { median: 2.0, low: 1.0, high: 3.0 }));
        let ten = (1..=10).map(f64::from).collect();
        assert_eq!(summary(ten), Some(Summary { median: 5.5, low: 2.0, high: 9.0 }));
    }
}
