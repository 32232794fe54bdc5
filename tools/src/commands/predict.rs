//! `pschema predict ACTION`.

use pschema_inspect::{Answer, Request};
use pschema_protocol::domain::LearnerName;

use crate::cli::PredictArgs;
use crate::failure::Failure;
use crate::learner::ask_for;
use crate::output;
use crate::past::asked;
use crate::render::{goals, json_goals};

pub(crate) fn run(name: &LearnerName, args: PredictArgs) -> Result<(), Failure> {
    let mut learner = asked(name, &args.data)?;
    let answer = ask_for!(learner, &Request::Predict { action: args.action }, Answer::Prediction)?;
    if args.json {
        output::print_json(&json_goals::Prediction::from(&*answer))
    } else {
        output::print(&goals::prediction(&answer))
    }
}
