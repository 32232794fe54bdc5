//! Figures of runs, beside the published ones, for people.

use crate::render::statistics::{Summary, interval, summary};
use crate::render::table::Columns;
use crate::render::words::{count, duration};
use crate::run::{Results, Unit};

use super::comparison::number;

/// One run.
pub(crate) fn one(f: &Results) -> String {
    let mut table = Columns::new(&["", "this run", "published"]).figures(&[1, 2]);
    let published = f.published.as_ref();
    let or_dash = |n: Option<u32>| n.map_or_else(|| "-".to_owned(), |n| n.to_string());
    let mut row =
        |what: &str, ours: String, theirs: Option<u32>| table.row([what.to_owned(), ours, or_dash(theirs)]);
    row("schemas", f.schemas_total.to_string(), published.and_then(|p| p.schemas_total));
    row("  generalised", f.schemas_generalised.to_string(), None);
    row("  counter-examples", f.counter_examples.to_string(), None);
    let placements = match f.generalised_after_placement {
        Some(_) => "placements until it generalised",
        None => "placements, never generalised",
    };
    row(placements, f.placements.to_string(), published.and_then(|p| p.placements));
    if f.probe.placements_tried > 0 {
        let share = |n: u32| format!("{n} of {}", f.probe.placements_tried);
        row("touched afterwards, learning frozen", share(f.probe.touched), None);
        row("  with the first action", share(f.probe.touched_first_try), None);
    }
    row("actions", f.actions_total.to_string(), None);
    row("a step takes, median", format!("{:.0} us", f.step_latency_us_p50), None);
    row("  99th percentile", format!("{:.0} us", f.step_latency_us_p99), None);
    row("time", duration(f.wall_s), None);
    let text = table.text(&[0, 1, 2]);
    format!("{text}{}\nmemory digest {}\n", measures(f), f.memory_digest)
}

/// What else was read off a run.
fn measures(f: &Results) -> String {
    if f.measures.is_empty() {
        return String::new();
    }
    let mut table = Columns::new(&["measured", "this run", "published"]).figures(&[1]);
    for measure in &f.measures {
        let unit = if measure.unit == Unit::Share { " %" } else { "" };
        let value = measure.value.map(|value| number(value, measure.unit) + unit);
        let or_dash = |text: Option<String>| text.unwrap_or_else(|| "-".to_owned());
        table.row([measure.name.clone(), or_dash(value), or_dash(measure.published.clone())]);
    }
    format!("\n{}", table.text(&[1]))
}

/// A column of the table of several runs: its heading, its decimals, and the figure of a run.
type RunColumn = (&'static str, usize, fn(&Results) -> f64);

const COLUMNS: [RunColumn; 8] = [
    ("schemas", 0, |f| f.schemas_total.into()),
    ("placements", 0, |f| f.placements.into()),
    ("tried", 0, |f| f.probe.placements_tried.into()),
    ("1st try", 0, |f| f.probe.touched_first_try.into()),
    ("touched", 0, |f| f.probe.touched.into()),
    #[expect(clippy::cast_precision_loss, reason = "shown, and far below 2^52")]
    ("actions", 0, |f| f.actions_total as f64),
    ("p99 us", 0, |f| f.step_latency_us_p99),
    ("s", 1, |f| f.wall_s),
];

/// Several runs that differ in their seeds.
pub(crate) fn several(runs: &[&Results]) -> String {
    let headings: Vec<_> = ["seed"].into_iter().chain(COLUMNS.map(|(heading, ..)| heading)).collect();
    let all: Vec<usize> = (0..headings.len()).collect();
    let mut table = Columns::new(&headings).figures(&all);
    for run in runs {
        let figures = COLUMNS.map(|(_, decimals, of)| format!("{:.decimals$}", of(run)));
        table.row([run.seed.to_string()].into_iter().chain(figures));
    }
    let summaries =
        COLUMNS.map(|(_, decimals, of)| (decimals, summary(runs.iter().map(|run| of(run)).collect())));
    for (end, name) in ["median", "from", "to"].into_iter().enumerate() {
        let cell = |(decimals, summary): &(usize, Option<Summary>)| {
            summary.map_or_else(|| "-".to_owned(), |summary| format!("{:.decimals$}", summary.ends()[end]))
        };
        table.row([name.to_owned()].into_iter().chain(summaries.iter().map(cell)));
    }
    let published =
        runs.first().and_then(|run| run.published.as_ref()).map_or_else(String::new, |published| {
            let schemas = published.schemas_total.map(|n| count(n, "schema"));
            let placements = published.placements.map(|n| count(n, "placement"));
            let all: Vec<_> = schemas.into_iter().chain(placements).collect();
            format!("published: {}\n", all.join(", "))
        });
    format!("{}\nfrom, to: {}\n{published}", table.text(&all), interval(runs.len()))
}
