//! `pschema say WORD...`.

use pschema_inspect::{Answer, Request};
use pschema_protocol::domain::LearnerName;

use crate::cli::SayArgs;
use crate::failure::Failure;
use crate::learner::{Learner, ask_for};
use crate::output;
use crate::past::no_orders;
use crate::render::words::plain;

pub(crate) fn run(name: &LearnerName, args: SayArgs) -> Result<(), Failure> {
    no_orders(&args.data, "`say`")?;
    let mut learner = Learner::connect(name)?;
    let said = args.words.join(" ");
    let request = Request::Say { words: args.words };
    let report = ask_for!(learner, &request, Answer::Report)?;
    if args.json {
        output::print_json(&report)
    } else {
        let when = if report.stage_state == "held" {
            "is held, and hears it when it steps or goes on"
        } else {
            "hears it next"
        };
        output::print(&format!("Said {:?} after step {}; {name} {when}.\n", plain(&said), report.step))
    }
}
