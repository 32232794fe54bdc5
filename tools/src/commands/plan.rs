//! `pschema plan PATTERN...`.

use clap::Args;
use pschema_inspect::PlanQuery;

use crate::args::{General, MemoryArgs};
use crate::failure::Failure;
use crate::learner::Asks;
use crate::output;
use crate::past::asked;
use crate::render::goals;

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema plan 'touch{}'\n  \
    pschema plan 'object{colour=blue, field=$x}' 'finger{field=$x}'")]
pub(crate) struct PlanArgs {
    #[command(flatten)]
    memory: MemoryArgs,
    /// What is wanted, all of it: patterns as schemas print; a variable is the same value in all of them
    #[arg(required = true, value_name = "PATTERN")]
    goal: Vec<String>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: PlanArgs, general: &General) -> Result<(), Failure> {
    let mut memory = asked(&args.memory, general)?;
    output::show(args.json, &memory.ask(PlanQuery { goal: args.goal })?, goals::plan)
}
