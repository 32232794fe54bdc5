//! Arguments that several commands take: the learner's name, the memory to ask, the process to end with.

use std::path::{Path, PathBuf};

use clap::Args;
use pschema_process::{LevelFilter, Log};
use pschema_protocol::domain::LearnerName;

use crate::failure::Failure;

/// The name of the learner when none is given.
const DEFAULT_NAME: &str = "default";

/// What is typed before the command, and is the same for all of them.
#[derive(Debug, Args)]
pub(crate) struct General {
    /// The learner meant [default: default]; several live side by side under different names
    #[arg(long, value_name = "NAME")]
    name: Option<LearnerName>,
    #[command(flatten)]
    pub(crate) loudness: Loudness,
}

/// How much a command says on stderr.
#[derive(Clone, Copy, Debug, Args)]
pub struct Loudness {
    /// Say more on stderr; twice or three times for still more
    #[arg(short, long, global = true, display_order = 900, action = clap::ArgAction::Count)]
    verbose: u8,
    /// Say only what went wrong
    #[arg(short, long, global = true, display_order = 901, conflicts_with = "verbose")]
    pub quiet: bool,
}

impl Loudness {
    /// The log: warnings, and `usual` levels more where nothing else is asked for.
    #[must_use]
    pub fn log(self, usual: u8) -> Log {
        Log::new(match (self.quiet, usual.saturating_add(self.verbose)) {
            (true, _) => LevelFilter::ERROR,
            (false, 0) => LevelFilter::WARN,
            (false, 1) => LevelFilter::INFO,
            (false, 2) => LevelFilter::DEBUG,
            (false, _) => LevelFilter::TRACE,
        })
    }
}

impl General {
    /// Whether only failures are said.
    pub(crate) fn quiet(&self) -> bool {
        self.loudness.quiet
    }

    /// The name given before the command, where the one behind it is only the default. Commands that bring a `--name` of
    /// their own need it.
    pub(crate) fn name_instead_of(&self, behind: &str) -> Option<&LearnerName> {
        self.name.as_ref().filter(|_| behind == DEFAULT_NAME)
    }
}

/// The learner that a command asks. It can be named before the command as well; one global option would not do, because
/// `server` and `sim` bring an option of that name with them.
#[derive(Clone, Debug, Args)]
pub(crate) struct NameArgs {
    /// The learner meant [default: default]
    #[arg(long, value_name = "NAME")]
    name: Option<LearnerName>,
}

impl NameArgs {
    /// The learner named behind the command, else the one named before it, else the default one.
    pub(crate) fn learner(&self, general: &General) -> Result<LearnerName, Failure> {
        match self.name.as_ref().or(general.name.as_ref()) {
            Some(name) => Ok(name.clone()),
            None => Ok(LearnerName::new(DEFAULT_NAME)?),
        }
    }
}

/// A memory on disk to ask instead of a daemon.
#[derive(Clone, Debug, Args)]
pub(crate) struct DataArgs {
    /// Ask the memory in this data directory, with or without a daemon on it; nothing in it is changed
    #[arg(long, value_name = "DIR", conflicts_with = "name")]
    pub(crate) data: Option<PathBuf>,
    /// As it was after step N, before step N + 1
    #[arg(long, value_name = "N", requires = "data")]
    pub(crate) until: Option<u64>,
}

/// The memory that a question is about: that of a running learner, or one on disk.
#[derive(Clone, Debug, Args)]
pub(crate) struct MemoryArgs {
    #[command(flatten)]
    pub(crate) name: NameArgs,
    #[command(flatten)]
    pub(crate) data: DataArgs,
}

/// The memory that a question is about, and how its answer is printed.
#[derive(Clone, Debug, Args)]
pub(crate) struct AskArgs {
    #[command(flatten)]
    pub(crate) memory: MemoryArgs,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// The learner that an order goes to. `--data` is accepted, so that it can be answered with why it can't be obeyed.
#[derive(Clone, Debug, Args)]
pub(crate) struct OrderArgs {
    #[command(flatten)]
    pub(crate) name: NameArgs,
    #[arg(long, value_name = "DIR", hide = true)]
    pub(crate) data: Option<PathBuf>,
}

impl OrderArgs {
    /// The learner to give the order `order` to; a failure when a data directory was named instead.
    pub(crate) fn learner(&self, general: &General, order: &str) -> Result<LearnerName, Failure> {
        refuse_order(self.data.as_deref(), order)?;
        self.name.learner(general)
    }
}

/// A failure when `order` was given to a memory on disk: a memory on disk is only read.
pub(crate) fn refuse_order(data: Option<&Path>, order: &str) -> Result<(), Failure> {
    let Some(data) = data else { return Ok(()) };
    Err(Failure::Usage(format!(
        "{order} needs a learner that is running: a data directory is only read, so that the past stays as it was. Start \
         `pschema server --data {}`, and give the order to it",
        data.display()
    )))
}

/// How a process that another one of ours started is told not to outlive it.
#[derive(Clone, Copy, Debug, Args)]
pub struct ParentArgs {
    /// End when this process does, which must be the parent
    #[arg(long, hide = true, value_name = "PID")]
    pub parent: Option<u32>,
}
