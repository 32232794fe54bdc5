//! The part of a work that is counted. Whatever a process does outside of it is set-up and is not counted.

use allocation_counter::AllocationInfo;
use serde::{Deserialize, Serialize};

/// What was counted in all rounds of a work, and how the rounds ended.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Tally {
    pub(crate) rounds: u64,
    pub(crate) allocations: u64,
    pub(crate) allocated_bytes: u64,
    /// A number that follows from everything the work did: it tells whether the work is the same each time.
    pub(crate) result: u64,
}

/// The name of the function under which callgrind counts. It must occur in no other function's name.
pub(crate) const REGION: &str = "counted_region";

/// Does one round of a work, and counts it.
pub(crate) fn counted<T>(tally: &mut Tally, round: impl FnOnce() -> T) -> T {
    let mut result = None;
    let AllocationInfo { count_total, bytes_total, .. } =
        allocation_counter::measure(|| result = Some(counted_region(round)));
    tally.rounds += 1;
    tally.allocations += count_total;
    tally.allocated_bytes += bytes_total;
    result.unwrap_or_else(|| unreachable!("a round was done"))
}

/// Callgrind begins to count when this function is entered, and stops when it is left.
#[inline(never)]
fn counted_region<T>(round: impl FnOnce() -> T) -> T {
    round()
}
