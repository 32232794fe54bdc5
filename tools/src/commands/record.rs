//! `pschema record`.

use pschema_protocol::domain::{LearnerName, Place, RuntimeDir};

use crate::cli::RecordArgs;
use crate::failure::Failure;
use crate::output;
use crate::record::{self, Lines, Recorder};
use crate::run::Stop;

pub(crate) fn run(name: &LearnerName, args: &RecordArgs) -> Result<(), Failure> {
    let place = Place::new(RuntimeDir::from_environment()?, name.clone());
    // Looked for first: no file is made where there is nothing to record.
    place.served()?;
    let mut recorders: Vec<Box<dyn Recorder>> = Vec::new();
    if let Some(path) = &args.rerun {
        recorders.push(record::rerun(path, name.as_str())?);
    }
    if let Some(path) = &args.jsonl {
        recorders.push(Box::new(Lines::create(path)?));
    }
    let stop = Stop::on_signals()?;
    let pictures = args.rerun.is_some() && !args.no_pictures;
    let recorded =
        record::record(&place, &mut recorders, pictures, args.steps.unwrap_or(u64::MAX), &stop.flag())?;
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
    output::print(&format!(
        "Recorded {steps}{missed}, {} new schemas, {} pictures.\n",
        recorded.schemas, recorded.pictures
    ))
}
