//! An emulator of the arm's V+ controller, with a simulated arm, table, blocks and camera behind it: the whole of a
//! real arm's path - text on a serial line, pictures, digital inputs - without one.
//!
//! It speaks on a pseudo-terminal, either as the controller's monitor ([`Speaks::Monitor`]) or as the program
//! `pschema.v2` on a user serial line ([`Speaks::Program`]). Beside the line it has a camera socket (a line feed in, a
//! binary PPM out) and an operator's socket: what a person in the room would do, one line each, answered by `done` or
//! `refused WHY`:
//!
//! | line | |
//! |---|---|
//! | `place OBJECT POSITION`, `remove OBJECT` | arranges what is on the table |
//! | `estop press`, `estop release` | the emergency stop button |
//! | `halt` | stops the arm, as with a pendant |
//! | `trip` | has the program that serves the line meet an error of V+ |
//! | `power cycle` | switches the controller off and on |
//! | `unplug MS` | pulls the plug of the line, and puts it back after so long |
//! | `say TEXT` | has the controller say something unasked |
//! | `faults on`, `faults off` | whether the line has the faults it was started with |
//! | `enable WHY`, `reset WHY` | asks for the person's consent, which there is if it was started with `--consent` |
//! | `record` | what the arm was made to do so far |
//!
//! What of its behaviour is documented, and what is from memory, stands at the head of `monitor`, `messages` and
//! `machine`. The driver (`pschema-adept`) and this crate do not depend on each other: both follow the documents.
//!
//! Time: the arm moves in its own time, `fast` times as fast as the clock on the wall. What guards the line - the
//! program's watchdog, faults, the pace of characters - goes by the clock on the wall always. The world moves only
//! while the arm does, so that the same orders and seed give the same pictures however long the pauses between them.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use clap::{Args, ValueEnum};
use pschema_sim::config::WorldError;
use thiserror::Error;

mod faults;
mod line;
mod machine;
mod messages;
mod monitor;
mod path;
mod pty;
mod record;
mod rig;
mod server_program;
mod sockets;
mod sum;
pub mod teach;

pub use faults::{FaultRates, FaultSetting};
pub use machine::SOFTSTOPS_DEG;
pub use messages::Message;
pub use path::{JOINTS, Joints};
pub use record::Record;

/// What is at the other end of the line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Speaks {
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
    /// What answers on the line.
    #[arg(long, value_enum, default_value_t)]
    pub speaks: Speaks,
    /// A Unix socket that gives a picture for each line feed, as a binary PPM.
    #[arg(long, value_name = "PATH")]
    pub camera: Option<PathBuf>,
    /// A Unix socket for what a person in the room would do: `place blue-block 7`, `estop press`, …
    #[arg(long, value_name = "PATH")]
    pub operator: Option<PathBuf>,
    /// The person in the room agrees when asked whether the arm may have power, or go on after a stop.
    #[arg(long)]
    pub consent: bool,
    /// The world behind it: `narrow`, `wide`, or a world file of body-sim.
    #[arg(long, value_name = "NAME|FILE", default_value = "narrow")]
    pub world: String,
    /// Decides the small errors of the hand that places blocks.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// How many times as fast as a real arm it moves, powers up and calibrates.
    #[arg(long, default_value_t = 1.0, value_name = "FACTOR", value_parser = factor)]
    pub fast: f64,
    /// Pace characters to this many bits a second, in both directions [default: no pacing].
    #[arg(long, value_name = "BAUD", value_parser = clap::value_parser!(u32).range(300..=4_000_000))]
    pub baud: Option<u32>,
    /// The monitor does not echo what is typed.
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
    /// Decides which bytes and answers the faults meet.
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
            speaks: Speaks::default(),
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
    World(#[from] WorldError),
    /// The line or a socket cannot be made.
    #[error("{what} {path}: {source}")]
    Place {
        /// What.
        what: &'static str,
        /// Where.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// The line or a socket failed while running.
    #[error("the emulated line failed: {0}")]
    Failed(#[source] std::io::Error),
    /// The thread that runs it cannot be started, or died.
    #[error("the emulator's thread: {0}")]
    Thread(String),
}

/// Runs the emulator until `stop` is set. `ready` is called once drivers and clients may come.
///
/// # Errors
/// When the world cannot be used, or the line or a socket cannot be made or fails.
pub fn run(args: &EmulatorArgs, stop: &AtomicBool, ready: impl FnOnce()) -> Result<(), EmulatorError> {
    let mut rig = rig::Rig::new(args)?;
    ready();
    while !stop.load(Ordering::Relaxed) {
        rig.turn()?;
    }
    Ok(())
}

/// An emulator in this process, in a thread of its own. Dropping it ends it.
#[derive(Debug)]
pub struct Emulator {
    stop: Arc<AtomicBool>,
    record: Arc<Mutex<Record>>,
    thread: Option<JoinHandle<()>>,
}

impl Emulator {
    /// Starts one, and returns when drivers may come.
    ///
    /// # Errors
    /// As [`run`].
    pub fn start(args: EmulatorArgs) -> Result<Self, EmulatorError> {
        let stop = Arc::new(AtomicBool::new(false));
        let (sender, receiver) = std::sync::mpsc::channel();
        let flag = Arc::clone(&stop);
        let thread = std::thread::Builder::new().name("emulator".to_owned()).spawn(move || {
            let mut rig = match rig::Rig::new(&args) {
                Ok(rig) => rig,
                Err(error) => return drop(sender.send(Err(error))),
            };
            drop(sender.send(Ok(rig.watched())));
            while !flag.load(Ordering::Relaxed) {
                if let Err(error) = rig.turn() {
                    return tracing::error!(%error, "the emulator ended");
                }
            }
        });
        let thread = thread.map_err(|error| EmulatorError::Thread(error.to_string()))?;
        let record = receiver
            .recv()
            .map_err(|_| EmulatorError::Thread("it died before it was ready".to_owned()))??;
        Ok(Self { stop, record, thread: Some(thread) })
    }

    /// What the arm was made to do so far.
    #[must_use]
    pub fn record(&self) -> Record {
        self.record.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            tracing::error!("the emulator's thread died");
        }
    }
}

/// A number as V+ reads it: digits with at most one point, and a sign; no exponents, no `nan`, no `inf`.
fn decimal(text: &str) -> Option<f64> {
    let digits = text.strip_prefix(['-', '+']).unwrap_or(text);
    let plain = digits.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.');
    let some = digits.bytes().any(|byte| byte.is_ascii_digit());
    if text.len() > 24 || !plain || !some || digits.matches('.').count() > 1 {
        return None;
    }
    text.parse().ok()
}

/// How long after a failure to look again; also how often to look at a flag while nothing happens.
const IDLE: Duration = Duration::from_millis(20);
