//! How an emulator is run, and why it cannot be.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use pschema_arm::FileError;
use thiserror::Error;

use crate::faults::FaultSetting;

/// The program at the controller's end of the line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Dialect {
    /// The monitor, as at the controller's terminal.
    Monitor,
    /// The program `pschema.v2`, on a user serial line.
    #[default]
    Program,
}

/// How to run the emulator.
#[derive(Args, Clone, Debug)]
pub struct EmulatorArgs {
    /// Where drivers find the line: a symbolic link to the pseudo-terminal, made here and removed at the end.
    #[arg(long, value_name = "PATH")]
    pub link: PathBuf,
    /// The program that answers on the line.
    #[arg(long, value_enum, default_value_t)]
    pub speaks: Dialect,
    /// A Unix socket that gives a picture for each line feed, as a binary PPM.
    #[arg(long, value_name = "PATH")]
    pub camera: Option<PathBuf>,
    /// A Unix socket for the deeds of a person in the room: `place blue-block 7`, `estop press`, …
    #[arg(long, value_name = "PATH")]
    pub operator: Option<PathBuf>,
    /// The person in the room agrees when asked whether the arm may have power, or go on after a stop.
    #[arg(long)]
    pub consent: bool,
    /// The world behind the controller: `narrow`, `wide`, a world file of body-sim, or `-` for stdin.
    #[arg(long, value_name = "NAME|FILE", default_value = "narrow")]
    pub world: String,
    /// The seed of the small errors of the hand that places blocks.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// How many times as fast as a real arm the emulated one moves, powers up and calibrates.
    #[arg(long, default_value_t = 1.0, value_name = "FACTOR", value_parser = factor)]
    pub fast: f64,
    /// Pace characters to this many bits a second, in both directions [default: no pacing].
    #[arg(long, value_name = "BAUD", value_parser = clap::value_parser!(u32).range(300..=4_000_000))]
    pub baud: Option<u32>,
    /// The monitor does not echo the bytes that are typed.
    #[arg(long)]
    pub no_echo: bool,
    /// The touch inputs are on when nothing is touched.
    #[arg(long)]
    pub touch_inverted: bool,
    /// Milliseconds without a line after which the program stops a motion.
    #[arg(long, default_value_t = 1000, value_name = "MS", value_parser = clap::value_parser!(u64).range(20..=60_000))]
    pub watchdog_ms: u64,
    /// A fault of the line and how often it happens: lose, flip, noise (shares of bytes), cut, mute, late, chatter,
    /// twice, unplug (shares of answers). May be given several times.
    #[arg(long, value_name = "KEY=SHARE")]
    pub fault: Vec<FaultSetting>,
    /// The seed that decides which bytes and answers the faults meet.
    #[arg(long, default_value_t = 1)]
    pub fault_seed: u64,
    /// At most so many faults.
    #[arg(long, default_value_t = u64::MAX, hide_default_value = true, value_name = "N")]
    pub faults_max: u64,
}

fn factor(text: &str) -> Result<f64, String> {
    let factor = text.parse().ok().filter(|factor| (0.01..=1e6).contains(factor));
    factor.ok_or_else(|| "a factor from 0.01 to 1000000".to_owned())
}

impl EmulatorArgs {
    /// The program on a line at `link`, with the defaults of the command line.
    #[must_use]
    pub fn at(link: &Path) -> Self {
        Self {
            link: link.to_owned(),
            speaks: Dialect::default(),
            camera: None,
            operator: None,
            consent: false,
            world: "narrow".to_owned(),
            seed: 1,
            fast: 1.0,
            baud: None,
            no_echo: false,
            touch_inverted: false,
            watchdog_ms: 1000,
            fault: Vec::new(),
            fault_seed: 1,
            faults_max: u64::MAX,
        }
    }
}

/// Why the emulator cannot run.
#[derive(Debug, Error)]
pub enum EmulatorError {
    /// The world cannot be used.
    #[error(transparent)]
    World(#[from] FileError),
    /// The line or a socket cannot be made.
    #[error("{what} {path}: {source}")]
    Place {
        /// The line or socket.
        what: &'static str,
        /// Its path.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// The line or a socket failed while running.
    #[error("the emulated line failed: {0}")]
    Failed(#[source] std::io::Error),
    /// The thread that runs it cannot be started, or died.
    #[error("the emulator's thread: {0}")]
    Thread(String),
}
