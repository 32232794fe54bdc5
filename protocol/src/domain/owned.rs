//! The daemon's side of a domain: its lock, and its epoch from the first file to the last.

use std::fs::{self, File, TryLockError};
use std::io::Write;
use std::time::Duration;

use super::error::io;
use super::shared_memory::{SHARED_MEMORY_NEEDED, require_shared_memory};
use super::{DomainError, DomainRecord, Place, runtime, sweep};

/// What a daemon holds of a learner: the lock and a fresh epoch. Dropping it removes the epoch.
#[derive(Debug)]
pub struct OwnedDomain {
    place: Place,
    record: DomainRecord,
    /// Held for its lock.
    _lock: File,
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
        tracing::debug!(learner = %place.learner(), epoch = record.epoch, prefix = %record.prefix, "domain created");
        Ok(Self { place, record, _lock: lock })
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
}

impl Drop for OwnedDomain {
    fn drop(&mut self) {
        let root = self.place.epoch_root(&self.record);
        if let Err(error) = sweep::epoch(&root, &self.record.prefix) {
            // The record stays, so that the next daemon of this learner sweeps the rest.
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
