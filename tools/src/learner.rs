//! Asking a learner's daemon: the one place that knows the client and its errors.

use std::time::Duration;

use pschema_inspect::{Answer, Request};
use pschema_protocol::client::{Client, ClientError};
use pschema_protocol::domain::{LearnerName, Place, RuntimeDir};

use crate::failure::Failure;

/// How long a daemon may take for each page of an answer. It answers in milliseconds; this is for one that
/// is stopped or swapped out.
const ANSWER_WITHIN: Duration = Duration::from_secs(5);

impl From<ClientError> for Failure {
    fn from(error: ClientError) -> Self {
        if error.is_no_daemon() { Self::NoDaemon(error.to_string()) } else { Self::of(error) }
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

    /// Connects to the daemon that serves `place`.
    pub(crate) fn connect_at(place: &Place) -> Result<Self, Failure> {
        Ok(Self { client: Client::connect(place, ANSWER_WITHIN)? })
    }

    /// Whether the daemon connected to still serves the learner.
    pub(crate) fn is_current(&self) -> bool {
        self.client.is_current()
    }

    /// Asks, and turns the daemon's "no" into a failure.
    pub(crate) fn ask(&mut self, request: &Request) -> Result<Answer, Failure> {
        match self.client.ask(request)? {
            Answer::Error(problem) => Err(Failure::Failed(problem)),
            answer => Ok(answer),
        }
    }
}

/// Who can be asked about a learner: its daemon, or the learner itself where it is in this process.
pub(crate) trait Asks {
    /// Asks, and turns a "no" into a failure.
    fn ask(&mut self, request: &Request) -> Result<Answer, Failure>;
}

impl Asks for Learner {
    fn ask(&mut self, request: &Request) -> Result<Answer, Failure> {
        Learner::ask(self, request)
    }
}

/// An answer of a kind that the question does not have.
pub(crate) fn unexpected(answer: &Answer) -> Failure {
    let got = match answer {
        Answer::Status(_) => "a status",
        Answer::Schemas(_) => "a list of schemas",
        Answer::Schema(_) => "a schema",
        Answer::Explanation(_) => "an explanation",
        Answer::Report(_) => "a report",
        Answer::Done => "only that it is done",
        Answer::Error(_) => "an error",
        Answer::Trace(_) => "steps",
        Answer::Prediction(_) => "a prediction",
        Answer::Plan(_) => "a plan",
        Answer::Pursuit(_) => "a goal",
        Answer::Live(_) => "what is shown to those who watch",
        Answer::Graph(_) => "a graph",
        Answer::WhyNot(_) => "what stood in a schema's way",
    };
    Failure::Failed(format!(
        "the daemon answered with {got}, which was not asked for: use one release throughout"
    ))
}

/// Asks for one kind of answer: `expect!(learner, request, Answer::Status)`.
macro_rules! ask_for {
    ($learner:expr, $request:expr, $kind:path) => {
        match $learner.ask($request)? {
            $kind(answer) => Ok(answer),
            other => Err($crate::learner::unexpected(&other)),
        }
    };
}
pub(crate) use ask_for;
