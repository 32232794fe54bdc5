//! The thread that writes. The daemon hands it what changed and goes on; a reply leaves when the thread says that what
//! led to it is durable. What comes in while the disk is at work is written together.

use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use pschema_learner::digest::digest;
use pschema_learner::effect::Effect;
use pschema_learner::memory::Content;

use crate::codec;
use crate::error::StoreError;
use crate::format::v1;
use crate::journal::Journal;
use crate::snapshot;
use crate::storage::Storage;

/// Batches that may wait for the disk; beyond it the daemon waits with them.
const WAITING_MAX: usize = 1_024;
/// A digest of memory is written after every so many steps.
pub const DIGEST_STEPS: u64 = 1_024;
/// How old what is not yet durable may get under [`Durability::Relaxed`].
const RELAXED_MAX: Duration = Duration::from_secs(1);

/// When a reply may leave.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Durability {
    /// When the step that led to it is durable.
    #[default]
    Strict,
    /// At once; up to a second of steps is lost with the machine's power. For simulations.
    Relaxed,
}

impl fmt::Display for Durability {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str(match self {
            Self::Strict => "strict",
            Self::Relaxed => "relaxed",
        })
    }
}

struct Job {
    payload: Vec<u8>,
    step: u64,
    /// Memory after it, when its digest is to be written or a snapshot made.
    content: Option<Box<Content>>,
    snapshot: bool,
}

#[derive(Debug, Default)]
struct Shared {
    durable: AtomicU64,
    durable_step: AtomicU64,
    journal_bytes: AtomicU64,
    /// The step of the last snapshot, plus one; 0 for none.
    snapshot: AtomicU64,
    failure: Mutex<Option<String>>,
}

/// The thread, from the daemon's side. Dropping it writes what was handed over and ends the thread.
pub struct Writer {
    jobs: Option<SyncSender<Job>>,
    thread: Option<JoinHandle<()>>,
    shared: Arc<Shared>,
    handed: u64,
    digested: u64,
    bytes_at_snapshot: u64,
    snapshot_bytes: u64,
}

impl fmt::Debug for Writer {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "Writer({:?})", self.shared)
    }
}

/// What the thread starts from.
pub(crate) struct Start {
    pub(crate) storage: Arc<dyn Storage>,
    pub(crate) journal: Journal,
    pub(crate) durability: Durability,
    pub(crate) step: u64,
    pub(crate) snapshot_step: Option<u64>,
    pub(crate) journal_bytes: u64,
    /// A snapshot is made whenever the journal has grown by so much.
    pub(crate) snapshot_bytes: u64,
}

impl Writer {
    pub(crate) fn start(start: Start, wake: impl Fn() + Send + 'static) -> Result<Self, StoreError> {
        let (jobs, waiting) = sync_channel(WAITING_MAX);
        let shared = Arc::new(Shared::default());
        shared.durable_step.store(start.step, Ordering::Release);
        shared.journal_bytes.store(start.journal_bytes, Ordering::Release);
        shared.snapshot.store(start.snapshot_step.map_or(0, |step| step + 1), Ordering::Release);
        let (step, snapshot_bytes) = (start.step, start.snapshot_bytes);
        // What was replayed counts, so that a daemon that is often restarted makes snapshots too.
        let mut thread =
            Thread { start, shared: shared.clone(), wake: Box::new(wake), synced: Instant::now() };
        let run = move || thread.run(&waiting);
        let spawned = std::thread::Builder::new().name("writer".to_owned()).spawn(run);
        let thread = spawned.map_err(StoreError::disk("start a thread for", "the journal".to_owned()))?;
        Ok(Self {
            jobs: Some(jobs),
            thread: Some(thread),
            shared,
            handed: 0,
            digested: step / DIGEST_STEPS,
            bytes_at_snapshot: 0,
            snapshot_bytes,
        })
    }

    /// Hands over what one step, order or attachment changed; `content` is memory after it. Returns the number to wait
    /// for with [`Writer::is_durable`].
    ///
    /// # Errors
    /// When it can't be written, or the thread has failed.
    pub fn append(&mut self, effects: &[Effect], content: &Content) -> Result<u64, StoreError> {
        if effects.is_empty() {
            return Ok(self.handed);
        }
        let step = content.step;
        let record = v1::Record::Batch { step, effects: effects.iter().map(v1::Effect::from).collect() };
        let payload = codec::encode(&record)?;
        let bytes = self.journal_bytes();
        let snapshot = bytes.saturating_sub(self.bytes_at_snapshot) >= self.snapshot_bytes;
        if snapshot {
            self.bytes_at_snapshot = bytes;
        }
        let due = step / DIGEST_STEPS > self.digested;
        self.digested = step / DIGEST_STEPS;
        let content = (due || snapshot).then(|| Box::new(content.clone()));
        self.hand(Job { payload, step, content, snapshot })
    }

    fn hand(&mut self, job: Job) -> Result<u64, StoreError> {
        let sent = self.jobs.as_ref().is_some_and(|jobs| jobs.send(job).is_ok());
        if !sent {
            return Err(self
                .failure()
                .unwrap_or_else(|| StoreError::Failed("the writer has ended".to_owned())));
        }
        self.handed += 1;
        Ok(self.handed)
    }

    /// Writes a digest of memory and a snapshot, and ends the thread.
    ///
    /// # Errors
    /// When it can't be written.
    pub fn finish(mut self, content: &Content) -> Result<(), StoreError> {
        let step = content.step;
        let payload = codec::encode(&v1::Record::Digest { step, digest: digest(content) })?;
        let snapshot = Some(Box::new(content.clone()));
        self.hand(Job { payload, step, content: snapshot, snapshot: true })?;
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
    pub fn is_durable(&self, batch: u64) -> bool {
        self.shared.durable.load(Ordering::Acquire) >= batch
    }

    /// The last step that is durable.
    #[must_use]
    pub fn durable_step(&self) -> u64 {
        self.shared.durable_step.load(Ordering::Acquire)
    }

    /// Bytes in the journal since the snapshot that the start began from.
    #[must_use]
    pub fn journal_bytes(&self) -> u64 {
        self.shared.journal_bytes.load(Ordering::Acquire)
    }

    /// The step of the last snapshot.
    #[must_use]
    pub fn snapshot_step(&self) -> Option<u64> {
        self.shared.snapshot.load(Ordering::Acquire).checked_sub(1)
    }

    /// Why nothing more can be written, if so.
    #[must_use]
    pub fn failure(&self) -> Option<StoreError> {
        let failure = self.shared.failure.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(failure) = &*failure {
            return Some(StoreError::Failed(failure.clone()));
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

impl Shared {
    fn fail(&self, why: &str) {
        let mut failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
        failure.get_or_insert_with(|| why.to_owned());
    }
}

struct Thread {
    start: Start,
    shared: Arc<Shared>,
    wake: Box<dyn Fn() + Send>,
    synced: Instant,
}

impl Thread {
    fn run(&mut self, waiting: &Receiver<Job>) {
        let mut taken = 0;
        let mut unsynced = None;
        loop {
            let first = match waiting.recv_timeout(RELAXED_MAX) {
                Ok(job) => Some(job),
                Err(RecvTimeoutError::Timeout) => None,
                Err(RecvTimeoutError::Disconnected) => break,
            };
            // One group: what has come in by now.
            let jobs: Vec<Job> = first.into_iter().chain(waiting.try_iter()).collect();
            let done = self.write(&jobs, &mut taken, &mut unsynced);
            if let Err(error) = done {
                // Never tried again: what the disk has is not known any more.
                tracing::error!(%error, "memory could not be written");
                self.shared.fail(&error.to_string());
                (self.wake)();
                return;
            }
        }
        if let Some(step) = unsynced
            && let Err(error) = self.sync(taken, step)
        {
            self.shared.fail(&error.to_string());
        }
    }

    fn write(&mut self, jobs: &[Job], taken: &mut u64, unsynced: &mut Option<u64>) -> Result<(), StoreError> {
        for job in jobs {
            self.append(&job.payload)?;
            *taken += 1;
            *unsynced = Some(job.step);
            let Some(content) = &job.content else { continue };
            let record = v1::Record::Digest { step: job.step, digest: digest(content) };
            self.append(&codec::encode(&record)?)?;
            if job.snapshot {
                self.sync(*taken, job.step)?;
                snapshot::write(&*self.start.storage, content, self.start.journal.last())?;
                self.shared.snapshot.store(job.step + 1, Ordering::Release);
            }
        }
        let due = match self.start.durability {
            Durability::Strict => true,
            Durability::Relaxed => self.synced.elapsed() >= RELAXED_MAX,
        };
        if let Some(step) = unsynced.filter(|_| due) {
            self.sync(*taken, step)?;
            *unsynced = None;
            (self.wake)();
        }
        Ok(())
    }

    fn append(&mut self, payload: &[u8]) -> Result<(), StoreError> {
        let path = self.start.storage.path(crate::journal::DIRECTORY);
        self.start.journal.append(payload).map_err(StoreError::disk("write", path))?;
        let bytes = self.start.journal_bytes + self.start.journal.written();
        self.shared.journal_bytes.store(bytes, Ordering::Release);
        Ok(())
    }

    fn sync(&mut self, taken: u64, step: u64) -> Result<(), StoreError> {
        let path = self.start.storage.path(crate::journal::DIRECTORY);
        self.start.journal.sync().map_err(StoreError::disk("make durable", path))?;
        self.synced = Instant::now();
        self.shared.durable_step.store(step, Ordering::Release);
        self.shared.durable.store(taken, Ordering::Release);
        Ok(())
    }
}
