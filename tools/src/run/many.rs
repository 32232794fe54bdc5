//! Runs one after the other, or several side by side.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::thread;

use pschema_process::Stop;

use crate::design::Design;
use crate::failure::Failure;

use super::experiment::Condition;
use super::in_process::in_process;
use super::outcome::Outcome;
use super::pair::Pair;
use super::progress::{Bars, Progress};

/// One run to be carried out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Job<'a> {
    /// What it is a run of.
    pub(crate) design: &'a Design,
    /// Under which condition.
    pub(crate) condition: &'a Condition,
    /// The seed of learner and body.
    pub(crate) seed: u64,
}

/// How runs are carried out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Schedule {
    /// Without shared memory.
    pub(crate) in_process: bool,
    /// How many side by side.
    pub(crate) jobs: usize,
    /// Without bars.
    pub(crate) quiet: bool,
}

/// Carries the runs out. `each` gets every outcome as soon as it and those before it are known, in order. The first
/// failure ends them all.
pub(crate) fn carry_out(
    jobs: &[Job<'_>],
    schedule: Schedule,
    stop: &Stop,
    mut each: impl FnMut(&Job<'_>, Outcome) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let bars = Bars::new(schedule.quiet);
    let stop = &stop.cancellable();
    let next = AtomicUsize::new(0);
    thread::scope(|scope| {
        let (sender, results) = channel();
        for _ in 0..schedule.jobs.clamp(1, jobs.len().max(1)) {
            let sender = sender.clone();
            let (next, bars) = (&next, &bars);
            // A thread outlives the processes that it starts, as it must: see `Child::start`.
            scope.spawn(move || work(jobs, next, schedule, bars, stop, &sender));
        }
        drop(sender);
        let mut early = BTreeMap::new();
        let mut next_known = 0;
        let mut failed = None;
        for (at, result) in results {
            early.insert(at, result);
            while failed.is_none()
                && let Some(result) = early.remove(&next_known)
            {
                let done = result.and_then(|outcome| match jobs.get(next_known) {
                    Some(job) => each(job, outcome),
                    None => Ok(()),
                });
                next_known += 1;
                failed = done.err();
            }
            // One that failed out of turn ends the others as well; its own failure is then the one to tell.
            if failed.is_none() && early.values().any(Result::is_err) {
                failed = early.into_values().find_map(Result::err);
                early = BTreeMap::new();
            }
            if failed.is_some() {
                stop.cancel();
            }
        }
        failed.map_or(Ok(()), Err)
    })
}

fn work(
    jobs: &[Job<'_>],
    next: &AtomicUsize,
    schedule: Schedule,
    bars: &Bars,
    stop: &Stop,
    results: &Sender<(usize, Result<Outcome, Failure>)>,
) {
    loop {
        let at = next.fetch_add(1, Ordering::Relaxed);
        let Some(job) = jobs.get(at) else { return };
        let result = stop.check().map_err(Failure::from).and_then(|()| once(job, schedule, bars, stop));
        let over = result.is_err();
        if results.send((at, result)).is_err() || over {
            return;
        }
    }
}

fn once(job: &Job<'_>, schedule: Schedule, bars: &Bars, stop: &Stop) -> Result<Outcome, Failure> {
    let Job { design, condition, seed } = *job;
    let variant = condition.name.as_ref().map_or_else(String::new, |name| format!("{name}, "));
    let label = format!("{}: {variant}seed {seed}", design.name);
    let progress = Progress::new(bars, format!("{label}, "), condition.size());
    let run = || {
        if schedule.in_process {
            return in_process(design, condition, seed, stop, |report| progress.show(report));
        }
        let mut pair = Pair::start(condition, seed, stop)?;
        pair.watch(design, condition, stop, |report| progress.show(report))
    };
    run().map_err(|failure| match failure {
        Failure::Failed(problem) | Failure::NoDaemon(problem) => {
            Failure::Failed(format!("{label}: {problem}"))
        }
        failure => failure,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::{Experiment, Overrides};

    const SMALL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/curricula/small.toml");
    const SCHEDULE: Schedule = Schedule { in_process: true, jobs: 3, quiet: true };

    #[test]
    fn outcomes_come_in_order_whichever_ends_first() {
        let experiment = Experiment::new(SMALL, Overrides::default()).unwrap();
        let job = |seed| Job { design: &experiment.design, condition: &experiment.conditions[0], seed };
        let jobs: Vec<_> = (1..=5).map(job).collect();
        let mut seeds = Vec::new();
        let each = |job: &Job<'_>, outcome: Outcome| {
            assert_eq!(job.seed, outcome.results.seed);
            seeds.push(job.seed);
            Ok(())
        };
        carry_out(&jobs, SCHEDULE, &Stop::default(), each).unwrap();
        assert_eq!(seeds, [1, 2, 3, 4, 5]);
    }

    #[test]
    fn the_first_failure_ends_them_all_and_is_the_one_told() {
        let experiment = Experiment::new(SMALL, Overrides::default()).unwrap();
        let sound = &experiment.conditions[0];
        let broken = Condition { world: "/nowhere/w.toml".to_owned(), ..sound.clone() };
        let job = |condition, seed| Job { design: &experiment.design, condition, seed };
        let jobs: Vec<_> = (1..=40).map(|seed| job(if seed == 2 { &broken } else { sound }, seed)).collect();
        let mut told = 0;
        let each = |_: &Job<'_>, _| {
            told += 1;
            Ok(())
        };
        let failure = carry_out(&jobs, SCHEDULE, &Stop::default(), each).unwrap_err().to_string();
        assert!(failure.contains("/nowhere/w.toml"), "{failure}");
        assert!(told <= 1, "{told} outcomes were told after a failure");
    }

    #[test]
    fn a_failure_to_tell_an_outcome_ends_them_all() {
        let experiment = Experiment::new(SMALL, Overrides::default()).unwrap();
        let job = |seed| Job { design: &experiment.design, condition: &experiment.conditions[0], seed };
        let jobs: Vec<_> = (1..=3).map(job).collect();
        let each = |_: &Job<'_>, _| Err(Failure::NobodyReads);
        let failure = carry_out(&jobs, SCHEDULE, &Stop::default(), each).unwrap_err();
        assert!(matches!(failure, Failure::NobodyReads), "{failure}");
    }
}
