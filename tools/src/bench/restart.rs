//! How long a daemon takes to find a memory again, for memories of some sizes.

use pschema_store::bench;
use serde::Serialize;

use super::on_disk;
use crate::cli::BenchRestartArgs;
use crate::failure::Failure;
use crate::output;
use crate::render::table::Columns;
use crate::render::words::{bytes, duration};
use crate::talk;

/// What is wanted: so many seconds at so many schemas.
const WANTED: [(u32, f64); 2] = [(20_000, 0.2), (1_000_000, 5.0)];

#[derive(Debug, Serialize)]
struct Measured {
    schemas: u64,
    snapshot_bytes: u64,
    /// From nothing to a memory that can be stepped: the snapshot, and the journal after it.
    start_s: f64,
    /// Frames of that journal.
    frames: u64,
    /// What is wanted of it; `null` where nothing is.
    start_s_wanted: Option<f64>,
    snapshot_s: f64,
    commit_us_p50: f64,
    commit_us_p99: f64,
    commit_beside_snapshot_us_p50: f64,
    commit_beside_snapshot_us_p99: f64,
    clone_us: f64,
    digest_ms: f64,
}

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct Figures {
    rows: Vec<Measured>,
}

pub(super) fn run(args: &BenchRestartArgs, quiet: bool) -> Result<(), Failure> {
    let mut rows = Vec::new();
    for schemas in &args.schemas {
        if !quiet {
            talk::say(&format!("a memory of {schemas} schemas is made, kept, and found again"));
        }
        rows.push(measured(*schemas, args)?);
    }
    let figures = Figures { rows };
    if args.json { output::print_json(&figures) } else { output::print(&text(&figures)) }
}

fn measured(schemas: u32, args: &BenchRestartArgs) -> Result<Measured, Failure> {
    let directory = on_disk(args.data.as_deref())?;
    let size = usize::try_from(schemas).unwrap_or(usize::MAX);
    let found = bench::figures(&directory.path().join("memory"), size);
    let found = found.map_err(Failure::of)?;
    Ok(Measured {
        schemas: found.schemas as u64,
        snapshot_bytes: found.snapshot_bytes,
        start_s: found.start_s,
        frames: found.frames,
        start_s_wanted: WANTED.iter().find(|(size, _)| schemas <= *size).map(|(_, wanted)| *wanted),
        snapshot_s: found.snapshot_s,
        commit_us_p50: found.commit_us.0,
        commit_us_p99: found.commit_us.1,
        commit_beside_snapshot_us_p50: found.commit_beside_snapshot_us.0,
        commit_beside_snapshot_us_p99: found.commit_beside_snapshot_us.1,
        clone_us: found.clone_us,
        digest_ms: found.digest_ms,
    })
}

fn text(figures: &Figures) -> String {
    let headings = ["schemas", "start", "wanted", "snapshot", "made in", "commit", "beside a snapshot"];
    let mut table = Columns::new(&headings).figures(&[0, 1, 2, 3, 4, 5, 6]);
    let pair = |p50: f64, p99: f64| format!("{p50:.0} / {p99:.0} us");
    for row in &figures.rows {
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
