//! Where a learner's daemon, bodies and tools meet: a private directory, and an iceoryx2 domain of its
//! own that lives exactly as long as one run of the daemon (an *epoch*).
//!
//! ```text
//! <runtime>/                 0700, owned by the user
//!   <learner>/lock           held by the daemon for its life
//!   <learner>/domain         text: which epoch is being served, written atomically
//!   .ps0123456789/           the epoch's iceoryx2 files; the name is its prefix in /dev/shm
//! ```
//!
//! Every start of a daemon takes a new random prefix and removes all that the epoch before it left. A
//! process that dies at any instruction can therefore leave nothing that a restart does not sweep, and no
//! state in shared memory outlives the daemon it belonged to.

mod doctor;
mod record;
mod runtime;
mod sweep;

use std::fs::{self, File, TryLockError};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

pub use doctor::{Exposed, Facts, Stale, examine};
pub use record::DomainRecord;
pub(crate) use runtime::private_file;
pub use runtime::{LearnerName, RuntimeDir};
pub(crate) use sweep::shared_memory_files;

/// Why a domain could not be made or found.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DomainError {
    /// The name of the learner is not one.
    #[error("{name:?} is no name for a learner: use 1 to 32 of a-z, 0-9, _ and -")]
    LearnerName {
        /// The name.
        name: String,
    },
    /// The runtime directory cannot be trusted or used.
    #[error("runtime directory {path}: {problem}")]
    Runtime {
        /// The directory.
        path: PathBuf,
        /// What is wrong and what to do.
        problem: String,
    },
    /// Another daemon serves this learner.
    #[error(
        "learner {name} is already served by process {pid}: stop that daemon first, or choose another --name"
    )]
    AlreadyServed {
        /// The learner.
        name: String,
        /// The process, as the lock file has it.
        pid: String,
    },
    /// No daemon serves this learner.
    #[error("no daemon serves learner {name} in {runtime}: start one with `pschema server --name {name}`")]
    NotServed {
        /// The learner.
        name: String,
        /// The runtime directory looked in.
        runtime: PathBuf,
    },
    /// The learner's daemon is not ready yet.
    #[error("the daemon of learner {name}, process {pid}, is only just starting: try again in a moment")]
    Starting {
        /// The learner.
        name: String,
        /// The daemon's process.
        pid: u32,
    },
    /// The daemon speaks another version of the protocol.
    #[error(
        "the daemon of learner {name} speaks protocol version {theirs}, this process version {ours}: use one release"
    )]
    Version {
        /// The learner.
        name: String,
        /// The daemon's version.
        theirs: u32,
        /// This build's version.
        ours: u32,
    },
    /// The domain file is damaged.
    #[error("{path} is damaged ({problem}): restart the daemon, it writes a new one")]
    Record {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
    /// Too little shared memory is left.
    #[error("/dev/shm has {available} bytes free, {needed} are needed: free some, or mount it larger")]
    SharedMemory {
        /// Bytes free.
        available: u64,
        /// Bytes needed.
        needed: u64,
    },
    /// The operating system refused.
    #[error("cannot {doing} {path}: {error}")]
    Io {
        /// What was being done.
        doing: &'static str,
        /// To what.
        path: PathBuf,
        /// What it said.
        error: std::io::Error,
    },
}

/// For `map_err`: an operating system error with what was being done to which file.
pub(crate) fn io(doing: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> DomainError {
    let path = path.to_owned();
    move |error| DomainError::Io { doing, path, error }
}

/// Shared memory a daemon with all its bodies and tools reserves, generously rounded up, in bytes.
pub const SHARED_MEMORY_NEEDED: u64 = 40 * 1024 * 1024;

/// Shared memory a body or a tool needs for itself, rounded up, in bytes.
pub(crate) const PEER_SHARED_MEMORY_NEEDED: u64 = 3 * 1024 * 1024;

/// Makes sure that so many bytes of shared memory are free. iceoryx2 writes to what it creates before
/// anything can be reserved, and a process that writes where there is no memory is killed.
pub(crate) fn require_shared_memory(needed: u64) -> Result<(), DomainError> {
    let available = sweep::shared_memory_available()?;
    if available < needed { Err(DomainError::SharedMemory { available, needed }) } else { Ok(()) }
}

/// A learner's place in a runtime directory: what bodies, tools and the daemon all start from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    runtime: RuntimeDir,
    learner: LearnerName,
}

impl Place {
    /// The place of `learner` in `runtime`.
    #[must_use]
    pub fn new(runtime: RuntimeDir, learner: LearnerName) -> Self {
        Self { runtime, learner }
    }

    /// The learner's name.
    #[must_use]
    pub fn learner(&self) -> &LearnerName {
        &self.learner
    }

    /// The runtime directory.
    #[must_use]
    pub fn runtime(&self) -> &RuntimeDir {
        &self.runtime
    }

    fn directory(&self) -> PathBuf {
        self.runtime.path().join(self.learner.as_str())
    }

    fn lock_path(&self) -> PathBuf {
        self.directory().join("lock")
    }

    fn record_path(&self) -> PathBuf {
        self.directory().join("domain")
    }

    fn not_served(&self) -> DomainError {
        DomainError::NotServed { name: self.learner.to_string(), runtime: self.runtime.path().to_owned() }
    }

    /// Whether a daemon holds the learner's lock. The kernel drops the lock with the process, so this is
    /// exact even for one that was killed or is not yet reaped.
    #[must_use]
    pub fn is_served(&self) -> bool {
        let Ok(lock) = File::open(self.lock_path()) else { return false };
        matches!(lock.try_lock_shared(), Err(TryLockError::WouldBlock))
    }

    /// The epoch being served.
    ///
    /// # Errors
    /// [`DomainError::NotServed`] when there is none; [`DomainError::Version`] when its daemon is of another
    /// release; [`DomainError::Starting`] when its daemon has not opened all of it yet; else what is wrong with
    /// its record.
    pub fn served(&self) -> Result<DomainRecord, DomainError> {
        let path = self.record_path();
        let record = match DomainRecord::read(&path) {
            Err(DomainError::Io { error, .. }) if error.kind() == std::io::ErrorKind::NotFound => {
                return Err(self.not_served());
            }
            record => record?,
        };
        // A daemon that has its lock and not yet its record is only starting: the record is the dead one's.
        if !self.is_served() || lock_holder(&self.lock_path()) != record.pid.to_string() {
            return Err(self.not_served());
        }
        if record.protocol != crate::wire::VERSION {
            return Err(DomainError::Version {
                name: self.learner.to_string(),
                theirs: record.protocol,
                ours: crate::wire::VERSION,
            });
        }
        // Its services come one by one, and each before the daemon's port on it: a request sent in between
        // reaches nobody, which looks just like a daemon that has gone.
        if !record.ready {
            return Err(DomainError::Starting { name: self.learner.to_string(), pid: record.pid });
        }
        Ok(record)
    }

    /// The iceoryx2 root directory of an epoch.
    pub(crate) fn epoch_root(&self, record: &DomainRecord) -> PathBuf {
        self.runtime.path().join(format!(".{}", record.prefix))
    }
}

/// Held by a peer for as long as it has anything on an epoch, its node last. A peer that was starting while
/// its daemon was replaced brings back a part of what the new daemon has swept; so the peer that finds
/// its epoch ended sweeps it again. One that is killed before leaves that to the next daemon.
#[derive(Debug)]
pub(crate) struct EpochGuard {
    place: Place,
    record: DomainRecord,
}

impl EpochGuard {
    pub(crate) fn new(place: &Place, record: &DomainRecord) -> Self {
        Self { place: place.clone(), record: record.clone() }
    }
}

impl Drop for EpochGuard {
    fn drop(&mut self) {
        let ended = match DomainRecord::read(&self.place.record_path()) {
            Ok(current) => current.prefix != self.record.prefix,
            Err(DomainError::Io { error, .. }) => error.kind() == std::io::ErrorKind::NotFound,
            Err(_) => false,
        };
        let root = self.place.epoch_root(&self.record);
        if ended && let Err(error) = sweep::epoch(&root, &self.record.prefix) {
            tracing::debug!(%error, "what is left of an ended epoch could not all be removed");
        }
    }
}

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
        // back. One that comes later still sweeps that itself (see `EpochGuard`).
        sweep_before()?;
        sweep::orphans(place.runtime.path())?;
        let root = place.epoch_root(&record);
        // An eager peer may have been first; below the runtime directory nobody else could be.
        runtime::private_directory(&root)?;
        tracing::debug!(learner = %place.learner, epoch = record.epoch, prefix = %record.prefix, "domain created");
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
    Err(DomainError::AlreadyServed { name: place.learner.to_string(), pid: lock_holder(&path) })
}

/// The process that wrote itself into a lock file, as text; empty when it cannot be read.
fn lock_holder(path: &Path) -> String {
    let mut pid = String::new();
    let read = File::open(path).and_then(|file| file.take(32).read_to_string(&mut pid));
    if read.is_err() {
        return String::new();
    }
    pid.trim().to_owned()
}
