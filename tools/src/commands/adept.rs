//! `pschema adept`: the Adept arm on its serial line.

use clap::Args;
use pschema_adept::AdeptError;
use pschema_protocol::domain::DomainError;

use crate::args::{General, OwnName, ParentArgs};
use crate::failure::Failure;
use crate::run::follow_parent;

use super::sim::body_ended;

#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  pschema adept --port /dev/ttyS0 --arm my-arm.toml --camera folder:/var/camera"
)]
pub(crate) struct AdeptCommand {
    // Read before the options below are taken out of what was typed.
    #[command(flatten)]
    own_name: OwnName,
    #[command(flatten)]
    parent: ParentArgs,
    #[command(flatten)]
    args: pschema_adept::AdeptArgs,
}

/// Runs until stopped or sent away.
pub(crate) fn run(command: AdeptCommand, general: &General) -> Result<(), Failure> {
    let mut args = command.args;
    if let Some(name) = general.name_instead_of(command.own_name, &args.name)? {
        name.as_str().clone_into(&mut args.name);
    }
    follow_parent(command.parent.parent)?;
    pschema_adept::run(&args)?.iter().for_each(body_ended);
    Ok(())
}

impl From<AdeptError> for Failure {
    fn from(error: AdeptError) -> Self {
        match error {
            AdeptError::Usage(_) => Self::Usage(error.to_string()),
            AdeptError::Domain(error @ DomainError::LearnerName { .. }) => error.into(),
            error => Self::of(error),
        }
    }
}
