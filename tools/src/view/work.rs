//! Hands questions from the asynchronous server to a thread that blocks, and brings the answers back.

use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};

use hyper::StatusCode;
use serde::Serialize;
use tokio::sync::oneshot;

use super::question::PageQuestion;
use crate::failure::Failure;

/// Questions that may wait for one thread.
const WAITING_MAX: usize = 16;

/// An answer as JSON, or why there is none.
pub(super) type Reply = Result<Vec<u8>, Trouble>;

/// The reason why a question is not answered.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Trouble {
    /// The status in HTTP.
    #[serde(skip)]
    pub(super) status: StatusCode,
    /// What happened and what to do, for people.
    pub(super) problem: String,
    /// Whether the reason is that no daemon runs.
    pub(super) no_daemon: bool,
}

impl Trouble {
    /// A reason with its status.
    pub(super) fn new(status: StatusCode, problem: impl Into<String>) -> Self {
        Self { status, problem: problem.into(), no_daemon: false }
    }
}

impl From<Failure> for Trouble {
    fn from(failure: Failure) -> Self {
        let no_daemon = matches!(failure, Failure::NoDaemon(_));
        let status = match failure {
            Failure::NoDaemon(_) => StatusCode::SERVICE_UNAVAILABLE,
            Failure::Usage(_) => StatusCode::BAD_REQUEST,
            _ => StatusCode::UNPROCESSABLE_ENTITY,
        };
        Self { status, problem: failure.to_string(), no_daemon }
    }
}

/// Takes questions for one thread.
#[derive(Clone, Debug)]
pub(super) struct Worker(SyncSender<Job>);

type Job = (PageQuestion, oneshot::Sender<Reply>);

impl Worker {
    /// Starts a thread that answers questions one after the other with what `begin` makes there, until nobody is left to
    /// ask. A question that nobody waits for any more is not answered.
    ///
    /// # Errors
    /// When the system has no thread left.
    pub(super) fn begin<W>(
        name: &str,
        begin: impl FnOnce() -> W + Send + 'static,
        answer: impl Fn(&mut W, PageQuestion) -> Reply + Send + 'static,
    ) -> Result<Self, Failure> {
        let (to, from): (_, Receiver<Job>) = sync_channel(WAITING_MAX);
        let thread = std::thread::Builder::new().name(name.to_owned());
        let work = move || {
            let mut with = begin();
            for (asked, reply) in from {
                if !reply.is_closed() {
                    // The page may have gone meanwhile.
                    drop(reply.send(answer(&mut with, asked)));
                }
            }
        };
        thread.spawn(work).map_err(|error| Failure::Failed(format!("cannot start a thread: {error}")))?;
        Ok(Self(to))
    }

    /// Asks, and waits for the answer without blocking.
    pub(super) async fn ask(&self, asked: PageQuestion) -> Reply {
        let (to, answer) = oneshot::channel();
        match self.0.try_send((asked, to)) {
            Ok(()) => (),
            Err(TrySendError::Full(_)) => {
                let problem = format!("{WAITING_MAX} questions are waiting already: ask again in a moment");
                return Err(Trouble::new(StatusCode::TOO_MANY_REQUESTS, problem));
            }
            Err(TrySendError::Disconnected(_)) => return Err(ended()),
        }
        answer.await.unwrap_or_else(|_| Err(ended()))
    }
}

fn ended() -> Trouble {
    Trouble::new(
        StatusCode::INTERNAL_SERVER_ERROR,
        "what answers this question has ended unexpectedly: start `pschema view` again",
    )
}
