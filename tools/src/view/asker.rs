//! Asks the daemon, on a thread of its own, over one connection. The connection is made again when another daemon serves
//! the learner.

use hyper::StatusCode;
use pschema_inspect::{Ask, Report, StatusQuery};
use pschema_protocol::domain::Place;
use pschema_server::inspect::Inspect;

use super::answers::{self, About, Respondent};
use super::past::Directory;
use super::question::Question;
use super::work::{Reply, Trouble, Worker};
use crate::failure::Failure;
use crate::learner::{Asks, Learner};

/// Begins to ask the daemon that serves `place`, whenever there is one. The data directory of the daemon is kept in `directory`.
///
/// # Errors
/// When the system has no thread left.
pub(super) fn begin(place: Place, directory: Directory) -> Result<Worker, Failure> {
    let begin = move || Connection { place, directory, learner: None };
    Worker::begin("asks", begin, |connection, asked| connection.reply(asked.question))
}

struct Connection {
    place: Place,
    directory: Directory,
    learner: Option<Learner>,
}

impl Connection {
    fn reply(&mut self, question: Question) -> Reply {
        let known = self.learner.take().filter(Learner::is_current);
        let learner = known.map_or_else(|| Learner::connect_at(&self.place), Ok)?;
        let mut present = Present { learner, directory: &self.directory };
        let reply = answers::reply(question, &mut present);
        // A refusal leaves the connection as good as before.
        if reply.is_ok() || present.learner.is_current() {
            self.learner = Some(present.learner);
        }
        reply
    }
}

/// The learner as it is now, asked by its daemon.
struct Present<'a> {
    learner: Learner,
    directory: &'a Directory,
}

impl Asks for Present<'_> {
    fn ask<Q: Inspect>(&mut self, question: Q) -> Result<Q::Answer, Failure> {
        self.learner.ask(question)
    }
}

impl Respondent for Present<'_> {
    fn about(&mut self) -> Result<About, Trouble> {
        let status = self.learner.ask(StatusQuery {})?;
        let directory = status.storage.as_ref().map(|storage| storage.directory.clone());
        self.directory.is(directory.as_ref().map(Into::into));
        Ok(About {
            name: status.name,
            live: true,
            directory,
            oldest_step: status.storage.as_ref().map(|storage| storage.oldest_step),
            last_step: status.durable_step,
            version: env!("CARGO_PKG_VERSION"),
        })
    }

    fn obey<O: Ask<Answer = Report>>(&mut self, order: O) -> Result<Report, Trouble> {
        self.learner.ask(order).map_err(|failure| match failure {
            // The daemon refused the order.
            Failure::Failed(problem) if self.learner.is_current() => {
                Trouble::new(StatusCode::UNPROCESSABLE_ENTITY, problem)
            }
            failure => failure.into(),
        })
    }

    fn undecided(&self) -> Option<&str> {
        None
    }
}
