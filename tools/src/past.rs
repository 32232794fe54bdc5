//! Asking a memory on disk what a daemon would be asked: the answers come from the same code.

use std::path::Path;

use pschema_inspect::{GraphQuery, Question, Request, SchemaSort, StatusQuery};
use pschema_server::inspect::{Inspect, reply};
use pschema_server::view::View;
use pschema_store::past::{Moment, Past, PastError};

use crate::args::{AskArgs, General, MeantMemory, MemoryArgs};
use crate::failure::Failure;
use crate::learner::{Asks, Learner};
use crate::output;

impl From<PastError> for Failure {
    fn from(error: PastError) -> Self {
        Self::of(error)
    }
}

/// Whom to ask.
pub(crate) enum Source {
    /// A learner's daemon.
    Daemon(Box<Learner>),
    /// A memory on disk.
    Disk(Box<MemoryOnDisk>),
}

/// Whom to ask about a memory: the learner's daemon, or the memory on disk if a data directory is given.
pub(crate) fn asked(memory: &MemoryArgs, general: &General) -> Result<Source, Failure> {
    Ok(match memory.meant(general)? {
        MeantMemory::Running(name) => Source::Daemon(Box::new(Learner::connect(&name)?)),
        MeantMemory::OnDisk(directory, until) => {
            Source::Disk(Box::new(MemoryOnDisk::open(directory, until)?))
        }
    })
}

/// Asks a question, and prints the answer as JSON or as the text for people.
pub(crate) fn show<Q: Inspect>(
    args: &AskArgs,
    general: &General,
    question: Q,
    text: impl FnOnce(&Q::Answer) -> String,
) -> Result<(), Failure> {
    // The place at the daemon is given back before anything is printed: who reads may take long.
    let answer = asked(&args.memory, general)?.ask(question)?;
    output::show(args.json, &answer, text)
}

impl Asks for Source {
    fn ask<Q: Inspect>(&mut self, question: Q) -> Result<Q::Answer, Failure> {
        match self {
            Self::Daemon(learner) => learner.ask(question),
            Self::Disk(memory) => memory.ask(question),
        }
    }
}

/// The answer to a question about a decision: of the daemon, while it keeps the decision; else of the memory that the daemon
/// keeps on disk, which is only read, and delays nothing.
pub(crate) fn answered<Q: Inspect>(
    memory: &MemoryArgs,
    general: &General,
    question: Q,
) -> Result<Q::Answer, Failure> {
    memory.check_step(decision_asked(&question))?;
    let mut source = asked(memory, general)?;
    let Source::Daemon(learner) = &mut source else { return source.ask(question) };
    let problem = match learner.ask(question.clone()) {
        Err(Failure::Failed(problem)) => problem,
        answered => return answered,
    };
    let status = learner.ask(StatusQuery {})?;
    if decision_asked(&question).is_some_and(|step| step > status.step) {
        return Err(Failure::Failed(problem));
    }
    let Some(storage) = status.storage else {
        return Err(Failure::Failed(format!(
            "{problem}. Nothing older is kept: the daemon has its memory in RAM only; with `pschema server --data DIR` it \
             keeps all of it"
        )));
    };
    MemoryOnDisk::open(Path::new(&storage.directory), None)?.ask(question)
}

/// The step whose decision a question is about, if it names one.
fn decision_asked(question: &impl Inspect) -> Option<u64> {
    match question.clone().into() {
        Request::Question(Question::Explain(explain)) => explain.step,
        Request::Question(Question::WhyNot(why_not)) => why_not.step,
        _ => None,
    }
}

/// A memory on disk, as it was at one moment.
#[derive(Debug)]
pub struct MemoryOnDisk {
    past: Past,
    until: Option<u64>,
}

impl MemoryOnDisk {
    /// The memory in `directory`, as it was after step `until`.
    ///
    /// # Errors
    /// When there is no memory, or its manifest can't be read.
    pub fn open(directory: &Path, until: Option<u64>) -> Result<Self, Failure> {
        Ok(Self { past: Past::open(directory)?, until })
    }

    /// What is on disk.
    pub(crate) fn past(&self) -> &Past {
        &self.past
    }

    /// The moment of the past that a question is about.
    pub(crate) fn moment(&self, question: &impl Inspect) -> Result<Moment, Failure> {
        match question.clone().into() {
            Request::Question(question) => self.moment_of(&question),
            Request::Order(_) => Ok(self.past.moment(self.until)?),
        }
    }

    fn moment_of(&self, question: &Question) -> Result<Moment, Failure> {
        Ok(match question {
            Question::Explain(explain) => self.past.decision(explain.step, self.until)?,
            Question::WhyNot(why_not) => self.past.decision(why_not.step, self.until)?,
            Question::Status(_) => self.past.moment_with_decision(self.until)?,
            Question::Schemas(query) if query.sort == SchemaSort::Excitation => {
                self.past.moment_with_decision(self.until)?
            }
            _ => self.past.moment(self.until)?,
        })
    }

    /// The answer to a question about a moment.
    pub(crate) fn answer<Q: Inspect>(&self, moment: Moment, question: &Q) -> Result<Q::Answer, Failure> {
        if let Request::Question(question) = question.clone().into() {
            check_perceived(&moment, &question)?;
        }
        question.answer(&self.view(moment)).map_err(Failure::of)
    }

    /// The reply to a question, as the bytes that a daemon sends.
    ///
    /// # Errors
    /// When there is nothing to make the reply of: the step is not kept, a file is damaged, or what was perceived is not known.
    pub fn reply(&self, question: &Question) -> Result<Vec<u8>, Failure> {
        let moment = self.moment_of(question)?;
        check_perceived(&moment, question)?;
        Ok(reply(&self.view(moment), question))
    }

    /// Everything there is to ask of a moment.
    pub(crate) fn view(&self, moment: Moment) -> View {
        let Moment { learner, decision, perceived, .. } = moment;
        View::alone(self.past.learner(), &learner, self.past.seed(), decision, perceived)
    }
}

/// A failure when a question is about the world as it was, and nothing is known of what was perceived.
fn check_perceived(moment: &Moment, question: &Question) -> Result<(), Failure> {
    let of_the_world = match question {
        Question::Predict(_) | Question::Plan(_) => true,
        Question::Graph(GraphQuery { goal, .. }) => !goal.is_empty(),
        _ => false,
    };
    if moment.perceived.is_none() && of_the_world {
        let step = moment.step();
        return Err(Failure::Failed(format!(
            "nothing is known of what was perceived up to step {step}, so nothing can be said of the world as it was: \
             name a later step with --until, or ask the running learner"
        )));
    }
    Ok(())
}

impl Asks for MemoryOnDisk {
    fn ask<Q: Inspect>(&mut self, question: Q) -> Result<Q::Answer, Failure> {
        let moment = self.moment(&question)?;
        self.answer(moment, &question)
    }
}
