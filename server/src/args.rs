//! The daemon as a program: arguments, log, signals.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;

use clap::Parser;
use pschema_process::{LevelFilter, Log, Stop, ended, usage};
use pschema_protocol::domain::{LearnerName, Place, RuntimeDir};

use crate::{Durability, Hosting, Keeping, Retention, ServerError, Setup, config, resident, serve_kept};

/// Run a learner in the foreground, for bodies to attach to and tools to ask.
///
/// With --data what is learnt is kept on disk and found again at the next start. Without it memory is in RAM only.
#[derive(Clone, Debug, clap::Args)]
pub struct ServerArgs {
    /// The learner's name: 1 to 32 of a-z, 0-9, _ and -. Several learners live side by side by name.
    #[arg(long, default_value = "default")]
    pub name: LearnerName,

    /// What the learner's draws begin from. The same seed, curriculum and body give the same memory. 1 unless given; a
    /// memory found with --data has its own.
    #[arg(long)]
    pub seed: Option<u64>,

    /// A file with the learner's parameters, such as `server/learner.toml`, or `-` for stdin; without it, the defaults.
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,

    /// A built-in curriculum (free, or that of an experiment, such as exp1-s1), a file with one, or `-` for stdin. `free`
    /// unless given; a memory found with --data has its own, and its own parameters.
    #[arg(long, value_name = "NAME|FILE")]
    pub curriculum: Option<String>,

    /// Replace what the curriculum says: `learner.PARAMETER=VALUE`, or `values.NAME=NUMBER` for a number that it
    /// names in its `[values]`. May be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub settings: Vec<String>,

    /// How much memory the process may take until it learns nothing new: a size such as 4GiB, or `none`. Acting, and learning how
    /// well known schemas do, go on. Half of the machine's memory, or of the process's group, unless given.
    #[arg(long, value_name = "SIZE|none", value_parser = memory_max)]
    pub memory_max: Option<MemoryMax>,

    /// Take a body that declares other ranges or another repertoire than when it attached before, or that is in another world.
    /// Without this it is refused: what was learnt would be of something else.
    #[arg(long)]
    pub accept_changes: bool,

    /// The directory that memory is kept in, made when it isn't there. Without it, memory ends with the daemon.
    #[arg(long, value_name = "DIR")]
    pub data: Option<PathBuf>,

    /// Have a memory that was found go on under the --curriculum, --config and --set given now, from the first stage.
    /// Without this, a memory that lives under others is refused.
    #[arg(long, requires = "data")]
    pub change: bool,

    /// When an action may leave: `strict`, when the step that chose it is on disk; `relaxed`, at once, so that up to a
    /// second of steps is lost with the machine's power.
    #[arg(long, value_enum, default_value_t = DurabilityArg::Strict, requires = "data")]
    pub durability: DurabilityArg,

    /// How much of the journal is kept to return to earlier steps: a size such as 500MiB, or `all`. What the two newest
    /// snapshots need is always kept.
    #[arg(long, value_name = "SIZE|all", value_parser = history, default_value = "8GiB", requires = "data")]
    pub history: History,

    /// A snapshot of memory is made whenever the journal has grown by this, or by the size of the last snapshot when that
    /// is more. A start reads the last snapshot and the journal after it.
    #[arg(long, value_name = "SIZE", value_parser = size, default_value = "64MiB", requires = "data")]
    pub snapshot_every: u64,
}

/// How many bytes of journal are kept; none: all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct History(pub Option<u64>);

fn history(text: &str) -> Result<History, String> {
    if text == "all" { Ok(History(None)) } else { size(text).map(|bytes| History(Some(bytes))) }
}

/// How many bytes the process may take; none: without a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryMax(pub Option<u64>);

fn memory_max(text: &str) -> Result<MemoryMax, String> {
    if text == "none" { Ok(MemoryMax(None)) } else { size(text).map(|bytes| MemoryMax(Some(bytes))) }
}

/// Bytes: a whole number, alone or with KiB, MiB, GiB or TiB.
fn size(text: &str) -> Result<u64, String> {
    let digits = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    let (number, unit) = text.split_at(digits);
    let shift = match unit.trim() {
        "" | "B" => 0,
        "KiB" => 10,
        "MiB" => 20,
        "GiB" => 30,
        "TiB" => 40,
        _ => return Err(format!("{unit:?} is no unit: give B, KiB, MiB, GiB or TiB, as in 500MiB")),
    };
    let number: u64 = number.parse().map_err(|_| "give a whole number of bytes, as in 500MiB".to_owned())?;
    number.checked_mul(1 << shift).ok_or_else(|| format!("{text} is more than can be counted"))
}

/// A [`Durability`] on the command line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum DurabilityArg {
    /// When the step is on disk.
    #[default]
    Strict,
    /// At once.
    Relaxed,
}

impl From<DurabilityArg> for Durability {
    fn from(given: DurabilityArg) -> Self {
        match given {
            DurabilityArg::Strict => Self::Strict,
            DurabilityArg::Relaxed => Self::Relaxed,
        }
    }
}

impl ServerArgs {
    /// What the learner starts from, read and checked.
    ///
    /// # Errors
    /// [`config::ConfigError`] with the place of the mistake.
    pub fn setup(&self) -> Result<Setup, config::ConfigError> {
        if self.config.as_deref() == Some("-".as_ref()) && self.curriculum.as_deref() == Some("-") {
            return Err(config::ConfigError::StdinTwice);
        }
        let learner = config::learner(self.config.as_deref())?;
        let curriculum = self.curriculum.as_deref().unwrap_or("free");
        let (curriculum, learner) = config::lesson(curriculum, learner, &self.settings)?;
        Ok(Setup { seed: self.seed.unwrap_or(1), learner, curriculum })
    }

    /// Where and how memory is kept, if on disk.
    fn keeping(&self) -> Option<Keeping> {
        Some(Keeping {
            directory: self.data.clone()?,
            durability: self.durability.into(),
            retention: Retention { snapshot_bytes: self.snapshot_every, history_bytes: self.history.0 },
            seed_given: self.seed.is_some(),
            setting_given: self.curriculum.is_some() || self.config.is_some() || !self.settings.is_empty(),
            change: self.change,
        })
    }
}

/// Runs the daemon that `args` describe, in the runtime directory that the environment says, until `stop` is
/// set or a tool ends it.
///
/// # Errors
/// [`ServerError`]; nothing that a body or a tool does is one.
pub fn run(args: &ServerArgs, stop: &AtomicBool) -> Result<(), ServerError> {
    // Before anything is created: a mistake in a file leaves nothing behind.
    let setup = args.setup()?;
    let place = Place::new(RuntimeDir::from_environment()?, args.name.clone());
    let memory_max = match args.memory_max {
        None => resident::default_max(),
        Some(MemoryMax(given)) => {
            // Before the memory on disk is read, which may have come to its limit.
            let taken = resident::bytes();
            if let Some(max) = given.filter(|max| *max <= taken) {
                return Err(ServerError::MemoryMax { max, taken });
            }
            given
        }
    };
    let hosting = Hosting { memory_max, accept_changes: args.accept_changes };
    serve_kept(place, setup, args.keeping().as_ref(), hosting, stop)
}

/// The whole program `pschema-server`: reads the command line, logs to stderr, ends cleanly on SIGINT and
/// SIGTERM, at once on the second of them.
#[must_use]
pub fn program() -> ExitCode {
    let program = match Program::try_parse() {
        Ok(program) => program,
        Err(error) => return usage(&error),
    };
    Log::new(LevelFilter::INFO).as_json(program.log_json).begin();
    let result =
        Stop::on_signals().map_err(ServerError::from).and_then(|stop| run(&program.args, &stop.flag()));
    ended("pschema-server", result)
}

/// Run a learner in the foreground, for bodies to attach to and tools to ask.
///
/// With --data what is learnt is kept on disk and found again at the next start. Without it memory is in RAM only.
#[derive(Debug, Parser)]
#[command(name = "pschema-server", version)]
#[command(after_help = "Example:\n  pschema-server --name arm --seed 7 --curriculum exp1-s1")]
struct Program {
    #[command(flatten)]
    args: ServerArgs,

    /// Write the log as JSON, one object a line. `RUST_LOG` sets the level; the default is info.
    #[arg(long)]
    log_json: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_with_their_units() {
        let sound =
            [("0", 0), ("17", 17), ("0B", 0), ("3KiB", 3 << 10), ("500MiB", 500 << 20), ("2 TiB", 2 << 40)];
        for (text, bytes) in sound {
            assert_eq!(size(text), Ok(bytes), "{text}");
        }
        for text in ["", "MiB", "-1", "1.5GiB", "5MB", "99999999999999999999", "99999999TiB"] {
            assert!(size(text).is_err(), "{text}");
        }
        assert_eq!((history("all"), history("1GiB")), (Ok(History(None)), Ok(History(Some(1 << 30)))));
    }

    #[test]
    fn what_is_not_given_is_the_memorys_own() {
        let kept = |text: &str| {
            let words = ["pschema-server", "--data", "somewhere"].into_iter().chain(text.split_whitespace());
            Program::try_parse_from(words).unwrap().args.keeping().unwrap()
        };
        assert_eq!((kept("").seed_given, kept("").setting_given), (false, false));
        assert_eq!((kept("--seed 1").seed_given, kept("--seed 1").setting_given), (true, false));
        for given in ["--curriculum free", "--config learner.toml", "--set learner.attention=false"] {
            assert!(kept(given).setting_given, "{given}");
        }
        assert_eq!(
            kept("--history 5").retention,
            Retention { history_bytes: Some(5), ..Retention::default() }
        );
        assert!(Program::try_parse_from(["pschema-server", "--change"]).is_err());
    }
}
