//! `pschema predict ACTION`.

use clap::Args;
use pschema_inspect::PredictionQuery;

use crate::args::{AskArgs, General};
use crate::failure::Failure;
use crate::past::show;
use crate::render::goals;

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema predict 'move(j1=0.426, j2=0.817)'")]
pub(crate) struct PredictArgs {
    #[command(flatten)]
    ask: AskArgs,
    /// The action, written as schemas print it
    action: String,
}

pub(crate) fn run(args: PredictArgs, general: &General) -> Result<(), Failure> {
    show(&args.ask, general, PredictionQuery { action: args.action }, goals::prediction)
}
