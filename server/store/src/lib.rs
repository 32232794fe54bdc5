//! The learner's memory on disk: a journal of what changed it, and snapshots of it. `docs/FORMAT.md` has the bytes.
//!
//! [`open`] finds a memory again, or begins one, and returns it with the [`Writer`] that keeps it from then on. What is
//! damaged is reported and never dropped in silence.
#![forbid(unsafe_code)]

mod codec;
mod error;
mod format;
mod frame;
mod journal;
#[cfg(test)]
mod journal_tests;
mod lock;
mod manifest;
mod recovery;
mod snapshot;
mod storage;
#[cfg(test)]
mod store_tests;
#[cfg(test)]
mod twin;
mod writer;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use pschema_learner::curriculum::Curriculum;
use pschema_learner::memory::Memory;
use pschema_learner::parameters::Parameters;

pub use codec::CodecError;
pub use error::StoreError;
pub use format::v1::Impossible;
pub use journal::JournalError;
pub use recovery::Recovered;
pub use writer::{DIGEST_STEPS, Durability, Writer};

use journal::{Journal, Sizes};
use manifest::Manifest;
use storage::{Directory, Storage};

/// Journal after which a snapshot is made.
const SNAPSHOT_BYTES: u64 = 64 * 1024 * 1024;

/// What a memory is begun with, and found again with.
#[derive(Clone, Copy, Debug)]
pub struct Origin<'a> {
    /// The learner's name.
    pub learner: &'a str,
    /// Where its randomness begins.
    pub seed: u64,
    /// Its numbers and switches.
    pub parameters: &'a Parameters,
    /// What it is led through.
    pub curriculum: &'a Curriculum,
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

/// Finds the memory in `directory` again, or begins one there. `wake` is called, from another thread, whenever more of
/// it is durable, or no more can be.
///
/// # Errors
/// When another daemon has the directory, the memory was begun with something else, it is damaged, or the disk can't be
/// read or written. What is on disk is then as it was.
pub fn open(
    directory: &Path,
    origin: Origin<'_>,
    durability: Durability,
    wake: impl Fn() + Send + 'static,
) -> Result<(Memory, Store), StoreError> {
    let shown = || directory.display().to_string();
    std::fs::create_dir_all(directory).map_err(StoreError::disk("create", shown()))?;
    let directory = directory.canonicalize().map_err(StoreError::disk("find", shown()))?;
    let lock = lock::take(&directory, origin.learner)?;
    let storage = Arc::new(Directory::new(&directory));
    let (memory, writer, recovered) =
        open_in(storage, origin, durability, Sizes::default(), SNAPSHOT_BYTES, wake)?;
    Ok((memory, Store { writer, recovered, durability, directory, lock: Some(lock) }))
}

fn open_in(
    storage: Arc<dyn Storage>,
    origin: Origin<'_>,
    durability: Durability,
    sizes: Sizes,
    snapshot_bytes: u64,
    wake: impl Fn() + Send + 'static,
) -> Result<(Memory, Writer, Recovered), StoreError> {
    let Origin { learner, seed, parameters, curriculum } = origin;
    let given = Manifest::new(learner, seed, parameters, curriculum);
    let there = manifest::check(&*storage, &given)?;
    let disk = |what, name| StoreError::disk(what, storage.path(name));
    if !there {
        for name in [journal::DIRECTORY, snapshot::DIRECTORY] {
            storage.directory(name).map_err(disk("create", name))?;
        }
        manifest::write(&*storage, &given)?;
    }
    let (memory, end, recovered) = recovery::recover(&*storage, seed, parameters)?;
    recovery::settle(&*storage, &end).map_err(disk("make durable", journal::DIRECTORY))?;
    if let Some((file, offset)) = &recovered.torn {
        tracing::warn!(
            file,
            offset,
            "cut what was being written when the last daemon ended; nothing acted on it"
        );
    }
    let start = writer::Start {
        journal: Journal::after(storage.clone(), end.last, sizes),
        storage,
        durability,
        step: recovered.step,
        snapshot_step: recovered.snapshot_step,
        journal_bytes: recovered.journal_bytes,
        snapshot_bytes,
    };
    Ok((memory, Writer::start(start, wake)?, recovered))
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
