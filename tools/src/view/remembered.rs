//! Memory as it was at an earlier step, read from its data directory on a thread of its own.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use hyper::StatusCode;
use pschema_server::inspect;
use pschema_server::mind::View;

use super::answers::{self, About};
use super::question::{Asked, Question};
use super::work::{Reply, Trouble, Worker};
use crate::failure::Failure;
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
    kept: Option<(PathBuf, u64, View)>,
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
        let view = self.view(path, step)?;
        answers::answer(&inspect::answer(view, &question.request()))
    }

    /// Everything there is to ask of memory after `step`.
    fn view(&mut self, path: PathBuf, step: u64) -> Result<&View, Trouble> {
        let kept = self.kept.take().filter(|(known, at, _)| *known == path && *at == step);
        let kept = match kept {
            Some(kept) => kept,
            None => {
                let remembered = Remembered::open(&path, Some(step))?;
                let moment = remembered.past().moment_with_decision(Some(step)).map_err(Failure::from)?;
                (path, step, remembered.view(moment))
            }
        };
        Ok(&self.kept.insert(kept).2)
    }
}

fn last_step(path: &std::path::Path) -> Result<u64, Trouble> {
    let moment = Remembered::open(path, None)?.past().moment(None).map_err(Failure::from)?;
    Ok(moment.step())
}

fn about(path: &std::path::Path) -> Reply {
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
