//! The daemon's side of a domain: its lock, and its epoch from the first file to the last.

use std::fs::{self, File, TryLockError};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

use pschema_process::Anchor;

use super::error::io;
use super::shared_memory::{SHARED_MEMORY_NEEDED, require_shared_memory, shared_memory_files};
use super::{DomainError, DomainRecord, Place, runtime, sweep};

/// What a daemon holds of a learner: the lock and a fresh epoch. Dropping it removes the epoch.
#[derive(Debug)]
pub struct OwnedDomain {
    place: Place,
    record: DomainRecord,
    /// Held for its lock.
    _lock: File,
    /// The epoch's directory, held open so that its inode is not used again.
    _root: File,
    /// The files by which peers join, all of which stay as long as the epoch.
    anchors: Vec<Anchor>,
}

/// How often, and how far apart, a daemon tries to take a lock that a peer may be testing just then.
const LOCK_TRIES: u32 = 10;
const LOCK_TRY_APART: Duration = Duration::from_millis(20);

impl OwnedDomain {
    /// Takes the learner's lock, sweeps what earlier daemons left and begins a new epoch.
    ///
    /// # Errors
    /// [`DomainError::AlreadyServed`] while another daemon lives; [`DomainError::SharedMemory`] when
    /// `/dev/shm` is nearly full; else what the operating system said.
    pub fn create(place: Place) -> Result<Self, DomainError> {
        runtime::private_directory(&place.directory())?;
        let lock = lock(&place)?;
        let path = place.record_path();
        let before = DomainRecord::read(&path).ok();
        let sweep_before =
            || before.as_ref().map_or(Ok(()), |old| sweep::epoch(&place.epoch_root(old), &old.prefix));
        sweep_before()?;
        require_shared_memory(SHARED_MEMORY_NEEDED)?;
        let record = DomainRecord::next(before.as_ref());
        // The record is written before anything of the epoch exists: whenever this process dies, the next knows the prefix.
        record.write(&path)?;
        // The sweep is done again: until the new record was there, a late peer could bring back a part of the old epoch. A
        // peer that is later still sweeps that itself (see `Membership`).
        sweep_before()?;
        sweep::orphans(place.runtime().path())?;
        let root = place.epoch_root(&record);
        // An eager peer may have made the directory already; nobody else can, below the runtime directory.
        runtime::private_directory(&root)?;
        let open = File::open(&root).map_err(io("open", &root))?;
        let directory = place.directory();
        let examined = io("examine", &directory);
        let anchors = [(&lock, place.lock_path()), (&open, root)];
        let anchors = anchors.iter().map(|(file, path)| Anchor::of(file, path)).collect::<Result<_, _>>();
        let anchors = anchors.map_err(examined)?;
        tracing::debug!(learner = %place.learner(), epoch = record.epoch, prefix = %record.prefix, "domain created");
        Ok(Self { place, record, _lock: lock, _root: open, anchors })
    }

    /// The learner's place.
    #[must_use]
    pub fn place(&self) -> &Place {
        &self.place
    }

    /// The epoch.
    #[must_use]
    pub fn record(&self) -> &DomainRecord {
        &self.record
    }

    /// Writes into the record that the epoch is ready, so that bodies and tools connect.
    ///
    /// # Errors
    /// What the operating system said when the record could not be written.
    pub(crate) fn announce(&mut self) -> Result<(), DomainError> {
        self.record.ready = true;
        self.record.write(&self.place.record_path())
    }

    /// Notes the files that the epoch has by now, in its directory and in shared memory. All are this process's own, and stay as
    /// long as the epoch.
    ///
    /// # Errors
    /// What the operating system said when they could not be found.
    pub(crate) fn note_files(&mut self) -> Result<(), DomainError> {
        let mut files = shared_memory_files(&self.record.prefix)?;
        files_below(&self.place.epoch_root(&self.record), &mut files)?;
        for path in files {
            self.anchors.push(Anchor::at(&path).map_err(io("examine", &path))?);
        }
        Ok(())
    }

    /// Why no new peer can join the epoch any more, if so: a file by which it would was moved, removed or replaced, as
    /// those do who clean up directories and shared memory without asking.
    #[must_use]
    pub fn loss(&self) -> Option<String> {
        let missing = self.anchors.iter().find_map(|anchor| anchor.check().err());
        let missing = missing.map(|error| error.to_string());
        missing.or_else(|| {
            let path = self.place.record_path();
            match DomainRecord::read(&path) {
                Ok(found) if found == self.record => None,
                Ok(_) => Some(format!("{} is that of another epoch", path.display())),
                Err(error) => Some(error.to_string()),
            }
        })
    }
}

impl Drop for OwnedDomain {
    fn drop(&mut self) {
        let root = self.place.epoch_root(&self.record);
        if let Err(error) = sweep::epoch(&root, &self.record.prefix) {
            // The record stays, so that the next daemon of this learner sweeps the rest.
            tracing::warn!(%error, "the epoch's files were not all removed");
            return;
        }
        let path = self.place.record_path();
        // The record may be another daemon's by now, and it may be gone.
        let ours = DomainRecord::read(&path).is_ok_and(|found| found.prefix == self.record.prefix);
        if ours && let Err(error) = fs::remove_file(&path) {
            tracing::warn!(%error, path = %path.display(), "cannot remove the domain file");
        }
    }
}

/// Adds the paths of all files in a directory and in those below it.
fn files_below(directory: &Path, files: &mut Vec<PathBuf>) -> Result<(), DomainError> {
    for entry in fs::read_dir(directory).map_err(io("list", directory))? {
        let entry = entry.map_err(io("list", directory))?;
        if entry.file_type().map_err(io("examine", directory))?.is_dir() {
            files_below(&entry.path(), files)?;
        } else {
            files.push(entry.path());
        }
    }
    Ok(())
}

fn lock(place: &Place) -> Result<File, DomainError> {
    let path = place.lock_path();
    let mut file = runtime::private_file(&path)?;
    for _ in 0..LOCK_TRIES {
        match file.try_lock() {
            Ok(()) => {
                file.set_len(0).map_err(io("write", &path))?;
                file.write_all(format!("{}\n", std::process::id()).as_bytes()).map_err(io("write", &path))?;
                return Ok(file);
            }
            Err(TryLockError::WouldBlock) => std::thread::sleep(LOCK_TRY_APART),
            Err(TryLockError::Error(error)) => return Err(io("lock", &path)(error)),
        }
    }
    Err(DomainError::AlreadyServed { name: place.learner().to_string(), pid: place.lock_holder() })
}
