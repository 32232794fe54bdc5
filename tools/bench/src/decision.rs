//! How long a step takes, learning included, as memory grows: frame in, action chosen. The learner lives in worlds of its
//! own (`tools/bench/worlds`), so that no body and no transport is in the figure.

use std::time::{Duration, Instant};

use pschema_tools::kit::{Columns, Failure, show};
use rustix::time::{ClockId, clock_gettime};
use serde::{Deserialize, Serialize};

use crate::lives::{Lives, LivesArgs, OfLife, growth, lives, resident_bytes};
use crate::times::Times;
use pschema_worlds::{Mix, World};

/// Steps that are measured at each size.
const STEPS: usize = 5_000;
/// What is wanted of the 99th percentile: so many microseconds up to so many schemas.
const WANTED: [(usize, f64); 2] = [(20_000, 100.0), (1_000_000, 1_000.0)];
/// Between these sizes it is measured how times grow.
const GROWTH: (usize, usize) = (10_000, 1_000_000);
/// What is wanted of the exponent.
const GROWTH_WANTED: f64 = 0.25;

/// Times of a step with a memory of one size.
#[derive(Debug, Serialize, Deserialize)]
struct StepTimes {
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

/// What `--json` prints. The exponents of growth are those of the median.
#[derive(Debug, Serialize)]
struct DecisionMeasurement {
    #[serde(flatten)]
    lives: Lives<StepTimes>,
    growth_exponent_wanted: f64,
}

pub(crate) fn run(args: &LivesArgs, quiet: bool) -> Result<(), Failure> {
    let measurement =
        DecisionMeasurement { lives: lives(args, quiet)?, growth_exponent_wanted: GROWTH_WANTED };
    show(args.json, &measurement, text)
}

impl OfLife for StepTimes {
    const COMMAND: &'static str = "decision";
    const SCHEMAS_MIN: usize = 0;

    fn life(mix: Mix, sizes: &[usize], seed: u64) -> Result<Vec<Self>, Failure> {
        let resident_before = resident_bytes();
        let mut world = World::new(mix, seed).map_err(Failure::of)?;
        let mut rows: Vec<Self> = Vec::new();
        for size in sizes {
            while world.schemas() < *size {
                step(&mut world);
            }
            let (at, mut times, mut processor) = (world.schemas(), Times::default(), Times::default());
            // A small memory would be a larger one before that many steps are over.
            for _ in 0..STEPS.min(at.max(200) * 5) {
                let (took, used) = step(&mut world);
                times.push(took);
                processor.push(used);
            }
            let content = world.learner().memory().content();
            let grown = resident_bytes().zip(resident_before).map(|(now, before)| now.saturating_sub(before));
            let step_us_p50 = times.p50();
            rows.push(Self {
                mix: mix.name().to_owned(),
                schemas: at,
                generalised: content.generalised_count,
                observations: content.observations.len(),
                steps: times.len(),
                step_us_p50,
                step_us_p99: times.p99(),
                processor_us_p50: processor.p50(),
                processor_us_p99: processor.p99(),
                ratio_p50: step_us_p50 / rows.first().map_or(step_us_p50, |first| first.step_us_p50),
                bytes_per_schema: grown
                    .filter(|_| at >= GROWTH.0)
                    .map(|bytes| bytes as f64 / content.schemas.len() as f64),
                step_us_p99_wanted: WANTED.iter().find(|(most, _)| *size <= *most).map(|(_, wanted)| *wanted),
            });
        }
        Ok(rows)
    }

    /// From 10,000 schemas to the largest memory measured, up to a million.
    fn exponent(life: &[Self]) -> Option<f64> {
        let from = life.iter().find(|row| row.schemas >= GROWTH.0)?;
        let to = life.iter().rfind(|row| row.schemas <= GROWTH.1 + GROWTH.1 / 10)?;
        growth(from.step_us_p50, to.step_us_p50, to.schemas as f64 / from.schemas as f64)
    }
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

fn text(measurement: &DecisionMeasurement) -> String {
    let headings = ["mix", "schemas", "laws", "p50 us", "p99", "wanted", "cpu p50", "p99", "ratio", "bytes"];
    let mut table = Columns::new(&headings).figures(&[1, 2, 3, 4, 5, 6, 7, 8, 9]);
    for row in &measurement.lives.rows {
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
    for (mix, exponent) in &measurement.lives.growth_exponent {
        if let Some(exponent) = exponent {
            text.push_str(&format!(
                "{mix}: the median grows with schemas to the power of {exponent:.2} (wanted: at most {GROWTH_WANTED})\n"
            ));
        }
    }
    text
}
