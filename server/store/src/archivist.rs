//! The thread that makes digests of memory and snapshots, which take time. It works on a copy that shares memory's chunks, so
//! that neither the daemon nor the journal waits for it.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::thread::JoinHandle;

use pschema_learner::digest::digest;
use pschema_learner::memory::Content;

use crate::error::StoreError;
use crate::format::v1::Setting;
use crate::journal::Place;
use crate::retention;
use crate::shared::{Shared, Wake};
use crate::snapshot;
use crate::storage::Storage;

/// Memory as it was at a mark that is durable: a digest of it is to be made.
#[derive(Debug)]
pub(crate) struct ArchiveTask {
    pub(crate) content: Box<Content>,
    pub(crate) mark: Place,
    /// Whether a snapshot is to be made as well.
    pub(crate) snapshot: bool,
}

/// The digest of memory at a mark.
#[derive(Debug)]
pub(crate) struct MarkDigest {
    pub(crate) mark: u64,
    pub(crate) step: u64,
    pub(crate) digest: String,
}

/// The archivist's thread from the writer's side.
#[derive(Debug)]
pub(crate) struct Archivist {
    tasks: Option<SyncSender<ArchiveTask>>,
    digested: Receiver<MarkDigest>,
    thread: Option<JoinHandle<()>>,
    shared: Arc<Shared>,
}

/// Where snapshots go, and what is kept.
#[derive(Debug)]
pub(crate) struct Archive {
    pub(crate) storage: Arc<dyn Storage>,
    pub(crate) setting: Setting,
    pub(crate) history_bytes: Option<u64>,
    /// The numbers of snapshots that were found damaged at the start.
    pub(crate) damaged: Vec<u64>,
}

impl Archivist {
    pub(crate) fn start(archive: Archive, shared: Arc<Shared>, wake: Wake) -> Result<Self, StoreError> {
        let (tasks, waiting) = sync_channel(1);
        let (found, digested) = channel();
        let own = shared.clone();
        let run = move || serve(&archive, &waiting, &found, &own, &wake);
        let spawned = std::thread::Builder::new().name("archivist".to_owned()).spawn(run);
        let thread = spawned.map_err(StoreError::disk("start a thread for", "snapshots".to_owned()))?;
        Ok(Self { tasks: Some(tasks), digested, thread: Some(thread), shared })
    }

    /// Hands a task over. Waits while there is another task that has not been begun.
    pub(crate) fn hand(&self, task: ArchiveTask) {
        if let Some(tasks) = &self.tasks
            && tasks.send(task).is_err()
        {
            // It ends only after a failure, which it has reported.
            tracing::debug!("the archivist has ended");
        }
    }

    /// The next digest that was made; none if none is waiting.
    pub(crate) fn digested(&self) -> Option<MarkDigest> {
        self.digested.try_recv().ok()
    }

    /// Waits until all tasks are done. Their digests are then still to be asked for.
    pub(crate) fn end(&mut self) {
        drop(self.tasks.take());
        if self.thread.take().is_some_and(|thread| thread.join().is_err()) {
            self.shared.fail("the thread that makes snapshots panicked");
        }
    }
}

impl Drop for Archivist {
    fn drop(&mut self) {
        self.end();
    }
}

fn serve(
    archive: &Archive,
    tasks: &Receiver<ArchiveTask>,
    digested: &Sender<MarkDigest>,
    shared: &Shared,
    wake: &Wake,
) {
    let _alive = Alive(shared, wake);
    while let Ok(ArchiveTask { content, mark, snapshot }) = tasks.recv() {
        if shared.has_failed() {
            return;
        }
        let (step, digest) = (content.step, digest(&content));
        // Nobody receives it only when the writer has failed.
        drop(digested.send(MarkDigest { mark: mark.number, step, digest: digest.clone() }));
        if snapshot && let Err(error) = archive.snapshot(&content, mark, &digest, shared) {
            tracing::error!(%error, "a snapshot could not be made");
            shared.fail(&error.to_string());
            wake();
            return;
        }
        shared.busy.store(false, Ordering::Release);
    }
}

/// Reports a failure when the thread ends in a panic: a journal that is never tidied would fill the disk.
struct Alive<'a>(&'a Shared, &'a Wake);

impl Drop for Alive<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.fail("the thread that makes snapshots panicked");
            (self.1)();
        }
    }
}

impl Archive {
    fn snapshot(
        &self,
        content: &Content,
        mark: Place,
        digest: &str,
        shared: &Shared,
    ) -> Result<(), StoreError> {
        let storage = &*self.storage;
        // Another daemon's files must be neither replaced nor removed.
        let held = || {
            let found = storage.check().and_then(|()| snapshot::check(storage, shared.newest_snapshot()));
            found.map_err(|error| StoreError::Displaced { problem: error.to_string() })
        };
        held()?;
        let given_up = || shared.has_failed();
        let Some(bytes) = snapshot::write(storage, content, &self.setting, mark, digest, given_up)? else {
            return Ok(());
        };
        shared.snapshot_bytes.store(bytes, Ordering::Release);
        shared.note_snapshot(content.step, mark.number);
        held()?;
        let removed = retention::tidy(storage, self.history_bytes, &self.damaged)?;
        shared.removed_bytes.fetch_add(removed, Ordering::AcqRel);
        shared.oldest_step.store(retention::kept(storage)?.oldest_step, Ordering::Release);
        Ok(())
    }
}
