//! A daemon and a body as two processes of their own, talking over shared memory, in a runtime directory
//! that nobody else uses. Dropping the pair ends both and removes the directory.

use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use pschema_inspect::{Report, ReportQuery};
use pschema_process::Stop;
use pschema_protocol::domain::{LearnerName, Place, RuntimeDir};
use tempfile::TempDir;

use crate::design::Design;
use crate::failure::Failure;
use crate::learner::Learner;
use crate::render::words::plain;

use super::body::BodyProcess;
use super::child::{Child, private_name, retry};
use super::experiment::Condition;
use super::names;
use super::outcome::Outcome;
use super::trace::Trace;

/// How long a daemon may take to answer its first question. It takes a few milliseconds; a machine under
/// load takes its time.
const READY_WITHIN: Duration = Duration::from_secs(20);
/// How often to look how far the run is. Each look costs the daemon a copy of what it changes next.
const LOOK_EVERY: Duration = Duration::from_millis(100);
/// Steps between two fetches of what was decided in them: far fewer than the daemon keeps.
const FETCH_EVERY: u64 = 8_192;
/// How long after a failure to look for its cause.
const CAUSE_WITHIN: Duration = Duration::from_millis(500);
/// How long nothing may happen in a run before it counts as failed.
const STALLED_AFTER: Duration = Duration::from_secs(60);

/// A running pair. Fields are dropped in this order: the tool leaves, then the body, then the daemon; what
/// is left of the directory goes last.
pub(crate) struct Pair {
    learner: Learner,
    body: BodyProcess,
    daemon: Child,
    /// None while it is lent by the run that this one is the first part of.
    _directory: Option<TempDir>,
    started: Instant,
}

impl Pair {
    /// Starts the processes of a run and waits until the daemon answers. What is to be learnt before is learnt by then.
    pub(crate) fn start(condition: &Condition, seed: u64, stop: &Stop) -> Result<Self, Failure> {
        let started = Instant::now();
        let directory = runtime_directory()?;
        let memory = directory.path().join("memory");
        let mut keeping = Vec::new();
        if let Some(earlier) = &condition.after {
            // What is learnt there must outlive its daemon and its body.
            keeping = vec!["--data".to_owned(), memory.display().to_string()];
            let mut first = Self::begin(earlier, seed, stop, directory.path(), &keeping)?;
            first.learn(stop)?;
            keeping.push("--change".to_owned());
        }
        let pair = Self::begin(condition, seed, stop, directory.path(), &keeping)?;
        Ok(Self { _directory: Some(directory), started, ..pair })
    }

    /// Starts the processes of one part of a run.
    fn begin(
        condition: &Condition,
        seed: u64,
        stop: &Stop,
        directory: &Path,
        keeping: &[String],
    ) -> Result<Self, Failure> {
        let started = Instant::now();
        let name = private_name(std::process::id());
        let place = Place::new(RuntimeDir::at(directory)?, LearnerName::new(&name)?);
        let own = ["server", "--name", &name].map(str::to_owned).into_iter().chain(condition.daemon(seed));
        let mut daemon = Child::start("daemon", directory, own.chain(keeping.iter().cloned()))?;
        let mut body = BodyProcess::start(condition, seed, directory, &name, stop)?;
        let learner = connect(&place, &mut daemon, &mut body, stop)?;
        Ok(Self { learner, body, daemon, _directory: None, started })
    }

    /// Follows the run to the end of its curriculum.
    fn learn(&mut self, stop: &Stop) -> Result<(), Failure> {
        self.follow(stop, |_, _| Ok(())).map(drop).map_err(|failure| self.explained(failure, stop))
    }

    fn explained(&mut self, failure: Failure, stop: &Stop) -> Failure {
        match failure {
            Failure::Interrupted => failure,
            failure => self.cause(stop).unwrap_or(failure),
        }
    }

    /// Follows the run to the end of its curriculum; `seen` gets each report. Returns all that is then known of it.
    pub(crate) fn watch(
        &mut self,
        design: &Design,
        condition: &Condition,
        stop: &Stop,
        mut seen: impl FnMut(&Report),
    ) -> Result<Outcome, Failure> {
        let (mut trace, mut checked) = (Trace::default(), false);
        // A run may go on from a memory that has steps already; the body is there when there is one more.
        let mut begun_at = None;
        let followed = self.follow(stop, |report, learner| {
            seen(report);
            let stepped = report.step > *begun_at.get_or_insert(report.step);
            if (stepped || report.finished) && !checked {
                names::check(design, learner)?;
                checked = true;
            }
            // Now and then, so that nothing is lost of a run longer than the daemon keeps.
            if report.step > trace.last_step() + FETCH_EVERY { trace.fetch(learner, design) } else { Ok(()) }
        });
        let wall_s = self.started.elapsed().as_secs_f64();
        let outcome = followed
            .and_then(|report| Outcome::ask(design, condition, &report, trace, wall_s, &mut self.learner));
        outcome.map_err(|failure| self.explained(failure, stop))
    }

    fn follow(
        &mut self,
        stop: &Stop,
        mut seen: impl FnMut(&Report, &mut Learner) -> Result<(), Failure>,
    ) -> Result<Report, Failure> {
        let mut moved = (0, Instant::now());
        loop {
            stop.check()?;
            // A child that ended explains better what is wrong than an answer that fails to come.
            self.daemon.check()?;
            self.body.check()?;
            let report = self.learner.ask(ReportQuery {})?;
            seen(&report, &mut self.learner)?;
            if report.finished {
                return Ok(report);
            }
            if report.stuck.is_some() {
                return Err(stuck(&report));
            }
            if report.step != moved.0 {
                moved = (report.step, Instant::now());
            } else if moved.1.elapsed() > STALLED_AFTER {
                return Err(stalled(&report));
            }
            thread::sleep(LOOK_EVERY);
        }
    }

    /// What an answer that did not come is down to, if that becomes known within a moment: a process that ended is
    /// noticed later than its silence.
    fn cause(&mut self, stop: &Stop) -> Option<Failure> {
        let attempt = || {
            stop.check()?;
            self.daemon.check()?;
            self.body.check().map(|()| None::<()>)
        };
        retry(CAUSE_WITHIN, attempt).err()
    }
}

/// A curriculum that ended before its end.
pub(super) fn stuck(report: &Report) -> Failure {
    let why = plain(&report.stuck.clone().unwrap_or_else(|| report.stage_state.to_string()));
    Failure::Failed(format!(
        "the curriculum cannot go on after step {}, stage {}: {why}",
        report.step,
        plain(&report.stage)
    ))
}

fn stalled(report: &Report) -> Failure {
    let (step, state, seconds) = (report.step, &report.stage_state, STALLED_AFTER.as_secs());
    Failure::Failed(format!(
        "nothing happened for {seconds} s after step {step} ({state}): run it again with -v and look at what the body says last"
    ))
}

/// A directory short enough for sockets, whatever TMPDIR is.
///
/// # Errors
/// When /tmp can't be written.
pub fn runtime_directory() -> Result<TempDir, Failure> {
    let mut builder = tempfile::Builder::new();
    builder.prefix("pschema-").permissions(Permissions::from_mode(0o700));
    let directory = builder.tempdir_in(Path::new("/tmp"));
    directory.map_err(|error| Failure::Failed(format!("cannot create a directory in /tmp: {error}")))
}

fn connect(
    place: &Place,
    daemon: &mut Child,
    body: &mut BodyProcess,
    stop: &Stop,
) -> Result<Learner, Failure> {
    let attempt = || {
        stop.check()?;
        daemon.check()?;
        body.check()?;
        match Learner::connect_at(place) {
            Ok(learner) => Ok(Some(learner)),
            Err(Failure::NoDaemon(_)) => Ok(None),
            Err(failure) => Err(failure),
        }
    };
    retry(READY_WITHIN, attempt)?.ok_or_else(|| {
        Failure::Failed(format!("the daemon was not ready after {} s", READY_WITHIN.as_secs()))
    })
}
