//! `pschema status`.

use clap::Args;
use pschema_inspect::StatusQuery;

use crate::args::{General, MeantMemory, MemoryArgs};
use crate::failure::Failure;
use crate::learner::Learner;
use crate::output;
use crate::past::MemoryOnDisk;
use crate::render::past_status::{self, PastStatus};
use crate::render::{metrics, status};

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema status --json\n  \
    pschema status --data ~/arm --until 5000\n  \
    pschema status --metrics | curl --data-binary @- http://gateway:9091/metrics/job/pschema")]
pub(crate) struct StatusArgs {
    #[command(flatten)]
    memory: MemoryArgs,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Print metrics in Prometheus' text format; without a daemon, that there is none
    #[arg(long, conflicts_with_all = ["json", "data", "until"])]
    metrics: bool,
}

pub(crate) fn run(args: StatusArgs, general: &General) -> Result<(), Failure> {
    let name = match args.memory.meant(general)? {
        MeantMemory::OnDisk(data, until) => return past(&MemoryOnDisk::open(data, until)?, args.json),
        MeantMemory::Running(name) => name,
    };
    match Learner::connect_as_operator(&name).and_then(|mut learner| learner.ask(StatusQuery {})) {
        Ok(answer) if args.metrics => output::print(&metrics::metrics(&answer)),
        Ok(answer) => output::show(args.json, &answer, status::status),
        Err(failure @ Failure::NoDaemon(_)) if args.metrics => {
            // A collector wants to know that, too.
            output::print(&metrics::down(name.as_str()))?;
            Err(failure)
        }
        Err(failure) => Err(failure),
    }
}

fn past(memory: &MemoryOnDisk, json: bool) -> Result<(), Failure> {
    let moment = memory.moment(&StatusQuery {})?;
    let (frame, at_unix_ms) = (moment.frame, moment.at_unix_ms);
    let status = memory.answer(moment, &StatusQuery {})?;
    let told = PastStatus::new(&status, memory.past(), frame, at_unix_ms)?;
    output::show(json, &told, |told| past_status::past_status(told, &status))
}
