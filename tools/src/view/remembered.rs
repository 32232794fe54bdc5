//! Memory as it was at an earlier step, read from its data directory on a thread of its own.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use hyper::StatusCode;
use pschema_inspect::SchemaSort;
use pschema_server::inspect;
use pschema_server::mind::View;
use pschema_store::past::PastError;

use super::answers::{self, About};
use super::question::{Asked, Question};
use super::work::{Reply, Trouble, Worker};
use crate::failure::Failure;
use crate::learner::Asks;
use crate::past::Remembered;

/// Where memory is on disk, once that is known.
#[derive(Clone, Debug, Default)]
pub(super) struct Directory(Arc<Mutex<Option<PathBuf>>>);

impl Directory {
    /// It is there; or memory is in RAM only.
    pub(super) fn is(&self, path: Option<PathBuf>) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = path;
    }

    fn path(&self) -> Option<PathBuf> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// Begins to answer questions about the past of what is in `directory`.
///
/// # Errors
/// When the system has no thread left.
pub(super) fn begin(directory: Directory) -> Result<Worker, Failure> {
    Worker::begin("remembers", move || Memory { directory, kept: None }, Memory::reply)
}

/// The last moment that was asked about: whoever looks at one asks several questions of it.
struct Memory {
    directory: Directory,
    kept: Option<Kept>,
}

/// Memory as it was after a step.
struct Kept {
    path: PathBuf,
    step: u64,
    view: View,
    /// Why the last decision can't be made again; then `view` is without it, and tells everything else.
    undecided: Option<String>,
}

impl Memory {
    fn reply(&mut self, asked: Asked) -> Reply {
        let Asked { question, until } = asked;
        if question.is_order() {
            let problem = "memory on disk takes no orders: go back to the present of a learner that runs";
            return Err(Trouble::new(StatusCode::CONFLICT, problem));
        }
        let path = self.directory.path().ok_or_else(|| {
            let problem = "this learner's memory is in RAM only, so there is no past to look at: a daemon with \
                `--data DIR` keeps one";
            Trouble::new(StatusCode::CONFLICT, problem)
        })?;
        if question == Question::About {
            return about(&path);
        }
        let step = match until {
            Some(step) => step,
            None => last_step(&path)?,
        };
        if matches!(question, Question::WhyNot { .. }) {
            return why_not(&path, step, question);
        }
        let needs_decision = matches!(question, Question::Schemas { sort: SchemaSort::Excitation, .. });
        let kept = self.kept(path, step)?;
        match &kept.undecided {
            Some(problem) if needs_decision => Err(Failure::Failed(problem.clone()).into()),
            problem => answers::answer(&inspect::answer(&kept.view, &question.request()), problem.as_deref()),
        }
    }

    /// Everything there is to ask of memory after `step`.
    fn kept(&mut self, path: PathBuf, step: u64) -> Result<&Kept, Trouble> {
        let kept = self.kept.take().filter(|kept| kept.path == path && kept.step == step);
        let kept = match kept {
            Some(kept) => kept,
            None => Kept::rebuilt(path, step)?,
        };
        Ok(self.kept.insert(kept))
    }
}

impl Kept {
    fn rebuilt(path: PathBuf, step: u64) -> Result<Self, Trouble> {
        let remembered = Remembered::open(&path, Some(step))?;
        let mut moment = remembered.past().moment(Some(step)).map_err(Failure::from)?;
        // What is known does not depend on whether a decision can be made again: another release may decide otherwise.
        let undecided = match remembered.past().decision(None, Some(step)) {
            Ok(decided) => {
                moment.decision = decided.decision;
                None
            }
            Err(PastError::NeverDecided { .. }) => None,
            Err(problem) => Some(problem.to_string()),
        };
        let view = remembered.view(moment);
        Ok(Self { path, step, view, undecided })
    }
}

/// A decision is weighed once more in memory as it was right after it, which may be some steps before `step`. Nothing of
/// that is kept: a second memory may be large, and it is seldom asked for.
fn why_not(path: &Path, step: u64, question: Question) -> Reply {
    let answer = Remembered::open(path, Some(step))?.ask(&question.request())?;
    answers::answer(&answer, None)
}

fn last_step(path: &Path) -> Result<u64, Trouble> {
    let moment = Remembered::open(path, None)?.past().moment(None).map_err(Failure::from)?;
    Ok(moment.step())
}

fn about(path: &Path) -> Reply {
    let remembered = Remembered::open(path, None)?;
    let past = remembered.past();
    let files = past.files().map_err(Failure::from)?;
    answers::json(&About {
        name: past.learner().to_owned(),
        live: false,
        directory: Some(past.directory().display().to_string()),
        oldest_step: Some(files.oldest_step),
        last_step: Some(last_step(path)?),
        version: env!("CARGO_PKG_VERSION"),
    })
}
