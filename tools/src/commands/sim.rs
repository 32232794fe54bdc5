//! `pschema sim`: the simulated body.

use clap::Args;
use pschema_protocol::body::RunSummary;
use pschema_protocol::domain::DomainError;
use pschema_sim::SimError;

use crate::args::{General, OwnName, ParentArgs};
use crate::failure::Failure;
use crate::run::follow_parent;

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema --name robot-1 sim --realtime")]
pub(crate) struct SimCommand {
    // Read before the options below are taken out of what was typed.
    #[command(flatten)]
    own_name: OwnName,
    #[command(flatten)]
    args: pschema_sim::SimArgs,
    #[command(flatten)]
    parent: ParentArgs,
}

/// Runs until stopped or sent away.
pub(crate) fn run(command: SimCommand, general: &General) -> Result<(), Failure> {
    let mut args = command.args;
    if let Some(name) = general.name_instead_of(command.own_name, &args.name)? {
        name.as_str().clone_into(&mut args.name);
    }
    follow_parent(command.parent.parent)?;
    pschema_sim::run(&args)?.iter().for_each(body_ended);
    Ok(())
}

/// Logs what a body has done.
pub(super) fn body_ended(summary: &RunSummary) {
    let (frames, orders, refused) = (summary.frames, summary.orders, summary.refused);
    tracing::info!(frames, orders, refused, sessions = summary.sessions, ending = ?summary.ending, "body ended");
}

impl From<SimError> for Failure {
    fn from(error: SimError) -> Self {
        match error {
            SimError::Domain(error @ DomainError::LearnerName { .. }) => error.into(),
            error => Self::of(error),
        }
    }
}
