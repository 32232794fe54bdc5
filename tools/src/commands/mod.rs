//! The subcommands, one file each.

mod achieve;
mod adept;
mod completions;
mod demo;
mod doctor;
mod emulator;
mod experiment;
mod explain;
mod export;
mod graph;
mod import;
mod journal;
mod plan;
mod predict;
mod record;
mod repair;
mod replay;
mod say;
mod schemas;
mod server;
mod show;
mod sim;
mod stage;
mod status;
mod verify;
mod view;
mod watch;

use pschema_protocol::domain::LearnerName;

use crate::cli::{Cli, Command, NameArgs};
use crate::failure::Failure;

/// Does what was typed.
pub(crate) fn run(cli: Cli) -> Result<(), Failure> {
    let (name, quiet) = (cli.name, cli.quiet);
    let learner = |args: &NameArgs| args.name.clone().or_else(|| name.clone()).map_or_else(default_name, Ok);
    match cli.command {
        Command::Demo(args) => demo::run(&args, quiet),
        Command::Server(command) => server::run(*command, name),
        Command::Sim(command) => sim::run(*command, name),
        Command::Adept(command) => adept::run(*command, name),
        Command::Emulator(command) => emulator::run(*command),
        Command::Status(args) => status::run(&learner(&args.name)?, &args),
        Command::Schemas(args) => schemas::run(&learner(&args.name)?, args),
        Command::Show(args) => show::run(&learner(&args.name)?, &args),
        Command::Explain(args) => explain::run(&learner(&args.name)?, &args),
        Command::Graph(args) => graph::run(&learner(&args.name)?, args),
        Command::View(args) => view::run(&learner(&args.name)?, &args, quiet),
        Command::Watch(args) => watch::run(&learner(&args.name)?, &args),
        Command::Record(args) => record::run(&learner(&args.name)?, &args),
        Command::Predict(args) => predict::run(&learner(&args.name)?, args),
        Command::Plan(args) => plan::run(&learner(&args.name)?, args),
        Command::Achieve(args) => achieve::run(&learner(&args.name)?, args, quiet),
        Command::Say(args) => say::run(&learner(&args.name)?, args),
        Command::Stage(args) => stage::run(&learner(&args.name)?, args),
        Command::Journal(args) => journal::run(&args),
        Command::Verify(args) => verify::run(&args, quiet),
        Command::Repair(args) => repair::run(&args),
        Command::Replay(args) => replay::run(&args),
        Command::Export(args) => export::run(&learner(&args.name)?, &args, quiet),
        Command::Import(args) => import::run(&args, quiet),
        Command::Experiment(args) => experiment::run(&args, quiet),
        Command::Bench(args) => crate::bench::run(&args.what, quiet),
        Command::Doctor(args) => doctor::run(args),
        Command::Completions { shell } => completions::run(shell),
    }
}

fn default_name() -> Result<LearnerName, Failure> {
    Ok(LearnerName::new(DEFAULT_NAME)?)
}

/// The learner of those who need only one.
const DEFAULT_NAME: &str = "default";
