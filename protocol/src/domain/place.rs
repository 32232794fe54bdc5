//! A learner's place in a runtime directory, and the epoch that is served there.

use std::fs::{File, TryLockError};
use std::io::Read;
use std::path::PathBuf;

use super::{DomainError, DomainRecord, LearnerName, RuntimeDir};
use crate::wire::VERSION;

/// A learner's place in a runtime directory. Bodies, tools and the daemon all start from it.
///
/// ```no_run
/// use pschema_protocol::domain::{LearnerName, Place, RuntimeDir};
///
/// let place = Place::new(RuntimeDir::from_environment()?, LearnerName::new("demo")?);
/// println!("{}: {}", place.learner(), if place.is_served() { "served" } else { "not served" });
/// # Ok::<_, pschema_protocol::domain::DomainError>(())
/// ```
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

    pub(super) fn directory(&self) -> PathBuf {
        self.runtime.path().join(self.learner.as_str())
    }

    pub(super) fn lock_path(&self) -> PathBuf {
        self.directory().join("lock")
    }

    pub(super) fn record_path(&self) -> PathBuf {
        self.directory().join("domain")
    }

    fn not_served(&self) -> DomainError {
        DomainError::NotServed { name: self.learner.to_string(), runtime: self.runtime.path().to_owned() }
    }

    /// Whether a daemon holds the learner's lock. The kernel drops the lock with the process, so this is exact also for a
    /// daemon that was killed and is not yet reaped.
    #[must_use]
    pub fn is_served(&self) -> bool {
        let Ok(lock) = File::open(self.lock_path()) else { return false };
        matches!(lock.try_lock_shared(), Err(TryLockError::WouldBlock))
    }

    /// The epoch being served.
    ///
    /// # Errors
    /// [`DomainError::NotServed`] when there is none; [`DomainError::Version`] when its daemon is of another
    /// release; [`DomainError::Starting`] when its daemon has not opened all of it yet, or still looks for its memory; else
    /// what is wrong with its record.
    pub fn served(&self) -> Result<DomainRecord, DomainError> {
        let path = self.record_path();
        let record = match DomainRecord::read(&path) {
            Err(DomainError::Io { error, .. }) if error.kind() == std::io::ErrorKind::NotFound => None,
            record => Some(record?),
        };
        if !self.is_served() {
            return Err(self.not_served());
        }
        let pid = self.lock_holder();
        let starting = || DomainError::Starting { name: self.learner.to_string(), pid: pid.clone() };
        // A daemon that holds the lock and has not yet written its record is starting: the record is that of a dead daemon.
        let record = record.filter(|record| pid == record.pid.to_string()).ok_or_else(starting)?;
        if record.protocol != VERSION {
            return Err(DomainError::Version {
                name: self.learner.to_string(),
                theirs: record.protocol,
                ours: VERSION,
            });
        }
        // The daemon makes its services one by one, and each before its own port on it. A request that is sent in between
        // reaches nobody, which looks just as if the daemon had gone.
        if !record.ready {
            return Err(starting());
        }
        Ok(record)
    }

    /// The process that wrote itself into the lock file, as text; empty when it cannot be read.
    pub(super) fn lock_holder(&self) -> String {
        let mut pid = String::new();
        let read = File::open(self.lock_path()).and_then(|file| file.take(32).read_to_string(&mut pid));
        if read.is_err() {
            return String::new();
        }
        pid.trim().to_owned()
    }

    /// The iceoryx2 root directory of an epoch.
    pub(crate) fn epoch_root(&self, record: &DomainRecord) -> PathBuf {
        self.runtime.path().join(format!(".{}", record.prefix))
    }
}
