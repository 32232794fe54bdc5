//! `pschema emulator`: the Adept arm's controller, emulated.

use clap::Args;
use pschema_process::Stop;

use crate::args::ParentArgs;
use crate::failure::Failure;
use crate::run::follow_parent;

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema emulator --link /tmp/adept --camera /tmp/adept-camera \
    --operator /tmp/adept-operator --fast 10 --consent")]
pub(crate) struct EmulatorCommand {
    #[command(flatten)]
    args: pschema_vplus_emulator::EmulatorArgs,
    #[command(flatten)]
    parent: ParentArgs,
}

/// Runs until stopped.
pub(crate) fn run(command: EmulatorCommand) -> Result<(), Failure> {
    let stop = Stop::on_signals()?;
    follow_parent(command.parent.parent)?;
    let args = command.args;
    let ready = || tracing::info!(line = %args.link.display(), world = %args.world, "the emulated controller is ready");
    pschema_vplus_emulator::run(&args, &stop.flag(), ready).map_err(Failure::of)
}
