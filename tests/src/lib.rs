//! The harness of the system tests, which start real processes.
//!
//! Every test lives in a [`Sandbox`] of its own: a private runtime directory, so that tests run beside each other and
//! beside daemons of yours. No test sleeps in the hope that an event has happened by then: [`until`] looks
//! for the event, again and again, up to a deadline.

pub mod fuzz;
mod leftovers;
mod page;
mod process;
mod resources;
mod row;
mod sandbox;

use std::thread;
use std::time::{Duration, Instant};

pub use leftovers::{Leftovers, demo_directory, processes_with};
pub use page::{Block, Page};
pub use process::{ChildProcess, ProcessOutput, signal_process};
pub use resources::{descriptors, own_memory, prefix_of, shared_files};
pub use row::{FIELDS, Row};
pub use sandbox::Sandbox;

/// How long anything may take before a test gives up on it. Runs take seconds; this is for machines under load.
pub const DEADLINE: Duration = Duration::from_secs(120);

/// Calls `look` again and again until it finds a value, and returns the value.
///
/// # Panics
/// With `what` in the message when there is no value after [`DEADLINE`].
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

/// How often a test does something: `by_default`, or the number in the environment variable `name`, for a run by hand.
///
/// # Panics
/// When the variable is no number.
#[must_use]
pub fn count(name: &str, by_default: u64) -> u64 {
    let Ok(given) = std::env::var(name) else { return by_default };
    given.parse().unwrap_or_else(|error| panic!("{name}={given}: {error}"))
}
