//! `pschema server`: the daemon, in the foreground.

use clap::Args;
use pschema_process::Stop;
use pschema_protocol::domain::{DomainError, Place, RuntimeDir};
use pschema_server::{ServerArgs, ServerError};

use crate::args::{General, OwnName, ParentArgs};
use crate::failure::Failure;
use crate::run::{follow_parent, is_orphan, remove_orphaned};

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema --name robot-1 server")]
pub(crate) struct ServerCommand {
    // Read before the options below are taken out of what was typed.
    #[command(flatten)]
    own_name: OwnName,
    #[command(flatten)]
    args: ServerArgs,
    /// Write the log as JSON, one object a line
    #[arg(long)]
    pub(crate) log_json: bool,
    #[command(flatten)]
    parent: ParentArgs,
}

/// Runs until stopped.
pub(crate) fn run(command: ServerCommand, general: &General) -> Result<(), Failure> {
    let mut args = command.args;
    if let Some(name) = general.name_instead_of(command.own_name, args.name.as_str())? {
        args.name = name.clone();
    }
    serve(&args, command.parent)
}

/// Runs the daemon until stopped, or until the process that started it has died.
///
/// # Errors
/// When the daemon can't be run.
pub fn serve(args: &ServerArgs, ParentArgs { parent }: ParentArgs) -> Result<(), Failure> {
    let stop = Stop::on_signals()?;
    follow_parent(parent)?;
    pschema_server::run(args, &stop.flag())?;
    if is_orphan(parent) {
        remove_orphaned(&Place::new(RuntimeDir::from_environment()?, args.name.clone()), parent);
    }
    Ok(())
}

impl From<ServerError> for Failure {
    fn from(error: ServerError) -> Self {
        match error {
            ServerError::Domain(error @ DomainError::LearnerName { .. }) => error.into(),
            error => Self::of(error),
        }
    }
}
