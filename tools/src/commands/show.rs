//! `pschema show ID`.

use clap::Args;
use pschema_inspect::DetailQuery;

use crate::args::{AskArgs, General};
use crate::failure::Failure;
use crate::past::show;
use crate::render::schema;

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema show 226")]
pub(crate) struct ShowArgs {
    #[command(flatten)]
    ask: AskArgs,
    /// Its number, as `pschema schemas` prints it
    id: u32,
}

pub(crate) fn run(args: ShowArgs, general: &General) -> Result<(), Failure> {
    show(&args.ask, general, DetailQuery { id: args.id }, schema::detail)
}
