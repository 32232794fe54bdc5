//! `pschema verify`: checks every byte of a memory on disk.

use pschema_store::past::{Past, Progress};

use crate::bar::Bar;
use crate::cli::VerifyArgs;
use crate::failure::Failure;
use crate::output;
use crate::render::journal;

pub(crate) fn run(args: &VerifyArgs, quiet: bool) -> Result<(), Failure> {
    let past = Past::open(&args.data)?;
    let bar = Bar::bytes(quiet);
    let mut told = |Progress { bytes, of, step }| bar.show(bytes, of, format!("step {step}"));
    let checked = past.verify(args.relearn, &mut told)?;
    drop(bar);
    if args.json {
        output::print_json(&checked)?;
    } else {
        output::print(&journal::checked(&checked, args.relearn))?;
    }
    if checked.sound {
        return Ok(());
    }
    let things = crate::render::words::count(checked.findings.len() as u64, "thing");
    let are = if checked.findings.len() == 1 { "is" } else { "are" };
    Err(Failure::Failed(format!("{things} in {} {are} wrong", checked.directory)))
}
