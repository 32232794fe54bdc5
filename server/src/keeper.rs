//! Memory on disk, from the daemon's side: what was decided leaves only when the step that decided it is durable.

use std::collections::VecDeque;
use std::path::PathBuf;

use pschema_learner::effect::Effect;
use pschema_learner::memory::{Content, Memory};
use pschema_protocol::inspect::Storage;
use pschema_store::{Durability, Store, StoreError};

/// Where and how memory is kept.
#[derive(Clone, Debug)]
pub struct Keeping {
    /// The data directory; made when it isn't there.
    pub directory: PathBuf,
    /// When a reply may leave.
    pub durability: Durability,
}

/// What keeps memory, and what waits for it.
#[derive(Debug)]
pub(crate) struct Keeper<T> {
    /// None: memory is in RAM only, and nothing waits.
    store: Option<Store>,
    waiting: VecDeque<(u64, T)>,
    failure: Option<StoreError>,
}

impl<T> Keeper<T> {
    pub(crate) fn new(store: Option<Store>) -> Self {
        Self { store, waiting: VecDeque::new(), failure: None }
    }

    /// Has what changed written. Returns what to wait for.
    pub(crate) fn keep(&mut self, effects: &[Effect], content: &Content) -> u64 {
        let Some(store) = self.store.as_mut().filter(|_| self.failure.is_none()) else { return 0 };
        store.writer.append(effects, content).unwrap_or_else(|error| {
            self.failure = Some(error);
            u64::MAX
        })
    }

    /// Holds `what` back until `batch` is durable; [`Keeper::released`] has it then.
    pub(crate) fn hold(&mut self, batch: u64, what: T) {
        self.waiting.push_back((batch, what));
    }

    /// The next thing that may leave. Nothing may after a failure: what the disk has is not known then.
    pub(crate) fn released(&mut self) -> Option<T> {
        let (batch, _) = self.waiting.front()?;
        let free = match &self.store {
            None => true,
            Some(_) if self.failed() => false,
            Some(store) => store.durability == Durability::Relaxed || store.writer.is_durable(*batch),
        };
        if free { self.waiting.pop_front().map(|(_, what)| what) } else { None }
    }

    fn failed(&self) -> bool {
        self.failure.is_some() || self.store.as_ref().is_some_and(|store| store.writer.failure().is_some())
    }

    /// Why nothing more can be kept, if so.
    pub(crate) fn failure(&mut self) -> Option<StoreError> {
        // What the thread says is the cause of what `keep` met.
        let thread = self.store.as_ref().and_then(|store| store.writer.failure());
        thread.or_else(|| self.failure.take())
    }

    /// How memory is kept, for `status`.
    pub(crate) fn facts(&self) -> Option<Storage> {
        let store = self.store.as_ref()?;
        Some(Storage {
            directory: store.directory.display().to_string(),
            durability: store.durability.to_string(),
            durable_step: store.writer.durable_step(),
            journal_bytes: store.writer.journal_bytes(),
            snapshot_step: store.writer.snapshot_step(),
        })
    }

    /// Writes the last of it. Returns what may leave after that.
    pub(crate) fn finish(mut self, memory: &Memory) -> Result<impl Iterator<Item = T>, StoreError> {
        if let Some(store) = self.store.take() {
            store.finish(memory)?;
        }
        Ok(self.waiting.into_iter().map(|(_, what)| what))
    }
}
