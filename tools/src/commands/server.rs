//! `pschema server`: the daemon, in the foreground.

use pschema_protocol::domain::{DomainError, LearnerName, Place, RuntimeDir};
use pschema_server::ServerError;

use crate::cli::ServerCommand;
use crate::failure::Failure;
use crate::run::{Stop, follow_parent, is_orphan, remove_orphaned};

use super::DEFAULT_NAME;

/// Runs until stopped. `name` is one given before the command; one given after it wins.
pub(crate) fn run(command: ServerCommand, name: Option<LearnerName>) -> Result<(), Failure> {
    let mut args = command.args;
    if let Some(name) = name.filter(|_| args.name.as_str() == DEFAULT_NAME) {
        args.name = name;
    }
    let parent = command.parent.parent;
    let stop = Stop::on_signals()?;
    follow_parent(parent)?;
    pschema_server::run(&args, &stop.flag())?;
    if is_orphan(parent) {
        remove_orphaned(&Place::new(RuntimeDir::from_environment()?, args.name), parent);
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
