//! `pschema import`: a data directory of what was exported.

use std::path::PathBuf;

use clap::Args;
use pschema_process::input;
use pschema_store::past::export;
use pschema_store::past::{self, DataDirectory};
use serde::Serialize;

use crate::args::General;
use crate::bar::Bar;
use crate::failure::Failure;
use crate::output;

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema import arm.jsonl --data ~/arm-again\n  \
    pschema server --data ~/arm-again")]
pub(crate) struct ImportArgs {
    /// What `pschema export` wrote; `-` for stdin
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// The data directory to make; there must be nothing in it
    #[arg(long, value_name = "DIR")]
    data: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// How often a person is told how far it is, in lines.
const TELL_EVERY: u64 = 1_024;

/// A memory that was imported, and the data directory that was made of it.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct ImportReport {
    /// Lines of the export.
    lines: u64,
    /// The learner's name.
    learner: String,
    /// The learner's seed.
    seed: u64,
    /// Schemas in memory.
    schemas_total: u64,
    #[serde(flatten)]
    made: DataDirectory,
}

pub(crate) fn run(args: ImportArgs, general: &General) -> Result<(), Failure> {
    let shown = args.file.display();
    let from = input(&args.file);
    let mut from = from.map_err(|error| Failure::Failed(format!("cannot read {shown}: {error}")))?;
    let bar = Bar::count(general.quiet());
    let imported = export::read(&mut *from, |lines| {
        if lines.is_multiple_of(TELL_EVERY) {
            bar.show(lines, lines, "lines".to_owned());
        }
    });
    let imported = imported.map_err(|error| Failure::Failed(format!("{shown}: {error}")))?;
    let made = past::import(&imported, &args.data)?;
    drop(bar);
    let report = ImportReport {
        lines: imported.lines.lines,
        learner: imported.learner,
        seed: imported.seed,
        schemas_total: imported.content.schemas.len() as u64,
        made,
    };
    if args.json {
        return output::print_json(&report);
    }
    let DataDirectory { directory, step, memory_digest } = &report.made;
    output::print(&format!(
        "Memory of {} at step {step}, {} schemas, digest {memory_digest}.\n\
         Go on from there with: pschema server --data {directory}\n",
        report.learner, report.schemas_total
    ))
}
