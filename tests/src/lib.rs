//! System tests on real processes: this is their harness.
//!
//! Every test lives in a [`House`] of its own: a private runtime directory, so that tests run beside each other and
//! beside daemons of yours. Nothing here sleeps in the hope that something has happened by then: [`until`] looks
//! for it, again and again, up to a deadline.

mod facts;
pub mod fuzz;
mod house;
mod page;
mod process;
mod row;
mod traces;

use std::thread;
use std::time::{Duration, Instant};

pub use facts::{descriptors, own_memory, prefix_of, shared_files};
pub use house::House;
pub use page::{Block, Page};
pub use process::{Finished, Running, signal_process};
pub use row::{FIELDS, Row};
pub use traces::{Traces, demo_directory, processes_with};

/// How long anything may take before a test gives up on it. Runs take seconds; this is for machines under load.
pub const DEADLINE: Duration = Duration::from_secs(120);

/// Looks until there is something to see, and returns it.
///
/// # Panics
/// With `what` when there is still nothing after [`DEADLINE`].
pub fn until<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(seen) = look() {
            return seen;
        }
        assert!(start.elapsed() < DEADLINE, "{what}: not within {DEADLINE:?}");
        thread::sleep(Duration::from_millis(10));
    }
}

/// How often a test does something: `by_default`, or what the environment variable `name` says for a run by hand.
///
/// # Panics
/// When the variable is no number.
#[must_use]
pub fn count(name: &str, by_default: u64) -> u64 {
    let Ok(given) = std::env::var(name) else { return by_default };
    given.parse().unwrap_or_else(|error| panic!("{name}={given}: {error}"))
}
