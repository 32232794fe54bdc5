//! `pschema experiment NAME`: the paper's runs, as figures.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use clap::Args;
use pschema_process::{Occupied, Stop, say};

use crate::args::General;
use crate::design::BodyKind;
use crate::failure::Failure;
use crate::output;
use crate::render::schema::wrapped;
use crate::report::{self, Group, Provenance, Section, comparison, figures};
use crate::run::{Experiment, Job, Outcome, Overrides, Results, Schedule, Seeds, Trace, carry_out};

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema experiment exp1-s1 --seed 7 --json\n  \
    pschema experiment exp1-s1 --seeds 1..20 --jobs 2 --out report\n  \
    pschema experiment ./my.toml\n  pschema experiment all\n\n\
    The published figures stand beside ours. The exit code says whether the runs could be carried out, \
    not whether they agree.")]
pub(crate) struct ExperimentArgs {
    /// Which experiment: a built-in one (an unknown name lists them), a curriculum file of your own with an
    /// `[experiment]` table, or `all`
    #[arg(value_name = "NAME|FILE|all")]
    experiment: String,
    /// Everything drawn by lot follows from it [default: 1]
    #[arg(long, conflicts_with = "seeds")]
    seed: Option<u64>,
    /// One run for each seed from A to B, both included [default for all: 1..10]
    #[arg(long, value_name = "A..B")]
    seeds: Option<Seeds>,
    /// How many runs side by side
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=64))]
    jobs: u8,
    /// Learner and body in this process, without shared memory: the same results
    #[arg(long)]
    in_process: bool,
    /// Another world: wide (the paper's simulated robot), narrow (its physical one), or a world file
    #[arg(long, value_name = "WORLD")]
    world: Option<String>,
    /// Another body: the simulated arm, or the Adept arm at the end of a serial line, on an emulator of its controller
    #[arg(long, value_enum)]
    body: Option<BodyKind>,
    /// Of an experiment with variants, only this one
    #[arg(long, value_name = "NAME")]
    variant: Option<String>,
    /// Write a report into this folder: a page to look at, and the raw figures as CSV and JSON Lines
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace the files of an earlier report in that folder
    #[arg(long, requires = "out")]
    overwrite: bool,
    /// Print JSON: an object, or one object a line if there are several runs
    #[arg(long, conflicts_with = "markdown")]
    json: bool,
    /// Print the table of published figures and ours as Markdown
    #[arg(long)]
    markdown: bool,
}

/// Seeds of `experiment all` unless others are asked for: enough for a 95 % interval.
const SEEDS_OF_ALL: (u64, u64) = (1, 10);

/// What stands for every experiment there is.
const ALL: &str = "all";

pub(crate) fn run(args: ExperimentArgs, general: &General) -> Result<(), Failure> {
    let stop = Stop::on_signals()?;
    let experiments = experiments(&args)?;
    let seeds = seeds(&args);
    if let Some(folder) = &args.out {
        // Before anything is run: a slip must not cost an hour.
        let designs = experiments.iter().map(|experiment| &experiment.design);
        report::prepare(folder, designs, Occupied::overwritten(args.overwrite))?;
    }
    let mut jobs = Vec::new();
    for experiment in &experiments {
        for condition in &experiment.conditions {
            jobs.extend(seeds.iter().map(|seed| Job { design: &experiment.design, condition, seed: *seed }));
        }
    }
    let schedule = Schedule { in_process: args.in_process, jobs: args.jobs.into(), quiet: general.quiet() };
    let several = jobs.len() > 1 || args.seeds.is_some();
    let mut outcomes: Vec<Outcome> = Vec::with_capacity(jobs.len());
    carry_out(&jobs, schedule, &stop, |_, mut outcome| {
        if args.json && several {
            // As soon as it is known: a sweep may be long.
            output::print_json_line(&outcome.results)?;
        }
        if args.out.is_none() {
            outcome.trace = Trace::default();
        }
        outcomes.push(outcome);
        Ok(())
    })?;
    let sections = sections(&experiments, &outcomes, seeds.len());
    print(&args, several, &sections)?;
    match &args.out {
        Some(folder) => write_report(folder, &sections, general.quiet()),
        None => Ok(()),
    }
}

fn experiments(args: &ExperimentArgs) -> Result<Vec<Experiment>, Failure> {
    let asked = Overrides { world: args.world.as_deref(), body: args.body, variant: args.variant.as_deref() };
    if args.experiment != ALL {
        return Ok(vec![Experiment::new(&args.experiment, asked)?]);
    }
    if asked.world.is_some() || asked.variant.is_some() || asked.body.is_some() {
        let problem = "`experiment all` runs each as its file says: name one experiment to change its world or body or \
                       to run one variant of it";
        return Err(Failure::Usage(problem.to_owned()));
    }
    Experiment::all()
}

fn seeds(args: &ExperimentArgs) -> Vec<u64> {
    match (args.seeds, args.seed) {
        (Some(seeds), _) => seeds.iter().collect(),
        (None, Some(seed)) => vec![seed],
        (None, None) if args.experiment == ALL => Seeds::from(SEEDS_OF_ALL).iter().collect(),
        (None, None) => vec![1],
    }
}

/// The outcomes, which are in the order of their jobs, by experiment and condition.
fn sections<'a>(
    experiments: &'a [Experiment],
    mut outcomes: &'a [Outcome],
    seeds: usize,
) -> Vec<Section<'a>> {
    let mut sections = Vec::new();
    for experiment in experiments {
        let mut groups = Vec::new();
        for condition in &experiment.conditions {
            let (own, rest) = outcomes.split_at(seeds.min(outcomes.len()));
            outcomes = rest;
            groups.push(Group::new(condition, own));
        }
        sections.push(Section { design: &experiment.design, groups });
    }
    sections
}

fn print(args: &ExperimentArgs, several: bool, sections: &[Section<'_>]) -> Result<(), Failure> {
    let results: Vec<&Results> = sections.iter().flat_map(Section::results).collect();
    if args.json {
        return match results.first() {
            Some(results) if !several => output::print_json(results),
            _ => Ok(()),
        };
    }
    let compared = sections.iter().filter(|section| section.groups.len() > 1);
    let lines = comparison::as_they_stand(sections);
    if args.markdown {
        let mut text = comparison::markdown(&lines);
        for section in compared {
            text.push_str(&format!(
                "\n{}\n\n{}",
                section.design.title,
                comparison::variants_markdown(section)
            ));
        }
        return output::print(&text);
    }
    let is_one_condition = sections.len() == 1 && compared.clone().next().is_none();
    let mut text = match results.as_slice() {
        [only] if is_one_condition && !several => figures::one(only),
        all if is_one_condition => figures::several(all),
        _ => comparison::table(&lines),
    };
    for section in compared {
        text.push_str(&format!("\n{}\n\n{}", section.design.title, comparison::variants(section)));
    }
    if let Some(group) =
        sections.first().and_then(|section| section.groups.first()).filter(|_| !is_one_condition)
    {
        text.push_str(&format!("\n{}", wrapped(&comparison::footnote(group.outcomes.len()), "")));
    }
    output::print(&text)
}

/// Writes the report, and says where its page is.
pub(super) fn write_report(folder: &Path, sections: &[Section<'_>], quiet: bool) -> Result<(), Failure> {
    let page = report::write(folder, sections, &Provenance::now(SystemTime::now()))?;
    if !quiet {
        say(&format!("report: {}", page.display()));
    }
    Ok(())
}
