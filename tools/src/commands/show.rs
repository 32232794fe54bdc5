//! `pschema show ID`.

use clap::Args;
use pschema_inspect::DetailQuery;

use crate::args::{General, MemoryArgs};
use crate::failure::Failure;
use crate::learner::Asks;
use crate::output;
use crate::past::asked;
use crate::render::schema;

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
    output::show(args.json, &memory.ask(DetailQuery { id: args.id })?, schema::detail)
}
