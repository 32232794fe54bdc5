//! `pschema verify`: checks every byte of a memory on disk.

use std::path::PathBuf;

use clap::Args;
use pschema_store::past::{Past, VerificationProgress};

use crate::args::General;
use crate::bar::Bar;
use crate::failure::Failure;
use crate::output;
use crate::render::journal;

#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  pschema verify --data ~/arm\n  pschema verify --data ~/arm --relearn\n\n\
    It exits with 0 when everything is sound, else with 1."
)]
pub(crate) struct VerifyArgs {
    /// The data directory; a daemon may be running on it
    #[arg(long, value_name = "DIR")]
    data: PathBuf,
    /// Put every frame that a body sent through a learner once more, and compare what it changes
    #[arg(long)]
    relearn: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: VerifyArgs, general: &General) -> Result<(), Failure> {
    let past = Past::open(&args.data)?;
    let bar = Bar::bytes(general.quiet());
    let mut told = |VerificationProgress { bytes, of, step }| bar.show(bytes, of, format!("step {step}"));
    let checked = past.verify(args.relearn, &mut told)?;
    drop(bar);
    output::show(args.json, &checked, |checked| journal::checked(checked, args.relearn))?;
    if checked.sound {
        return Ok(());
    }
    let things = crate::render::words::count(checked.findings.len() as u64, "thing");
    let are = if checked.findings.len() == 1 { "is" } else { "are" };
    Err(Failure::Failed(format!("{things} in {} {are} wrong", checked.directory)))
}
