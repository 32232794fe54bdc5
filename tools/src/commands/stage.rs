//! `pschema stage [show|next|hold|resume|step|set NAME]`.

use clap::{Args, ValueEnum};
use pschema_inspect::{ReportQuery, StageOrder};

use crate::args::{AskArgs, General, MeantMemory, refused_order};
use crate::failure::Failure;
use crate::learner::Learner;
use crate::output;
use crate::past::show;
use crate::render::status;

#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  pschema stage show --json\n  pschema stage next\n  pschema stage set 'first touches'"
)]
pub(crate) struct StageArgs {
    #[command(flatten)]
    ask: AskArgs,
    /// What is to be done
    // No command of its own with options of its own: of an option that stood before the order and behind it as well, clap
    // would obey the second alone.
    #[arg(value_enum, default_value_t)]
    order: Order,
    /// The name of the stage, for `set`
    #[arg(required_if_eq("order", "set"))]
    stage: Option<String>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Order {
    /// Say where the curriculum stands
    #[default]
    Show,
    /// End the present stage and enter the next
    Next,
    /// Wait: nothing is done until `resume`
    Hold,
    /// Go on after `hold`
    Resume,
    /// Take one action, and wait again
    Step,
    /// Enter a stage of the curriculum, or enter it again
    Set,
}

pub(crate) fn run(args: StageArgs, general: &General) -> Result<(), Failure> {
    if let (Some(stage), true) = (&args.stage, args.order != Order::Set) {
        return Err(Failure::Usage(format!(
            "only `stage set` takes the name of a stage: leave out {stage:?}"
        )));
    }
    let order = match args.order {
        Order::Show => None,
        Order::Next => Some(StageOrder::Next),
        Order::Hold => Some(StageOrder::Hold),
        Order::Resume => Some(StageOrder::Resume),
        Order::Step => Some(StageOrder::Step),
        Order::Set => Some(StageOrder::Set(args.stage.unwrap_or_default())),
    };
    let name = match args.ask.memory.meant(general)? {
        MeantMemory::Running(name) => name,
        MeantMemory::OnDisk(..) if order.is_none() => {
            return show(&args.ask, general, ReportQuery {}, status::report);
        }
        MeantMemory::OnDisk(data, _) => return Err(refused_order(data, "an order to the curriculum")),
    };
    // The place is given back before anything is printed: who reads may take long.
    let mut learner = Learner::connect_as_operator(&name)?;
    let report = match order {
        None => learner.ask(ReportQuery {})?,
        Some(order) => learner.ask(order)?,
    };
    drop(learner);
    output::show(args.ask.json, &report, status::report)
}
