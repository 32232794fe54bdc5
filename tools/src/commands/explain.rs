//! `pschema explain`.

use pschema_inspect::{Answer, Request};
use pschema_protocol::domain::LearnerName;

use crate::cli::ExplainArgs;
use crate::failure::Failure;
use crate::learner::unexpected;
use crate::output;
use crate::past::answered;
use crate::render::{explanation, json, why_not};

pub(crate) fn run(name: &LearnerName, args: &ExplainArgs) -> Result<(), Failure> {
    let request = match args.why_not {
        Some(schema) => Request::WhyNot { schema, step: args.step },
        None => Request::Explain { step: args.step, candidates_max: args.candidates },
    };
    match (answered(name, &args.data, &request)?, args.json) {
        (Answer::Explanation(told), true) => output::print_json(&json::Reasons::from(&*told)),
        (Answer::Explanation(told), false) => output::print(&explanation::explanation(&told)),
        (Answer::WhyNot(told), true) => output::print_json(&why_not::Json::from(&*told)),
        (Answer::WhyNot(told), false) => output::print(&why_not::why_not(&told)),
        (other, _) => Err(unexpected(&other)),
    }
}
