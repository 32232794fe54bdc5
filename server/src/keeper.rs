//! Memory on disk, from the daemon's side: what was decided leaves only when the step that decided it is durable.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::time::{SystemTime, UNIX_EPOCH};

use pschema_inspect::StorageStatus;
use pschema_learner::effect::Effect;
use pschema_learner::memory::{Content, Memory};
use pschema_store::{Cause, Change, Durability, Retention, Store, StoreError};

/// Where and how memory is kept.
#[derive(Clone, Debug)]
pub struct Keeping {
    /// The data directory; made when it isn't there.
    pub directory: PathBuf,
    /// When a reply may leave.
    pub durability: Durability,
    /// How much is kept.
    pub retention: Retention,
    /// Whether somebody asked for the seed: a memory that began with another is refused then, and else goes on.
    pub seed_given: bool,
    /// Whether somebody asked for the parameters and the curriculum: a memory that lives under others is refused then,
    /// and else goes on under its own.
    pub setting_given: bool,
    /// Whether a memory that lives under others goes on under those asked for.
    pub change: bool,
}

/// The time by the machine's clock, in milliseconds since 1970; 0 before that.
#[expect(
    clippy::disallowed_methods,
    reason = "the one place; what it says is for people and decides nothing"
)]
pub(crate) fn now_unix_ms() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since.as_millis()).unwrap_or(u64::MAX)
}

/// What writes changes down; a seam, so that a test can hold the disk back.
pub(crate) trait Ledger {
    /// Writes a change; returns what to wait for.
    fn append(&mut self, change: &Change<'_>, content: &Content) -> Result<u64, StoreError>;
    /// Whether replies wait for the disk.
    fn is_strict(&self) -> bool;
    /// Whether the batch of this number is on disk.
    fn is_durable(&self, batch: u64) -> bool;
    /// Why nothing more can be written, if so.
    fn failure(&self) -> Option<StoreError>;
}

impl Ledger for Store {
    fn append(&mut self, change: &Change<'_>, content: &Content) -> Result<u64, StoreError> {
        Store::append(self, change, content)
    }

    fn is_strict(&self) -> bool {
        self.durability() == Durability::Strict
    }

    fn is_durable(&self, batch: u64) -> bool {
        Store::is_durable(self, batch)
    }

    fn failure(&self) -> Option<StoreError> {
        Store::failure(self)
    }
}

/// What keeps memory, and what waits for it.
#[derive(Debug)]
pub(crate) struct Keeper<T, L = Store> {
    /// None: memory is in RAM only, and nothing waits.
    ledger: Option<L>,
    waiting: VecDeque<(u64, T)>,
    failure: Option<StoreError>,
}

impl<T, L: Ledger> Keeper<T, L> {
    pub(crate) fn new(ledger: Option<L>) -> Self {
        Self { ledger, waiting: VecDeque::new(), failure: None }
    }

    /// Has what changed written. Returns what to wait for.
    pub(crate) fn keep(&mut self, cause: Cause<'_>, effects: &[Effect], content: &Content) -> u64 {
        let Some(ledger) = self.ledger.as_mut().filter(|_| self.failure.is_none()) else { return 0 };
        let change = Change { cause, at_unix_ms: now_unix_ms(), effects };
        ledger.append(&change, content).unwrap_or_else(|error| {
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
        let free = match &self.ledger {
            None => true,
            Some(ledger) if self.failure.is_some() || ledger.failure().is_some() => false,
            Some(ledger) => !ledger.is_strict() || ledger.is_durable(*batch),
        };
        if free { self.waiting.pop_front().map(|(_, what)| what) } else { None }
    }

    /// Why nothing more can be kept, if so.
    pub(crate) fn failure(&mut self) -> Option<StoreError> {
        // What the thread says is the cause of what `keep` met.
        let thread = self.ledger.as_ref().and_then(Ledger::failure);
        thread.or_else(|| self.failure.take())
    }
}

impl<T> Keeper<T> {
    /// How memory is kept, for `status`.
    pub(crate) fn facts(&self) -> Option<StorageStatus> {
        let store = self.ledger.as_ref()?;
        Some(StorageStatus {
            directory: store.directory().display().to_string(),
            durability: match store.durability() {
                Durability::Strict => pschema_inspect::Durability::Strict,
                Durability::Relaxed => pschema_inspect::Durability::Relaxed,
            },
            durable_step: store.durable_step(),
            journal_bytes: store.journal_bytes(),
            oldest_step: store.oldest_step(),
            snapshot_step: store.snapshot_step(),
        })
    }

    /// Writes the last of it. Returns what may leave after that.
    pub(crate) fn finish(mut self, memory: &Memory) -> Result<impl Iterator<Item = T>, StoreError> {
        if let Some(store) = self.ledger.take() {
            store.finish(memory)?;
        }
        Ok(self.waiting.into_iter().map(|(_, what)| what))
    }
}

#[cfg(test)]
mod tests {
    use pschema_learner::parameters::Parameters;
    use pschema_learner::progress::StageEffect;

    use super::*;

    /// A disk whose syncs are the test's to make.
    #[derive(Default)]
    struct Held {
        appended: u64,
        durable: u64,
        relaxed: bool,
        full: bool,
        failed: bool,
    }

    impl Ledger for Held {
        fn append(&mut self, _: &Change<'_>, _: &Content) -> Result<u64, StoreError> {
            if self.full {
                return Err(StoreError::Failed("full".to_owned()));
            }
            self.appended += 1;
            Ok(self.appended)
        }

        fn is_strict(&self) -> bool {
            !self.relaxed
        }

        fn is_durable(&self, batch: u64) -> bool {
            self.durable >= batch
        }

        fn failure(&self) -> Option<StoreError> {
            self.failed.then(|| StoreError::Failed("not confirmed".to_owned()))
        }
    }

    type Kept = Keeper<&'static str, Held>;

    fn kept(keeper: &mut Kept, cause: Cause<'_>, what: &'static str) {
        let memory = Memory::new(1, Parameters::default());
        let batch = keeper.keep(cause, &[Effect::Stage(StageEffect::Held(true))], memory.content());
        keeper.hold(batch, what);
    }

    fn released(keeper: &mut Kept) -> Vec<&'static str> {
        std::iter::from_fn(|| keeper.released()).collect()
    }

    fn sync(keeper: &mut Kept, durable: u64) -> Vec<&'static str> {
        if let Some(held) = &mut keeper.ledger {
            held.durable = durable;
        }
        released(keeper)
    }

    /// Replies to two bodies, the answers to orders, and one that changed nothing but may tell of what did.
    fn several(keeper: &mut Kept) {
        kept(keeper, Cause::Declared("left"), "to the left body");
        kept(keeper, Cause::Declared("right"), "to the right body");
        kept(keeper, Cause::Order("stage hold"), "to an order");
        keeper.hold(3, "to a question");
        kept(keeper, Cause::Order("cancel 1"), "to another order");
    }

    #[test]
    fn nothing_leaves_before_it_is_durable_and_then_in_order() {
        let mut keeper = Kept::new(Some(Held::default()));
        several(&mut keeper);
        assert!(released(&mut keeper).is_empty());
        assert_eq!(sync(&mut keeper, 1), ["to the left body"]);
        assert_eq!(sync(&mut keeper, 3), ["to the right body", "to an order", "to a question"]);
        assert!(released(&mut keeper).is_empty() && keeper.failure().is_none());
        assert_eq!(sync(&mut keeper, 4), ["to another order"]);
    }

    #[test]
    fn nothing_leaves_after_a_failure() {
        let mut keeper = Kept::new(Some(Held { failed: true, durable: 1, ..Held::default() }));
        several(&mut keeper);
        assert!(released(&mut keeper).is_empty());
        assert!(keeper.failure().is_some_and(|error| error.to_string().contains("not confirmed")));
        let mut keeper = Kept::new(Some(Held::default()));
        kept(&mut keeper, Cause::Declared("left"), "written");
        if let Some(held) = &mut keeper.ledger {
            held.full = true;
        }
        several(&mut keeper);
        assert!(sync(&mut keeper, 1).is_empty(), "what the disk has is not known");
        assert!(keeper.failure().is_some_and(|error| error.to_string().contains("full")));
    }

    #[test]
    fn without_a_disk_to_wait_for_all_leaves_at_once() {
        for ledger in [None, Some(Held { relaxed: true, ..Held::default() })] {
            let mut keeper = Kept::new(ledger);
            several(&mut keeper);
            assert_eq!(released(&mut keeper).len(), 5);
        }
    }
}
