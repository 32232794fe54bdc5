//! The thread that writes the journal. The daemon hands each change to it and goes on; a reply leaves when the thread says
//! that the change that led to the reply is durable. Changes that come while the disk is at work are written together.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use pschema_learner::memory::Content;

use crate::archivist::{Archive, ArchiveTask, Archivist, MarkDigest};
use crate::change::Durability;
use crate::codec;
use crate::error::StoreError;
use crate::format::v1;
use crate::journal::Journal;
use crate::shared::{Shared, Wake};

/// Batches that may wait for the disk. When there are so many, the daemon waits as well.
const WAITING_MAX: usize = 1_024;
/// How long a change may wait under [`Durability::Relaxed`] until it is made durable.
const RELAXED_MAX: Duration = Duration::from_secs(1);

/// A record for the journal.
#[derive(Debug)]
pub(crate) struct Job {
    /// The record in bytes.
    pub(crate) payload: Vec<u8>,
    /// Steps taken before the change that the record tells, and after it.
    pub(crate) before: u64,
    pub(crate) step: u64,
    pub(crate) checkpoint: Option<Checkpoint>,
}

/// Memory as it is after a job, of which a digest is to be made.
#[derive(Debug)]
pub(crate) struct Checkpoint {
    pub(crate) content: Box<Content>,
    /// Whether a snapshot is to be made as well.
    pub(crate) snapshot: bool,
}

/// Starts the thread, which goes on with `journal` after `step`. It ends when the sender that is returned is dropped and all
/// jobs are written.
pub(crate) fn start(
    archive: Archive,
    journal: Journal,
    durability: Durability,
    step: u64,
    shared: Arc<Shared>,
    wake: Wake,
) -> Result<(SyncSender<Job>, JoinHandle<()>), StoreError> {
    let (jobs, waiting) = sync_channel(WAITING_MAX);
    let path = archive.storage.path(crate::journal::DIRECTORY);
    let archivist = Archivist::start(archive, shared.clone(), wake.clone())?;
    let mut thread = WriterThread {
        path,
        journal,
        durability,
        shared,
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
    Ok((jobs, thread))
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
