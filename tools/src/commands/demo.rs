//! `pschema demo`: a robot learns to touch, told as it happens.

use std::path::{Path, PathBuf};

use clap::Args;
use pschema_process::{Occupied, Stop};

use crate::args::General;
use crate::design::BodyKind;
use crate::failure::Failure;
use crate::output::{self, Style};
use crate::render::schema::{capital, wrapped};
use crate::render::story::Story;
use crate::render::words::{duration, missing, probability, schema_notation, schema_sentence};
use crate::report::{self, Group, Section, figures};
use crate::run::{Bars, Condition, Experiment, Knowledge, Outcome, Overrides, Pair, Progress, Results};

use super::experiment::write_report;

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema demo --seed 7")]
pub(crate) struct DemoArgs {
    /// Everything drawn by lot follows from it
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The body: the simulated arm, or the Adept arm at the end of a serial line, on an emulator of its controller
    #[arg(long, value_enum, default_value_t)]
    body: BodyKind,
    /// Print the figures as JSON instead of the story
    #[arg(long)]
    json: bool,
    /// Write a report into this folder: a page to look at, and the raw figures as CSV and JSON Lines
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace the files of an earlier report in that folder
    #[arg(long, requires = "out")]
    overwrite: bool,
}

/// The experiment that a demo is.
const EXPERIMENT: &str = "exp1-s1";
/// The same in the view of the physical robot.
const ROBOT_EXPERIMENT: &str = "exp1-s1-narrow";

pub(crate) fn run(args: DemoArgs, general: &General) -> Result<(), Failure> {
    let stop = Stop::on_signals()?;
    let name = match args.body {
        BodyKind::Sim => EXPERIMENT,
        BodyKind::Adept => ROBOT_EXPERIMENT,
    };
    let experiment = Experiment::new(name, Overrides { body: Some(args.body), ..Overrides::default() })?;
    let Some(condition) = experiment.conditions.first() else {
        return Err(Failure::Failed(format!("{name} has no run")));
    };
    if let Some(folder) = &args.out {
        report::prepare(folder, [&experiment.design], Occupied::overwritten(args.overwrite))?;
    }
    let outcome = learn(&experiment, condition, args.seed, &stop, general.quiet() || args.json)?;
    if args.json {
        output::print_json(&outcome.results)?;
    } else {
        output::print(&told(&outcome.results, &outcome.learnt, Style::of_stdout()))?;
    }
    let Some(folder) = &args.out else { return Ok(()) };
    let group = Group::new(condition, std::slice::from_ref(&outcome));
    let section = Section { design: &experiment.design, groups: vec![group] };
    write_report(folder, &[section], general.quiet())
}

/// The whole run; when it returns, both processes have ended and nothing of theirs is left.
fn learn(
    experiment: &Experiment,
    condition: &Condition,
    seed: u64,
    stop: &Stop,
    quiet: bool,
) -> Result<Outcome, Failure> {
    let size = condition.size();
    let mut story = Story::new(experiment.design.object.clone(), size.postures);
    let progress = Progress::new(&Bars::new(quiet), String::new(), size);
    let say = |line: &str| {
        if !quiet {
            progress.say(line);
        }
    };
    say("A robot arm, a camera, a table. It knows nothing, not even what its own moves do.");
    if condition.body == BodyKind::Adept {
        say(
            "Its controller is emulated: orders to it are text on a serial line, pictures come from a socket.",
        );
    }
    let mut pair = Pair::start(condition, seed, stop)?;
    pair.watch(&experiment.design, condition, stop, |report| {
        story.news(report).iter().for_each(|line| say(&format!("  {line}")));
        progress.show(report);
    })
}

fn told(results: &Results, learnt: &Knowledge, style: Style) -> String {
    let mut text = format!("\n{}\n", style.bold("What it learnt"));
    for schema in &learnt.generalised {
        let (n, of) = (schema.successes, schema.executions);
        let holds = probability(schema.probability, n, of, schema.low, schema.high);
        text.push_str(&wrapped(&capital(&schema_sentence(schema)), "  "));
        text.push_str(&wrapped(&schema_notation(schema), "    "));
        text.push_str(&format!(
            "    schema {}, from examples {:?}; succeeds {holds}\n",
            schema.id, schema.examples
        ));
    }
    if learnt.generalised.is_empty() {
        text.push_str("  It did not generalise.\n");
    }
    if !learnt.exceptions.is_empty() {
        text.push_str(&format!("\n{}\n", style.bold("Where that does not hold")));
    }
    for schema in &learnt.exceptions {
        let general = learnt.generalised.iter().find(|general| Some(general.id) == schema.contradicts);
        let missing = general.map_or_else(String::new, |general| missing(general, schema));
        text.push_str(&wrapped(&capital(&(schema_sentence(schema) + &missing)), "  "));
        text.push_str(&wrapped(&format!("schema {}: {}", schema.id, schema_notation(schema)), "    "));
    }
    text.push_str(&format!("\n{}\n", style.bold("In figures")));
    text.push_str(&figures::one(results));
    text.push_str(&format!("\nIt took {}. {}\n", duration(results.wall_s), style.bold("Try next:")));
    text + &next_commands(&invocation())
}

fn next_commands(pschema: &str) -> String {
    let commands = [
        ("experiment exp1-s1 --seeds 1..6 --in-process", "is it always so?"),
        ("server --curriculum exp1-s1 &", "a learner that stays,"),
        ("sim &", "and its body"),
        ("schemas --generalised", "ask it what it knows"),
        ("explain", "and why it did what it did last"),
    ];
    let widest = commands.iter().map(|(command, _)| command.len()).max().unwrap_or(0);
    commands.iter().map(|(command, why)| format!("  {pschema} {command:widest$}  # {why}\n")).collect()
}

/// How this command was typed, to be typed again.
fn invocation() -> String {
    let typed = std::env::args().next().filter(|typed| Path::new(typed).components().count() > 1);
    typed.unwrap_or_else(|| "pschema".to_owned())
}
