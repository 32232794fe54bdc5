//! `pschema status`.

use pschema_inspect::{Answer, Request};
use pschema_protocol::domain::LearnerName;

use crate::cli::StatusArgs;
use crate::failure::Failure;
use crate::learner::{Learner, ask_for};
use crate::output;
use crate::past::Remembered;
use crate::render::past_status::{self, PastStatus};
use crate::render::{metrics, status};

pub(crate) fn run(name: &LearnerName, args: &StatusArgs) -> Result<(), Failure> {
    if let Some(directory) = &args.data.data {
        return past(&Remembered::open(directory, args.data.until)?, args.json);
    }
    let answered =
        Learner::connect(name).and_then(|mut learner| ask_for!(learner, &Request::Status, Answer::Status));
    match answered {
        Ok(answer) if args.metrics => output::print(&metrics::metrics(&answer)),
        Ok(answer) if args.json => output::print_json(&answer),
        Ok(answer) => output::print(&status::status(&answer)),
        Err(failure @ Failure::NoDaemon(_)) if args.metrics => {
            // A collector wants to know that, too.
            output::print(&metrics::down(name.as_str()))?;
            Err(failure)
        }
        Err(failure) => Err(failure),
    }
}

fn past(remembered: &Remembered, json: bool) -> Result<(), Failure> {
    let moment = remembered.moment(&Request::Status)?;
    let (frame, at_unix_ms) = (moment.frame, moment.at_unix_ms);
    let Answer::Status(status) = remembered.answer(moment, &Request::Status)? else {
        return Err(Failure::Failed("memory was rebuilt, and can't be told of".to_owned()));
    };
    let past = remembered.past();
    let directory = past.directory().display().to_string();
    let told = PastStatus::new(&status, directory, past.seed(), frame, at_unix_ms, past.files()?);
    if json { output::print_json(&told) } else { output::print(&past_status::past_status(&told, &status)) }
}
