//! Opening a memory on disk: finding it again, or beginning it.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use pschema_learner::Learner;
use pschema_learner::effect::Effect;
use pschema_process::no_directory;

use crate::archivist::Archive;
use crate::codec;
use crate::durable;
use crate::error::StoreError;
use crate::format::mirror::list;
use crate::format::v1::{self, Setting};
use crate::journal::{self, Journal, Sizes};
use crate::lock;
use crate::manifest::{self, Manifest, profile};
use crate::options::Options;
use crate::recovery;
use crate::retention;
use crate::shared::{Shared, Wake};
use crate::snapshot;
use crate::storage::{self, Directory, Storage};
use crate::store::Store;
use crate::writer::{self, Writer};

/// Segments of the journal that a start may read before a snapshot is due: a daemon that is killed again and again makes
/// one segment each time, however short.
const SEGMENTS_READ_MAX: usize = 32;
/// So many files of others are named when a directory is refused for them.
const FOREIGN_SHOWN: usize = 3;

/// A memory that was found again, or begun.
#[derive(Debug)]
pub struct Opened {
    /// The learner that has the memory, under the settings that are in force.
    pub learner: Learner,
    /// The seed that the memory was begun with.
    pub seed: u64,
    /// Whether no memory was found, so that one was begun.
    pub begun: bool,
    /// Whether the memory goes on under other parameters, other mechanisms or another curriculum from here.
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
    let made = create(directory).map_err(|error| no_directory(directory, error));
    made.map_err(StoreError::disk("create", shown()))?;
    let directory = directory.canonicalize().map_err(StoreError::disk("find", shown()))?;
    only_ours(&directory)?;
    let lock = lock::take(&directory, options.learner)?;
    let storage = Directory::locked(&directory, lock).map_err(StoreError::disk("open", shown()))?;
    let mut opened = open_in(Arc::new(storage), options, options.retention.sizes(), Arc::new(wake))?;
    opened.store.directory = directory;
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

/// Makes sure that a directory without a memory has no files but those that a daemon which was killed at its first start left:
/// a mistyped name must not put a memory among the files of others.
fn only_ours(directory: &Path) -> Result<(), StoreError> {
    if directory.join(manifest::FILE).exists() {
        return Ok(());
    }
    let shown = || directory.display().to_string();
    let entries = std::fs::read_dir(directory).map_err(StoreError::disk("read", shown()))?;
    // A file system that was made for a memory has the last of them in its root.
    let ours = [lock::FILE, manifest::TEMPORARY, journal::DIRECTORY, snapshot::DIRECTORY, "lost+found"];
    let names = entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned());
    let mut foreign: Vec<_> = names.filter(|name| !ours.contains(&name.as_str())).collect();
    if foreign.is_empty() {
        return Ok(());
    }
    foreign.sort_unstable();
    let more = if foreign.len() > FOREIGN_SHOWN { ", …" } else { "" };
    foreign.truncate(FOREIGN_SHOWN);
    let named: Vec<_> = foreign.iter().map(|name| format!("{name:?}")).collect();
    Err(StoreError::Foreign { path: shown(), found: named.join(", ") + more })
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
    let found = manifest::read(&*storage)?;
    let begun = found.is_none();
    let manifest = match found {
        Some(manifest) => manifest,
        None => {
            durable::create_all(&*storage, &snapshot::DIRECTORIES)?;
            let learner = options.learner.to_owned();
            let mechanisms = Some(options.mechanisms);
            let manifest = Manifest { learner, seed: options.seed, mechanisms, setting: given.clone() };
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
    let base = recovery::base(&*storage, &manifest, None)?;
    let snapshot = base.snapshot();
    let recovery::Recovery { replay, end, found, batches, damaged, .. } =
        recovery::recover(&*storage, base, None)?;
    let mut setting = replay.setting;
    // The first start may have been killed before the mechanisms were in the journal.
    let unlived = snapshot.is_none() && found.frames == 0;
    let mechanisms = replay.memory.content().mechanisms;
    // What nobody asks for is as the memory was begun.
    let asked = options.setting_given || begun;
    let wanted = if asked { options.mechanisms } else { manifest.mechanisms.unwrap_or(mechanisms) };
    let switched = !unlived && mechanisms != options.mechanisms;
    let changed = options.setting_given && (switched || !manifest::same(&setting, &given)?);
    if changed && !options.change {
        let mut differences = manifest::differences(&setting, &given);
        if switched {
            let (kept, given) = (profile(mechanisms), profile(options.mechanisms));
            differences.insert(0, ("profile".to_owned(), kept, given));
        }
        return Err(StoreError::OtherSetting { path: storage.path(""), differences });
    }
    // An empty directory does not come through git, object stores and archives of files.
    durable::create_all(&*storage, &snapshot::DIRECTORIES)?;
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
    journal.read_before(&end.segments).map_err(disk("read", journal::DIRECTORY))?;
    if changed {
        setting = given;
        let mut effects = learner.change(options.parameters.clone(), options.curriculum.clone())?;
        effects.extend(learner.set_mechanisms(options.mechanisms));
        let cause = v1::Cause::Changed(Box::new(setting.clone()));
        order(&learner, &mut journal, cause, &effects, options.at_unix_ms)?;
    } else if unlived {
        let effects = learner.set_mechanisms(wanted);
        if !effects.is_empty() {
            let cause = v1::Cause::Order(format!("profile {}", profile(wanted)));
            order(&learner, &mut journal, cause, &effects, options.at_unix_ms)?;
        }
    }
    let kept = retention::kept(&*storage)?;
    let shared = Arc::new(Shared::new(found.step, snapshot, kept));
    let archive = Archive { storage, setting, history_bytes: options.retention.history_bytes, damaged };
    let durability = options.durability;
    let Writer { jobs, thread, ended } =
        writer::start(archive, journal, durability, found.step, shared.clone(), wake)?;
    // After a clean end only the digest follows the snapshot. The step alone does not tell: an order may have come without a
    // step.
    let at_snapshot =
        found.snapshot_step == Some(found.step) && batches == 0 && !changed && found.torn.is_none();
    let store = Store {
        jobs: Some(jobs),
        thread: Some(thread),
        ended,
        shared,
        handed: 0,
        step: found.step,
        digested_step: found.step,
        // Journal that was replayed counts, so that a daemon that is often restarted makes snapshots too.
        bytes_at_snapshot: kept.bytes.saturating_sub(found.journal_bytes),
        snapshot_bytes: options.retention.snapshot_bytes,
        overdue: end.segments.len() > SEGMENTS_READ_MAX,
        at_snapshot,
        recovered: found,
        durability,
        directory: PathBuf::new(),
    };
    Ok(Opened { learner, seed: manifest.seed, begun, changed, store })
}

/// Writes the effects that a start had on the memory of `learner`, and makes them durable.
fn order(
    learner: &Learner,
    journal: &mut Journal,
    cause: v1::Cause,
    effects: &[Effect],
    at_unix_ms: u64,
) -> Result<(), StoreError> {
    let step = learner.memory().content().step;
    let record = v1::Record::Batch { step, at_unix_ms, cause, effects: list(effects) };
    let written = journal.append(&codec::encode(&record)?, step).and_then(|_| journal.sync());
    written.map_err(StoreError::disk("write", journal.path()))
}
