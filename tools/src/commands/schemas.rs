//! `pschema schemas`.

use clap::{Args, ValueEnum};
use pschema_inspect::{SchemaQuery, SchemaSort};

use crate::args::{AskArgs, General};
use crate::failure::Failure;
use crate::past::show;
use crate::render::schema;

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema schemas --generalised\n  \
    pschema schemas --post 'touch{}' --sort probability --limit 5")]
pub(crate) struct SchemasArgs {
    #[command(flatten)]
    ask: AskArgs,
    /// Only those with this action
    #[arg(long, value_name = "NAME")]
    action: Option<String>,
    /// Only those with a pre-condition like this, written as schemas print: 'object{colour=blue}'
    #[arg(long, value_name = "PATTERN")]
    pre: Option<String>,
    /// Only those with a post-condition like this
    #[arg(long, value_name = "PATTERN")]
    post: Option<String>,
    /// Only generalised ones
    #[arg(long)]
    generalised: bool,
    /// The order
    #[arg(long, value_enum, default_value_t)]
    sort: Sort,
    /// At most this many
    #[arg(long, default_value_t = 20, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    limit: u32,
    /// Leave out so many of the first: with --limit, page by page
    #[arg(long, default_value_t = 0, value_name = "N")]
    offset: u32,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Sort {
    /// The oldest first
    #[default]
    Age,
    /// The most executed first
    Uses,
    /// The surest to succeed first
    Probability,
    /// The most exciting in the last decision first
    Excitation,
}

impl From<Sort> for SchemaSort {
    fn from(sort: Sort) -> Self {
        match sort {
            Sort::Age => Self::Age,
            Sort::Uses => Self::Uses,
            Sort::Probability => Self::Probability,
            Sort::Excitation => Self::Excitation,
        }
    }
}

pub(crate) fn run(args: SchemasArgs, general: &General) -> Result<(), Failure> {
    let query = SchemaQuery {
        action: args.action,
        pre: args.pre,
        post: args.post,
        generalised: args.generalised,
        sort: args.sort.into(),
        limit: args.limit,
        offset: args.offset,
    };
    show(&args.ask, general, query, |list| schema::list(list, args.offset))
}
