//! `pschema adept`: the Adept arm on its serial line.

use pschema_adept::AdeptError;
use pschema_protocol::domain::{DomainError, LearnerName};

use crate::cli::AdeptCommand;
use crate::failure::Failure;
use crate::run::follow_parent;

use super::DEFAULT_NAME;

/// Runs until stopped or sent away. `name` is one given before the command; one given after it wins.
pub(crate) fn run(command: AdeptCommand, name: Option<LearnerName>) -> Result<(), Failure> {
    let mut args = command.args;
    if let Some(name) = name.filter(|_| args.name == DEFAULT_NAME) {
        name.as_str().clone_into(&mut args.name);
    }
    follow_parent(command.parent.parent)?;
    if let Some(summary) = pschema_adept::run(&args)? {
        let (frames, orders, refused) = (summary.frames, summary.orders, summary.refused);
        tracing::info!(frames, orders, refused, sessions = summary.sessions, ending = ?summary.ending, "body ended");
    }
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
