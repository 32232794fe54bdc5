//! `pschema journal`: what happened, batch by batch.

use pschema_store::past::Past;
use serde::Serialize;

use crate::cli::JournalArgs;
use crate::failure::Failure;
use crate::output;
use crate::render::journal::{self, Listing};

/// The last line of the JSON.
#[derive(Serialize)]
struct Directory<'a> {
    directory: &'a journal::Listed,
}

/// The others.
#[derive(Serialize)]
struct Line<'a> {
    batch: &'a pschema_store::past::Batch,
}

pub(crate) fn run(args: &JournalArgs) -> Result<(), Failure> {
    if let (Some(from), Some(to)) = (args.from, args.to)
        && from > to
    {
        return Err(Failure::Usage(format!("--from {from} is above --to {to}")));
    }
    let past = Past::open(&args.data)?;
    let limit = usize::try_from(args.limit).unwrap_or(usize::MAX);
    let (batches, tail) = past.batches(args.from, args.to, limit, args.effects)?;
    let (path, learner) = (past.directory().display().to_string(), past.learner().to_owned());
    let listed = journal::Listed { path, learner, seed: past.seed(), files: past.files()?, tail };
    if !args.json {
        return output::print(&journal::listing(&Listing { batches: &batches, listed: &listed }));
    }
    for batch in &batches {
        output::print_json_line(&Line { batch })?;
    }
    output::print_json_line(&Directory { directory: &listed })
}
