//! `pschema predict ACTION`.

use clap::Args;
use pschema_inspect::PredictionQuery;

use crate::args::{General, MemoryArgs};
use crate::failure::Failure;
use crate::learner::Asks;
use crate::output;
use crate::past::asked;
use crate::render::goals;

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema predict 'move(j1=0.426, j2=0.817)'")]
pub(crate) struct PredictArgs {
    #[command(flatten)]
    memory: MemoryArgs,
    /// The action, written as schemas print it
    action: String,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: PredictArgs, general: &General) -> Result<(), Failure> {
    let mut memory = asked(&args.memory, general)?;
    output::show(args.json, &memory.ask(PredictionQuery { action: args.action })?, goals::prediction)
}
