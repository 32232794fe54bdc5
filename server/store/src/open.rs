//! A memory on disk from the daemon's side: opening it, keeping it, finishing it.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use pschema_learner::Learner;
use pschema_learner::memory::{Content, Memory};

use crate::archivist::Archive;
use crate::change::{Change, Durability};
use crate::codec;
use crate::error::StoreError;
use crate::format::mirror::list;
use crate::format::v1::{self, Setting};
use crate::journal::{self, Journal, Sizes};
use crate::lock::{self, Lock};
use crate::manifest::{self, Manifest};
use crate::options::Options;
use crate::recovery::{self, RecoveryReport};
use crate::retention;
use crate::shared::Wake;
use crate::snapshot;
use crate::storage::{self, Directory, Storage};
use crate::writer::{Start, Writer};

/// Segments of the journal that a start may read before a snapshot is due: a daemon that is killed again and again makes
/// one segment each time, however short.
const SEGMENTS_READ_MAX: usize = 32;

/// A memory on disk. Every change of the memory is handed to it, and it says when the change is durable.
#[derive(Debug)]
pub struct Store {
    pub(crate) writer: Writer,
    recovered: RecoveryReport,
    durability: Durability,
    directory: PathBuf,
    /// None in tests, whose storage is not a directory of the file system.
    lock: Option<Lock>,
}

/// A memory that was found again, or begun.
#[derive(Debug)]
pub struct Opened {
    /// The learner that has the memory, under the settings that are in force.
    pub learner: Learner,
    /// The seed that the memory was begun with.
    pub seed: u64,
    /// Whether the memory goes on under other parameters or another curriculum from here.
    pub changed: bool,
    /// Where each change of the memory is to be handed to.
    pub store: Store,
}

/// Finds the memory in `directory` again, or begins a memory there. `wake` is called, from another thread, whenever more changes
/// are durable, and when no more can be written.
///
/// # Errors
/// When another daemon has the directory, the memory was begun with another seed or lives under other settings, it is damaged,
/// or the disk can't be read or written. The directory is then as it was.
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
    let mut opened = open_in(storage, options, options.retention.sizes(), Arc::new(wake))?;
    (opened.store.directory, opened.store.lock) = (directory, Some(lock));
    Ok(opened)
}

/// Makes the directory and the missing ones above it, so that they are there after a loss of power too.
fn create(directory: &Path) -> io::Result<()> {
    let above = directory.parent().filter(|above| !above.as_os_str().is_empty());
    if directory.is_dir() {
        // The process that made it may have been killed before its name was durable. A directory above it that can't be
        // opened belongs to others, who confirm it.
        return std::fs::File::open(above.unwrap_or(Path::new("."))).map_or(Ok(()), |above| above.sync_all());
    }
    above.map_or(Ok(()), create)?;
    match storage::own_directory(directory) {
        // Another daemon made it first; the lock decides which of them has it.
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists && directory.is_dir() => (),
        made => made?,
    }
    std::fs::File::open(above.unwrap_or(Path::new(".")))?.sync_all()
}

/// Opens the memory in any storage that nobody else uses.
pub(crate) fn open_in(
    storage: Arc<dyn Storage>,
    options: Options<'_>,
    sizes: Sizes,
    wake: Wake,
) -> Result<Opened, StoreError> {
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
    // The first start may have been killed before the manifest and the directory were durable.
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
    let (_, curriculum) = setting.checked()?;
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
        // After a clean end only the digest follows the snapshot. The step alone does not tell: an order may have come without
        // a step.
        at_snapshot: found.snapshot_step == Some(found.step)
            && batches == 0
            && !changed
            && found.torn.is_none(),
    };
    let writer = Writer::start(start, wake)?;
    let (durability, directory) = (options.durability, PathBuf::new());
    let store = Store { writer, recovered: found, durability, directory, lock: None };
    Ok(Opened { learner, seed: manifest.seed, changed, store })
}

/// Makes memory go on under `setting`, and makes that durable.
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
        effects: list(&effects),
    };
    let written = journal.append(&codec::encode(&record)?, step).and_then(|_| journal.sync());
    written.map_err(StoreError::disk("write", journal.path()))
}

impl Store {
    /// Hands over what one step, one order or one attachment changed; `content` is memory after it. Returns the number of
    /// the batch, to be asked for with [`Store::is_durable`].
    ///
    /// # Errors
    /// When the change can't be encoded, or an earlier one could not be written.
    pub fn append(&mut self, change: &Change<'_>, content: &Content) -> Result<u64, StoreError> {
        self.writer.append(change, content)
    }

    /// Whether the batch of this number is durable.
    #[must_use]
    pub fn is_durable(&self, batch: u64) -> bool {
        self.writer.is_durable(batch)
    }

    /// Why nothing more can be written, if so.
    #[must_use]
    pub fn failure(&self) -> Option<StoreError> {
        self.writer.failure()
    }

    /// Has a snapshot made with the next change, however little the journal has grown.
    pub fn request_snapshot(&mut self) {
        self.writer.request_snapshot();
    }

    /// What was found in the directory when it was opened.
    #[must_use]
    pub fn recovered(&self) -> &RecoveryReport {
        &self.recovered
    }

    /// When a reply may leave.
    #[must_use]
    pub fn durability(&self) -> Durability {
        self.durability
    }

    /// The data directory.
    #[must_use]
    pub fn directory(&self) -> &Path {
        &self.directory
    }

    /// The last step that is durable.
    #[must_use]
    pub fn durable_step(&self) -> u64 {
        self.writer.durable_step()
    }

    /// The length of the journal that is kept, in bytes.
    #[must_use]
    pub fn journal_bytes(&self) -> u64 {
        self.writer.journal_bytes()
    }

    /// The oldest step that memory can be returned to.
    #[must_use]
    pub fn oldest_step(&self) -> u64 {
        self.writer.oldest_step()
    }

    /// The step of the newest snapshot; none before the first.
    #[must_use]
    pub fn snapshot_step(&self) -> Option<u64> {
        self.writer.snapshot_step()
    }

    /// The length of the last snapshot that was made since the directory was opened, in bytes; 0 before the first.
    #[must_use]
    pub fn snapshot_bytes(&self) -> u64 {
        self.writer.snapshot_bytes()
    }

    /// Writes what is left, a snapshot and the digest of memory, and gives the directory free.
    ///
    /// # Errors
    /// When they can't be written.
    pub fn finish(self, memory: &Memory) -> Result<(), StoreError> {
        let Self { writer, lock, .. } = self;
        let written = writer.finish(memory.content());
        drop(lock);
        written
    }
}
