//! The whole life of a body's process: it attaches, and again whenever the daemon comes back; it sends frames and obeys
//! replies; it leaves.

use std::fmt;
use std::ops::ControlFlow;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use pschema_process::{LevelFilter, Log, Stop, require_descriptors, say};

use crate::domain::{DomainError, LearnerName, Place, RuntimeDir};
use crate::limits::PEER_DESCRIPTORS_NEEDED;
use crate::refusal::{Refusal, codes};
use crate::transport::TransportError;
use crate::transport::body_link::BodyLink;

use super::{Body, BodyLoop, Directive};

/// The first and the longest pause between two tries to attach. Each pause is twice the one before.
const BACKOFF_FIRST: Duration = Duration::from_millis(20);
const BACKOFF_LAST: Duration = Duration::from_millis(500);
/// How long a daemon may be absent before a body that is to end with it does so.
const GONE_GRACE: Duration = Duration::from_secs(3);
/// How long a daemon may be unwilling, or full, before the body gives up.
const UNWILLING_GRACE: Duration = Duration::from_secs(5);
/// How long a body waits before it says what it waits for: starting together, it and its daemon wait for each other a little.
const WAIT_SAID_AFTER: Duration = Duration::from_secs(1);
/// How long after that it says so again, and how soon where it waits for another reason meanwhile.
const WAIT_SAID_AGAIN: Duration = Duration::from_secs(600);
const OTHER_WAIT_SAID_AGAIN: Duration = Duration::from_secs(10);
/// How many frames may be refused one after another before the body gives up: more is a fault in the body.
const REFUSALS_MAX: u64 = 50;
/// The pause after a refused frame.
const REFUSAL_PAUSE: Duration = Duration::from_millis(20);

/// How to run a body.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct RunOptions {
    /// The learner to attach to.
    pub place: Place,
    /// End when the daemon has been gone for 3 s, instead of waiting for it to come back.
    pub exit_when_daemon_gone: bool,
    /// The flag that ends the run, whichever thread sets it.
    pub stop: Arc<AtomicBool>,
}

impl RunOptions {
    /// Attaches to the learner at `place`, and to its next daemon whenever the daemon goes, until `stop` is set.
    #[must_use]
    pub fn new(place: Place) -> Self {
        Self { place, exit_when_daemon_gone: false, stop: Arc::default() }
    }

    /// The same, with this flag as the one that ends the run.
    #[must_use]
    pub fn stop(mut self, stop: Arc<AtomicBool>) -> Self {
        self.stop = stop;
        self
    }

    /// The same; `true` ends the run when the daemon has been gone for 3 s.
    #[must_use]
    pub fn exit_when_daemon_gone(mut self, exits: bool) -> Self {
        self.exit_when_daemon_gone = exits;
        self
    }
}

/// Why a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RunEnding {
    /// The stop flag was set.
    Stopped,
    /// The daemon sent the body away.
    Detached,
    /// The daemon had gone, and the options said to end with it.
    DaemonGone,
}

/// What happened in a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct RunSummary {
    /// Why it ended.
    pub ending: RunEnding,
    /// Sessions opened.
    pub sessions: u64,
    /// Frames replied to.
    pub frames: u64,
    /// Orders (actions and scene commands) that the body was given.
    pub orders: u64,
    /// Frames refused.
    pub refused: u64,
}

impl fmt::Display for RunSummary {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { ending, sessions, frames, orders, refused } = self;
        write!(
            to,
            "{sessions} session(s), {frames} frames ({refused} refused), {orders} orders; ended: {ending:?}"
        )
    }
}

/// Why a run failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// The body's description is not allowed: a fault in the body.
    #[error("the body's description is not allowed: {0}")]
    Description(#[source] Refusal),
    /// The daemon does not take this body.
    #[error("the daemon refused the body ({code}): {reason}")]
    Refused {
        /// The number of the refusal.
        code: u32,
        /// Why.
        reason: String,
    },
    /// Frame after frame was refused: a fault in the body.
    #[error("{count} frames were refused one after another, the last because: {reason}")]
    FramesRefused {
        /// How many.
        count: u64,
        /// Why the last was.
        reason: String,
    },
    /// The daemon sent an order the body never declared.
    #[error("the daemon's reply is wrong: {0}")]
    Reply(#[source] Refusal),
    /// The transport failed in a way that trying again does not help.
    #[error(transparent)]
    Transport(#[from] TransportError),
}

/// Runs a body until it is told to stop, the daemon sends it away, or the daemon has gone (see [`RunOptions`]). If a daemon
/// restarts, the body attaches to it again.
///
/// # Errors
/// When the body or the daemon breaks the protocol, or shared memory cannot be used.
///
/// ```no_run
/// use pschema_protocol::body::{Body, RunOptions, run};
/// use pschema_protocol::domain::{LearnerName, Place, RuntimeDir};
///
/// # fn example(body: impl Body) -> Result<(), Box<dyn std::error::Error>> {
/// let place = Place::new(RuntimeDir::from_environment()?, LearnerName::new("demo")?);
/// let summary = run(body, &RunOptions::new(place).exit_when_daemon_gone(true))?;
/// println!("{} orders in {} sessions", summary.orders, summary.sessions);
/// # Ok(())
/// # }
/// ```
pub fn run<B: Body>(body: B, options: &RunOptions) -> Result<RunSummary, RunError> {
    require_descriptors("a body", PEER_DESCRIPTORS_NEEDED).map_err(TransportError::from)?;
    let mut run = Run {
        driver: BodyLoop::new(body),
        options,
        summary: RunSummary { ending: RunEnding::Stopped, sessions: 0, frames: 0, orders: 0, refused: 0 },
    };
    run.driver.hello().map_err(RunError::Description)?;
    run.summary.ending = loop {
        let link = match run.attach()? {
            ControlFlow::Continue(link) => link,
            ControlFlow::Break(ending) => break ending,
        };
        match run.session(link)? {
            ControlFlow::Continue(()) => tracing::info!("session lost; attaching again"),
            ControlFlow::Break(ending) => break ending,
        }
    };
    run.summary.orders = run.driver.orders();
    Ok(run.summary)
}

struct Run<'a, B> {
    driver: BodyLoop<B>,
    options: &'a RunOptions,
    summary: RunSummary,
}

impl<B: Body> Run<'_, B> {
    fn stopped(&self) -> bool {
        self.options.stop.load(Ordering::Relaxed)
    }

    /// Attaches, with as many tries as it takes.
    fn attach(&mut self) -> Result<ControlFlow<RunEnding, BodyLink>, RunError> {
        let mut wait = Wait { start: Instant::now(), said: None };
        let mut backoff = BACKOFF_FIRST;
        while !self.stopped() {
            let waited = wait.start.elapsed();
            match BodyLink::attach(&self.options.place, self.driver.description(), &self.options.stop) {
                Ok(link) => {
                    self.summary.sessions += 1;
                    self.driver.attached(link.session());
                    tracing::info!(session = link.session(), learner = %self.options.place.learner(), "attached");
                    return Ok(ControlFlow::Continue(link));
                }
                Err(TransportError::Stopped) => break,
                Err(error) => wait.say(&waited_for(error, waited)?),
            }
            if self.options.exit_when_daemon_gone && waited > GONE_GRACE && !self.options.place.is_served() {
                return Ok(ControlFlow::Break(RunEnding::DaemonGone));
            }
            self.pause(backoff);
            backoff = (backoff * 2).min(BACKOFF_LAST);
        }
        Ok(ControlFlow::Break(RunEnding::Stopped))
    }

    /// One session, to its end: whether to attach again, or how the run ends.
    fn session(&mut self, mut link: BodyLink) -> Result<ControlFlow<RunEnding>, RunError> {
        let mut refused_in_a_row = 0;
        let mut frames = 0;
        loop {
            if self.stopped() {
                link.detach();
                return Ok(ControlFlow::Break(RunEnding::Stopped));
            }
            self.driver.next_frame();
            if self.stopped() {
                // A body that could not sense to the end raises the flag: what it has reported by then is not how the world is.
                link.detach();
                return Ok(ControlFlow::Break(RunEnding::Stopped));
            }
            if link.is_watched()
                && let Some(picture) = self.driver.picture()
            {
                link.show(&picture, frames);
            }
            frames += 1;
            let reply = match link.exchange(self.driver.frame(), &self.options.stop) {
                Ok(reply) => reply,
                Err(TransportError::Stopped) => return Ok(ControlFlow::Break(RunEnding::Stopped)),
                Err(error) => {
                    tracing::warn!(%error, "the exchange of frames ended");
                    return Ok(ControlFlow::Continue(()));
                }
            };
            self.summary.frames += 1;
            let directive = self.driver.obey(&reply).map_err(RunError::Reply)?;
            if !matches!(directive, Directive::Refused { .. }) {
                refused_in_a_row = 0;
            }
            match directive {
                Directive::Continue => {}
                Directive::Wait(time) => link.rest(time, &self.options.stop),
                Directive::Detach => return Ok(ControlFlow::Break(RunEnding::Detached)),
                Directive::Refused { code, reason } => {
                    self.summary.refused += 1;
                    refused_in_a_row += 1;
                    tracing::warn!(code, %reason, "frame refused");
                    if refused_in_a_row >= REFUSALS_MAX {
                        return Err(RunError::FramesRefused { count: refused_in_a_row, reason });
                    }
                    if matches!(code, codes::SESSION | codes::SEQUENCE) {
                        return Ok(ControlFlow::Continue(()));
                    }
                    self.pause(REFUSAL_PAUSE);
                }
            }
        }
    }

    /// Sleeps for `time`, a little at a time so that the stop flag is seen soon.
    fn pause(&self, time: Duration) {
        let end = Instant::now() + time;
        while !self.stopped() && Instant::now() < end {
            std::thread::sleep(end.saturating_duration_since(Instant::now()).min(BACKOFF_FIRST));
        }
    }
}

/// Why a try to attach failed, if another is worth it; else the error.
fn waited_for(error: TransportError, waited: Duration) -> Result<String, RunError> {
    match error {
        TransportError::Domain(DomainError::NotServed { .. } | DomainError::Starting { .. })
        | TransportError::DaemonGone
        | TransportError::TimedOut { .. } => Ok(error.to_string()),
        // A daemon that was just replaced, or the place of a body that has just died.
        TransportError::Setup { .. } | TransportError::Full { .. } if waited < UNWILLING_GRACE => {
            Ok(error.to_string())
        }
        TransportError::Refused { code: codes::UNWILLING, reason } if waited < UNWILLING_GRACE => Ok(reason),
        TransportError::Refused { code, reason } => Err(RunError::Refused { code, reason }),
        error => Err(error.into()),
    }
}

/// The wait of a body that can't attach yet.
struct Wait {
    start: Instant,
    /// When it was last said what the body waits for, and what that was.
    said: Option<(Instant, String)>,
}

impl Wait {
    /// Says what the body waits for, once it has waited for a moment, and then rarely.
    fn say(&mut self, reason: &str) {
        tracing::debug!(reason, "not attached");
        let is_due = match &self.said {
            None => self.start.elapsed() >= WAIT_SAID_AFTER,
            Some((at, said)) => {
                at.elapsed() >= if said == reason { WAIT_SAID_AGAIN } else { OTHER_WAIT_SAID_AGAIN }
            }
        };
        if is_due {
            tracing::warn!("waiting to attach: {reason}");
            self.said = Some((Instant::now(), reason.to_owned()));
        }
    }
}

/// Runs a body as a program: reads `--name <learner>` from the command line, ends on SIGINT and SIGTERM
/// with a farewell, and says on standard error what went wrong.
///
/// ```no_run
/// use pschema_protocol::prelude::*;
///
/// # struct Lamp;
/// # impl Body for Lamp {
/// #     fn describe(&self) -> Description { Description::new("lamp", "lamp") }
/// #     fn sense(&mut self, _frame: &mut Senses) {}
/// #     fn act(&mut self, _action: &Action) -> Outcome { Outcome::Done }
/// # }
/// fn main() -> std::process::ExitCode {
///     run_from_args(Lamp)
/// }
/// ```
pub fn run_from_args<B: Body>(body: B) -> ExitCode {
    Log::new(LevelFilter::WARN).begin();
    match run_as_program(body) {
        Ok(summary) => {
            say(&summary.to_string());
            ExitCode::SUCCESS
        }
        Err(message) => {
            say(&message);
            ExitCode::FAILURE
        }
    }
}

const USAGE: &str = "usage: <body> [--name <learner>]   (default: default)";

fn run_as_program<B: Body>(body: B) -> Result<RunSummary, String> {
    let mut name = "default".to_owned();
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--name" => name = arguments.next().ok_or(USAGE)?,
            _ => return Err(USAGE.to_owned()),
        }
    }
    let learner = LearnerName::new(&name).map_err(|error| error.to_string())?;
    let runtime = RuntimeDir::from_environment().map_err(|error| error.to_string())?;
    let stop = Stop::on_signals().map_err(|error| error.to_string())?.flag();
    let options = RunOptions::new(Place::new(runtime, learner)).stop(stop);
    run(body, &options).map_err(|error| error.to_string())
}
