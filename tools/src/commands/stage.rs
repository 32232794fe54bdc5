//! `pschema stage [show|next|hold|resume|set NAME]`.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use pschema_inspect::{ReportQuery, StageOrder};

use crate::args::{DataArgs, General, MemoryArgs, NameArgs, refuse_order};
use crate::failure::Failure;
use crate::learner::{Asks, Learner};
use crate::output;
use crate::past::asked;
use crate::render::status;

#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  pschema stage\n  pschema stage next\n  pschema stage set 'first touches'"
)]
pub(crate) struct StageArgs {
    #[command(flatten)]
    name: NameArgs,
    /// Say where it stood in the memory in this data directory, with or without a daemon on it
    #[arg(long, value_name = "DIR", global = true)]
    data: Option<PathBuf>,
    /// As it was after step N, before step N + 1
    #[arg(long, value_name = "N", requires = "data", global = true)]
    until: Option<u64>,
    #[command(subcommand)]
    order: Option<StageCommand>,
    /// Print JSON
    #[arg(long, global = true)]
    json: bool,
}

#[derive(Debug, Subcommand)]
enum StageCommand {
    /// Say where the curriculum stands
    #[command(after_help = "Example:\n  pschema stage show --json")]
    Show,
    /// End the present stage and enter the next
    #[command(after_help = "Example:\n  pschema stage next")]
    Next,
    /// Wait: nothing is done until `resume`
    #[command(after_help = "Example:\n  pschema stage hold")]
    Hold,
    /// Go on after `hold`
    #[command(after_help = "Example:\n  pschema stage resume")]
    Resume,
    /// Take one action, and wait again
    #[command(after_help = "Example:\n  pschema stage step")]
    Step,
    /// Enter a stage of the curriculum, or enter it again
    #[command(after_help = "Example:\n  pschema stage set 'first touches'")]
    Set {
        /// Its name
        stage: String,
    },
}

pub(crate) fn run(args: StageArgs, general: &General) -> Result<(), Failure> {
    let order = match args.order.unwrap_or(StageCommand::Show) {
        StageCommand::Show => None,
        StageCommand::Next => Some(StageOrder::Next),
        StageCommand::Hold => Some(StageOrder::Hold),
        StageCommand::Resume => Some(StageOrder::Resume),
        StageCommand::Step => Some(StageOrder::Step),
        StageCommand::Set { stage } => Some(StageOrder::Set(stage)),
    };
    let report = match order {
        Some(order) => {
            refuse_order(args.data.as_deref(), "an order to the curriculum")?;
            Learner::connect_to_order(&args.name.learner(general)?)?.ask(order)?
        }
        None => {
            let data = DataArgs { data: args.data, until: args.until };
            asked(&MemoryArgs { name: args.name, data }, general)?.ask(ReportQuery {})?
        }
    };
    output::show(args.json, &report, status::report)
}
