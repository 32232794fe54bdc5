//! Asking the daemon, on a thread of its own: one connection, made again when the daemon is another.

use hyper::StatusCode;
use pschema_inspect::Answer;
use pschema_protocol::domain::Place;

use super::answers::{self, About};
use super::question::{Asked, Question};
use super::remembered::Directory;
use super::work::{Reply, Trouble, Worker};
use crate::failure::Failure;
use crate::learner::{Learner, unexpected};

/// Where questions for the daemon are put.
#[derive(Clone, Debug)]
pub(super) struct Asker(Worker);

impl Asker {
    /// Begins to ask the daemon that serves `place`, whenever there is one; says in `directory` where its memory is.
    ///
    /// # Errors
    /// When the system has no thread left.
    pub(super) fn begin(place: Place, directory: Directory) -> Result<Self, Failure> {
        let begin = move || Connection { place, directory, learner: None };
        Ok(Self(Worker::begin("asks", begin, |connection, asked| connection.reply(asked.question))?))
    }

    /// Asks.
    pub(super) async fn ask(&self, question: Question) -> Reply {
        self.0.ask(Asked { question, until: None }).await
    }
}

struct Connection {
    place: Place,
    directory: Directory,
    learner: Option<Learner>,
}

impl Connection {
    fn reply(&mut self, question: Question) -> Reply {
        let about = question == Question::About;
        match self.answer(question)? {
            Answer::Status(status) if about => {
                let directory = status.storage.as_ref().map(|storage| storage.directory.clone());
                self.directory.is(directory.as_ref().map(Into::into));
                answers::json(&About {
                    name: status.name.clone(),
                    live: true,
                    directory,
                    oldest_step: status.storage.as_ref().map(|storage| storage.oldest_step),
                    last_step: status.durable_step,
                    version: env!("CARGO_PKG_VERSION"),
                })
            }
            answer if about => Err(unexpected(&answer).into()),
            answer => answers::answer(&answer, None),
        }
    }

    fn answer(&mut self, question: Question) -> Result<Answer, Trouble> {
        let order = question.is_order();
        let request = question.request();
        let known = self.learner.take().filter(Learner::is_current);
        let mut learner = known.map_or_else(|| Learner::connect_at(&self.place), Ok)?;
        match learner.ask(&request) {
            Ok(answer) => {
                self.learner = Some(learner);
                Ok(answer)
            }
            // The daemon's "no"; the connection is as good as before.
            Err(Failure::Failed(problem)) if learner.is_current() => {
                self.learner = Some(learner);
                Err(Trouble::new(StatusCode::UNPROCESSABLE_ENTITY, problem))
            }
            Err(failure) if order => {
                let problem = format!("{failure} (whether the order was obeyed is not known)");
                Err(Trouble { problem, ..failure.into() })
            }
            Err(failure) => Err(failure.into()),
        }
    }
}
