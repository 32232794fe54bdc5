//! `pschema record`.

use std::path::PathBuf;

use clap::Args;
use pschema_process::{Occupied, Stop, say};
use pschema_protocol::domain::{Place, RuntimeDir};

use crate::args::{General, NameArgs};
use crate::failure::Failure;
use crate::output;
use crate::record::{self, JsonLinesFile};

#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  pschema record --jsonl steps.jsonl --steps 1000\n  pschema record --jsonl - | jq -c .step.decision\n\n\
    The steps that the daemon still has come first. It goes on until so many steps are written, the daemon ends or Ctrl-C."
)]
pub(crate) struct RecordArgs {
    #[command(flatten)]
    name: NameArgs,
    /// One JSON object a line: {"step": …} or {"schema": …}; to a file that is not there yet, to a pipe, or with `-` to stdout
    #[arg(long, value_name = "FILE")]
    jsonl: PathBuf,
    /// Replace what is there under the name of --jsonl
    #[arg(long)]
    overwrite: bool,
    /// End after so many steps
    #[arg(long, value_name = "N")]
    steps: Option<u64>,
    /// What was recorded as JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: RecordArgs, general: &General) -> Result<(), Failure> {
    let to_stdout = output::is_stdout(&args.jsonl);
    if to_stdout && args.json {
        let problem = "--json prints on stdout what was recorded, and the lines go there: record them to a file, or leave out --json";
        return Err(Failure::Usage(problem.to_owned()));
    }
    let stop = Stop::on_signals()?;
    let place = Place::new(RuntimeDir::from_environment()?, args.name.learner(general)?);
    // Looked for first: no file is made where there is nothing to record.
    place.served()?;
    let occupied = Occupied::overwritten(args.overwrite);
    let mut to = JsonLinesFile::create(&args.jsonl, occupied, &stop.flag())?;
    let recorded = record::record(&place, &mut to, args.steps.unwrap_or(u64::MAX), &stop.flag())?;
    if args.json {
        return output::print_json(&recorded);
    }
    let steps = match (recorded.first_step, recorded.last_step) {
        (Some(first), Some(last)) => format!("{} steps, {first} to {last}", recorded.steps),
        _ => "no step: the learner took none".to_owned(),
    };
    let missed = match recorded.steps_missed {
        0 => String::new(),
        missed => format!(" ({missed} before them are no longer kept)"),
    };
    let told = format!("Recorded {steps}{missed}, {} new schemas.", recorded.schemas);
    match (to_stdout, general.quiet()) {
        (false, _) => output::print(&(told + "\n")),
        (true, false) => {
            say(&told);
            Ok(())
        }
        (true, true) => Ok(()),
    }
}
