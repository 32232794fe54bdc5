//! Asking a learner's daemon: the one place that knows the client and its errors.

use std::time::Duration;

use pschema_inspect::{Ask, AskError, Request, ask};
use pschema_protocol::client::{Client, ClientError, Purpose};
use pschema_protocol::domain::{LearnerName, Place, RuntimeDir};
use pschema_server::inspect::Inspect;

use crate::failure::Failure;

/// How long a daemon may take for each page of an answer. It answers in milliseconds; this is for one that
/// is stopped or swapped out, and for an order, which waits for the disk.
const ANSWER_WITHIN: Duration = Duration::from_secs(5);

impl From<ClientError> for Failure {
    fn from(error: ClientError) -> Self {
        if error.is_no_daemon() { Self::NoDaemon(error.to_string()) } else { Self::of(error) }
    }
}

impl From<AskError<ClientError>> for Failure {
    fn from(error: AskError<ClientError>) -> Self {
        match error {
            AskError::Problem(problem) => Self::Failed(problem.0),
            AskError::Codec(error) => Self::Failed(format!("{error}: use one release throughout")),
            AskError::Send(error) => error.into(),
        }
    }
}

/// A connection to the daemon of one learner.
pub(crate) struct Learner {
    client: Client,
}

impl Learner {
    /// Connects to the daemon of `name` in the runtime directory that the environment says.
    pub(crate) fn connect(name: &LearnerName) -> Result<Self, Failure> {
        Self::connect_at(&Place::new(RuntimeDir::from_environment()?, name.clone()))
    }

    /// Connects to the daemon of `name`, to give an order, or to ask how it is and to leave at once: places are kept for that, however
    /// many tools are connected.
    pub(crate) fn connect_as_operator(name: &LearnerName) -> Result<Self, Failure> {
        let place = Place::new(RuntimeDir::from_environment()?, name.clone());
        Ok(Self { client: Client::connect_for(Purpose::Order, &place, ANSWER_WITHIN)? })
    }

    /// Connects to the daemon that serves `place`.
    pub(crate) fn connect_at(place: &Place) -> Result<Self, Failure> {
        Ok(Self { client: Client::connect(place, ANSWER_WITHIN)? })
    }

    /// Whether the daemon connected to still serves the learner.
    pub(crate) fn is_current(&self) -> bool {
        self.client.is_current()
    }

    /// Asks or orders; that the daemon does not answer is a failure.
    pub(crate) fn ask<Q: Ask>(&mut self, asked: Q) -> Result<Q::Answer, Failure> {
        let is_order = matches!(asked.clone().into(), Request::Order(_));
        ask(asked, |request| self.client.request(request)).map_err(|error| match error {
            AskError::Send(error) if is_order && error.is_unanswered() => {
                let told =
                    format!("{error} (whether the order was obeyed is not known: `pschema status` tells)");
                if error.is_no_daemon() { Failure::NoDaemon(told) } else { Failure::Failed(told) }
            }
            error => error.into(),
        })
    }
}

/// Who can be asked about a learner: its daemon, its memory on disk, or the learner itself where it is in this process.
pub(crate) trait Asks {
    /// The answer; that there is none is a failure.
    fn ask<Q: Inspect>(&mut self, question: Q) -> Result<Q::Answer, Failure>;
}

impl Asks for Learner {
    fn ask<Q: Inspect>(&mut self, question: Q) -> Result<Q::Answer, Failure> {
        Learner::ask(self, question)
    }
}
