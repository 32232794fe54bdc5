//! The `pschema-bench` program: figures of this machine, each beside a baseline that was measured in the same run. One file
//! a figure. `docs/PERFORMANCE.md` has what was measured, and the command of each figure.

mod bare_engine;
mod body;
mod decision;
mod durability;
mod goals;
mod inspect;
mod ipc;
mod lives;
mod memory;
mod play;
mod restart;
mod scenes;
mod sim;
mod tasks;
mod times;
mod vision;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use pschema_tools::kit::{Failure, Loudness, ParentArgs};

/// Measure this machine: figures as ratios against a baseline in the same run
#[derive(Debug, Parser)]
#[command(
    name = "pschema-bench",
    version,
    propagate_version = true,
    arg_required_else_help = true,
    after_help = "Example:\n  pschema-bench durability\n  pschema-bench restart --schemas 1000000\n\n\
    Each figure stands beside a baseline that was measured in the same run, taking turns with it."
)]
struct Cli {
    #[command(flatten)]
    loudness: Loudness,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// How long a step takes, learning included, as memory grows: three mixes of what is remembered
    #[command(after_help = "Example:\n  pschema-bench decision\n  \
        pschema-bench decision --mix scenario-3 --schemas 20000,1000000")]
    Decision(lives::LivesArgs),
    /// How many bytes a schema takes in RAM, indexes included, beside the same as plain structures
    #[command(after_help = "Example:\n  pschema-bench memory\n  \
        pschema-bench memory --mix scenario-3 --schemas 10000,1000000")]
    Memory(lives::LivesArgs),
    /// How long an action waits for the disk, against a bare write and fdatasync of the same bytes
    #[command(after_help = "Example:\n  pschema-bench durability --data /mnt/robot\n\n\
        It exits with 0 whatever it finds; `within` in the JSON says whether the figure is reached.")]
    Durability(durability::DurabilityArgs),
    /// How long a daemon takes to find a memory again
    #[command(after_help = "Example:\n  pschema-bench restart --schemas 20000,1000000")]
    Restart(restart::RestartArgs),
    /// How long answers to tools take, and what being asked all the time does to a step
    #[command(after_help = "Example:\n  pschema-bench inspect --schemas 1000000")]
    Inspect(inspect::InspectArgs),
    /// How long it takes from a frame to its action between two processes, against bare iceoryx2
    #[command(after_help = "Example:\n  pschema-bench ipc\n  pschema-bench ipc --rounds 10000 --json\n\n\
        Both cores of a small machine are in use: what else runs shows first in the 99th percentile.")]
    Ipc(ipc::IpcArgs),
    /// How long the simulated body takes for an action, against the physics engine alone on the same way
    #[command(after_help = "Example:\n  pschema-bench sim --world narrow")]
    Sim(scenes::ScenesArgs),
    /// How long it takes to render a picture and see what is in it, against copying the picture once
    #[command(after_help = "Example:\n  pschema-bench vision --world narrow")]
    Vision(scenes::ScenesArgs),
    /// How well the learner foretells in small worlds with exact rules, against the truth and a table
    #[command(after_help = "Example:\n  pschema-bench tasks --world gripper --seeds 1..5")]
    Tasks(tasks::TasksArgs),
    /// Whether the learner arrives where it is sent, in environments of gymnasium and minigrid
    #[command(after_help = "Example:\n  pschema-bench goals --environment taxi --seeds 1..5")]
    Goals(goals::GoalsArgs),
    /// How soon the learner's own choices lead to a true model, and how much of its time goes to noise
    #[command(after_help = "Example:\n  pschema-bench play --world blocks --seeds 1..5")]
    Play(play::PlayArgs),
    /// The other process of `ipc`
    #[command(hide = true)]
    IpcPeer(ipc::PeerArgs),
    /// The daemon of `durability`
    #[command(hide = true)]
    Server {
        #[command(flatten)]
        args: Box<pschema_server::ServerArgs>,
        #[command(flatten)]
        parent: ParentArgs,
    },
}

/// Measures what this process was started for, and gives the code to exit with: 0 done, 1 failed, 2 wrong usage.
#[must_use]
pub fn main() -> ExitCode {
    pschema_tools::kit::program("pschema-bench", |cli: &Cli| cli.loudness.log(0), run)
}

/// Whether a command line would be accepted: `arguments` begin with the program's name. For a test of the commands that the
/// documentation shows.
///
/// # Errors
/// The complaint about it.
pub fn check_usage(arguments: &[String]) -> Result<(), String> {
    pschema_tools::kit::check_usage::<Cli>(arguments)
}

fn run(cli: Cli) -> Result<(), Failure> {
    let quiet = cli.loudness.quiet;
    match cli.command {
        Command::Decision(args) => decision::run(&args, quiet),
        Command::Memory(args) => memory::run(&args, quiet),
        Command::Durability(args) => durability::run(&args, quiet),
        Command::Restart(args) => restart::run(&args, quiet),
        Command::Inspect(args) => inspect::run(&args, quiet),
        Command::Ipc(args) => ipc::run(&args, quiet),
        Command::Sim(args) => sim::run(&args, quiet),
        Command::Vision(args) => vision::run(&args, quiet),
        Command::Tasks(args) => tasks::run(&args, quiet),
        Command::Goals(args) => goals::run(&args, quiet),
        Command::Play(args) => play::run(&args, quiet),
        Command::IpcPeer(args) => ipc::serve(&args),
        Command::Server { args, parent } => pschema_tools::kit::serve(&args, parent),
    }
}
