//! The thread that writes the journal. The daemon hands each change to it and goes on; a reply leaves when the thread says
//! that the change that led to the reply is durable. Changes that come while the disk is at work are written together.

use std::convert::Infallible;
use std::io::ErrorKind;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use pschema_learner::memory::Content;

use crate::archivist::{Archive, ArchiveTask, Archivist, MarkDigest};
use crate::change::Durability;
use crate::codec;
use crate::error::StoreError;
use crate::format::v1;
use crate::journal::Journal;
use crate::manifest;
use crate::shared::{Shared, Wake};
use crate::snapshot;
use crate::storage::Storage;

/// Under [`Durability::Relaxed`] a reply leaves while no more batches than these wait for the disk: a disk that is slower than
/// the bodies slows the bodies down, and nothing else.
pub(crate) const WAITING_MAX: u64 = 1_024;
/// How often it is looked whether the files that nobody writes are whole.
const LOOK_EVERY: Duration = Duration::from_secs(1);
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

/// The thread from the daemon's side.
#[derive(Debug)]
pub(crate) struct Writer {
    /// Where the thread takes jobs from. No more come when this is dropped.
    pub(crate) jobs: Sender<Job>,
    pub(crate) thread: JoinHandle<()>,
    /// Disconnected when the thread has ended.
    pub(crate) ended: Receiver<Infallible>,
}

/// Starts the thread, which goes on with `journal` after `step`. It ends when the sender of jobs is dropped and all jobs are
/// written.
pub(crate) fn start(
    archive: Archive,
    journal: Journal,
    durability: Durability,
    step: u64,
    shared: Arc<Shared>,
    wake: Wake,
) -> Result<Writer, StoreError> {
    let (jobs, waiting) = channel();
    let (alive, ended) = channel();
    let storage = archive.storage.clone();
    let manifest =
        storage.read(manifest::FILE).map_err(StoreError::disk("read", storage.path(manifest::FILE)))?;
    let archivist = Archivist::start(archive, shared.clone(), wake.clone())?;
    let mut thread = WriterThread {
        storage,
        manifest,
        journal,
        durability,
        shared,
        wake,
        synced: Instant::now(),
        looked: Instant::now(),
        step,
        taken: 0,
        unsynced: false,
        task: None,
        archivist,
    };
    let run = move || {
        thread.run(&waiting);
        drop(thread);
        drop::<Sender<Infallible>>(alive);
    };
    let spawned = std::thread::Builder::new().name("writer".to_owned()).spawn(run);
    let thread = spawned.map_err(StoreError::disk("start a thread for", "the journal".to_owned()))?;
    Ok(Writer { jobs, thread, ended })
}

struct WriterThread {
    storage: Arc<dyn Storage>,
    /// The manifest's bytes.
    manifest: Vec<u8>,
    journal: Journal,
    durability: Durability,
    shared: Arc<Shared>,
    wake: Wake,
    synced: Instant,
    /// When it was last looked whether the files that nobody writes are whole.
    looked: Instant,
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
                Err(RecvTimeoutError::Timeout) => {
                    self.check()?;
                    None
                }
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            };
            // One group: all jobs that have come by now.
            let before = self.taken;
            for job in first.into_iter().chain(waiting.try_iter()) {
                self.take(job)?;
            }
            self.shared.written.store(self.taken, Ordering::Release);
            if self.taken - before >= WAITING_MAX {
                // There were so many that replies waited.
                (self.wake)();
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
        self.journal.append(payload, before).map_err(StoreError::disk("write", self.journal.path()))?;
        self.shared.journal_bytes.fetch_add(self.journal.written() - written, Ordering::AcqRel);
        self.unsynced = true;
        Ok(())
    }

    fn sync(&mut self) -> Result<(), StoreError> {
        let synced = self.journal.sync().map_err(StoreError::disk("make durable", self.journal.path()));
        // What is durable in a directory that nobody finds any more, or that another daemon has, must not be acknowledged.
        self.check()?;
        synced?;
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

    /// Makes sure that the journal and the newest snapshot are still where the next start looks for them, and that no other daemon
    /// can write there. Once a second it looks at the manifest and the earlier segments too.
    fn check(&mut self) -> Result<(), StoreError> {
        let newest = self.shared.newest_snapshot();
        let mut found = self.storage.check().and_then(|()| self.journal.check());
        found = found.and_then(|()| snapshot::check(&*self.storage, newest));
        if self.looked.elapsed() >= LOOK_EVERY {
            self.looked = Instant::now();
            found = found.and_then(|()| manifest::check(&*self.storage, &self.manifest));
            found = found.and_then(|()| self.journal.check_closed(newest));
        }
        found.or_else(|error| {
            if self.shared.newest_snapshot() != newest {
                // The archivist has made another meanwhile, after which it removes what is no longer needed.
                return Ok(());
            }
            let (kind, problem) = (error.kind(), error.to_string());
            Err(if kind == ErrorKind::UnexpectedEof {
                StoreError::Cut { problem }
            } else {
                StoreError::Displaced { problem }
            })
        })
    }

    /// Writes everything that is left.
    fn end(&mut self) -> Result<(), StoreError> {
        self.sync()?;
        self.archivist.end();
        self.digests()?;
        self.sync()?;
        self.journal.end().map_err(StoreError::disk("cut", self.journal.path()))
    }
}
