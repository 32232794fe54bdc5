//! `pschema repair`: saves what can be saved of a damaged memory on disk, after a copy of everything.

use std::path::PathBuf;

use clap::Args;
use pschema_store::past::{Past, RepairOutcome, RepairPlan};
use serde::Serialize;

use crate::failure::Failure;
use crate::output;
use crate::render::journal;

#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  pschema repair --data ~/arm --dry-run\n  pschema repair --data ~/arm\n\n\
    Nothing is destroyed: everything is copied aside before anything is cut."
)]
pub(crate) struct RepairArgs {
    /// The data directory; no daemon may be running on it
    #[arg(long, value_name = "DIR")]
    data: PathBuf,
    /// Leave it as it is, and put what can be saved into this directory, which is made
    #[arg(long, value_name = "DIR", conflicts_with = "dry_run")]
    to: Option<PathBuf>,
    /// Only say what would be done
    #[arg(long)]
    dry_run: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// What is damaged and can be saved, and what was done about it.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct RepairReport<'a> {
    #[serde(flatten)]
    plan: &'a RepairPlan,
    /// What was done; none when nothing was to be done, or the plan alone was asked for.
    done: Option<&'a RepairOutcome>,
}

pub(crate) fn run(args: RepairArgs) -> Result<(), Failure> {
    let past = Past::open(&args.data)?;
    let plan = past.plan_repair()?;
    if !args.json {
        output::print(&journal::repair(&plan))?;
    }
    let done = match &args.to {
        _ if args.dry_run => None,
        Some(to) => Some(past.repair_to(&plan, to)?),
        None if plan.damage.is_empty() => None,
        None => Some(past.repair(&plan)?),
    };
    if args.json {
        return output::print_json(&RepairReport { plan: &plan, done: done.as_ref() });
    }
    match &done {
        Some(done) => output::print(&said(done)),
        None if args.dry_run && !plan.damage.is_empty() => {
            output::print("\nNothing was changed. Without --dry-run, everything is copied aside first.\n")
        }
        None => Ok(()),
    }
}

fn said(done: &RepairOutcome) -> String {
    let directory = &done.directory;
    let aside = match &done.aside {
        Some(aside) => format!("\nEverything as it was is in {aside}.\n"),
        None => "\nThe damaged directory was left as it is.\n".to_owned(),
    };
    format!("{aside}Mended. Go on from there with: pschema server --data {directory}\n")
}
