//! How long a daemon takes to find a memory of some size again on a real disk, and what a snapshot costs the steps beside
//! it. The memory is made of effects as a learner returns them, in a world of one block on a row.

mod growing;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;
use pschema_learner::digest::digest;
use pschema_process::say;
use pschema_store::{Opened, Options};
use pschema_tools::kit::{Columns, Failure, bytes, duration, show};
use serde::Serialize;

use crate::times::directory_on_disk;
use growing::GrowingMemory;

/// What is wanted: so many seconds at so many schemas.
const WANTED: [(u32, f64); 2] = [(20_000, 0.2), (1_000_000, 5.0)];
/// Steps timed without a snapshot beside them.
const STEPS: usize = 500;
/// Steps timed at most with one.
const STEPS_MAX: usize = 20_000;

/// The memories to measure.
#[derive(Debug, Args)]
pub(crate) struct RestartArgs {
    /// Sizes of memory, in schemas
    #[arg(long, value_name = "N", value_delimiter = ',', default_values_t = [20_000], value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    schemas: Vec<u32>,
    /// Measure the disk that this directory is on; a directory made in it is removed again [default: here]
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Times of a store with a memory of one size.
#[derive(Debug, Serialize)]
struct StoreTimes {
    schemas: u64,
    snapshot_bytes: u64,
    /// From nothing to a memory that can be stepped: the snapshot, and the journal after it.
    start_s: f64,
    /// Frames of that journal.
    frames: u64,
    /// What is wanted of it; `null` where nothing is.
    start_s_wanted: Option<f64>,
    /// How long a snapshot took, beside steps that were taken as fast as they became durable.
    snapshot_s: f64,
    /// From handing a step over until it was durable, without a snapshot beside it.
    commit_us_p50: f64,
    commit_us_p99: f64,
    /// The same while a snapshot was made.
    commit_beside_snapshot_us_p50: f64,
    commit_beside_snapshot_us_p99: f64,
    /// Cloning memory's chunks.
    clone_us: f64,
    /// One digest.
    digest_ms: f64,
}

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct RestartMeasurement {
    rows: Vec<StoreTimes>,
}

pub(crate) fn run(args: &RestartArgs, quiet: bool) -> Result<(), Failure> {
    let mut rows = Vec::new();
    for schemas in &args.schemas {
        if !quiet {
            say(&format!("a memory of {schemas} schemas is made, kept, and found again"));
        }
        let directory = directory_on_disk(args.data.as_deref())?;
        rows.push(measured(&directory.path().join("memory"), *schemas)?);
    }
    show(args.json, &RestartMeasurement { rows }, text)
}

/// Makes a memory of `schemas` schemas in the empty directory `directory`, has a snapshot made while steps are taken, ends
/// without saying so, and starts again.
fn measured(directory: &Path, schemas: u32) -> Result<StoreTimes, Failure> {
    let (parameters, curriculum) = growing::setting();
    let mut options = Options::new("bench", 1, &parameters, &curriculum);
    // No snapshot but the one that is asked for.
    options.retention.snapshot_bytes = u64::MAX;
    let mut memory = GrowingMemory::open(directory, options)?;
    memory.build(usize::try_from(schemas).unwrap_or(usize::MAX))?;
    let cloned = Instant::now();
    let content = memory.content().clone();
    let clone_us = cloned.elapsed().as_secs_f64() * 1e6;
    let digested = Instant::now();
    drop(digest(&content));
    let digest_ms = digested.elapsed().as_secs_f64() * 1e3;
    drop(content);
    let commits = memory.steps(STEPS, |_| true)?;
    memory.store().request_snapshot();
    let (started, last) = (Instant::now(), memory.store().snapshot_step());
    let beside = memory.steps(STEPS_MAX, |store| store.snapshot_step() == last)?;
    while memory.store().snapshot_step() == last {
        if let Some(failure) = memory.store().failure() {
            return Err(Failure::of(failure));
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    let snapshot_s = started.elapsed().as_secs_f64();
    let (schemas_made, last_digest) = (memory.content().schemas.len(), digest(memory.content()));
    let snapshot_bytes = memory.store().snapshot_bytes();
    drop(memory);
    let started = Instant::now();
    let Opened { learner, store, .. } =
        pschema_store::open(directory, options, || ()).map_err(Failure::of)?;
    let start_s = started.elapsed().as_secs_f64();
    if digest(learner.memory().content()) != last_digest {
        return Err(Failure::Failed("the memory that was found again is another one".to_owned()));
    }
    Ok(StoreTimes {
        schemas: schemas_made as u64,
        snapshot_bytes,
        start_s,
        frames: store.recovered().frames,
        start_s_wanted: WANTED.iter().find(|(size, _)| schemas <= *size).map(|(_, wanted)| *wanted),
        snapshot_s,
        commit_us_p50: commits.p50(),
        commit_us_p99: commits.p99(),
        commit_beside_snapshot_us_p50: beside.p50(),
        commit_beside_snapshot_us_p99: beside.p99(),
        clone_us,
        digest_ms,
    })
}

fn text(measurement: &RestartMeasurement) -> String {
    let headings = ["schemas", "start", "wanted", "snapshot", "made in", "commit", "beside a snapshot"];
    let mut table = Columns::new(&headings).figures(&[0, 1, 2, 3, 4, 5, 6]);
    let pair = |p50: f64, p99: f64| format!("{p50:.0} / {p99:.0} us");
    for row in &measurement.rows {
        table.row([
            row.schemas.to_string(),
            duration(row.start_s),
            row.start_s_wanted.map_or(String::new(), |wanted| format!("< {}", duration(wanted))),
            bytes(row.snapshot_bytes),
            duration(row.snapshot_s),
            pair(row.commit_us_p50, row.commit_us_p99),
            pair(row.commit_beside_snapshot_us_p50, row.commit_beside_snapshot_us_p99),
        ]);
    }
    table.text(&[0])
}
