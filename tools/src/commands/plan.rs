//! `pschema plan PATTERN...`.

use clap::Args;
use pschema_inspect::PlanQuery;

use crate::args::{AskArgs, General};
use crate::failure::Failure;
use crate::past::show;
use crate::render::goals;

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema plan 'touch{}'\n  \
    pschema plan 'object{colour=blue, field=$x}' 'finger{field=$x}'")]
pub(crate) struct PlanArgs {
    #[command(flatten)]
    ask: AskArgs,
    /// What is wanted, all of it: patterns as schemas print; a variable is the same value in all of them
    #[arg(required = true, value_name = "PATTERN")]
    goal: Vec<String>,
}

pub(crate) fn run(args: PlanArgs, general: &General) -> Result<(), Failure> {
    show(&args.ask, general, PlanQuery { goal: args.goal }, goals::plan)
}
