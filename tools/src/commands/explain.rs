//! `pschema explain`.

use pschema_protocol::domain::LearnerName;
use pschema_protocol::inspect::{Answer, Request};

use crate::cli::ExplainArgs;
use crate::failure::Failure;
use crate::learner::ask_for;
use crate::output;
use crate::past::asked;
use crate::render::{explanation, json};

pub(crate) fn run(name: &LearnerName, args: &ExplainArgs) -> Result<(), Failure> {
    let mut learner = asked(name, &args.data)?;
    let request = Request::Explain { step: args.step, candidates_max: args.candidates };
    let answer = ask_for!(learner, &request, Answer::Explanation)?;
    if args.json {
        output::print_json(&json::Reasons::from(&*answer))
    } else {
        output::print(&explanation::explanation(&answer))
    }
}
