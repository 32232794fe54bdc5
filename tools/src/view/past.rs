//! Memory as it was at an earlier step, read from its data directory on a thread of its own.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use hyper::StatusCode;
use pschema_inspect::{Ask, Question, Report, Request, SchemaSort};
use pschema_server::inspect::Inspect;
use pschema_server::view::View;
use pschema_store::past::PastError;

use super::answers::{self, About, Respondent};
use super::question::PageQuestion;
use super::work::{Reply, Trouble, Worker};
use crate::failure::Failure;
use crate::learner::Asks;
use crate::past::MemoryOnDisk;

/// The data directory of the learner, once it is known.
#[derive(Clone, Debug, Default)]
pub(super) struct Directory(Arc<Mutex<Option<PathBuf>>>);

impl Directory {
    /// Sets the directory; none means that memory is in RAM only.
    pub(super) fn is(&self, path: Option<PathBuf>) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = path;
    }

    fn path(&self) -> Option<PathBuf> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// Begins to answer questions about the past of the memory in `directory`.
///
/// # Errors
/// When the system has no thread left.
pub(super) fn begin(directory: Directory) -> Result<Worker, Failure> {
    Worker::begin("remembers", move || PastReader { directory, kept: None }, PastReader::reply)
}

/// Keeps the last moment that was asked about, because a page asks several questions about each.
struct PastReader {
    directory: Directory,
    kept: Option<PastMoment>,
}

/// Memory as it was after a step.
struct PastMoment {
    path: PathBuf,
    step: u64,
    view: View,
    /// The reason why the last decision can't be made again; `view` then has everything but the decision.
    undecided: Option<String>,
}

impl PastReader {
    fn reply(&mut self, asked: PageQuestion) -> Reply {
        let PageQuestion { question, until } = asked;
        if question.is_order() {
            return Err(answers::no_orders());
        }
        let path = self.directory.path().ok_or_else(|| {
            let problem = "this learner's memory is in RAM only, so there is no past to look at: a daemon with \
                `--data DIR` keeps one";
            Trouble::new(StatusCode::CONFLICT, problem)
        })?;
        answers::reply(question, &mut Past { kept: &mut self.kept, path, until })
    }
}

/// A moment that is asked about; memory as it was then is rebuilt for the first question that needs it.
struct Past<'a> {
    kept: &'a mut Option<PastMoment>,
    path: PathBuf,
    until: Option<u64>,
}

impl Past<'_> {
    fn step(&self) -> Result<u64, Failure> {
        self.until.map_or_else(|| last_step(&self.path), Ok)
    }

    /// Memory as it was at that moment, rebuilt if it is not the one that is kept.
    fn kept(&mut self) -> Result<&PastMoment, Failure> {
        let step = self.step()?;
        let kept = self.kept.take().filter(|kept| kept.path == self.path && kept.step == step);
        let kept = match kept {
            Some(kept) => kept,
            None => PastMoment::rebuilt(self.path.clone(), step)?,
        };
        Ok(self.kept.insert(kept))
    }
}

impl Asks for Past<'_> {
    fn ask<Q: Inspect>(&mut self, question: Q) -> Result<Q::Answer, Failure> {
        let by_decision = match question.clone().into() {
            // A decision is weighed once more in memory as it was right after it, which may be some steps before. Nothing of
            // that is kept: a second memory may be large, and it is seldom asked for.
            Request::Question(Question::WhyNot(_)) => {
                return MemoryOnDisk::open(&self.path, Some(self.step()?))?.ask(question);
            }
            Request::Question(Question::Schemas(query)) => query.sort == SchemaSort::Excitation,
            _ => false,
        };
        let kept = self.kept()?;
        match &kept.undecided {
            Some(problem) if by_decision => Err(Failure::Failed(problem.clone())),
            _ => question.answer(&kept.view).map_err(Failure::of),
        }
    }
}

impl Respondent for Past<'_> {
    fn about(&mut self) -> Result<About, Trouble> {
        let memory = MemoryOnDisk::open(&self.path, None)?;
        let past = memory.past();
        let files = past.files().map_err(Failure::from)?;
        Ok(About {
            name: past.learner().to_owned(),
            live: false,
            directory: Some(past.directory().display().to_string()),
            oldest_step: Some(files.oldest_step),
            last_step: Some(last_step(&self.path)?),
            version: env!("CARGO_PKG_VERSION"),
        })
    }

    fn obey<O: Ask<Answer = Report>>(&mut self, _: O) -> Result<Report, Trouble> {
        Err(answers::no_orders())
    }

    fn undecided(&self) -> Option<&str> {
        self.kept.as_ref()?.undecided.as_deref()
    }
}

impl PastMoment {
    fn rebuilt(path: PathBuf, step: u64) -> Result<Self, Failure> {
        let memory = MemoryOnDisk::open(&path, Some(step))?;
        let mut moment = memory.past().moment(Some(step))?;
        // Memory is rebuilt from the effects on disk, so it can be shown even if this release would decide otherwise.
        let undecided = match memory.past().decision(None, Some(step)) {
            Ok(decided) => {
                moment.decision = decided.decision;
                None
            }
            Err(PastError::NeverDecided { .. }) => None,
            Err(problem) => Some(problem.to_string()),
        };
        let view = memory.view(moment);
        Ok(Self { path, step, view, undecided })
    }
}

fn last_step(path: &Path) -> Result<u64, Failure> {
    Ok(MemoryOnDisk::open(path, None)?.past().moment(None)?.step())
}
