//! `pschema show ID`.

use clap::Args;
use pschema_inspect::{Answer, Request};

use crate::args::{General, MemoryArgs};
use crate::failure::Failure;
use crate::learner::ask_for;
use crate::output;
use crate::past::asked;
use crate::render::{json, schema};

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema show 226")]
pub(crate) struct ShowArgs {
    #[command(flatten)]
    memory: MemoryArgs,
    /// Its number, as `pschema schemas` prints it
    id: u32,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: ShowArgs, general: &General) -> Result<(), Failure> {
    let mut memory = asked(&args.memory, general)?;
    let answer = ask_for!(memory, &Request::Show { id: args.id }, Answer::Schema)?;
    if args.json {
        output::print_json(&json::Schema::from(&*answer))
    } else {
        output::print(&schema::detail(&answer))
    }
}
