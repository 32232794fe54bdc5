//! The tie of a body or a tool to an epoch.

use super::{DomainError, DomainRecord, Place, sweep};

/// A peer holds this as long as it has anything on an epoch, and drops it after its node. A peer that was starting while its
/// daemon was replaced brings back a part of the files that the new daemon has swept. So a peer whose epoch has ended sweeps
/// it again when it drops this; if the peer is killed before, the next daemon does.
#[derive(Debug)]
pub struct Membership {
    place: Place,
    record: DomainRecord,
}

impl Membership {
    pub(crate) fn new(place: &Place, record: &DomainRecord) -> Self {
        Self { place: place.clone(), record: record.clone() }
    }

    /// What every name of the epoch in shared memory begins with.
    pub(crate) fn prefix(&self) -> &str {
        &self.record.prefix
    }

    /// The process of the epoch's daemon.
    pub(crate) fn daemon_pid(&self) -> u32 {
        self.record.pid
    }

    /// Whether the epoch is still being served.
    pub(crate) fn is_current(&self) -> bool {
        self.place.served().is_ok_and(|record| record.prefix == self.record.prefix)
    }
}

impl Drop for Membership {
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
