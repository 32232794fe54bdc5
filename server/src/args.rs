//! The daemon as a program: arguments, log, signals.

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Parser;
use pschema_protocol::domain::{LearnerName, Place, RuntimeDir};
use tracing_subscriber::EnvFilter;

use crate::{Durability, Keeping, ServerError, Setup, config, serve_kept};

/// Run a learner in the foreground, for bodies to attach to and tools to ask.
///
/// With --data what is learnt is kept on disk and found again at the next start. Without it memory is in RAM only.
#[derive(Clone, Debug, clap::Args)]
pub struct ServerArgs {
    /// The learner's name: 1 to 32 of a-z, 0-9, _ and -. Several learners live side by side by name.
    #[arg(long, default_value = "default")]
    pub name: LearnerName,

    /// What the learner's draws begin from. The same seed, curriculum and body give the same memory.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,

    /// A file with the learner's parameters, such as `server/learner.toml`; without it, the defaults.
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,

    /// A built-in curriculum (free, or that of an experiment, such as exp1-s1), or a file with one.
    #[arg(long, value_name = "NAME|FILE", default_value = "free")]
    pub curriculum: String,

    /// Replace what the curriculum says: `learner.PARAMETER=VALUE`, or `values.NAME=NUMBER` for a number that it
    /// names in its `[values]`. May be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub settings: Vec<String>,

    /// The directory that memory is kept in, made when it isn't there. Without it, memory ends with the daemon.
    #[arg(long, value_name = "DIR")]
    pub data: Option<PathBuf>,

    /// When an action may leave: `strict`, when the step that chose it is on disk; `relaxed`, at once, so that up to a
    /// second of steps is lost with the machine's power.
    #[arg(long, value_enum, default_value_t = DurabilityArg::Strict, requires = "data")]
    pub durability: DurabilityArg,
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
        let parameters = config::parameters(self.config.as_deref())?;
        let (curriculum, parameters) = config::lesson(&self.curriculum, parameters, &self.settings)?;
        Ok(Setup { seed: self.seed, parameters, curriculum })
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
    let durability = args.durability.into();
    let keeping = args.data.clone().map(|directory| Keeping { directory, durability });
    serve_kept(place, setup, keeping.as_ref(), stop)
}

/// The whole program `pschema-server`: reads the command line, logs to stderr, ends cleanly on SIGINT and
/// SIGTERM, at once on the second of them.
#[must_use]
pub fn program() -> ExitCode {
    let program = Program::parse();
    log_to_stderr(program.log_json);
    let result = signals().map_err(ServerError::Signals).and_then(|stop| run(&program.args, &stop));
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // Not `eprintln`, which panics when nobody reads any more.
            drop(writeln!(std::io::stderr(), "error: {error}"));
            ExitCode::FAILURE
        }
    }
}

fn log_to_stderr(json: bool) {
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new("info"));
    let log = tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr);
    // A log that nobody reads any more (the other end of the pipe died) must not end a daemon.
    let log = log.log_internal_errors(false);
    let log = log.with_ansi(
        std::io::IsTerminal::is_terminal(&std::io::stderr()) && std::env::var_os("NO_COLOR").is_none(),
    );
    let set = if json { log.json().try_init() } else { log.try_init() };
    if let Err(error) = set {
        // A host that has a log of its own keeps it.
        tracing::debug!(%error, "the log is set up already");
    }
}

fn signals() -> Result<Arc<AtomicBool>, std::io::Error> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        // The order matters: the first signal only sets the flag, which arms the second.
        signal_hook::flag::register_conditional_shutdown(signal, 1, stop.clone())?;
        signal_hook::flag::register(signal, stop.clone())?;
    }
    Ok(stop)
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
