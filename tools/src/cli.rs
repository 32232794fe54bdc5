//! What can be typed: the tree of commands, their options and an example for each.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use pschema_protocol::domain::LearnerName;
use pschema_protocol::inspect::SchemaSort;
use pschema_server::config::BodyKind;

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
    pub(crate) args: pschema_adept::emulator::EmulatorArgs,
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
    pschema explain --data ~/arm --step 228")]
pub(crate) struct ExplainArgs {
    #[command(flatten)]
    pub(crate) name: NameArgs,
    #[command(flatten)]
    pub(crate) data: DataArgs,
    /// The decision of this step (a daemon keeps the latest 64, a data directory all of its journal); the last one
    /// unless named
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
    /// How long an action waits for the disk, against a bare write and fdatasync of the same bytes
    #[command(after_help = "Example:\n  pschema bench durability --data /mnt/robot\n\n\
        It exits with 0 whatever it finds; `within` in the JSON says whether the figure is reached.")]
    Durability(BenchDurabilityArgs),
    /// How long a daemon takes to find a memory again
    #[command(after_help = "Example:\n  pschema bench restart --schemas 20000,1000000")]
    Restart(BenchRestartArgs),
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
