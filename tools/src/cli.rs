//! What can be typed: the tree of commands, their options and an example for each.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use pschema_inspect::SchemaSort;
use pschema_protocol::domain::LearnerName;
use pschema_server::config::BodyKind;

use crate::run::Seeds;
use crate::watch::Page;

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
    /// Run the learner daemon in the foreground; with --data it keeps what it learns
    Server(Box<ServerCommand>),
    /// Run the simulated body: an arm, a table, blocks, a camera
    Sim(Box<SimCommand>),
    /// Run the Adept arm on a serial line: the robot
    Adept(Box<AdeptCommand>),
    /// Emulate the Adept arm's controller on a serial line, with a simulated arm behind it
    Emulator(Box<EmulatorCommand>),
    /// How the daemon, its bodies and its learner are
    Status(StatusArgs),
    /// List schemas
    Schemas(SchemasArgs),
    /// One schema whole: statistics, examples, counter-examples, lineage
    Show(ShowArgs),
    /// Why the last action (or that of a step) was chosen, term by term
    Explain(ExplainArgs),
    /// The network of schemas as a picture: what enables what, examples and counter-examples, chains
    Graph(GraphArgs),
    /// Look inside in a browser: a page for this machine alone
    View(ViewArgs),
    /// Watch a learner live: what it perceives, what excites it, why it acts, what it learns
    Watch(WatchArgs),
    /// Write down what a learner does while it does it: for programs, or for the Rerun viewer
    Record(RecordArgs),
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
    /// What happened in a memory on disk, batch by batch
    Journal(JournalArgs),
    /// Check a memory on disk, every byte of it
    Verify(VerifyArgs),
    /// Mend a damaged memory on disk: save what can be saved, after a copy of everything
    Repair(RepairArgs),
    /// Rebuild memory as it was at a step, and go on from there in another directory if you like
    Replay(ReplayArgs),
    /// Write a memory as JSON Lines, for people, programs and archives
    Export(ExportArgs),
    /// Make a data directory of an export
    Import(ImportArgs),
    /// Repeat an experiment of the paper and print its figures
    Experiment(ExperimentArgs),
    /// Measure this machine: figures as ratios against a baseline in the same run
    Bench(BenchArgs),
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

/// Asks a memory on disk instead of a daemon.
#[derive(Clone, Debug, Args)]
pub(crate) struct DataArgs {
    /// Ask the memory in this data directory, with or without a daemon on it; nothing in it is changed
    #[arg(long, value_name = "DIR", conflicts_with = "name")]
    pub(crate) data: Option<PathBuf>,
    /// As it was after step N, before step N + 1
    #[arg(long, value_name = "N", requires = "data")]
    pub(crate) until: Option<u64>,
}

/// So that an order with `--data` is answered with why it can't be obeyed.
#[derive(Clone, Debug, Args)]
pub(crate) struct NoDataArgs {
    #[arg(long, value_name = "DIR", hide = true)]
    pub(crate) data: Option<PathBuf>,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema status --json\n  \
    pschema status --data ~/arm --until 5000\n  \
    pschema status --metrics | curl --data-binary @- http://gateway:9091/metrics/job/pschema")]
pub(crate) struct StatusArgs {
    #[command(flatten)]
    pub(crate) name: NameArgs,
    #[command(flatten)]
    pub(crate) data: DataArgs,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Print metrics in Prometheus' text format; without a daemon, that there is none
    #[arg(long, conflicts_with_all = ["json", "data"])]
    pub(crate) metrics: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema demo --seed 7")]
pub(crate) struct DemoArgs {
    /// Everything drawn by lot follows from it
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// The body: the simulated arm, or the Adept arm at the end of a serial line, on an emulator of its controller
    #[arg(long, value_enum, default_value_t)]
    pub(crate) body: BodyKind,
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

#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  pschema adept --port /dev/ttyS0 --arm my-arm.toml --camera folder:/var/camera"
)]
pub(crate) struct AdeptCommand {
    #[command(flatten)]
    pub(crate) parent: ParentArgs,
    #[command(flatten)]
    pub(crate) args: pschema_adept::AdeptArgs,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema emulator --link /tmp/adept --camera /tmp/adept-camera \
    --operator /tmp/adept-operator --fast 10 --consent")]
pub(crate) struct EmulatorCommand {
    #[command(flatten)]
    pub(crate) args: pschema_vplus_emulator::EmulatorArgs,
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
    #[command(flatten)]
    pub(crate) data: DataArgs,
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
    /// Leave out so many of the first: with --limit, page by page
    #[arg(long, default_value_t = 0, value_name = "N")]
    pub(crate) offset: u32,
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
    #[command(flatten)]
    pub(crate) data: DataArgs,
    /// Its number, as `pschema schemas` prints it
    pub(crate) id: u32,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema explain\n  pschema explain --step 228 --candidates 3\n  \
    pschema explain --why-not 42\n  pschema explain --data ~/arm --step 228")]
pub(crate) struct ExplainArgs {
    #[command(flatten)]
    pub(crate) name: NameArgs,
    #[command(flatten)]
    pub(crate) data: DataArgs,
    /// The decision of this step; the last one unless named. A daemon has the latest 64 at hand; older ones are made
    /// again from its data directory, if it has one
    #[arg(long, value_name = "N")]
    pub(crate) step: Option<u64>,
    /// Say what stood in the way of this schema instead
    #[arg(long, value_name = "ID", conflicts_with = "candidates")]
    pub(crate) why_not: Option<u32>,
    /// How many of the things it could have done to list
    #[arg(long, default_value_t = 5, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) candidates: u32,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema graph --out schemas.svg\n  \
    pschema graph --around 226 --depth 2 --out touching.svg\n  \
    pschema graph --goal 'touch{}' --format dot | dot -Tpdf -o chain.pdf")]
pub(crate) struct GraphArgs {
    #[command(flatten)]
    pub(crate) name: NameArgs,
    #[command(flatten)]
    pub(crate) data: DataArgs,
    /// Only what is tied to this schema
    #[arg(long, value_name = "ID")]
    pub(crate) around: Option<u32>,
    /// How many ties away from it
    #[arg(long, value_name = "N", default_value_t = 1, requires = "around", value_parser = clap::value_parser!(u32).range(1..=8))]
    pub(crate) depth: u32,
    /// Only the chain that would bring this about from the world as it is; several patterns must hold at once
    #[arg(long, value_name = "PATTERN", conflicts_with = "around", num_args = 1..=8)]
    pub(crate) goal: Vec<String>,
    /// Schemas to draw one by one, at most; the others stand together, counted
    #[arg(long, value_name = "N", default_value_t = 2000, value_parser = clap::value_parser!(u32).range(1..=5000))]
    pub(crate) limit: u32,
    /// A picture for browsers, a text for Graphviz, or data
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: GraphFormat,
    /// Write it to this file; to stdout unless named
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(crate) enum GraphFormat {
    /// A picture that can be zoomed
    #[default]
    Svg,
    /// The language of Graphviz
    Dot,
    /// Nodes and ties
    Json,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema view\n  pschema view --data ~/arm --no-open\n\n\
    The address is printed on stdout; who knows it can look, and give orders. Ctrl-C ends it.")]
pub(crate) struct ViewArgs {
    #[command(flatten)]
    pub(crate) name: NameArgs,
    /// Look at the memory in this data directory, with or without a daemon on it; nothing in it is changed
    #[arg(long, value_name = "DIR", conflicts_with = "name")]
    pub(crate) data: Option<PathBuf>,
    /// Serve the page on this port of this machine [default: one that is free]
    #[arg(long, value_name = "PORT", default_value_t = 0, hide_default_value = true)]
    pub(crate) port: u16,
    /// Only print the address: open no browser
    #[arg(long)]
    pub(crate) no_open: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema watch\n  pschema watch --rate 2 --page choice\n  \
    pschema watch --once --width 120 --height 40\n\n\
    Keys: space holds the learner and lets it go on, . takes one step, w says words, f follows a schema, ? has the \
    rest, q quits.")]
pub(crate) struct WatchArgs {
    #[command(flatten)]
    pub(crate) name: NameArgs,
    #[command(flatten)]
    pub(crate) data: NoDataArgs,
    /// How often a second to look, at most
    #[arg(long, default_value_t = 10, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=30))]
    pub(crate) rate: u8,
    /// The page to begin with
    #[arg(long, value_enum, default_value_t)]
    pub(crate) page: Page,
    /// Follow the schema of this number
    #[arg(long, value_name = "ID")]
    pub(crate) follow: Option<u32>,
    /// Print one frame as plain text, and end
    #[arg(long, conflicts_with = "rate")]
    pub(crate) once: bool,
    /// Columns of that frame
    #[arg(long, default_value_t = 80, requires = "once", value_name = "N", value_parser = clap::value_parser!(u16).range(40..=500))]
    pub(crate) width: u16,
    /// Rows of it
    #[arg(long, default_value_t = 24, requires = "once", value_name = "N", value_parser = clap::value_parser!(u16).range(10..=500))]
    pub(crate) height: u16,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema predict 'move(j1=0.426, j2=0.817)'")]
pub(crate) struct PredictArgs {
    #[command(flatten)]
    pub(crate) name: NameArgs,
    #[command(flatten)]
    pub(crate) data: DataArgs,
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
    #[command(flatten)]
    pub(crate) data: DataArgs,
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
    #[command(flatten)]
    pub(crate) data: NoDataArgs,
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
#[command(
    after_help = "Example:\n  pschema record --jsonl steps.jsonl --steps 1000\n  pschema record --rerun life.rrd\n\n\
    The steps that the daemon still has come first. It goes on until so many steps are written, the daemon ends or Ctrl-C."
)]
#[command(group = clap::ArgGroup::new("to").required(true).multiple(true).args(["jsonl", "rerun"]))]
pub(crate) struct RecordArgs {
    #[command(flatten)]
    pub(crate) name: NameArgs,
    /// One JSON object a line: {"step": …} or {"schema": …}
    #[arg(long, value_name = "FILE")]
    pub(crate) jsonl: Option<PathBuf>,
    /// A recording for the Rerun viewer, pictures included; needs a pschema built with `--features rerun`
    #[arg(long, value_name = "FILE")]
    pub(crate) rerun: Option<PathBuf>,
    /// Leave the pictures out of it: they are most of its bytes
    #[arg(long, requires = "rerun")]
    pub(crate) no_pictures: bool,
    /// End after so many steps
    #[arg(long, value_name = "N")]
    pub(crate) steps: Option<u64>,
    /// What was recorded as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema say touch")]
pub(crate) struct SayArgs {
    #[command(flatten)]
    pub(crate) name: NameArgs,
    #[command(flatten)]
    pub(crate) data: NoDataArgs,
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
    /// Say where it stood in the memory in this data directory, with or without a daemon on it
    #[arg(long, value_name = "DIR", global = true)]
    pub(crate) data: Option<PathBuf>,
    /// As it was after step N, before step N + 1
    #[arg(long, value_name = "N", requires = "data", global = true)]
    pub(crate) until: Option<u64>,
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
    /// Take one action, and wait again
    #[command(after_help = "Example:\n  pschema stage step")]
    Step,
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
    /// Another body: the simulated arm, or the Adept arm at the end of a serial line, on an emulator of its controller
    #[arg(long, value_enum)]
    pub(crate) body: Option<BodyKind>,
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

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema journal --data ~/arm\n  \
    pschema journal --data ~/arm --from 228 --to 230 --effects")]
pub(crate) struct JournalArgs {
    /// The data directory; a daemon may be running on it
    #[arg(long, value_name = "DIR")]
    pub(crate) data: PathBuf,
    /// From this step on
    #[arg(long, value_name = "N")]
    pub(crate) from: Option<u64>,
    /// Up to this step
    #[arg(long, value_name = "N")]
    pub(crate) to: Option<u64>,
    /// At most this many batches: the last of them, or the first ones if `--from` is given
    #[arg(long, default_value_t = 20, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) limit: u32,
    /// Say every effect in words
    #[arg(long)]
    pub(crate) effects: bool,
    /// Print JSON: one object a line, a batch each, and the directory last
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  pschema verify --data ~/arm\n  pschema verify --data ~/arm --relearn\n\n\
    It exits with 0 when everything is sound, else with 1."
)]
pub(crate) struct VerifyArgs {
    /// The data directory; a daemon may be running on it
    #[arg(long, value_name = "DIR")]
    pub(crate) data: PathBuf,
    /// Put every frame that a body sent through a learner once more, and compare what it changes
    #[arg(long)]
    pub(crate) relearn: bool,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  pschema repair --data ~/arm --dry-run\n  pschema repair --data ~/arm\n\n\
    Nothing is destroyed: everything is copied aside before anything is cut."
)]
pub(crate) struct RepairArgs {
    /// The data directory; no daemon may be running on it
    #[arg(long, value_name = "DIR")]
    pub(crate) data: PathBuf,
    /// Leave it as it is, and put what can be saved into this directory, which is made
    #[arg(long, value_name = "DIR", conflicts_with = "dry_run")]
    pub(crate) to: Option<PathBuf>,
    /// Only say what would be done
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema replay --data ~/arm --until 5000\n  \
    pschema replay --data ~/arm --until 5000 --out ~/arm-at-5000\n  \
    pschema server --data ~/arm-at-5000")]
pub(crate) struct ReplayArgs {
    /// The data directory; a daemon may be running on it
    #[arg(long, value_name = "DIR")]
    pub(crate) data: PathBuf,
    /// To this step; to the last one unless named
    #[arg(long, value_name = "N")]
    pub(crate) until: Option<u64>,
    /// Write it as a data directory, which is made: a life that branches off there
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema export --data ~/arm -o arm.jsonl\n  \
    pschema export --name arm | jq -r 'select(.schema.generalised) | .schema.id'")]
pub(crate) struct ExportArgs {
    #[command(flatten)]
    pub(crate) name: NameArgs,
    #[command(flatten)]
    pub(crate) data: DataArgs,
    /// Write to this file, which must not be there yet; to stdout unless named
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema import arm.jsonl --data ~/arm-again\n  \
    pschema server --data ~/arm-again")]
pub(crate) struct ImportArgs {
    /// What `pschema export` wrote; `-` for stdin
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// The data directory to make; there must be nothing in it
    #[arg(long, value_name = "DIR")]
    pub(crate) data: PathBuf,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema bench durability\n  pschema bench restart --schemas 1000000\n\n\
    Each figure stands beside a baseline that was measured in the same run, taking turns with it.")]
pub(crate) struct BenchArgs {
    #[command(subcommand)]
    pub(crate) what: BenchCommand,
}

#[derive(Debug, Subcommand)]
pub(crate) enum BenchCommand {
    /// How long a step takes, learning included, as memory grows: three mixes of what is remembered
    #[command(after_help = "Example:\n  pschema bench decision\n  \
        pschema bench decision --mix scenario-3 --schemas 20000,1000000")]
    Decision(BenchDecisionArgs),
    /// How many bytes a schema takes in RAM, indexes included, beside the same as plain structures
    #[command(after_help = "Example:\n  pschema bench memory\n  \
        pschema bench memory --mix scenario-3 --schemas 10000,1000000")]
    Memory(BenchDecisionArgs),
    /// How long an action waits for the disk, against a bare write and fdatasync of the same bytes
    #[command(after_help = "Example:\n  pschema bench durability --data /mnt/robot\n\n\
        It exits with 0 whatever it finds; `within` in the JSON says whether the figure is reached.")]
    Durability(BenchDurabilityArgs),
    /// How long a daemon takes to find a memory again
    #[command(after_help = "Example:\n  pschema bench restart --schemas 20000,1000000")]
    Restart(BenchRestartArgs),
    /// How long answers to tools take, and what being asked all the time does to a step
    #[command(after_help = "Example:\n  pschema bench inspect --schemas 1000000")]
    Inspect(BenchInspectArgs),
    /// How long it takes from a frame to its action between two processes, against bare iceoryx2
    #[command(after_help = "Example:\n  pschema bench ipc\n  pschema bench ipc --rounds 10000 --json\n\n\
        Both cores of a small machine are in use: what else runs shows first in the 99th percentile.")]
    Ipc(BenchIpcArgs),
    /// The other side of `bench ipc`
    #[command(hide = true)]
    IpcPeer(BenchPeerArgs),
    /// How long the simulated body takes for an action, against the physics engine alone on the same way
    #[command(after_help = "Example:\n  pschema bench sim --world narrow")]
    Sim(BenchSimArgs),
    /// How long it takes to render a picture and see what is in it, against copying the picture once
    #[command(after_help = "Example:\n  pschema bench vision --world narrow")]
    Vision(BenchVisionArgs),
}

#[derive(Debug, Args)]
pub(crate) struct BenchIpcArgs {
    /// How many round trips each way, for each payload and way of waiting
    #[arg(long, default_value_t = 2_000, value_name = "N", value_parser = clap::value_parser!(u32).range(100..=1_000_000))]
    pub(crate) rounds: u32,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct BenchPeerArgs {
    /// How it waits: polling, event or hybrid
    #[arg(long)]
    pub(crate) mode: String,
    #[command(flatten)]
    pub(crate) parent: ParentArgs,
}

#[derive(Debug, Args)]
pub(crate) struct BenchSimArgs {
    /// The world the body lives in: `wide`, `narrow`, `block-and-ball`, or a world file
    #[arg(long, value_name = "NAME|FILE", default_value = "wide")]
    pub(crate) world: String,
    /// Everything drawn by lot follows from it
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// How many actions
    #[arg(long, default_value_t = 1_000, value_name = "N", value_parser = clap::value_parser!(u32).range(10..=1_000_000))]
    pub(crate) rounds: u32,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct BenchVisionArgs {
    /// The world that is looked at: `wide`, `narrow`, `block-and-ball`, or a world file
    #[arg(long, value_name = "NAME|FILE", default_value = "wide")]
    pub(crate) world: String,
    /// Everything drawn by lot follows from it
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// How many pictures
    #[arg(long, default_value_t = 1_000, value_name = "N", value_parser = clap::value_parser!(u32).range(10..=1_000_000))]
    pub(crate) rounds: u32,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct BenchDecisionArgs {
    /// Only this mix: scenario-1, scenario-3 or wide
    #[arg(long, value_name = "MIX", value_parser = ["scenario-1", "scenario-3", "wide"])]
    pub(crate) mix: Option<String>,
    /// Sizes of memory at which to measure, in schemas; a million takes some minutes
    #[arg(long, value_name = "N", value_delimiter = ',', default_values_t = [100, 1_000, 10_000, 20_000, 100_000], value_parser = sizes)]
    pub(crate) schemas: Vec<usize>,
    /// Everything drawn by lot follows from it
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// A size of memory that can be measured.
fn sizes(text: &str) -> Result<usize, String> {
    let size: usize = text.parse().map_err(|_| format!("{text:?} is no number of schemas"))?;
    match size {
        100..=10_000_000 => Ok(size),
        _ => Err(format!("{size} schemas can't be measured: give 100 to 10000000")),
    }
}

#[derive(Debug, Args)]
pub(crate) struct BenchDurabilityArgs {
    /// Measure the disk that this directory is on; a directory made in it is removed again [default: here]
    #[arg(long, value_name = "DIR")]
    pub(crate) data: Option<PathBuf>,
    /// How many times each way
    #[arg(long, default_value_t = 1000, value_name = "N", value_parser = clap::value_parser!(u32).range(100..=1_000_000))]
    pub(crate) rounds: u32,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct BenchRestartArgs {
    /// Sizes of memory, in schemas
    #[arg(long, value_name = "N", value_delimiter = ',', default_values_t = [20_000], value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    pub(crate) schemas: Vec<u32>,
    /// Measure the disk that this directory is on; a directory made in it is removed again [default: here]
    #[arg(long, value_name = "DIR")]
    pub(crate) data: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct BenchInspectArgs {
    /// What memory is filled with: scenario-1, scenario-3 or wide
    #[arg(long, value_name = "MIX", default_value = "scenario-3", value_parser = ["scenario-1", "scenario-3", "wide"])]
    pub(crate) mix: String,
    /// Sizes of memory, in schemas; a million takes some minutes
    #[arg(long, value_name = "N", value_delimiter = ',', default_values_t = [20_000], value_parser = sizes)]
    pub(crate) schemas: Vec<usize>,
    /// How many times each question
    #[arg(long, default_value_t = 9, value_name = "N", value_parser = clap::value_parser!(u32).range(3..=1_000))]
    pub(crate) rounds: u32,
    /// Everything drawn by lot follows from it
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
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
