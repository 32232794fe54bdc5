//! `pschema predict ACTION`.

use clap::Args;
use pschema_inspect::{Answer, Request};

use crate::args::{General, MemoryArgs};
use crate::failure::Failure;
use crate::learner::ask_for;
use crate::output;
use crate::past::asked;
use crate::render::{goals, json_goals};

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
    let answer = ask_for!(memory, &Request::Predict { action: args.action }, Answer::Prediction)?;
    if args.json {
        output::print_json(&json_goals::Prediction::from(&*answer))
    } else {
        output::print(&goals::prediction(&answer))
    }
}
