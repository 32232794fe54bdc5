//! A run in one process: the daemon's own code without the shared memory between it and the body.

use std::time::{Duration, Instant};

use pschema_inspect::Report;
use pschema_process::Stop;
use pschema_server::ServerArgs;
use pschema_server::in_process::{InProcess, RunState};
use pschema_server::inspect::Inspect;

use crate::design::Design;
use crate::failure::Failure;
use crate::learner::Asks;

use super::any_body::AnyBody;
use super::experiment::{Condition, read};
use super::names;
use super::outcome::Outcome;
use super::pair::stuck;
use super::trace::Trace;

/// How often to make a report, which takes longer than a step.
const LOOK_EVERY: Duration = Duration::from_millis(200);

/// Carries a run out in this process; `seen` gets a report now and then.
pub(crate) fn in_process(
    design: &Design,
    condition: &Condition,
    seed: u64,
    stop: &Stop,
    mut seen: impl FnMut(&Report),
) -> Result<Outcome, Failure> {
    let started = Instant::now();
    let mut run = begun(condition, seed, stop)?;
    names::check(design, &mut run)?;
    let mut looked = Instant::now();
    let mut trace = Trace::default();
    while run.advance().map_err(Failure::of)? == RunState::Running {
        stop.check()?;
        if looked.elapsed() > LOOK_EVERY {
            trace.fetch(&mut run, design)?;
            seen(&run.report());
            looked = Instant::now();
        }
    }
    let report = run.report();
    if !report.finished {
        return Err(stuck(&report));
    }
    let wall_s = started.elapsed().as_secs_f64();
    Outcome::ask(design, condition, &report, trace, wall_s, &mut run)
}

/// The run about to begin: what is to be learnt before has been learnt.
fn begun(condition: &Condition, seed: u64, stop: &Stop) -> Result<InProcess<AnyBody>, Failure> {
    let body = AnyBody::new(condition, seed)?;
    let setup = read::<ServerArgs>(condition.daemon(seed))?.setup().map_err(Failure::of)?;
    let Some(earlier) = &condition.after else { return InProcess::new(body, setup).map_err(Failure::of) };
    let mut first = begun(earlier, seed, stop)?;
    while first.advance().map_err(Failure::of)? == RunState::Running {
        stop.check()?;
    }
    let report = first.report();
    if !report.finished {
        return Err(stuck(&report));
    }
    let mut learner = first.into_learner();
    learner.change(setup.learner.parameters, setup.curriculum).map_err(Failure::of)?;
    learner.set_mechanisms(setup.learner.mechanisms);
    InProcess::going_on(body, learner, seed).map_err(Failure::of)
}

impl Asks for InProcess<AnyBody> {
    fn ask<Q: Inspect>(&mut self, question: Q) -> Result<Q::Answer, Failure> {
        InProcess::ask(self, &question).map_err(Failure::of)
    }
}
