//! The thread that writes the journal. The daemon hands each change to it and goes on; a reply leaves when the thread says
//! that the change that led to the reply is durable. Changes that come while the disk is at work are written together.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use pschema_learner::memory::Content;

use crate::archivist::{Archive, ArchiveTask, Archivist, MarkDigest};
use crate::change::{Change, Durability};
use crate::codec;
use crate::error::StoreError;
use crate::format::v1;
use crate::journal::Journal;
use crate::shared::{Shared, Wake};

/// Batches that may wait for the disk. When there are so many, the daemon waits as well.
const WAITING_MAX: usize = 1_024;
/// A digest of memory is written after so many steps, or after a sixteenth as many as there are schemas if that is more: a
/// digest of many schemas takes time.
pub(crate) const DIGEST_STEPS: u64 = 1_024;
const DIGEST_SCHEMAS: u64 = 16;
/// How long a change may wait under [`Durability::Relaxed`] until it is made durable.
const RELAXED_MAX: Duration = Duration::from_secs(1);

struct Job {
    payload: Vec<u8>,
    /// Steps taken before this job and after it.
    before: u64,
    step: u64,
    checkpoint: Option<Checkpoint>,
}

/// Memory as it is after a job, of which a digest is to be made.
struct Checkpoint {
    content: Box<Content>,
    snapshot: bool,
}

/// The writing thread from the daemon's side. When it is dropped, it writes all that was handed over and ends the thread.
pub(crate) struct Writer {
    jobs: Option<SyncSender<Job>>,
    thread: Option<JoinHandle<()>>,
    shared: Arc<Shared>,
    handed: u64,
    step: u64,
    digested_step: u64,
    bytes_at_snapshot: u64,
    snapshot_bytes: u64,
    /// Whether a snapshot is due, however little the journal has grown.
    overdue: bool,
    /// Whether the newest snapshot is all of the memory, so that the end needs no other.
    at_snapshot: bool,
}

impl fmt::Debug for Writer {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "Writer({:?})", self.shared)
    }
}

/// What the threads begin with.
pub(crate) struct Start {
    pub(crate) archive: Archive,
    pub(crate) journal: Journal,
    pub(crate) durability: Durability,
    pub(crate) step: u64,
    pub(crate) snapshot_step: Option<u64>,
    /// The length of the journal, and the oldest step that can be returned to.
    pub(crate) kept: crate::retention::History,
    /// The length of the journal after the newest snapshot, in bytes.
    pub(crate) since_snapshot: u64,
    /// A snapshot is made whenever the journal has grown by so many bytes, and at least by the size of the last snapshot.
    pub(crate) snapshot_bytes: u64,
    /// Whether a snapshot is due, however little the journal has grown: the start had many files to read.
    pub(crate) overdue: bool,
    /// Whether the newest snapshot is all of the memory.
    pub(crate) at_snapshot: bool,
}

impl Writer {
    pub(crate) fn start(start: Start, wake: Wake) -> Result<Self, StoreError> {
        let (jobs, waiting) = sync_channel(WAITING_MAX);
        let Start { archive, journal, durability, step, snapshot_step, kept, since_snapshot, .. } = start;
        let shared = Arc::new(Shared::new(step, snapshot_step, kept));
        let path = archive.storage.path(crate::journal::DIRECTORY);
        let archivist = Archivist::start(archive, shared.clone(), wake.clone())?;
        let mut thread = WriterThread {
            path,
            journal,
            durability,
            shared: shared.clone(),
            wake,
            synced: Instant::now(),
            step,
            taken: 0,
            unsynced: false,
            task: None,
            archivist,
        };
        let run = move || thread.run(&waiting);
        let spawned = std::thread::Builder::new().name("writer".to_owned()).spawn(run);
        let thread = spawned.map_err(StoreError::disk("start a thread for", "the journal".to_owned()))?;
        Ok(Self {
            jobs: Some(jobs),
            thread: Some(thread),
            shared,
            handed: 0,
            step,
            digested_step: step,
            // Journal that was replayed counts, so that a daemon that is often restarted makes snapshots too.
            bytes_at_snapshot: kept.bytes.saturating_sub(since_snapshot),
            snapshot_bytes: start.snapshot_bytes,
            overdue: start.overdue,
            at_snapshot: start.at_snapshot,
        })
    }

    /// Hands over what one step, one order or one attachment changed; `content` is memory after the change. Returns the number
    /// of the batch, which [`Writer::is_durable`] takes.
    ///
    /// # Errors
    /// When the change can't be encoded, or the thread has failed.
    pub(crate) fn append(&mut self, change: &Change<'_>, content: &Content) -> Result<u64, StoreError> {
        if change.effects.is_empty() {
            return Ok(self.handed);
        }
        let payload = codec::encode(&change.record(content.step))?;
        let checkpoint = self.checkpoint(content);
        self.hand(payload, content.step, checkpoint)
    }

    /// Memory for a digest and perhaps a snapshot, if one is due and the archivist is free.
    fn checkpoint(&mut self, content: &Content) -> Option<Checkpoint> {
        let bytes = self.written_bytes();
        let enough = self.snapshot_bytes.max(self.shared.snapshot_bytes.load(Ordering::Acquire));
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

    /// Writes a snapshot and a digest of memory, unless they are there, and ends the threads.
    ///
    /// # Errors
    /// When the snapshot or the digest can't be written.
    pub(crate) fn finish(mut self, content: &Content) -> Result<(), StoreError> {
        if self.handed > 0 || !self.at_snapshot {
            let step = content.step;
            let payload = codec::encode(&v1::Record::Mark { step })?;
            let content = Box::new(content.clone());
            self.hand(payload, step, Some(Checkpoint { content, snapshot: true }))?;
        }
        self.join();
        self.failure().map_or(Ok(()), Err)
    }

    fn join(&mut self) {
        drop(self.jobs.take());
        if self.thread.take().is_some_and(|thread| thread.join().is_err()) {
            self.shared.fail("the thread that writes panicked");
        }
    }

    /// Whether the batch of this number is durable.
    #[must_use]
    pub(crate) fn is_durable(&self, batch: u64) -> bool {
        self.shared.durable.load(Ordering::Acquire) >= batch
    }

    /// The last step that is durable.
    #[must_use]
    pub(crate) fn durable_step(&self) -> u64 {
        self.shared.durable_step.load(Ordering::Acquire)
    }

    /// The length of the journal that is kept, in bytes.
    #[must_use]
    pub(crate) fn journal_bytes(&self) -> u64 {
        self.written_bytes().saturating_sub(self.shared.removed_bytes.load(Ordering::Acquire))
    }

    fn written_bytes(&self) -> u64 {
        self.shared.journal_bytes.load(Ordering::Acquire)
    }

    /// The oldest step that memory can be returned to.
    #[must_use]
    pub(crate) fn oldest_step(&self) -> u64 {
        self.shared.oldest_step.load(Ordering::Acquire)
    }

    /// The step of the newest snapshot.
    #[must_use]
    pub(crate) fn snapshot_step(&self) -> Option<u64> {
        self.shared.snapshot.load(Ordering::Acquire).checked_sub(1)
    }

    /// The length of the last snapshot that these threads made, in bytes; 0 before the first.
    #[must_use]
    pub(crate) fn snapshot_bytes(&self) -> u64 {
        self.shared.snapshot_bytes.load(Ordering::Acquire)
    }

    /// Has a snapshot made with the next change, however little the journal has grown.
    pub(crate) fn request_snapshot(&mut self) {
        self.overdue = true;
    }

    /// Whether a digest or a snapshot is being made.
    #[cfg(test)]
    pub(crate) fn is_archiving(&self) -> bool {
        self.shared.busy.load(Ordering::Acquire)
    }

    /// Why nothing more can be written, if so.
    #[must_use]
    pub(crate) fn failure(&self) -> Option<StoreError> {
        if let Some(failure) = self.shared.failure() {
            return Some(StoreError::Failed(failure));
        }
        let ended = self.thread.as_ref().is_some_and(JoinHandle::is_finished);
        ended.then(|| StoreError::Failed("the thread that writes has ended".to_owned()))
    }
}

impl Drop for Writer {
    fn drop(&mut self) {
        self.join();
    }
}

struct WriterThread {
    /// How the journal is called in messages.
    path: String,
    journal: Journal,
    durability: Durability,
    shared: Arc<Shared>,
    wake: Wake,
    synced: Instant,
    /// Steps and batches that were written.
    step: u64,
    taken: u64,
    unsynced: bool,
    /// A task for the archivist, which gets it as soon as the mark is durable.
    task: Option<ArchiveTask>,
    archivist: Archivist,
}

impl WriterThread {
    fn run(&mut self, waiting: &Receiver<Job>) {
        if let Err(error) = self.serve(waiting).and_then(|()| self.end()) {
            // Never tried again: after a failure nobody knows what the disk has.
            tracing::error!(%error, "memory could not be written");
            self.shared.fail(&error.to_string());
            (self.wake)();
        }
    }

    fn serve(&mut self, waiting: &Receiver<Job>) -> Result<(), StoreError> {
        loop {
            // A change that waits for its second has waited since the last sync at most.
            let waited = if self.unsynced { self.synced.elapsed() } else { Duration::ZERO };
            let first = match waiting.recv_timeout(RELAXED_MAX.saturating_sub(waited)) {
                Ok(job) => Some(job),
                Err(RecvTimeoutError::Timeout) => None,
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            };
            // One group: all jobs that have come by now.
            for job in first.into_iter().chain(waiting.try_iter()) {
                self.take(job)?;
            }
            self.digests()?;
            let due = self.durability == Durability::Strict || self.synced.elapsed() >= RELAXED_MAX;
            if self.unsynced && (due || self.task.is_some()) {
                self.sync()?;
            }
        }
    }

    fn take(&mut self, job: Job) -> Result<(), StoreError> {
        self.append(&job.payload, job.before)?;
        self.step = job.step;
        self.taken += 1;
        let Some(Checkpoint { content, snapshot }) = job.checkpoint else { return Ok(()) };
        self.append(&codec::encode(&v1::Record::Mark { step: job.step })?, job.step)?;
        self.task = Some(ArchiveTask { content, mark: self.journal.last(), snapshot });
        // There is one task at a time, so the archivist begins it at once, or, at the end, as soon as it can.
        self.sync()
    }

    /// Writes the digests that the archivist has made by now.
    fn digests(&mut self) -> Result<(), StoreError> {
        while let Some(MarkDigest { mark, step, digest }) = self.archivist.digested() {
            self.append(&codec::encode(&v1::Record::Digest { mark, step, digest })?, self.step)?;
        }
        Ok(())
    }

    fn append(&mut self, payload: &[u8], before: u64) -> Result<(), StoreError> {
        let written = self.journal.written();
        self.journal.append(payload, before).map_err(StoreError::disk("write", self.path.clone()))?;
        self.shared.journal_bytes.fetch_add(self.journal.written() - written, Ordering::AcqRel);
        self.unsynced = true;
        Ok(())
    }

    fn sync(&mut self) -> Result<(), StoreError> {
        self.journal.sync().map_err(StoreError::disk("make durable", self.path.clone()))?;
        self.synced = Instant::now();
        self.unsynced = false;
        self.shared.durable_step.store(self.step, Ordering::Release);
        self.shared.durable.store(self.taken, Ordering::Release);
        (self.wake)();
        if let Some(task) = self.task.take() {
            self.archivist.hand(task);
        }
        Ok(())
    }

    /// Writes everything that is left.
    fn end(&mut self) -> Result<(), StoreError> {
        self.sync()?;
        self.archivist.end();
        self.digests()?;
        self.sync()?;
        self.journal.end().map_err(StoreError::disk("cut", self.path.clone()))
    }
}
