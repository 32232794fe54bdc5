//! `pschema status`.

use pschema_protocol::domain::LearnerName;
use pschema_protocol::inspect::{Answer, Request};

use crate::cli::ReportArgs;
use crate::failure::Failure;
use crate::learner::{Learner, ask_for};
use crate::output;
use crate::render::status;

pub(crate) fn run(name: &LearnerName, args: &ReportArgs) -> Result<(), Failure> {
    let mut learner = Learner::connect(name)?;
    let answer = ask_for!(learner, &Request::Status, Answer::Status)?;
    if args.json { output::print_json(&answer) } else { output::print(&status::status(&answer)) }
}
