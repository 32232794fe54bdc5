//! The state that the daemon, the writer's thread and the archivist's thread have in common.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use crate::retention::History;

/// Figures and flags that one thread sets and the others read.
#[derive(Debug, Default)]
pub(crate) struct Shared {
    /// Batches that are durable, and batches that were given to the disk.
    pub(crate) durable: AtomicU64,
    pub(crate) written: AtomicU64,
    pub(crate) durable_step: AtomicU64,
    /// The length of the journal in bytes: what was there at the start, and what was written since.
    pub(crate) journal_bytes: AtomicU64,
    /// How many of these bytes were removed since.
    pub(crate) removed_bytes: AtomicU64,
    pub(crate) oldest_step: AtomicU64,
    /// The step of the newest snapshot, plus one; 0 before the first snapshot.
    pub(crate) snapshot: AtomicU64,
    /// The frame that it was made after; 0 before the first snapshot.
    newest: AtomicU64,
    /// The length of that snapshot in bytes.
    pub(crate) snapshot_bytes: AtomicU64,
    /// Whether the archivist is at work on a digest or a snapshot.
    pub(crate) busy: AtomicBool,
    failure: Mutex<Option<String>>,
}

/// Wakes the daemon: more is durable, or nothing more can be written.
pub(crate) type Wake = Arc<dyn Fn() + Send + Sync>;

impl Shared {
    /// After a start at `step`, with the step and the frame of the newest snapshot and what is kept of the journal.
    pub(crate) fn new(step: u64, snapshot: Option<(u64, u64)>, kept: History) -> Self {
        Self {
            durable_step: step.into(),
            journal_bytes: kept.bytes.into(),
            oldest_step: kept.oldest_step.into(),
            snapshot: snapshot.map_or(0, |(step, _)| step + 1).into(),
            newest: snapshot.map_or(0, |(_, frame)| frame).into(),
            ..Self::default()
        }
    }

    /// Notes that a snapshot was made after `step` and `frame`.
    pub(crate) fn note_snapshot(&self, step: u64, frame: u64) {
        self.snapshot.store(step + 1, Ordering::Release);
        self.newest.store(frame, Ordering::Release);
    }

    /// The frame that the newest snapshot was made after.
    pub(crate) fn newest_snapshot(&self) -> Option<u64> {
        Some(self.newest.load(Ordering::Acquire)).filter(|frame| *frame > 0)
    }

    pub(crate) fn fail(&self, why: &str) {
        let mut failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
        failure.get_or_insert_with(|| why.to_owned());
    }

    pub(crate) fn failure(&self) -> Option<String> {
        self.failure.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    pub(crate) fn has_failed(&self) -> bool {
        self.failure().is_some()
    }
}
