//! A run in one process: the daemon's own code without the shared memory between it and the body.

use std::time::{Duration, Instant};

use pschema_protocol::inspect::Report;
use pschema_server::ServerArgs;
use pschema_server::in_process::{InProcess, InProcessError, Progress};
use pschema_sim::SimArgs;
use pschema_sim::config::WorldError;

use crate::failure::Failure;

use super::experiment::{Experiment, read};
use super::figures::Figures;
use super::pair::stuck;
use super::signals::Stop;

/// How often to make a report, which takes longer than a step.
const LOOK_EVERY: Duration = Duration::from_millis(200);

/// Carries `experiment` out in this process; `seen` gets a report now and then.
pub(crate) fn in_process(
    experiment: &Experiment,
    seed: u64,
    stop: &Stop,
    mut seen: impl FnMut(&Report),
) -> Result<Figures, Failure> {
    let started = Instant::now();
    let daemon = read::<ServerArgs>(experiment.daemon(seed))?;
    let body = read::<SimArgs>(experiment.body(seed))?;
    let mut run = InProcess::new(pschema_sim::build(&body)?, daemon.setup().map_err(Failure::of)?)?;
    let mut looked = Instant::now();
    while run.advance()? == Progress::Running {
        stop.check()?;
        if looked.elapsed() > LOOK_EVERY {
            looked = Instant::now();
            seen(&run.report());
        }
    }
    let report = run.report();
    if !report.finished {
        return Err(stuck(&report));
    }
    Ok(Figures::new(experiment, &report, started.elapsed().as_secs_f64()))
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
