//! A run in one process: the daemon's own code without the shared memory between it and the body.

use std::time::{Duration, Instant};

use pschema_protocol::inspect::{Answer, Report, Request};
use pschema_server::ServerArgs;
use pschema_server::config;
use pschema_server::in_process::{InProcess, InProcessError, Progress};
use pschema_sim::SimArgs;
use pschema_sim::body::SimBody;
use pschema_sim::config::WorldError;

use crate::failure::Failure;
use crate::learner::Asks;

use super::experiment::{Condition, read};
use super::outcome::Outcome;
use super::pair::stuck;
use super::signals::Stop;
use super::trace::Trace;

/// How often to make a report, which takes longer than a step.
const LOOK_EVERY: Duration = Duration::from_millis(200);

/// Carries a run out in this process; `seen` gets a report now and then.
pub(crate) fn in_process(
    told: &config::Experiment,
    condition: &Condition,
    seed: u64,
    stop: &Stop,
    mut seen: impl FnMut(&Report),
) -> Result<Outcome, Failure> {
    let started = Instant::now();
    let daemon = read::<ServerArgs>(condition.daemon(seed))?;
    let body = read::<SimArgs>(condition.body(seed))?;
    let mut run = InProcess::new(pschema_sim::build(&body)?, daemon.setup().map_err(Failure::of)?)?;
    let mut looked = Instant::now();
    let mut trace = Trace::default();
    while run.advance()? == Progress::Running {
        stop.check()?;
        if looked.elapsed() > LOOK_EVERY {
            trace.fetch(&mut run, told)?;
            seen(&run.report());
            looked = Instant::now();
        }
    }
    let report = run.report();
    if !report.finished {
        return Err(stuck(&report));
    }
    let wall_s = started.elapsed().as_secs_f64();
    Outcome::ask(told, condition, &report, trace, wall_s, &mut run)
}

impl Asks for InProcess<SimBody> {
    fn ask(&mut self, request: &Request) -> Result<Answer, Failure> {
        match self.answer(request) {
            Answer::Error(problem) => Err(Failure::Failed(problem)),
            answer => Ok(answer),
        }
    }
}

impl From<InProcessError> for Failure {
    fn from(error: InProcessError) -> Self {
        Self::of(error)
    }
}

impl From<WorldError> for Failure {
    fn from(error: WorldError) -> Self {
        Self::of(error)
    }
}
