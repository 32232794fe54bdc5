//! The thread that answers tools, so that no question delays a step.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

use pschema_inspect::Question;

use crate::inspect::{problem, reply};
use crate::view::View;

/// Questions that may wait for an answer.
pub(crate) const JOBS_MAX: usize = 64;

/// A question and the view that it is about.
struct Job {
    number: u64,
    question: Question,
    view: Box<View>,
}

/// The thread, from the daemon's side, and those who wait for answers: an `A` for each question. Dropping it ends the
/// thread after the question it is at.
pub(crate) struct Inspector<A> {
    jobs: Option<Sender<Job>>,
    answers: Receiver<(u64, Vec<u8>)>,
    askers: BTreeMap<u64, A>,
    /// The number of the last question.
    last: u64,
    thread: Option<JoinHandle<()>>,
}

impl<A> Inspector<A> {
    /// Starts the thread. `wake` is called after each answer.
    pub(crate) fn start(wake: impl Fn() + Send + 'static) -> std::io::Result<Self> {
        let (jobs, questions) = channel();
        let (answered, answers) = channel();
        let run = move || serve(&questions, &answered, &wake);
        let thread = std::thread::Builder::new().name("inspector".to_owned()).spawn(run)?;
        Ok(Self { jobs: Some(jobs), answers, askers: BTreeMap::new(), last: 0, thread: Some(thread) })
    }

    /// Whether as many questions wait as may.
    pub(crate) fn is_full(&self) -> bool {
        self.askers.len() >= JOBS_MAX
    }

    /// Hands a question over. The asker comes back, with what to tell it, when no more questions may wait.
    pub(crate) fn ask(&mut self, question: Question, view: View, asker: A) -> Result<(), (A, String)> {
        if self.is_full() {
            return Err((asker, format!("{JOBS_MAX} questions are waiting: ask again later")));
        }
        self.last += 1;
        let job = Job { number: self.last, question, view: Box::new(view) };
        if self.jobs.as_ref().is_none_or(|jobs| jobs.send(job).is_err()) {
            return Err((asker, "the inspector has ended: restart the daemon".to_owned()));
        }
        self.askers.insert(self.last, asker);
        Ok(())
    }

    /// Gives up all who wait for an answer.
    pub(crate) fn forget_askers(&mut self) {
        self.askers.clear();
    }

    /// An answer that is ready, encoded, and who asked.
    pub(crate) fn answer(&mut self) -> Option<(A, Vec<u8>)> {
        loop {
            let (number, bytes) = self.answers.try_recv().ok()?;
            if let Some(asker) = self.askers.remove(&number) {
                return Some((asker, bytes));
            }
        }
    }
}

impl<A> Drop for Inspector<A> {
    fn drop(&mut self) {
        drop(self.jobs.take());
        if self.thread.take().is_some_and(|thread| thread.join().is_err()) {
            tracing::error!("the inspector thread panicked");
        }
    }
}

fn serve(questions: &Receiver<Job>, answered: &Sender<(u64, Vec<u8>)>, wake: &dyn Fn()) {
    while let Ok(Job { number, question, view }) = questions.recv() {
        // A panic in here must not take the daemon down, nor leave the tool without an answer.
        let bytes = catch_unwind(AssertUnwindSafe(|| reply(&view, &question)));
        let bytes = bytes.unwrap_or_else(|_| {
            tracing::error!(?question, "answering panicked");
            problem("the daemon could not answer, by a fault of its own; its log says more".to_owned())
        });
        if answered.send((number, bytes)).is_err() {
            return;
        }
        wake();
    }
}
