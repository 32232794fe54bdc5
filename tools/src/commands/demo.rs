//! `pschema demo`: a robot learns to touch, told as it happens.

use std::path::Path;

use pschema_protocol::inspect::{Answer, Request, SchemaDetail, SchemaQuery};

use crate::cli::{DemoArgs, ExperimentName};
use crate::failure::Failure;
use crate::learner::{Learner, ask_for};
use crate::output::{self, Style};
use crate::render::figures;
use crate::render::schema::{capital, wrapped};
use crate::render::story::Story;
use crate::render::words::{duration, missing, probability, schema_notation, schema_sentence};
use crate::run::{Experiment, Figures, Pair, Progress, Stop};

/// Generalised schemas, and counter-examples, printed at most.
const SHOWN_MAX: usize = 4;

/// What was learnt that is worth showing.
struct Learnt {
    generalised: Vec<SchemaDetail>,
    exceptions: Vec<SchemaDetail>,
}

pub(crate) fn run(args: &DemoArgs, quiet: bool) -> Result<(), Failure> {
    let stop = Stop::on_signals()?;
    let experiment = Experiment::new(ExperimentName::Exp1S1, "wide");
    let (figures, learnt) = learn(&experiment, args.seed, &stop, quiet || args.json)?;
    if args.json {
        return output::print_json(&figures);
    }
    output::print(&told(&figures, &learnt, Style::of_stdout()))
}

/// The whole run; when it returns, both processes have ended and nothing of theirs is left.
fn learn(experiment: &Experiment, seed: u64, stop: &Stop, quiet: bool) -> Result<(Figures, Learnt), Failure> {
    let size = experiment.size();
    let mut story = Story::new(experiment.object, size.postures);
    let progress = Progress::new(String::new(), size, quiet);
    let say = |line: &str| {
        if !quiet {
            progress.say(line);
        }
    };
    say("A robot arm, a camera, a table. It knows nothing, not even what its own moves do.");
    let mut pair = Pair::start(experiment, seed, stop)?;
    let report = pair.watch(stop, |report| {
        story.news(report).iter().for_each(|line| say(&format!("  {line}")));
        progress.show(report);
    })?;
    let wall_s = pair.elapsed().as_secs_f64();
    let learnt = ask(pair.learner())?;
    Ok((Figures::new(experiment, &report, wall_s), learnt))
}

fn ask(learner: &mut Learner) -> Result<Learnt, Failure> {
    let query = SchemaQuery { generalised: true, limit: SHOWN_MAX as u32, ..SchemaQuery::default() };
    let list = ask_for!(learner, &Request::Schemas(query), Answer::Schemas)?;
    let mut show = |id: u32| ask_for!(learner, &Request::Show { id }, Answer::Schema).map(|schema| *schema);
    let generalised = list.schemas.iter().map(|s| show(s.id)).collect::<Result<Vec<_>, _>>()?;
    let exceptions = generalised.iter().flat_map(|s| s.counter_examples.iter().copied()).take(SHOWN_MAX);
    let exceptions = exceptions.map(&mut show).collect::<Result<Vec<_>, _>>()?;
    Ok(Learnt { generalised, exceptions })
}

fn told(figures: &Figures, learnt: &Learnt, style: Style) -> String {
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
    text.push_str(&figures::one(figures));
    text.push_str(&format!("\nIt took {}. {}\n", duration(figures.wall_s), style.bold("Try next:")));
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
