//! Figures of runs, beside the published ones, for people.

use crate::render::statistics::{interval, summary};
use crate::render::table::Columns;
use crate::render::words::{count, duration};
use crate::run::Results;

use super::comparison::shown;

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
    if let Some(placements) = f.placements {
        let what = match f.generalised_after_placement {
            Some(_) => "placements until it generalised",
            None => "placements, never generalised",
        };
        row(what, placements.to_string(), published.and_then(|p| p.placements));
    }
    if let Some(probe) = &f.probe {
        let share = |n: u32| format!("{n} of {}", probe.placements_tried);
        row("touched afterwards, learning frozen", share(probe.touched), None);
        row("  with the first action", share(probe.touched_first_try), None);
    }
    row("actions", f.actions_total.to_string(), None);
    row("a step takes, median", format!("{:.0} us", f.step_latency_us_p50), None);
    row("  99th percentile", format!("{:.0} us", f.step_latency_us_p99), None);
    row("time", duration(f.wall_s), None);
    let text = table.text(&[0, 1, 2]);
    format!("{text}{}\nmemory digest {}\n", measures(&[f]), f.memory_digest)
}

/// What else was read off the runs: of one its figure, of several the median and its interval.
fn measures(runs: &[&Results]) -> String {
    let Some(first) = runs.first().filter(|run| !run.measures.is_empty()) else { return String::new() };
    let these = if runs.len() == 1 { "this run" } else { "these runs" };
    let mut table = Columns::new(&["measured", these, "published"]).figures(&[1]);
    for (at, measure) in first.measures.iter().enumerate() {
        let ours = runs.iter().filter_map(|run| run.measures.get(at)?.value);
        let published = measure.published.clone().unwrap_or_else(|| "-".to_owned());
        table.row([measure.name.clone(), shown(summary(ours.collect()), measure.unit), published]);
    }
    format!("\n{}", table.text(&[1]))
}

/// A column of the table of several runs: its heading, its decimals, and the figure of a run; none where the run did not measure
/// it.
type RunColumn = (&'static str, usize, fn(&Results) -> Option<f64>);

const COLUMNS: [RunColumn; 8] = [
    ("schemas", 0, |f| Some(f.schemas_total.into())),
    ("placements", 0, |f| f.placements.map(f64::from)),
    ("tried", 0, |f| Some(f.probe?.placements_tried.into())),
    ("1st try", 0, |f| Some(f.probe?.touched_first_try.into())),
    ("touched", 0, |f| Some(f.probe?.touched.into())),
    #[expect(clippy::cast_precision_loss, reason = "shown, and far below 2^52")]
    ("actions", 0, |f| Some(f.actions_total as f64)),
    ("p99 us", 0, |f| Some(f.step_latency_us_p99)),
    ("s", 1, |f| Some(f.wall_s)),
];

/// Several runs that differ in their seeds. A figure that none of them measured has no column.
pub(crate) fn several(runs: &[&Results]) -> String {
    let measured = |(_, _, of): &RunColumn| runs.iter().any(|run| of(run).is_some());
    let columns: Vec<RunColumn> = COLUMNS.into_iter().filter(measured).collect();
    let headings: Vec<_> = ["seed"].into_iter().chain(columns.iter().map(|(heading, ..)| *heading)).collect();
    let all: Vec<usize> = (0..headings.len()).collect();
    let mut table = Columns::new(&headings).figures(&all);
    let cell = |figure: Option<f64>, decimals: usize| {
        figure.map_or_else(|| "-".to_owned(), |figure| format!("{figure:.decimals$}"))
    };
    for run in runs {
        let figures = columns.iter().map(|(_, decimals, of)| cell(of(run), *decimals));
        table.row([run.seed.to_string()].into_iter().chain(figures));
    }
    let over = |of: fn(&Results) -> Option<f64>| summary(runs.iter().filter_map(|run| of(run)).collect());
    let summaries: Vec<_> = columns.iter().map(|(_, decimals, of)| (*decimals, over(*of))).collect();
    for (end, name) in ["median", "from", "to"].into_iter().enumerate() {
        let figures =
            summaries.iter().map(|(decimals, over)| cell(over.map(|over| over.ends()[end]), *decimals));
        table.row([name.to_owned()].into_iter().chain(figures));
    }
    let published =
        runs.first().and_then(|run| run.published.as_ref()).map_or_else(String::new, |published| {
            let schemas = published.schemas_total.map(|n| count(n, "schema"));
            let placements = published.placements.map(|n| count(n, "placement"));
            let all: Vec<_> = schemas.into_iter().chain(placements).collect();
            format!("published: {}\n", all.join(", "))
        });
    let (figures, measures) = (table.text(&all), measures(runs));
    let ends = if measures.is_empty() { "from, to" } else { "from, to, and in brackets" };
    format!("{figures}{measures}\n{ends}: {}\n{published}", interval(runs.len()))
}
