//! A memory on disk from the daemon's side: keeping it and finishing it.

use std::convert::Infallible;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::Duration;

use pschema_learner::memory::{Content, Memory};

use crate::change::{Change, Durability};
use crate::codec;
use crate::error::StoreError;
use crate::format::v1;
use crate::recovery::RecoveryReport;
use crate::shared::Shared;
use crate::writer::{Checkpoint, Job, WAITING_MAX};

/// A digest of memory is written after so many steps, or after a sixteenth as many as there are schemas if that is more: a
/// digest of many schemas takes time.
pub(crate) const DIGEST_STEPS: u64 = 1_024;
const DIGEST_SCHEMAS: u64 = 16;

/// How long the end may take until it is said that the disk is slow.
const SLOW: Duration = Duration::from_secs(1);

/// How a memory on disk was left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// With a snapshot of all of it.
    Whole,
    /// With all changes in the journal, which the next start reads: there was no time for a snapshot.
    WithoutSnapshot,
}

/// A memory on disk. Every change of the memory is handed to it, and it says when the change is durable. When it is dropped, it
/// writes all that was handed over and ends the writing thread.
#[derive(Debug)]
pub struct Store {
    pub(crate) jobs: Option<Sender<Job>>,
    pub(crate) thread: Option<JoinHandle<()>>,
    /// Disconnected when the thread has ended.
    pub(crate) ended: Receiver<Infallible>,
    pub(crate) shared: Arc<Shared>,
    /// Batches that were handed over.
    pub(crate) handed: u64,
    /// Steps taken after the last of them.
    pub(crate) step: u64,
    pub(crate) digested_step: u64,
    pub(crate) bytes_at_snapshot: u64,
    /// A snapshot is made whenever the journal has grown by so many bytes, and at least by the size of the last snapshot.
    pub(crate) snapshot_bytes: u64,
    /// Whether a snapshot is due, however little the journal has grown: the start had many files to read, or somebody asked
    /// for one.
    pub(crate) overdue: bool,
    /// Whether the newest snapshot is all of the memory, so that the end needs no other.
    pub(crate) at_snapshot: bool,
    pub(crate) recovered: RecoveryReport,
    pub(crate) durability: Durability,
    pub(crate) directory: PathBuf,
}

impl Store {
    /// Hands over what one step, one order or one attachment changed; `content` is memory after it. Returns the number of
    /// the batch, to be asked for with [`Store::is_durable`].
    ///
    /// # Errors
    /// When the change can't be encoded, or an earlier one could not be written.
    pub fn append(&mut self, change: &Change<'_>, content: &Content) -> Result<u64, StoreError> {
        if change.effects.is_empty() {
            return Ok(self.handed);
        }
        let payload = codec::encode(&change.record(content.step))?;
        let checkpoint = self.checkpoint(content);
        self.hand(payload, content.step, checkpoint)
    }

    /// Memory for a digest and perhaps a snapshot, if one is due and the archivist is free.
    fn checkpoint(&mut self, content: &Content) -> Option<Checkpoint> {
        let bytes = self.shared.journal_bytes.load(Ordering::Acquire);
        let enough = self.snapshot_bytes.max(self.snapshot_bytes());
        let snapshot = self.overdue || bytes.saturating_sub(self.bytes_at_snapshot) >= enough;
        let steps = DIGEST_STEPS.max(content.schemas.len() as u64 / DIGEST_SCHEMAS);
        let due = content.step.saturating_sub(self.digested_step) >= steps;
        if !(due || snapshot) || self.shared.busy.swap(true, Ordering::AcqRel) {
            return None;
        }
        self.digested_step = content.step;
        if snapshot {
            self.bytes_at_snapshot = bytes;
            self.overdue = false;
        }
        Some(Checkpoint { content: Box::new(content.clone()), snapshot })
    }

    fn hand(
        &mut self,
        payload: Vec<u8>,
        step: u64,
        checkpoint: Option<Checkpoint>,
    ) -> Result<u64, StoreError> {
        let job = Job { payload, before: self.step, step, checkpoint };
        self.step = step;
        let sent = self.jobs.as_ref().is_some_and(|jobs| jobs.send(job).is_ok());
        if !sent {
            return Err(self
                .failure()
                .unwrap_or_else(|| StoreError::Failed("the writer has ended".to_owned())));
        }
        self.handed += 1;
        Ok(self.handed)
    }

    /// Whether a message that rests on the batch of this number may leave: the batch is durable, or, under
    /// [`Durability::Relaxed`], few enough are waiting for the disk.
    #[must_use]
    pub fn may_leave(&self, batch: u64) -> bool {
        match self.durability {
            Durability::Strict => self.is_durable(batch),
            Durability::Relaxed => {
                self.shared.written.load(Ordering::Acquire).saturating_add(WAITING_MAX) >= batch
            }
        }
    }

    /// Whether the batch of this number is durable.
    #[must_use]
    pub fn is_durable(&self, batch: u64) -> bool {
        self.shared.durable.load(Ordering::Acquire) >= batch
    }

    /// Why nothing more can be written, if so.
    #[must_use]
    pub fn failure(&self) -> Option<StoreError> {
        if let Some(failure) = self.shared.failure() {
            return Some(StoreError::Failed(failure));
        }
        let ended = self.thread.as_ref().is_some_and(JoinHandle::is_finished);
        ended.then(|| StoreError::Failed("the thread that writes has ended".to_owned()))
    }

    /// Has a snapshot made with the next change, however little the journal has grown.
    pub fn request_snapshot(&mut self) {
        self.overdue = true;
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
        self.shared.durable_step.load(Ordering::Acquire)
    }

    /// The length of the journal that is kept, in bytes.
    #[must_use]
    pub fn journal_bytes(&self) -> u64 {
        let written = self.shared.journal_bytes.load(Ordering::Acquire);
        written.saturating_sub(self.shared.removed_bytes.load(Ordering::Acquire))
    }

    /// The oldest step that memory can be returned to.
    #[must_use]
    pub fn oldest_step(&self) -> u64 {
        self.shared.oldest_step.load(Ordering::Acquire)
    }

    /// The step of the newest snapshot; none before the first.
    #[must_use]
    pub fn snapshot_step(&self) -> Option<u64> {
        self.shared.snapshot.load(Ordering::Acquire).checked_sub(1)
    }

    /// The length of the last snapshot that was made since the directory was opened, in bytes; 0 before the first.
    #[must_use]
    pub fn snapshot_bytes(&self) -> u64 {
        self.shared.snapshot_bytes.load(Ordering::Acquire)
    }

    /// Whether a digest or a snapshot is being made.
    #[cfg(test)]
    pub(crate) fn is_archiving(&self) -> bool {
        self.shared.busy.load(Ordering::Acquire)
    }

    /// Writes all that was handed over, a snapshot and the digest of memory unless they are there, and gives the directory free.
    ///
    /// # Errors
    /// When something of it can't be written.
    pub fn finish(self, memory: &Memory) -> Result<(), StoreError> {
        self.finish_within(memory, Duration::MAX).map(|_| ())
    }

    /// As [`Store::finish`], but waits for the disk no longer than `patience`. What is not written by then is left to the
    /// thread, which ends with the process at the latest.
    ///
    /// # Errors
    /// As [`Store::finish`]; and when the disk has not confirmed all changes by then.
    pub fn finish_within(mut self, memory: &Memory, patience: Duration) -> Result<Ending, StoreError> {
        if self.handed > 0 || !self.at_snapshot {
            let step = memory.content().step;
            let payload = codec::encode(&v1::Record::Mark { step })?;
            let content = Box::new(memory.content().clone());
            self.hand(payload, step, Some(Checkpoint { content, snapshot: true }))?;
        }
        drop(self.jobs.take());
        let soon = patience.min(SLOW);
        let mut waited = self.ended.recv_timeout(soon);
        if waited == Err(RecvTimeoutError::Timeout) && patience > soon {
            let (changes, seconds) = (self.unconfirmed(), patience.as_secs());
            tracing::warn!(
                changes,
                seconds,
                "the disk is slow: waiting at most so long for what is left to be written"
            );
            waited = self.ended.recv_timeout(patience.saturating_sub(soon));
        }
        if waited == Err(RecvTimeoutError::Timeout) {
            drop(self.thread.take());
            let changes = self.unconfirmed();
            return match self.failure() {
                Some(failure) => Err(failure),
                None if changes > 0 => Err(StoreError::Slow { changes, seconds: patience.as_secs() }),
                None => Ok(Ending::WithoutSnapshot),
            };
        }
        self.join();
        self.failure().map_or(Ok(Ending::Whole), Err)
    }

    /// How many of the changes that were handed over are not durable.
    #[must_use]
    pub fn unconfirmed(&self) -> u64 {
        self.handed.saturating_sub(self.shared.durable.load(Ordering::Acquire))
    }

    fn join(&mut self) {
        drop(self.jobs.take());
        if self.thread.take().is_some_and(|thread| thread.join().is_err()) {
            self.shared.fail("the thread that writes panicked");
        }
    }
}

impl Drop for Store {
    fn drop(&mut self) {
        self.join();
    }
}
