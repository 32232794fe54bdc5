//! What can be typed: the tree of commands, their options and an example for each.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use pschema_protocol::domain::LearnerName;
use pschema_protocol::inspect::SchemaSort;

use crate::run::Seeds;

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
    /// The learner meant [default: default]; several live side by side under different names
    #[arg(long, value_name = "NAME")]
    pub(crate) name: Option<LearnerName>,
    /// Say more on stderr; twice or three times for still more
    #[arg(short, long, global = true, display_order = 900, action = clap::ArgAction::Count)]
    pub(crate) verbose: u8,
    /// Say only what went wrong
    #[arg(short, long, global = true, display_order = 901, conflicts_with = "verbose")]
    pub(crate) quiet: bool,
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Watch a robot learn to touch: a daemon and a simulated body, from nothing, in seconds
    Demo(DemoArgs),
    /// Run the learner daemon in the foreground; what it learns ends with it
    Server(Box<ServerCommand>),
    /// Run the simulated body: an arm, a table, blocks, a camera
    Sim(Box<SimCommand>),
    /// How the daemon, its bodies and its learner are
    Status(ReportArgs),
    /// List schemas
    Schemas(SchemasArgs),
    /// One schema whole: statistics, examples, counter-examples, lineage
    Show(ShowArgs),
    /// Why the last action (or that of a step) was chosen, term by term
    Explain(ExplainArgs),
    /// What an action would do in the world as it is
    Predict(PredictArgs),
    /// How a goal could be brought about, and with what probability
    Plan(PlanArgs),
    /// Have the learner bring a goal about, and wait for it
    Achieve(AchieveArgs),
    /// Say words to the learner
    Say(SayArgs),
    /// Developmental control: where the curriculum stands, and moving it
    Stage(StageArgs),
    /// Repeat an experiment of the paper and print its figures
    Experiment(ExperimentArgs),
    /// Check this machine, and say how to mend what is wrong
    Doctor(DoctorArgs),
    /// Print completions for a shell
    #[command(
        after_help = "Example:\n  pschema completions bash > ~/.local/share/bash-completion/completions/pschema"
    )]
    Completions {
        /// The shell
        shell: Shell,
    },
}

/// Which learner a command asks. It can be named before the command as well; not by one global option, because
/// `server` and `sim` bring an option of that name with them.
#[derive(Clone, Debug, Args)]
pub(crate) struct NameArgs {
    /// The learner meant [default: default]
    #[arg(long, value_name = "NAME")]
    pub(crate) name: Option<LearnerName>,
}

/// Options of a command that reports and takes no others.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema status --json")]
pub(crate) struct ReportArgs {
    #[command(flatten)]
    pub(crate) name: NameArgs,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema demo --seed 7")]
pub(crate) struct DemoArgs {
    /// Everything drawn by lot follows from it
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Print the figures as JSON instead of the story
    #[arg(long)]
    pub(crate) json: bool,
    /// Write a report into this folder: a page to look at, and the raw figures as CSV and JSON Lines
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema --name robot-1 server")]
pub(crate) struct ServerCommand {
    #[command(flatten)]
    pub(crate) args: pschema_server::ServerArgs,
    /// Write the log as JSON, one object a line
    #[arg(long)]
    pub(crate) log_json: bool,
    #[command(flatten)]
    pub(crate) parent: ParentArgs,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema --name robot-1 sim --realtime")]
pub(crate) struct SimCommand {
    #[command(flatten)]
    pub(crate) args: pschema_sim::SimArgs,
    #[command(flatten)]
    pub(crate) parent: ParentArgs,
}

/// How a process started by another of ours is told not to outlive it.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct ParentArgs {
    /// End when this process does, which must be the parent
    #[arg(long, hide = true, value_name = "PID")]
    pub(crate) parent: Option<u32>,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema schemas --generalised\n  \
    pschema schemas --post 'touch{}' --sort probability --limit 5")]
pub(crate) struct SchemasArgs {
    #[command(flatten)]
    pub(crate) name: NameArgs,
    /// Only those with this action
    #[arg(long, value_name = "NAME")]
    pub(crate) action: Option<String>,
    /// Only those with a pre-condition like this, written as schemas print: 'object{colour=blue}'
    #[arg(long, value_name = "PATTERN")]
    pub(crate) pre: Option<String>,
    /// Only those with a post-condition like this
    #[arg(long, value_name = "PATTERN")]
    pub(crate) post: Option<String>,
    /// Only generalised ones
    #[arg(long)]
    pub(crate) generalised: bool,
    /// The order
    #[arg(long, value_enum, default_value_t)]
    pub(crate) sort: Sort,
    /// At most this many
    #[arg(long, default_value_t = 20, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) limit: u32,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(crate) enum Sort {
    /// The oldest first
    #[default]
    Age,
    /// The most executed first
    Uses,
    /// The surest to succeed first
    Probability,
    /// The most exciting in the last decision first
    Excitation,
}

impl From<Sort> for SchemaSort {
    fn from(sort: Sort) -> Self {
        match sort {
            Sort::Age => Self::Age,
            Sort::Uses => Self::Uses,
            Sort::Probability => Self::Probability,
            Sort::Excitation => Self::Excitation,
        }
    }
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema show 226")]
pub(crate) struct ShowArgs {
    #[command(flatten)]
    pub(crate) name: NameArgs,
    /// Its number, as `pschema schemas` prints it
    pub(crate) id: u32,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema explain\n  pschema explain --step 228 --candidates 3")]
pub(crate) struct ExplainArgs {
    #[command(flatten)]
    pub(crate) name: NameArgs,
    /// The decision of this step (the daemon keeps the latest); the last one unless named
    #[arg(long, value_name = "N")]
    pub(crate) step: Option<u64>,
    /// How many of the things it could have done to list
    #[arg(long, default_value_t = 5, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) candidates: u32,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema predict 'move(j1=0.43, j2=0.84)'")]
pub(crate) struct PredictArgs {
    #[command(flatten)]
    pub(crate) name: NameArgs,
    /// The action, written as schemas print it
    pub(crate) action: String,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema plan 'touch{}'\n  \
    pschema plan 'object{colour=blue, field=$x}' 'finger{field=$x}'")]
pub(crate) struct PlanArgs {
    #[command(flatten)]
    pub(crate) name: NameArgs,
    /// What is wanted, all of it: patterns as schemas print; a variable is the same value in all of them
    #[arg(required = true, value_name = "PATTERN")]
    pub(crate) goal: Vec<String>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema achieve 'touch{}'\n  \
    pschema achieve 'finger{field=17}' --actions-max 5 --wait 10\n\n\
    It exits with 0 when the goal was achieved, else with 1. Ctrl-C calls the goal off.")]
pub(crate) struct AchieveArgs {
    #[command(flatten)]
    pub(crate) name: NameArgs,
    /// What is wanted, all of it: patterns as schemas print; a variable is the same value in all of them
    #[arg(required = true, value_name = "PATTERN")]
    pub(crate) goal: Vec<String>,
    /// Actions that it may take
    #[arg(long, default_value_t = 50, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) actions_max: u32,
    /// Seconds to wait for it before it is called off
    #[arg(long, default_value_t = 60, value_name = "SECONDS", value_parser = clap::value_parser!(u64).range(1..=86_400))]
    pub(crate) wait: u64,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema say touch")]
pub(crate) struct SayArgs {
    #[command(flatten)]
    pub(crate) name: NameArgs,
    /// The words, heard together in the learner's next frame
    #[arg(required = true, value_name = "WORD")]
    pub(crate) words: Vec<String>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  pschema stage\n  pschema stage next\n  pschema stage set 'first touches'"
)]
pub(crate) struct StageArgs {
    #[command(flatten)]
    pub(crate) name: NameArgs,
    #[command(subcommand)]
    pub(crate) order: Option<StageCommand>,
    /// Print JSON
    #[arg(long, global = true)]
    pub(crate) json: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum StageCommand {
    /// Say where the curriculum stands
    #[command(after_help = "Example:\n  pschema stage show --json")]
    Show,
    /// End the present stage and enter the next
    #[command(after_help = "Example:\n  pschema stage next")]
    Next,
    /// Wait: nothing is done until `resume`
    #[command(after_help = "Example:\n  pschema stage hold")]
    Hold,
    /// Go on after `hold`
    #[command(after_help = "Example:\n  pschema stage resume")]
    Resume,
    /// Enter a stage of the curriculum, or enter it again
    #[command(after_help = "Example:\n  pschema stage set 'first touches'")]
    Set {
        /// Its name
        stage: String,
    },
}

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
    pub(crate) experiment: String,
    /// Everything drawn by lot follows from it [default: 1]
    #[arg(long, conflicts_with = "seeds")]
    pub(crate) seed: Option<u64>,
    /// One run for each seed from A to B, both included [default for all: 1..10]
    #[arg(long, value_name = "A..B")]
    pub(crate) seeds: Option<Seeds>,
    /// How many runs side by side
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=64))]
    pub(crate) jobs: u8,
    /// Learner and body in this process, without shared memory: the same results
    #[arg(long)]
    pub(crate) in_process: bool,
    /// Another world: wide (the paper's simulated robot), narrow (its physical one), or a world file
    #[arg(long, value_name = "WORLD")]
    pub(crate) world: Option<String>,
    /// Of an experiment with variants, only this one
    #[arg(long, value_name = "NAME")]
    pub(crate) variant: Option<String>,
    /// Write a report into this folder: a page to look at, and the raw figures as CSV and JSON Lines
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON: an object, or one object a line if there are several runs
    #[arg(long, conflicts_with = "markdown")]
    pub(crate) json: bool,
    /// Print the table of published figures and ours as Markdown
    #[arg(long)]
    pub(crate) markdown: bool,
}

#[derive(Clone, Copy, Debug, Args)]
#[command(after_help = "Example:\n  pschema doctor --clean")]
pub(crate) struct DoctorArgs {
    /// Remove what dead daemons left behind
    #[arg(long)]
    pub(crate) clean: bool,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}
