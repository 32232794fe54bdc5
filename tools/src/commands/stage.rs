//! `pschema stage [show|next|hold|resume|set NAME]`.

use clap::{Args, Subcommand};
use pschema_inspect::{ReportQuery, StageOrder};

use crate::args::{AskArgs, General, MeantMemory, refused_order};
use crate::failure::Failure;
use crate::learner::Learner;
use crate::output;
use crate::past::show;
use crate::render::status;

#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  pschema stage\n  pschema stage next\n  pschema stage set 'first touches'"
)]
pub(crate) struct StageArgs {
    #[command(flatten)]
    ask: AskArgs,
    #[command(subcommand)]
    order: Option<StageCommand>,
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
        StageCommand::Show => return show(&args.ask, general, ReportQuery {}, status::report),
        StageCommand::Next => StageOrder::Next,
        StageCommand::Hold => StageOrder::Hold,
        StageCommand::Resume => StageOrder::Resume,
        StageCommand::Step => StageOrder::Step,
        StageCommand::Set { stage } => StageOrder::Set(stage),
    };
    match args.ask.memory.meant(general)? {
        MeantMemory::OnDisk(data, _) => Err(refused_order(data, "an order to the curriculum")),
        MeantMemory::Running(name) => {
            output::show(args.ask.json, &Learner::connect_to_order(&name)?.ask(order)?, status::report)
        }
    }
}
