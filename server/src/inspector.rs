//! The thread that answers tools, so that no question delays a step.

use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, Sender, SyncSender, TrySendError, channel, sync_channel};
use std::thread::JoinHandle;

use pschema_inspect::Question;

use crate::inspect::{problem, reply};
use crate::mind::View;

/// Questions that may wait.
pub(crate) const JOBS_MAX: usize = 64;

/// A question with what it is about.
struct Job {
    number: u64,
    question: Question,
    view: Box<View>,
}

/// An answer as bytes for its tool.
#[derive(Debug)]
pub(crate) struct Inspected {
    /// The number that the question was given.
    pub(crate) number: u64,
    /// The answer, encoded.
    pub(crate) bytes: Vec<u8>,
}

/// The thread, from the daemon's side. Dropping it ends the thread after the question it is at.
pub(crate) struct Inspector {
    jobs: Option<SyncSender<Job>>,
    answers: Receiver<Inspected>,
    thread: Option<JoinHandle<()>>,
}

impl fmt::Debug for Inspector {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str("Inspector")
    }
}

impl Inspector {
    /// Starts the thread. `wake` is called after each answer.
    pub(crate) fn start(wake: impl Fn() + Send + 'static) -> std::io::Result<Self> {
        let (jobs, questions) = sync_channel(JOBS_MAX);
        let (answered, answers) = channel();
        let run = move || serve(&questions, &answered, &wake);
        let thread = std::thread::Builder::new().name("inspector".to_owned()).spawn(run)?;
        Ok(Self { jobs: Some(jobs), answers, thread: Some(thread) })
    }

    /// Hands a question over. The error is the answer to give instead.
    pub(crate) fn ask(&self, number: u64, question: Question, view: View) -> Result<(), Vec<u8>> {
        let job = Job { number, question, view: Box::new(view) };
        let why = match self.jobs.as_ref().map(|jobs| jobs.try_send(job)) {
            Some(Ok(())) => return Ok(()),
            Some(Err(TrySendError::Full(_))) => format!("{JOBS_MAX} questions are waiting: ask again later"),
            Some(Err(TrySendError::Disconnected(_))) | None => {
                "the inspector has ended: restart the daemon".to_owned()
            }
        };
        Err(problem(why))
    }

    /// An answer that is ready.
    pub(crate) fn answer(&self) -> Option<Inspected> {
        self.answers.try_recv().ok()
    }
}

impl Drop for Inspector {
    fn drop(&mut self) {
        drop(self.jobs.take());
        if self.thread.take().is_some_and(|thread| thread.join().is_err()) {
            tracing::error!("the inspector thread panicked");
        }
    }
}

fn serve(questions: &Receiver<Job>, answered: &Sender<Inspected>, wake: &dyn Fn()) {
    while let Ok(Job { number, question, view }) = questions.recv() {
        // A mistake in here must not take the daemon down, nor leave the tool without an answer.
        let bytes = catch_unwind(AssertUnwindSafe(|| reply(&view, &question)));
        let bytes = bytes.unwrap_or_else(|_| {
            tracing::error!(?question, "answering panicked");
            problem("the daemon could not answer, by a fault of its own; its log says more".to_owned())
        });
        if answered.send(Inspected { number, bytes }).is_err() {
            return;
        }
        wake();
    }
}
