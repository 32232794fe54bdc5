//! A body, as its author sees it: describe yourself, sense, act. [`run()`] is the whole life of a body
//! process around it; [`BodyLoop`] is the same without a process or shared memory.

mod driver;
mod interface;
mod run;
mod senses;

pub use driver::{BodyLoop, Directive};
pub use interface::Body;
pub use run::{RunEnding, RunError, RunOptions, RunSummary, run, run_from_args};
pub use senses::Senses;

pub use crate::outcome::Outcome;
