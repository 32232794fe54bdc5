//! `pschema emulator`: the Adept arm's controller, emulated.

use crate::cli::EmulatorCommand;
use crate::failure::Failure;
use crate::run::{Stop, follow_parent};

/// Runs until stopped.
pub(crate) fn run(command: EmulatorCommand) -> Result<(), Failure> {
    let stop = Stop::on_signals()?;
    follow_parent(command.parent.parent)?;
    let args = command.args;
    let ready = || tracing::info!(line = %args.link.display(), world = %args.world, "the emulated controller is ready");
    pschema_vplus_emulator::run(&args, &stop.flag(), ready).map_err(Failure::of)
}
