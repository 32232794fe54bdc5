//! `pschema journal`: what happened, batch by batch.

use std::path::PathBuf;

use clap::Args;
use pschema_store::past::{Batch, Past};
use serde::Serialize;

use crate::failure::Failure;
use crate::output;
use crate::render::journal::{self, DirectoryListing};

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema journal --data ~/arm\n  \
    pschema journal --data ~/arm --from 228 --to 230 --effects")]
pub(crate) struct JournalArgs {
    /// The data directory; a daemon may be running on it
    #[arg(long, value_name = "DIR")]
    data: PathBuf,
    /// From this step on
    #[arg(long, value_name = "N")]
    from: Option<u64>,
    /// Up to this step
    #[arg(long, value_name = "N")]
    to: Option<u64>,
    /// At most this many batches: the last of them, or the first ones if `--from` is given
    #[arg(long, default_value_t = 20, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    limit: u32,
    /// Say every effect in words
    #[arg(long)]
    effects: bool,
    /// Print JSON: one object a line, a batch each, and the directory last
    #[arg(long)]
    json: bool,
}

/// A line of the JSON.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub(super) enum JournalLine<'a> {
    /// What one step, one order or one attachment changed.
    Batch(&'a Batch),
    /// The directory: the last line.
    Directory(&'a DirectoryListing),
}

pub(crate) fn run(args: JournalArgs) -> Result<(), Failure> {
    if let (Some(from), Some(to)) = (args.from, args.to)
        && from > to
    {
        return Err(Failure::Usage(format!("--from {from} is above --to {to}")));
    }
    let past = Past::open(&args.data)?;
    let limit = usize::try_from(args.limit).unwrap_or(usize::MAX);
    let (batches, tail) = past.batches(args.from, args.to, limit, args.effects)?;
    let (path, learner) = (past.directory().display().to_string(), past.learner().to_owned());
    let listed = DirectoryListing { path, learner, seed: past.seed(), files: past.files()?, tail };
    if !args.json {
        return output::print(&journal::listing(&batches, &listed));
    }
    for batch in &batches {
        output::print_json_line(&JournalLine::Batch(batch))?;
    }
    output::print_json_line(&JournalLine::Directory(&listed))
}
