//! How long a step takes, learning included, as memory grows: frame in, action chosen. The learner lives in worlds of its
//! own (`worlds.rs`), so that no body and no transport is in the figure.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use rustix::time::{ClockId, clock_gettime};
use serde::{Deserialize, Serialize};

use super::worlds::{Mix, World, resident_bytes, schemas};
use super::{Times, alone};
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

#[derive(Debug, Serialize, Deserialize)]
struct Row {
    mix: String,
    /// Schemas when measuring began.
    schemas: usize,
    generalised: u32,
    observations: usize,
    steps: usize,
    step_us_p50: f64,
    step_us_p99: f64,
    /// The same by the processor's time of this thread: whatever else the machine does is not in it.
    processor_us_p50: f64,
    processor_us_p99: f64,
    /// Of the median, to that of the smallest memory of the mix.
    ratio_p50: f64,
    /// Of the process, less what it had before: `null` while that is too little to tell.
    bytes_per_schema: Option<f64>,
    step_us_p99_wanted: Option<f64>,
}

/// What `--json` prints.
#[derive(Debug, Serialize, Deserialize)]
struct Figures {
    rows: Vec<Row>,
    /// By mix: the exponent of the power of the number of schemas that the median grows by; `null` where memory was
    /// not measured both at 10,000 schemas and above.
    growth_exponent: BTreeMap<String, Option<f64>>,
    growth_exponent_wanted: f64,
}

pub(super) fn run(args: &BenchDecisionArgs, quiet: bool) -> Result<(), Failure> {
    let mut sizes = args.schemas.clone();
    sizes.sort_unstable();
    sizes.dedup();
    let figures = match Mix::ALL.into_iter().find(|mix| args.mix.as_deref() == Some(mix.name())) {
        Some(mix) => {
            if !quiet {
                talk::say(&format!("{}: a life up to {} schemas", mix.name(), sizes.last().unwrap_or(&0)));
            }
            let rows = life(mix, &sizes, args.seed)?;
            let growth_exponent = BTreeMap::from([(mix.name().to_owned(), exponent(&rows))]);
            Figures { rows, growth_exponent, growth_exponent_wanted: GROWTH_WANTED }
        }
        None => each(&sizes, args.seed, quiet)?,
    };
    if args.json { output::print_json(&figures) } else { output::print(&text(&figures)) }
}

/// Every mix, each in a process of its own: what one life leaves behind in an allocator is not the next one's.
fn each(sizes: &[usize], seed: u64, quiet: bool) -> Result<Figures, Failure> {
    let mut all =
        Figures { rows: Vec::new(), growth_exponent: BTreeMap::new(), growth_exponent_wanted: GROWTH_WANTED };
    for mix in Mix::ALL {
        let Figures { rows, growth_exponent, .. } = alone("decision", mix, sizes, seed, quiet)?;
        all.rows.extend(rows);
        all.growth_exponent.extend(growth_exponent);
    }
    Ok(all)
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
        let (at, mut times, mut processor) = (schemas(&world), Times::default(), Times::default());
        // A small memory would be a larger one before that many steps are over.
        for _ in 0..STEPS.min(at.max(200) * 5) {
            let (took, used) = step(&mut world);
            times.push(took);
            processor.push(used);
        }
        let content = world.learner().memory().content();
        let grown = resident_bytes().zip(resident_before).map(|(now, before)| now.saturating_sub(before));
        let step_us_p50 = times.at(0.5);
        rows.push(Row {
            mix: mix.name().to_owned(),
            schemas: at,
            generalised: content.generalised_count,
            observations: content.observations.len(),
            steps: times.0.len(),
            step_us_p50,
            step_us_p99: times.at(0.99),
            processor_us_p50: processor.at(0.5),
            processor_us_p99: processor.at(0.99),
            ratio_p50: step_us_p50 / rows.first().map_or(step_us_p50, |first| first.step_us_p50),
            bytes_per_schema: grown
                .filter(|_| at >= GROWTH.0)
                .map(|bytes| bytes as f64 / content.schemas.len() as f64),
            step_us_p99_wanted: WANTED.iter().find(|(most, _)| *size <= *most).map(|(_, wanted)| *wanted),
        });
    }
    Ok(rows)
}

/// One step; returns how long the learner took, by the clock and by the processor.
fn step(world: &mut World) -> (Duration, Duration) {
    let frame = world.frame();
    let (began, used_before) = (Instant::now(), used());
    let step = world.learner_mut().step(&frame);
    let (processor, clock) = (used().saturating_sub(used_before), began.elapsed());
    world.follow(&step.output);
    (clock, processor)
}

/// What this thread has used of the processor.
fn used() -> Duration {
    let now = clock_gettime(ClockId::ThreadCPUTime);
    Duration::new(now.tv_sec.unsigned_abs(), u32::try_from(now.tv_nsec).unwrap_or(0))
}

/// The exponent of growth from 10,000 schemas to the largest memory measured, up to a million.
fn exponent(rows: &[Row]) -> Option<f64> {
    let from = rows.iter().find(|row| row.schemas >= GROWTH.0)?;
    let to = rows.iter().rfind(|row| row.schemas <= GROWTH.1 + GROWTH.1 / 10)?;
    let times = to.schemas as f64 / from.schemas as f64;
    (times > 1.5).then(|| (to.step_us_p50 / from.step_us_p50).ln() / times.ln())
}

fn text(figures: &Figures) -> String {
    let headings = ["mix", "schemas", "laws", "p50 us", "p99", "wanted", "cpu p50", "p99", "ratio", "bytes"];
    let mut table = Columns::new(&headings).figures(&[1, 2, 3, 4, 5, 6, 7, 8, 9]);
    for row in &figures.rows {
        table.row([
            row.mix.clone(),
            row.schemas.to_string(),
            row.generalised.to_string(),
            format!("{:.1}", row.step_us_p50),
            format!("{:.1}", row.step_us_p99),
            row.step_us_p99_wanted.map_or(String::new(), |wanted| format!("{wanted:.0}")),
            format!("{:.1}", row.processor_us_p50),
            format!("{:.1}", row.processor_us_p99),
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
