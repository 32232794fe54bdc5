//! `pschema stage [show|next|hold|resume|set NAME]`.

use pschema_inspect::{Answer, Request, StageOrder};
use pschema_protocol::domain::LearnerName;

use crate::cli::{DataArgs, StageArgs, StageCommand};
use crate::failure::Failure;
use crate::learner::ask_for;
use crate::output;
use crate::past::{asked, refuse_order};
use crate::render::status;

pub(crate) fn run(name: &LearnerName, args: StageArgs) -> Result<(), Failure> {
    let order = match args.order.unwrap_or(StageCommand::Show) {
        StageCommand::Show => StageOrder::Show,
        StageCommand::Next => StageOrder::Next,
        StageCommand::Hold => StageOrder::Hold,
        StageCommand::Resume => StageOrder::Resume,
        StageCommand::Step => StageOrder::Step,
        StageCommand::Set { stage } => StageOrder::Set(stage),
    };
    if order != StageOrder::Show {
        refuse_order(args.data.as_deref(), "an order to the curriculum")?;
    }
    let data = DataArgs { data: args.data, until: args.until };
    let mut learner = asked(name, &data)?;
    let report = ask_for!(learner, &Request::Stage(order), Answer::Report)?;
    if args.json { output::print_json(&report) } else { output::print(&status::report(&report)) }
}
