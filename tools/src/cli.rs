//! What can be typed: the tree of commands. Each command's arguments, and their help, stand in its own file.

use std::io::{self, IsTerminal};

use clap::{CommandFactory, Parser, Subcommand};
use pschema_process::{LevelFilter, Log};

use crate::args::General;
use crate::commands::{
    achieve, adept, claims, completions, conformance, demo, doctor, emulator, experiment, explain, export,
    graph, import, journal, plan, predict, record, repair, replay, say, schemas, server, show, sim, stage,
    status, verify, view, watch,
};
use crate::failure::Failure;

/// A learner for embodied agents: it babbles, touches, generalises.
#[derive(Debug, Parser)]
#[command(
    name = "pschema",
    version,
    propagate_version = true,
    arg_required_else_help = true,
    after_help = "Start here:\n  pschema demo\n\nExit codes: 0 done, 1 failed, 2 wrong usage, 3 no daemon running"
)]
pub(crate) struct Cli {
    #[command(flatten)]
    general: General,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Watch a robot learn to touch: a daemon and a simulated body, from nothing, in seconds
    Demo(demo::DemoArgs),
    /// Run the learner daemon in the foreground; with --data it keeps what it learns
    Server(Box<server::ServerCommand>),
    /// Run the simulated body: an arm, a table, blocks, a camera
    Sim(Box<sim::SimCommand>),
    /// Run the Adept arm on a serial line: the robot
    Adept(Box<adept::AdeptCommand>),
    /// Emulate the Adept arm's controller on a serial line, with a simulated arm behind it
    Emulator(Box<emulator::EmulatorCommand>),
    /// How the daemon, its bodies and its learner are
    Status(status::StatusArgs),
    /// List schemas
    Schemas(schemas::SchemasArgs),
    /// One schema whole: statistics, examples, counter-examples, lineage
    Show(show::ShowArgs),
    /// What it holds to be so of an action, on which evidence: conditions, outcomes, exceptions
    Claims(claims::ClaimsArgs),
    /// Why the last action (or that of a step) was chosen, term by term
    Explain(explain::ExplainArgs),
    /// The network of schemas as a picture: what enables what, examples and counter-examples, chains
    Graph(graph::GraphArgs),
    /// Look inside in a browser: a page for this machine alone
    View(view::ViewArgs),
    /// Watch a learner live: what it perceives, what excites it, why it acts, what it learns
    Watch(watch::WatchArgs),
    /// Write down what a learner does while it does it, for programs
    Record(record::RecordArgs),
    /// What an action would do in the world as it is
    Predict(predict::PredictArgs),
    /// How a goal could be brought about, and with what probability
    Plan(plan::PlanArgs),
    /// Have the learner bring a goal about, and wait for it
    Achieve(achieve::AchieveArgs),
    /// Say words to the learner
    Say(say::SayArgs),
    /// Developmental control: where the curriculum stands, and moving it
    Stage(stage::StageArgs),
    /// What happened in a memory on disk, batch by batch
    Journal(journal::JournalArgs),
    /// Check a memory on disk, every byte of it
    Verify(verify::VerifyArgs),
    /// Mend a damaged memory on disk: save what can be saved, after a copy of everything
    Repair(repair::RepairArgs),
    /// Rebuild memory as it was at a step, and go on from there in another directory if you like
    Replay(replay::ReplayArgs),
    /// Write a memory as JSON Lines, for people, programs and archives
    Export(export::ExportArgs),
    /// Make a data directory of an export
    Import(import::ImportArgs),
    /// Repeat an experiment of the paper and print its figures
    Experiment(experiment::ExperimentArgs),
    /// Check this machine, and say how to mend what is wrong
    Doctor(doctor::DoctorArgs),
    /// Try whether a body, in any language, does its duties
    Conformance(conformance::ConformanceArgs),
    /// Print completions for a shell
    Completions(completions::CompletionsArgs),
}

impl Command {
    /// How the command is typed, if it asks no learner by its name.
    fn nameless(&self) -> Option<&'static str> {
        Some(match self {
            Self::Demo(_) => "demo",
            Self::Emulator(_) => "emulator",
            Self::Journal(_) => "journal",
            Self::Verify(_) => "verify",
            Self::Repair(_) => "repair",
            Self::Replay(_) => "replay",
            Self::Import(_) => "import",
            Self::Experiment(_) => "experiment",
            Self::Doctor(_) => "doctor",
            Self::Completions(_) => "completions",
            _ => return None,
        })
    }
}

impl Cli {
    /// How this command logs. A daemon and a body say what they do; every other command is silent while all is well; `-v` and
    /// `-q` change that.
    pub(crate) fn log(&self) -> Log {
        let usual = u8::from(matches!(self.command, Command::Server(_) | Command::Sim(_)));
        match &self.command {
            // A log would be written all over the picture on the same terminal.
            Command::Watch(args) if args.draws() && io::stderr().is_terminal() => Log::new(LevelFilter::OFF),
            Command::Server(args) => self.general.loudness.log(usual).as_json(args.log_json),
            _ => self.general.loudness.log(usual),
        }
    }

    /// Does what was typed.
    pub(crate) fn run(self) -> Result<(), Failure> {
        let Self { general, command } = self;
        general.check(command.nameless())?;
        match command {
            Command::Demo(args) => demo::run(args, &general),
            Command::Server(args) => server::run(*args, &general),
            Command::Sim(args) => sim::run(*args, &general),
            Command::Adept(args) => adept::run(*args, &general),
            Command::Emulator(args) => emulator::run(*args),
            Command::Status(args) => status::run(args, &general),
            Command::Schemas(args) => schemas::run(args, &general),
            Command::Show(args) => show::run(args, &general),
            Command::Claims(args) => claims::run(args, &general),
            Command::Explain(args) => explain::run(args, &general),
            Command::Graph(args) => graph::run(args, &general),
            Command::View(args) => view::run(args, &general),
            Command::Watch(args) => watch::run(args, &general),
            Command::Record(args) => record::run(args, &general),
            Command::Predict(args) => predict::run(args, &general),
            Command::Plan(args) => plan::run(args, &general),
            Command::Achieve(args) => achieve::run(args, &general),
            Command::Say(args) => say::run(args, &general),
            Command::Stage(args) => stage::run(args, &general),
            Command::Journal(args) => journal::run(args),
            Command::Verify(args) => verify::run(args, &general),
            Command::Repair(args) => repair::run(args),
            Command::Replay(args) => replay::run(args),
            Command::Export(args) => export::run(args, &general),
            Command::Import(args) => import::run(args, &general),
            Command::Experiment(args) => experiment::run(args, &general),
            Command::Doctor(args) => doctor::run(args),
            Command::Conformance(args) => conformance::run(args, &general),
            Command::Completions(args) => completions::run(args, Cli::command()),
        }
    }
}
