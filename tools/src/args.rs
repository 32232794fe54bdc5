//! Arguments that several commands take: the learner's name, the memory to ask, the process to end with.

use std::path::{Path, PathBuf};

use clap::parser::ValueSource;
use clap::{ArgMatches, Args, FromArgMatches};
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

    /// The name given before the command, where the one behind it, `behind`, is only the default. Commands that bring a `--name`
    /// of their own need it.
    pub(crate) fn name_instead_of(
        &self,
        own: OwnName,
        behind: &str,
    ) -> Result<Option<&LearnerName>, Failure> {
        match &self.name {
            Some(before) if own.is_typed && before.as_str() != behind => {
                Err(two_names(before.as_str(), behind))
            }
            before => Ok(before.as_ref()),
        }
    }

    /// A failure when what stands before the command can't be obeyed: the name of a learner where the command, if it is
    /// `nameless`, asks none by its name.
    pub(crate) fn check(&self, nameless: Option<&str>) -> Result<(), Failure> {
        if let (Some(command), Some(name)) = (nameless, &self.name) {
            return Err(Failure::Usage(format!(
                "`{command}` asks no learner by its name: leave out --name {name}"
            )));
        }
        // The two conflict wherever they stand; where one stands before the command and one behind it, only this sees both.
        if self.loudness.quiet && self.loudness.verbose > 0 {
            return Err(Failure::Usage(
                "--quiet and --verbose exclude each other: give one of them".to_owned(),
            ));
        }
        Ok(())
    }
}

fn two_names(before: &str, behind: &str) -> Failure {
    Failure::Usage(format!(
        "two learners are named, {before} before the command and {behind} behind it: name one"
    ))
}

/// Whether the `--name` that a command brings with it was typed. Its value does not tell: the default may be typed as well.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OwnName {
    is_typed: bool,
}

impl FromArgMatches for OwnName {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        Ok(Self { is_typed: matches.value_source("name") == Some(ValueSource::CommandLine) })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for OwnName {
    fn augment_args(command: clap::Command) -> clap::Command {
        command
    }

    fn augment_args_for_update(command: clap::Command) -> clap::Command {
        command
    }
}

/// The learner that a command asks. It can be named before the command as well; one global option would not do, because
/// `server` and `sim` bring an option of that name with them.
#[derive(Clone, Debug, Args)]
pub(crate) struct NameArgs {
    /// The learner meant [default: default]
    #[arg(id = "learner", long = "name", value_name = "NAME")]
    name: Option<LearnerName>,
}

impl NameArgs {
    /// The learner that was named, before the command or behind it.
    pub(crate) fn named<'a>(&'a self, general: &'a General) -> Result<Option<&'a LearnerName>, Failure> {
        match (&general.name, &self.name) {
            (Some(before), Some(behind)) if before != behind => {
                Err(two_names(before.as_str(), behind.as_str()))
            }
            (before, behind) => Ok(behind.as_ref().or(before.as_ref())),
        }
    }

    /// The learner that was named, else the default one.
    pub(crate) fn learner(&self, general: &General) -> Result<LearnerName, Failure> {
        match self.named(general)? {
            Some(name) => Ok(name.clone()),
            None => Ok(LearnerName::new(DEFAULT_NAME)?),
        }
    }

    /// The directory `data`, if no learner was named beside it: a data directory has the memory of one learner.
    pub(crate) fn instead<'a>(&self, data: &'a Path, general: &General) -> Result<&'a Path, Failure> {
        match self.named(general)? {
            None => Ok(data),
            Some(name) => Err(Failure::Usage(format!(
                "--data {} and --name {name} each say which memory is meant: give one of them",
                data.display()
            ))),
        }
    }
}

/// The memory that a question is about: that of a running learner, or one on disk. Whether the options can be obeyed together
/// is for [`MemoryArgs::meant`] to say, for they may stand before the command or behind it.
#[derive(Clone, Debug, Args)]
pub(crate) struct MemoryArgs {
    #[command(flatten)]
    name: NameArgs,
    /// Ask the memory in this data directory, with or without a daemon on it; nothing in it is changed
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// As it was after step N, before step N + 1; with --data
    #[arg(long, value_name = "N")]
    until: Option<u64>,
}

/// The memory that was meant.
#[derive(Clone, Debug)]
pub(crate) enum MeantMemory<'a> {
    /// That of a running learner.
    Running(LearnerName),
    /// One on disk, as it was after a step, or as it is.
    OnDisk(&'a Path, Option<u64>),
}

impl MemoryArgs {
    /// A failure when a question is about the decision of a `step` which the memory that was meant had not taken.
    pub(crate) fn check_step(&self, step: Option<u64>) -> Result<(), Failure> {
        match (step, self.until) {
            (Some(step), Some(until)) if step > until => Err(Failure::Usage(format!(
                "--until {until} means memory as it was before step {step}: leave out --until, or name a step up to {until}"
            ))),
            _ => Ok(()),
        }
    }

    /// The memory that was meant; a failure when what was typed can't be obeyed.
    pub(crate) fn meant(&self, general: &General) -> Result<MeantMemory<'_>, Failure> {
        match (&self.data, self.until) {
            (Some(data), until) => Ok(MeantMemory::OnDisk(self.name.instead(data, general)?, until)),
            (None, None) => Ok(MeantMemory::Running(self.name.learner(general)?)),
            (None, Some(until)) => Err(Failure::Usage(format!(
                "--until {until} is about a memory on disk: name its directory with --data DIR"
            ))),
        }
    }
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

/// What is wanted of a learner.
#[derive(Clone, Debug, Args)]
pub(crate) struct WantedArgs {
    /// What is wanted, all of it: patterns as schemas print; a variable is the same value in all of them
    #[arg(required_unless_present = "most", value_name = "PATTERN")]
    pub(crate) goal: Vec<String>,
    /// Bring it about though it holds already
    #[arg(long)]
    pub(crate) again: bool,
    /// Instead of patterns: as much as can be of a value, a number that comes with the body's frames (a reward)
    #[arg(long, value_name = "TYPE", conflicts_with_all = ["goal", "again"])]
    pub(crate) most: Option<String>,
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
        match &self.data {
            Some(data) => Err(refused_order(data, order)),
            None => self.name.learner(general),
        }
    }
}

/// Why `order` is not given to the memory on disk in `data`: it is only read.
pub(crate) fn refused_order(data: &Path, order: &str) -> Failure {
    Failure::Usage(format!(
        "{order} needs a learner that is running: a data directory is only read, so that the past stays as it was. Start \
         `pschema server --data {}`, and give the order to it",
        data.display()
    ))
}

/// How a process that another one of ours started is told not to outlive it.
#[derive(Clone, Copy, Debug, Args)]
pub struct ParentArgs {
    /// End when this process does, which must be the parent
    #[arg(long, hide = true, value_name = "PID")]
    pub parent: Option<u32>,
}
