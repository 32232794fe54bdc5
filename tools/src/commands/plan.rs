//! `pschema plan PATTERN...`.

use pschema_inspect::{Answer, Request};
use pschema_protocol::domain::LearnerName;

use crate::cli::PlanArgs;
use crate::failure::Failure;
use crate::learner::ask_for;
use crate::output;
use crate::past::asked;
use crate::render::{goals, json_goals};

pub(crate) fn run(name: &LearnerName, args: PlanArgs) -> Result<(), Failure> {
    let mut learner = asked(name, &args.data)?;
    let answer = ask_for!(learner, &Request::Plan { goal: args.goal }, Answer::Plan)?;
    if args.json {
        output::print_json(&json_goals::Plan::from(&*answer))
    } else {
        output::print(&goals::plan(&answer))
    }
}
