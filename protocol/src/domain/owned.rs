//! The daemon's side of a domain: its lock, and its epoch from the first file to the last.

use std::fs::{self, File, TryLockError};
use std::io::Write;
use std::time::Duration;

use super::error::io;
use super::shared_memory::{SHARED_MEMORY_NEEDED, require_shared_memory};
use super::{DomainError, DomainRecord, Place, runtime, sweep};

/// The daemon's hold on a learner: its lock and a fresh epoch. Dropping it removes the epoch.
#[derive(Debug)]
pub struct OwnedDomain {
    place: Place,
    record: DomainRecord,
    /// Held for its lock.
    _lock: File,
}

/// How often, and how far apart, a daemon tries for a lock that a peer may be testing just now.
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
        // Before anything of the epoch exists, so that whenever this process dies the next knows its prefix.
        record.write(&path)?;
        // Again: until the new record was there, a peer that was late could bring a part of the old epoch
        // back. One that comes later still sweeps that itself (see `Membership`).
        sweep_before()?;
        sweep::orphans(place.runtime().path())?;
        let root = place.epoch_root(&record);
        // An eager peer may have been first; below the runtime directory nobody else could be.
        runtime::private_directory(&root)?;
        tracing::debug!(learner = %place.learner(), epoch = record.epoch, prefix = %record.prefix, "domain created");
        Ok(Self { place, record, _lock: lock })
    }

    /// Where the learner is.
    #[must_use]
    pub fn place(&self) -> &Place {
        &self.place
    }

    /// The epoch.
    #[must_use]
    pub fn record(&self) -> &DomainRecord {
        &self.record
    }

    /// Tells bodies and tools that they can connect.
    ///
    /// # Errors
    /// What the operating system said when the record could not be written.
    pub(crate) fn announce(&mut self) -> Result<(), DomainError> {
        self.record.ready = true;
        self.record.write(&self.place.record_path())
    }
}

impl Drop for OwnedDomain {
    fn drop(&mut self) {
        let root = self.place.epoch_root(&self.record);
        if let Err(error) = sweep::epoch(&root, &self.record.prefix) {
            // The next daemon of this learner sweeps it: its record stays.
            tracing::warn!(%error, "the epoch's files were not all removed");
            return;
        }
        if let Err(error) = fs::remove_file(self.place.record_path()) {
            tracing::warn!(%error, path = %self.place.record_path().display(), "cannot remove the domain file");
        }
    }
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
