//! The learner's memory on disk: a journal of what changed it, and snapshots of it. `docs/FORMAT.md` has the bytes.
//!
//! [`open`] finds a memory again, or begins one, and returns it with the [`Writer`] that keeps it from then on. What is
//! damaged is reported and never dropped in silence.
#![forbid(unsafe_code)]

mod archivist;
pub mod bench;
mod change;
mod codec;
mod error;
mod format;
mod frame;
#[cfg(test)]
mod golden_tests;
mod journal;
#[cfg(test)]
mod journal_tests;
#[cfg(test)]
mod keeping_tests;
mod lock;
mod manifest;
pub mod past;
mod recovery;
mod retention;
mod snapshot;
mod storage;
#[cfg(test)]
mod store_tests;
#[cfg(test)]
mod twin;
mod writer;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use pschema_learner::Learner;
use pschema_learner::curriculum::Curriculum;
use pschema_learner::memory::Memory;
use pschema_learner::parameters::Parameters;

pub use change::{Cause, Change, Durability};
pub use codec::CodecError;
pub use error::StoreError;
pub use format::v1::Impossible;
pub use journal::JournalError;
pub use recovery::Recovered;
pub use writer::{DIGEST_STEPS, Writer};

use archivist::Archive;
use format::v1::{self, Setting};
use journal::{Journal, Sizes};
use manifest::Manifest;
use storage::{Directory, Storage};
use writer::Start;

/// Segments that a start may have to read before a snapshot is due: a daemon that is killed again and again makes one
/// each time, however short.
const SEGMENTS_READ_MAX: usize = 32;

/// What a memory is begun with, or found again with.
#[derive(Clone, Copy, Debug)]
pub struct Options<'a> {
    /// The learner's name.
    pub learner: &'a str,
    /// Where its randomness begins.
    pub seed: u64,
    /// Its numbers and switches.
    pub parameters: &'a Parameters,
    /// What it is led through.
    pub curriculum: &'a Curriculum,
    /// Whether somebody asked for this seed: a memory that was begun with another is refused then.
    pub seed_given: bool,
    /// Whether somebody asked for these parameters and this curriculum: a memory that lives under others is refused
    /// then, unless `change` is set.
    pub setting_given: bool,
    /// Whether a memory that lives under other parameters or another curriculum goes on under these.
    pub change: bool,
    /// The time now, in milliseconds since 1970: for people, who may look when a memory was changed.
    pub at_unix_ms: u64,
    /// When a reply may leave.
    pub durability: Durability,
    /// How much is kept.
    pub retention: Retention,
}

impl<'a> Options<'a> {
    /// A memory of this learner, begun with this and nothing else; durable at every step.
    #[must_use]
    pub fn new(learner: &'a str, seed: u64, parameters: &'a Parameters, curriculum: &'a Curriculum) -> Self {
        Self {
            learner,
            seed,
            parameters,
            curriculum,
            seed_given: true,
            setting_given: true,
            change: false,
            at_unix_ms: 0,
            durability: Durability::Strict,
            retention: Retention::default(),
        }
    }
}

/// How much is kept on disk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Retention {
    /// A snapshot is made whenever the journal has grown by so many bytes, or by the size of the last snapshot when
    /// that is more.
    pub snapshot_bytes: u64,
    /// Bytes of journal that are kept to return to earlier steps; none: all of it. What the two newest snapshots need
    /// is always kept.
    pub history_bytes: Option<u64>,
}

impl Default for Retention {
    fn default() -> Self {
        Self { snapshot_bytes: 64 << 20, history_bytes: Some(8 << 30) }
    }
}

impl Retention {
    /// Segments short enough that history can be dropped in small parts.
    fn sizes(self) -> Sizes {
        let default = Sizes::default();
        let history = self.history_bytes.unwrap_or(u64::MAX);
        Sizes { segment_max: (history / 8).clamp(1 << 20, default.segment_max), ..default }
    }
}

/// A memory on disk, kept from now on.
#[derive(Debug)]
pub struct Store {
    /// What keeps it.
    pub writer: Writer,
    /// What was found.
    pub recovered: Recovered,
    /// When a reply may leave.
    pub durability: Durability,
    /// Where it is.
    pub directory: PathBuf,
    lock: Option<lock::Lock>,
}

/// A memory that was found again, or begun.
#[derive(Debug)]
pub struct Opened {
    /// The memory, with what it lives under.
    pub learner: Learner,
    /// Where its randomness began.
    pub seed: u64,
    /// Whether it goes on under other parameters or another curriculum from here.
    pub changed: bool,
    /// What keeps it.
    pub store: Store,
}

/// Finds the memory in `directory` again, or begins one there. `wake` is called, from another thread, whenever more of
/// it is durable, or no more can be.
///
/// # Errors
/// When another daemon has the directory, the memory was begun with something else, it is damaged, or the disk can't be
/// read or written. What is on disk is then as it was.
pub fn open(
    directory: &Path,
    options: Options<'_>,
    wake: impl Fn() + Send + Sync + 'static,
) -> Result<Opened, StoreError> {
    let shown = || directory.display().to_string();
    create(directory).map_err(StoreError::disk("create", shown()))?;
    let directory = directory.canonicalize().map_err(StoreError::disk("find", shown()))?;
    let lock = lock::take(&directory, options.learner)?;
    let storage = Arc::new(Directory::new(&directory));
    let found = open_in(storage, options, options.retention.sizes(), Arc::new(wake))?;
    let Found { learner, seed, changed, writer, recovered } = found;
    let store = Store { writer, recovered, durability: options.durability, directory, lock: Some(lock) };
    Ok(Opened { learner, seed, changed, store })
}

/// Makes the directory and those above it that aren't there, so that they are there after a loss of power too.
fn create(directory: &Path) -> std::io::Result<()> {
    let above = directory.parent().filter(|above| !above.as_os_str().is_empty());
    if directory.is_dir() {
        // Whoever made it may have been killed before its name was durable. What can't be opened is not ours to confirm.
        return std::fs::File::open(above.unwrap_or(Path::new("."))).map_or(Ok(()), |above| above.sync_all());
    }
    above.map_or(Ok(()), create)?;
    match storage::own_directory(directory) {
        // Another daemon came first; the lock says which of them may have it.
        Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists && directory.is_dir() => (),
        made => made?,
    }
    std::fs::File::open(above.unwrap_or(Path::new(".")))?.sync_all()
}

#[derive(Debug)]
struct Found {
    learner: Learner,
    seed: u64,
    changed: bool,
    writer: Writer,
    recovered: Recovered,
}

fn open_in(
    storage: Arc<dyn Storage>,
    options: Options<'_>,
    sizes: Sizes,
    wake: writer::Wake,
) -> Result<Found, StoreError> {
    let given = Setting::new(options.parameters, options.curriculum);
    let disk = |what, name| StoreError::disk(what, storage.path(name));
    let manifest = match manifest::read(&*storage)? {
        Some(manifest) => manifest,
        None => {
            for name in [journal::DIRECTORY, snapshot::DIRECTORY] {
                storage.directory(name).map_err(disk("create", name))?;
            }
            let learner = options.learner.to_owned();
            let manifest = Manifest { learner, seed: options.seed, setting: given.clone() };
            manifest::write(&*storage, &manifest)?;
            manifest
        }
    };
    if options.seed_given && manifest.seed != options.seed {
        let (path, kept, given) = (storage.path(""), manifest.seed, options.seed);
        return Err(StoreError::OtherSeed { path, kept, given });
    }
    if manifest.learner != options.learner {
        tracing::info!(
            begun_as = %manifest.learner, now = %options.learner, "the memory was begun under another name"
        );
    }
    let recovery::Recovery { replay, end, found, batches, damaged } =
        recovery::recover(&*storage, &manifest, None)?;
    let mut setting = replay.setting;
    let changed = options.setting_given && !manifest::same(&setting, &given)?;
    if changed && !options.change {
        return Err(StoreError::OtherSetting {
            path: storage.path(""),
            differences: manifest::differences(&setting, &given),
        });
    }
    // A first start may have been killed before it made these durable.
    storage.sync(manifest::FILE).map_err(disk("make durable", manifest::FILE))?;
    storage.sync_directory("").map_err(disk("make durable", ""))?;
    recovery::settle(&*storage, &end).map_err(disk("make durable", journal::DIRECTORY))?;
    if let Some((file, offset)) = &found.torn {
        tracing::warn!(
            file,
            offset,
            "left out what was being written when the last daemon ended; nothing acted on it"
        );
    }
    let (_, curriculum) = setting.clone().live()?;
    let mut learner = Learner::resume(replay.memory, curriculum)?;
    let mut journal = Journal::after(storage.clone(), end.last, sizes);
    if changed {
        setting = given;
        change(&mut learner, &mut journal, &setting, &options)?;
    }
    let start = Start {
        kept: retention::kept(&*storage)?,
        archive: Archive { storage, setting, history_bytes: options.retention.history_bytes, damaged },
        journal,
        durability: options.durability,
        step: found.step,
        snapshot_step: found.snapshot_step,
        since_snapshot: found.journal_bytes,
        snapshot_bytes: options.retention.snapshot_bytes,
        overdue: end.segments.len() > SEGMENTS_READ_MAX,
        // After a clean end the digest is all that follows; an order may have come with no step.
        at_snapshot: found.snapshot_step == Some(found.step)
            && batches == 0
            && !changed
            && found.torn.is_none(),
    };
    let writer = Writer::start(start, wake)?;
    Ok(Found { learner, seed: manifest.seed, changed, writer, recovered: found })
}

/// Has memory go on under `setting`, durably.
fn change(
    learner: &mut Learner,
    journal: &mut Journal,
    setting: &Setting,
    options: &Options<'_>,
) -> Result<(), StoreError> {
    let effects = learner.change(options.parameters.clone(), options.curriculum.clone())?;
    let step = learner.memory().content().step;
    let record = v1::Record::Batch {
        step,
        at_unix_ms: options.at_unix_ms,
        cause: v1::Cause::Changed(Box::new(setting.clone())),
        effects: effects.iter().map(v1::Effect::from).collect(),
    };
    let written = journal.append(&codec::encode(&record)?, step).and_then(|_| journal.sync());
    written.map_err(StoreError::disk("write", journal.path()))
}

impl Store {
    /// Writes the last of it and lets the directory go.
    ///
    /// # Errors
    /// When it can't be written.
    pub fn finish(self, memory: &Memory) -> Result<(), StoreError> {
        let Self { writer, lock, .. } = self;
        let written = writer.finish(memory.content());
        drop(lock);
        written
    }
}
