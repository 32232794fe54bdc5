//! `pschema experiment NAME`: the paper's runs, as figures.

use crate::cli::ExperimentArgs;
use crate::failure::Failure;
use crate::output;
use crate::render::figures;
use crate::run::{Experiment, Figures, Pair, Progress, Stop, in_process};

pub(crate) fn run(args: &ExperimentArgs, quiet: bool) -> Result<(), Failure> {
    let stop = Stop::on_signals()?;
    let experiment = Experiment::new(args.experiment, &args.world);
    let Some(seeds) = args.seeds else {
        let figures = once(&experiment, args.seed, args.in_process, &stop, quiet)?;
        return if args.json { output::print_json(&figures) } else { output::print(&figures::one(&figures)) };
    };
    let mut runs = Vec::new();
    for seed in seeds.iter() {
        let figures = once(&experiment, seed, args.in_process, &stop, quiet)?;
        if args.json {
            // As soon as it is known: a sweep may be long.
            output::print_json_line(&figures)?;
        }
        runs.push(figures);
    }
    if args.json { Ok(()) } else { output::print(&figures::several(&runs)) }
}

fn once(
    experiment: &Experiment,
    seed: u64,
    in_one_process: bool,
    stop: &Stop,
    quiet: bool,
) -> Result<Figures, Failure> {
    let progress = Progress::new(format!("seed {seed}, "), experiment.size(), quiet);
    if in_one_process {
        return in_process(experiment, seed, stop, |report| progress.show(report));
    }
    let mut pair = Pair::start(experiment, seed, stop)?;
    let report = pair.watch(stop, |report| progress.show(report))?;
    Ok(Figures::new(experiment, &report, pair.elapsed().as_secs_f64()))
}
