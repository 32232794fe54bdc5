//! How long a step takes, learning included, as memory grows: frame in, action chosen. The learner lives in worlds of its
//! own (`worlds.rs`), so that no body and no transport is in the figure.

use std::collections::BTreeMap;
use std::time::Instant;

use serde::Serialize;

use super::Times;
use super::worlds::{Mix, World};
use crate::cli::BenchDecisionArgs;
use crate::failure::Failure;
use crate::output;
use crate::render::table::Columns;
use crate::talk;

/// Steps that are measured at each size.
const STEPS: usize = 5_000;
/// What is wanted of the 99th percentile: so many microseconds up to so many schemas.
const WANTED: [(usize, f64); 2] = [(20_000, 100.0), (1_000_000, 1_000.0)];
/// Between these sizes it is measured how times grow.
const GROWTH: (usize, usize) = (10_000, 1_000_000);
/// What is wanted of the exponent.
const GROWTH_WANTED: f64 = 0.25;

#[derive(Debug, Serialize)]
struct Row {
    mix: &'static str,
    /// Schemas when measuring began.
    schemas: usize,
    generalised: u32,
    observations: usize,
    steps: usize,
    step_us_p50: f64,
    step_us_p99: f64,
    /// Of the median, to that of the smallest memory of the mix.
    ratio_p50: f64,
    /// Of the process, less what it had before: `null` while that is too little to tell.
    bytes_per_schema: Option<f64>,
    step_us_p99_wanted: Option<f64>,
}

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct Figures {
    rows: Vec<Row>,
    /// By mix: the exponent of the power of the number of schemas that the median grows by; `null` where memory was
    /// not measured both at 10,000 schemas and above.
    growth_exponent: BTreeMap<&'static str, Option<f64>>,
    growth_exponent_wanted: f64,
}

pub(super) fn run(args: &BenchDecisionArgs, quiet: bool) -> Result<(), Failure> {
    let mut sizes = args.schemas.clone();
    sizes.sort_unstable();
    sizes.dedup();
    let mut rows = Vec::new();
    let mut growth_exponent = BTreeMap::new();
    for mix in Mix::ALL.into_iter().filter(|mix| args.mix.as_ref().is_none_or(|name| name == mix.name())) {
        if !quiet {
            talk::say(&format!("{}: a life up to {} schemas", mix.name(), sizes.last().unwrap_or(&0)));
        }
        let measured = life(mix, &sizes, args.seed)?;
        growth_exponent.insert(mix.name(), exponent(&measured));
        rows.extend(measured);
    }
    let figures = Figures { rows, growth_exponent, growth_exponent_wanted: GROWTH_WANTED };
    if args.json { output::print_json(&figures) } else { output::print(&text(&figures)) }
}

/// One life, measured whenever memory has come to one of `sizes`.
fn life(mix: Mix, sizes: &[usize], seed: u64) -> Result<Vec<Row>, Failure> {
    let resident_before = resident_bytes();
    let mut world = World::new(mix, seed).map_err(Failure::of)?;
    let mut rows: Vec<Row> = Vec::new();
    for size in sizes {
        while schemas(&world) < *size {
            step(&mut world);
        }
        let (at, mut times) = (schemas(&world), Times::default());
        // A small memory would be a larger one before that many steps are over.
        for _ in 0..STEPS.min(at.max(200) * 5) {
            times.push(step(&mut world));
        }
        let content = world.learner().memory().content();
        let grown = resident_bytes().zip(resident_before).map(|(now, before)| now.saturating_sub(before));
        let step_us_p50 = times.at(0.5);
        rows.push(Row {
            mix: mix.name(),
            schemas: at,
            generalised: content.generalised_count,
            observations: content.observations.len(),
            steps: times.0.len(),
            step_us_p50,
            step_us_p99: times.at(0.99),
            ratio_p50: step_us_p50 / rows.first().map_or(step_us_p50, |first| first.step_us_p50),
            bytes_per_schema: grown
                .filter(|_| at >= GROWTH.0)
                .map(|bytes| bytes as f64 / content.schemas.len() as f64),
            step_us_p99_wanted: WANTED.iter().find(|(most, _)| *size <= *most).map(|(_, wanted)| *wanted),
        });
    }
    Ok(rows)
}

fn schemas(world: &World) -> usize {
    world.learner().memory().content().schemas.len()
}

/// One step; returns how long the learner took.
fn step(world: &mut World) -> std::time::Duration {
    let frame = world.frame();
    let began = Instant::now();
    let step = world.learner_mut().step(&frame);
    let took = began.elapsed();
    world.follow(&step.output);
    took
}

/// The exponent of growth from 10,000 schemas to the largest memory measured, up to a million.
fn exponent(rows: &[Row]) -> Option<f64> {
    let from = rows.iter().find(|row| row.schemas >= GROWTH.0)?;
    let to = rows.iter().rfind(|row| row.schemas <= GROWTH.1 + GROWTH.1 / 10)?;
    let times = to.schemas as f64 / from.schemas as f64;
    (times > 1.5).then(|| (to.step_us_p50 / from.step_us_p50).ln() / times.ln())
}

/// Memory of this process that is in RAM.
fn resident_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let kilobytes = status.lines().find_map(|line| line.strip_prefix("VmRSS:")?.strip_suffix("kB"))?;
    kilobytes.trim().parse::<u64>().ok()?.checked_mul(1024)
}

fn text(figures: &Figures) -> String {
    let headings = ["mix", "schemas", "laws", "step p50", "p99", "p99 wanted", "ratio", "bytes/schema"];
    let mut table = Columns::new(&headings).figures(&[1, 2, 3, 4, 5, 6, 7]);
    for row in &figures.rows {
        table.row([
            row.mix.to_owned(),
            row.schemas.to_string(),
            row.generalised.to_string(),
            format!("{:.1} us", row.step_us_p50),
            format!("{:.1} us", row.step_us_p99),
            row.step_us_p99_wanted.map_or(String::new(), |wanted| format!("{wanted:.0} us")),
            format!("{:.2}", row.ratio_p50),
            row.bytes_per_schema.map_or(String::new(), |bytes| format!("{bytes:.0}")),
        ]);
    }
    let mut text = table.text(&[0]);
    for (mix, exponent) in &figures.growth_exponent {
        if let Some(exponent) = exponent {
            text.push_str(&format!(
                "{mix}: the median grows with schemas to the power of {exponent:.2} (wanted: at most {GROWTH_WANTED})\n"
            ));
        }
    }
    text
}
