//! A body and its learner in one process: with the same session, translation, learner and wire encoding as the daemon,
//! but without shared memory. The same seed gives the same memory, to the digest.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use pschema_inspect::codec::Problem;
use pschema_inspect::{AchieveOrder, Report};
use pschema_learner::digest::digest;
use pschema_learner::progress::{StageCommand, StageCommandError};
use pschema_learner::{Learner, LearnerError};
use pschema_protocol::body::{Body, BodyLoop, Directive};
use pschema_protocol::refusal::Refusal;
use pschema_protocol::wire::{decode, encode};

use crate::inspect::{self, Inspect};
use crate::mind::{GoalError, Mind, SayError, SingleStepError};
use crate::session::{AttachError, Session};
use crate::setup::Setup;
use crate::view::{Host, View};

/// After so many frames in a row without an order a run is given up: the learner wants nothing of this body.
const IDLE_FRAMES_MAX: u32 = 1000;

/// Why a run in one process failed.
#[derive(Debug, thiserror::Error)]
pub enum InProcessError {
    /// The learner can't be made.
    #[error(transparent)]
    Learner(#[from] LearnerError),
    /// The body's description is not allowed.
    #[error("the body's description is not allowed: {0}")]
    Description(#[source] Refusal),
    /// The learner can't take in what the body declares.
    #[error("the learner can't take the body: {0}")]
    Attach(#[from] AttachError),
    /// A frame of the body is not allowed.
    #[error("the body's frame was refused ({code}): {reason}")]
    Frame {
        /// The number of the refusal.
        code: u32,
        /// Why.
        reason: String,
    },
    /// A reply to the body is not allowed, which is a fault on the learner's side.
    #[error("the reply to the body is wrong: {0}")]
    Reply(#[source] Refusal),
    /// The learner wants nothing of the body, though its curriculum is not over.
    #[error("the learner asked for nothing in {IDLE_FRAMES_MAX} frames: does the body have a repertoire?")]
    Idle,
}

/// Whether a run goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RunState {
    /// The body has something to sense and the learner something to ask.
    Running,
    /// The learner waits: held, stuck, or through with its curriculum.
    Waiting,
}

/// A body and its learner in one process.
///
/// ```no_run
/// use pschema_server::in_process::{InProcess, RunState};
/// use pschema_server::{Setup, config};
/// # fn run(body: impl pschema_protocol::body::Body) -> Result<(), Box<dyn std::error::Error>> {
/// let (curriculum, learner) = config::lesson("exp1-s1", Default::default(), &[])?;
/// let mut run = InProcess::new(body, Setup { seed: 1, learner, curriculum })?;
/// while run.advance()? == RunState::Running {}
/// println!("{:?}", run.report().memory_digest);
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct InProcess<B> {
    body: BodyLoop<B>,
    mind: Mind,
    session: Session,
    idle_frames: u32,
}

impl<B: Body> InProcess<B> {
    /// Attaches `body` to a new learner.
    ///
    /// # Errors
    /// When the learner can't be made or can't take the body.
    pub fn new(body: B, setup: Setup) -> Result<Self, InProcessError> {
        Self::with(body, Mind::new(setup)?)
    }

    /// Attaches `body` to a learner that has learnt before, perhaps in another body.
    ///
    /// # Errors
    /// When the learner can't take the body.
    pub fn going_on(body: B, learner: Learner, seed: u64) -> Result<Self, InProcessError> {
        Self::with(body, Mind::resume(learner, seed))
    }

    fn with(body: B, mut mind: Mind) -> Result<Self, InProcessError> {
        let mut body = BodyLoop::new(body);
        let hello = body.hello().map_err(InProcessError::Description)?;
        let hello = decode::hello(&hello).map_err(InProcessError::Description)?;
        let (session, _) = Session::attach(1, &hello, mind.learner_mut())?;
        mind.examine(&session);
        body.attached(session.number());
        Ok(Self { body, mind, session, idle_frames: 0 })
    }

    /// Exchanges one frame and its reply, and has the body carry out the reply.
    ///
    /// # Errors
    /// When the body or the learner breaks the protocol.
    pub fn advance(&mut self) -> Result<RunState, InProcessError> {
        let frame = self.body.next_frame();
        let began = Instant::now();
        // There is no other body, so this one hears all words, student or not.
        let served = self.mind.serve(&mut self.session, frame, false);
        let decided = began.elapsed();
        let wire = encode::reply(self.session.number(), frame.header.sequence, &served.reply);
        if let Some(step) = served.step {
            self.mind.stepped(&self.session, step, decided);
            self.mind.committed(began.elapsed());
        }
        match self.body.obey(&wire).map_err(InProcessError::Reply)? {
            Directive::Continue => self.idle_frames = 0,
            Directive::Refused { code, reason } => return Err(InProcessError::Frame { code, reason }),
            Directive::Wait(_) | Directive::Detach => {
                if self.mind.is_waiting() {
                    self.idle_frames = 0;
                    return Ok(RunState::Waiting);
                }
                self.idle_frames += 1;
                if self.idle_frames >= IDLE_FRAMES_MAX {
                    return Err(InProcessError::Idle);
                }
            }
        }
        Ok(RunState::Running)
    }

    /// Says words, which the learner hears with the next frame.
    ///
    /// # Errors
    /// As [`Mind::say`].
    pub fn say(&mut self, words: &[String]) -> Result<(), SayError> {
        self.mind.say(words)
    }

    /// Obeys an operator's order to the curriculum.
    ///
    /// # Errors
    /// When there is no such stage.
    pub fn stage(&mut self, command: &StageCommand) -> Result<(), StageCommandError> {
        self.mind.stage(command)?;
        self.mind.examine(&self.session);
        Ok(())
    }

    /// Holds the learner, but for one action.
    ///
    /// # Errors
    /// As [`Mind::single_step`].
    pub fn single_step(&mut self) -> Result<(), SingleStepError> {
        self.mind.single_step(Some(&self.session)).map(drop)
    }

    /// Takes up a goal.
    ///
    /// # Errors
    /// As [`Mind::achieve`].
    pub fn achieve(&mut self, order: &AchieveOrder) -> Result<(), GoalError> {
        self.mind.achieve(&self.session, order).map(drop)
    }

    /// Calls a goal off.
    ///
    /// # Errors
    /// As [`Mind::cancel`].
    pub fn cancel(&mut self, number: u64) -> Result<(), GoalError> {
        self.mind.cancel(number).map(drop)
    }

    /// The learner.
    #[must_use]
    pub fn learner(&self) -> &Learner {
        self.mind.learner()
    }

    /// The learner alone, to go on in another body.
    #[must_use]
    pub fn into_learner(self) -> Learner {
        self.mind.into_learner()
    }

    /// The body.
    #[must_use]
    pub fn body(&self) -> &B {
        self.body.body()
    }

    /// The session between them.
    #[must_use]
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// The learner as it is now, to be inspected.
    #[must_use]
    pub fn view(&self) -> View {
        let host = Host { bodies: vec![self.session.status().clone()], ..Host::default() };
        self.mind.view("in-process".into(), Some(&self.session), host)
    }

    /// The answer that a tool would get. Orders are not obeyed here: see [`InProcess::say`], [`InProcess::stage`] and
    /// [`InProcess::achieve`].
    ///
    /// # Errors
    /// Why there is no answer.
    pub fn ask<Q: Inspect>(&self, question: &Q) -> Result<Q::Answer, Problem> {
        question.answer(&self.view())
    }

    /// What the curriculum has done so far, always with the digest of memory.
    #[must_use]
    pub fn report(&self) -> Report {
        let view = self.view();
        Report { memory_digest: Some(digest(&view.content)), ..inspect::report(&view) }
    }
}

/// Runs `body` with a new learner until its curriculum waits (it is over, or stuck: the report says which)
/// or `stop` is set.
///
/// # Errors
/// When the learner can't be made, or the body or the learner breaks the protocol.
pub fn run_in_process<B: Body>(body: B, setup: Setup, stop: &AtomicBool) -> Result<Report, InProcessError> {
    let mut run = InProcess::new(body, setup)?;
    while !stop.load(Ordering::Relaxed) && run.advance()? == RunState::Running {}
    Ok(run.report())
}
