//! Memory on disk, from the daemon's side: a reply leaves only when the step that decided it is durable, and an order is
//! acknowledged only when the change that it made is.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use pschema_inspect::StorageStatus;
use pschema_learner::effect::Effect;
use pschema_learner::memory::{Content, Memory};
use pschema_store::{Cause, Change, Durability, Ending, Retention, Store, StoreError};

/// How long the disk may take at the end: less than a service manager waits before it kills.
const FINISH_MAX: Duration = Duration::from_secs(10);

/// Where and how memory is kept.
#[derive(Clone, Debug)]
pub struct Keeping {
    /// The data directory. It is made if it does not exist.
    pub directory: PathBuf,
    /// Whether a reply waits until its step is on disk.
    pub durability: Durability,
    /// How much of the journal is kept, and how often a snapshot is made.
    pub retention: Retention,
    /// Whether the seed was given on the command line. If so, a memory that began with another seed is refused; if not,
    /// it goes on with its own.
    pub seed_given: bool,
    /// Whether parameters or a curriculum were given on the command line. If so, a memory that lives under others is
    /// refused; if not, it goes on under its own.
    pub setting_given: bool,
    /// Whether a memory that lives under other parameters or another curriculum goes on under those that were given.
    pub change: bool,
}

/// The time by the machine's clock, in milliseconds since 1970; 0 if the clock is before that.
#[expect(
    clippy::disallowed_methods,
    reason = "the one place that asks for the time of day, which is for people and decides nothing"
)]
pub(crate) fn now_unix_ms() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since.as_millis()).unwrap_or(u64::MAX)
}

/// The writer of changes to memory. It is a trait so that a test can stand in for the disk.
pub(crate) trait Ledger {
    /// Writes a change; returns the number of its batch.
    fn append(&mut self, change: &Change<'_>, content: &Content) -> Result<u64, StoreError>;
    /// Whether messages that rest on the batch of this number may leave: it is on disk, or they do not wait for that.
    fn may_leave(&self, batch: u64) -> bool;
    /// Why nothing more can be written, if so.
    fn failure(&self) -> Option<StoreError>;
}

impl Ledger for Store {
    fn append(&mut self, change: &Change<'_>, content: &Content) -> Result<u64, StoreError> {
        Store::append(self, change, content)
    }

    fn may_leave(&self, batch: u64) -> bool {
        Store::may_leave(self, batch)
    }

    fn failure(&self) -> Option<StoreError> {
        Store::failure(self)
    }
}

/// The queue of messages that wait for the disk, and the ledger that they wait for.
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

    /// Has the ledger write the `effects` that changed memory, and what caused them. Returns the number of the batch, to be
    /// waited for; 0, which nothing waits for, when memory is in RAM only.
    pub(crate) fn keep(&mut self, cause: Cause<'_>, effects: &[Effect], content: &Content) -> u64 {
        let Some(ledger) = self.ledger.as_mut().filter(|_| self.failure.is_none()) else { return 0 };
        let change = Change { cause, at_unix_ms: now_unix_ms(), effects };
        ledger.append(&change, content).unwrap_or_else(|error| {
            self.failure = Some(error);
            u64::MAX
        })
    }

    /// Holds `message` back until `batch` is durable; [`Keeper::released`] then returns it.
    pub(crate) fn hold(&mut self, batch: u64, message: T) {
        self.waiting.push_back((batch, message));
    }

    /// Gives up the messages that are held back.
    pub(crate) fn forget_waiting(&mut self) {
        self.waiting.clear();
    }

    /// The next message that may leave. After a failure none may, for it is not known which batches the disk has.
    pub(crate) fn released(&mut self) -> Option<T> {
        let (batch, _) = self.waiting.front()?;
        let free = match &self.ledger {
            None => true,
            Some(ledger) if self.failure.is_some() || ledger.failure().is_some() => false,
            Some(ledger) => ledger.may_leave(*batch),
        };
        if free { self.waiting.pop_front().map(|(_, message)| message) } else { None }
    }

    /// Why no more changes can be written, if that is so.
    pub(crate) fn failure(&mut self) -> Option<StoreError> {
        // The failure that the writing thread reports is the cause of the one that `keep` met.
        let thread = self.ledger.as_ref().and_then(Ledger::failure);
        thread.or_else(|| self.failure.take())
    }
}

impl<T> Keeper<T> {
    /// How memory is kept, for `status`; none when it is in RAM only.
    pub(crate) fn storage(&self) -> Option<StorageStatus> {
        let store = self.ledger.as_ref()?;
        Some(StorageStatus {
            directory: store.directory().display().to_string(),
            durability: match store.durability() {
                Durability::Strict => pschema_inspect::Durability::Strict,
                Durability::Relaxed => pschema_inspect::Durability::Relaxed,
            },
            durable_step: store.durable_step(),
            changes_waiting: store.unconfirmed(),
            journal_bytes: store.journal_bytes(),
            oldest_step: store.oldest_step(),
            snapshot_step: store.snapshot_step(),
        })
    }

    /// Writes all that is left to be written, for which the disk has [`FINISH_MAX`]. Returns the messages that waited for it, which
    /// may now leave.
    pub(crate) fn finish(mut self, memory: &Memory) -> Result<impl Iterator<Item = T>, StoreError> {
        if let Some(store) = self.ledger.take()
            && store.finish_within(memory, FINISH_MAX)? == Ending::WithoutSnapshot
        {
            tracing::warn!(
                "there was no time for a last snapshot: the next start reads the journal, which has all"
            );
        }
        Ok(self.waiting.into_iter().map(|(_, message)| message))
    }
}

#[cfg(test)]
mod tests {
    use pschema_learner::parameters::Parameters;
    use pschema_learner::progress::StageEffect;

    use super::*;

    /// A disk that confirms what the test says.
    #[derive(Default)]
    struct TestDisk {
        appended: u64,
        durable: u64,
        relaxed: bool,
        full: bool,
        failed: bool,
    }

    impl Ledger for TestDisk {
        fn append(&mut self, _: &Change<'_>, _: &Content) -> Result<u64, StoreError> {
            if self.full {
                return Err(StoreError::Failed("full".to_owned()));
            }
            self.appended += 1;
            Ok(self.appended)
        }

        fn may_leave(&self, batch: u64) -> bool {
            self.relaxed || self.durable >= batch
        }

        fn failure(&self) -> Option<StoreError> {
            self.failed.then(|| StoreError::Failed("not confirmed".to_owned()))
        }
    }

    type TestKeeper = Keeper<&'static str, TestDisk>;

    fn keep(keeper: &mut TestKeeper, cause: Cause<'_>, message: &'static str) {
        let memory = Memory::new(1, Parameters::default());
        let batch = keeper.keep(cause, &[Effect::Stage(StageEffect::Held(true))], memory.content());
        keeper.hold(batch, message);
    }

    fn released(keeper: &mut TestKeeper) -> Vec<&'static str> {
        std::iter::from_fn(|| keeper.released()).collect()
    }

    fn sync(keeper: &mut TestKeeper, durable: u64) -> Vec<&'static str> {
        if let Some(disk) = &mut keeper.ledger {
            disk.durable = durable;
        }
        released(keeper)
    }

    /// Replies to two bodies, answers to two orders, and between them the answer to an order that changed nothing more.
    fn several(keeper: &mut TestKeeper) {
        keep(keeper, Cause::Declared("left"), "to the left body");
        keep(keeper, Cause::Declared("right"), "to the right body");
        keep(keeper, Cause::Order("stage hold"), "to an order");
        keeper.hold(3, "to the order given again");
        keep(keeper, Cause::Order("cancel 1"), "to another order");
    }

    #[test]
    fn nothing_leaves_before_it_is_durable_and_then_in_order() {
        let mut keeper = TestKeeper::new(Some(TestDisk::default()));
        several(&mut keeper);
        assert!(released(&mut keeper).is_empty());
        assert_eq!(sync(&mut keeper, 1), ["to the left body"]);
        assert_eq!(sync(&mut keeper, 3), ["to the right body", "to an order", "to the order given again"]);
        assert!(released(&mut keeper).is_empty() && keeper.failure().is_none());
        assert_eq!(sync(&mut keeper, 4), ["to another order"]);
    }

    #[test]
    fn nothing_leaves_after_a_failure() {
        let mut keeper = TestKeeper::new(Some(TestDisk { failed: true, durable: 1, ..TestDisk::default() }));
        several(&mut keeper);
        assert!(released(&mut keeper).is_empty());
        assert!(keeper.failure().is_some_and(|error| error.to_string().contains("not confirmed")));
        let mut keeper = TestKeeper::new(Some(TestDisk::default()));
        keep(&mut keeper, Cause::Declared("left"), "written");
        if let Some(disk) = &mut keeper.ledger {
            disk.full = true;
        }
        several(&mut keeper);
        assert!(sync(&mut keeper, 1).is_empty(), "what the disk has is not known");
        assert!(keeper.failure().is_some_and(|error| error.to_string().contains("full")));
    }

    #[test]
    fn without_a_disk_to_wait_for_all_leaves_at_once() {
        for ledger in [None, Some(TestDisk { relaxed: true, ..TestDisk::default() })] {
            let mut keeper = TestKeeper::new(ledger);
            several(&mut keeper);
            assert_eq!(released(&mut keeper).len(), 5);
        }
    }
}
