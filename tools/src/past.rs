//! Asking a memory on disk what a daemon would be asked: the answers come from the same code.

use std::path::Path;

use pschema_inspect::{Answer, Request, SchemaSort};
use pschema_server::inspect;
use pschema_server::mind::{HostFacts, View};
use pschema_store::past::{Moment, Past, PastError};

use crate::args::{General, MemoryArgs};
use crate::failure::Failure;
use crate::learner::{Asks, Learner};

impl From<PastError> for Failure {
    fn from(error: PastError) -> Self {
        Self::of(error)
    }
}

/// Whom to ask about a memory: the learner's daemon, or the memory on disk if a data directory is given.
pub(crate) fn asked(memory: &MemoryArgs, general: &General) -> Result<Box<dyn Asks>, Failure> {
    match &memory.data.data {
        None => Ok(Box::new(Learner::connect(&memory.name.learner(general)?)?)),
        Some(directory) => Ok(Box::new(Remembered::open(directory, memory.data.until)?)),
    }
}

/// The answer to what is asked about a decision: of the daemon, while it keeps it; else of the memory that the daemon
/// keeps on disk, which is only read, and delays nothing.
pub(crate) fn answered(memory: &MemoryArgs, general: &General, request: &Request) -> Result<Answer, Failure> {
    if memory.data.data.is_some() {
        return asked(memory, general)?.ask(request);
    }
    let mut learner = Learner::connect(&memory.name.learner(general)?)?;
    let problem = match learner.ask(request) {
        Err(Failure::Failed(problem)) => problem,
        answered => return answered,
    };
    let Answer::Status(status) = learner.ask(&Request::Status)? else { return Err(Failure::Failed(problem)) };
    let Some(storage) = status.storage else {
        return Err(Failure::Failed(format!(
            "{problem}. Nothing older is kept: the daemon has its memory in RAM only; with `pschema server --data DIR` it \
             keeps all of it"
        )));
    };
    Remembered::open(Path::new(&storage.directory), None)?.ask(request)
}

/// A memory on disk, as it was at one moment.
#[derive(Debug)]
pub(crate) struct Remembered {
    past: Past,
    until: Option<u64>,
}

impl Remembered {
    /// The memory in `directory`, as it was after step `until`.
    pub(crate) fn open(directory: &Path, until: Option<u64>) -> Result<Self, Failure> {
        Ok(Self { past: Past::open(directory)?, until })
    }

    /// What is on disk.
    pub(crate) fn past(&self) -> &Past {
        &self.past
    }

    /// What of the past is needed to answer.
    pub(crate) fn moment(&self, request: &Request) -> Result<Moment, Failure> {
        Ok(match request {
            Request::Explain { step, .. } | Request::WhyNot { step, .. } => {
                self.past.decision(*step, self.until)?
            }
            Request::Status => self.past.moment_with_decision(self.until)?,
            Request::Schemas(query) if query.sort == SchemaSort::Excitation => {
                self.past.moment_with_decision(self.until)?
            }
            _ => self.past.moment(self.until)?,
        })
    }

    /// What is answered of a moment.
    pub(crate) fn answer(&self, moment: Moment, request: &Request) -> Result<Answer, Failure> {
        let nothing_perceived = moment.perceived.is_none();
        let of_the_world = match request {
            Request::Predict { .. } | Request::Plan { .. } => true,
            Request::Graph(query) => !query.goal.is_empty(),
            _ => false,
        };
        if nothing_perceived && of_the_world {
            let step = moment.step();
            return Err(Failure::Failed(format!(
                "nothing is known of what was perceived up to step {step}, so nothing can be said of the world as it was: \
                 name a later step with --until, or ask the running learner"
            )));
        }
        match inspect::answer(&self.view(moment), request) {
            Answer::Error(problem) => Err(Failure::Failed(problem)),
            answer => Ok(answer),
        }
    }

    /// Everything there is to ask of a moment.
    pub(crate) fn view(&self, moment: Moment) -> View {
        let host = HostFacts {
            name: self.past.learner().to_owned(),
            perceived: moment.perceived,
            ..HostFacts::default()
        };
        View::past(moment.learner, self.past.seed(), moment.decision, host)
    }
}

impl Asks for Remembered {
    fn ask(&mut self, request: &Request) -> Result<Answer, Failure> {
        let moment = self.moment(request)?;
        self.answer(moment, request)
    }
}
