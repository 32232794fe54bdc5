//! `pschema show ID`.

use pschema_inspect::{Answer, Request};
use pschema_protocol::domain::LearnerName;

use crate::cli::ShowArgs;
use crate::failure::Failure;
use crate::learner::ask_for;
use crate::output;
use crate::past::asked;
use crate::render::{json, schema};

pub(crate) fn run(name: &LearnerName, args: &ShowArgs) -> Result<(), Failure> {
    let mut learner = asked(name, &args.data)?;
    let answer = ask_for!(learner, &Request::Show { id: args.id }, Answer::Schema)?;
    if args.json {
        output::print_json(&json::Schema::from(&*answer))
    } else {
        output::print(&schema::detail(&answer))
    }
}
