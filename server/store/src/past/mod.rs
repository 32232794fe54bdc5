//! The past of a memory, read from its data directory, beside a daemon or without one. Nothing is changed.
//!
//! [`Past::open`] reads only the manifest. Everything else is found by replaying the journal from a snapshot or from the
//! beginning, with the code that a daemon's start uses.

mod cut;
mod entry;
mod error;
pub mod export;
mod making;
mod moment;
mod relearn;
mod repair;
mod scan;
#[cfg(test)]
pub(crate) mod tests;
mod verify;

pub use entry::{Batch, BatchCause, EffectCount, EffectText};
pub use error::PastError;
pub use making::{DataDirectory, import};
pub use moment::{Moment, Past};
pub use repair::{RepairOutcome, RepairPlan};
pub use scan::{Files, SegmentFile, SnapshotFile, Tail};
pub use verify::{Finding, Verification, VerificationProgress};
