//! `pschema claims [ACTION]`.

use clap::Args;
use pschema_inspect::ClaimQuery;

use crate::args::{AskArgs, General};
use crate::failure::Failure;
use crate::past::show;
use crate::render::claims;

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema claims move\n  pschema claims 'move(j1=0.426, j2=0.817)'")]
pub(crate) struct ClaimsArgs {
    #[command(flatten)]
    ask: AskArgs,
    /// Only those about this action; or, written as schemas print it, about it with these parameters alone
    action: Option<String>,
    /// At most so many trees
    #[arg(long, default_value_t = 20, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    limit: u32,
    /// Leave out so many of the first: with --limit, page by page
    #[arg(long, default_value_t = 0, value_name = "N")]
    offset: u32,
}

pub(crate) fn run(args: ClaimsArgs, general: &General) -> Result<(), Failure> {
    let query = ClaimQuery { action: args.action, limit: args.limit, offset: args.offset };
    show(&args.ask, general, query, |list| claims::list(list, args.offset))
}
