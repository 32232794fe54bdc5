//! Whole runs: a daemon and a body started, watched to the end of their curriculum, and ended.

mod any_body;
mod body;
mod child;
mod experiment;
mod in_process;
mod knowledge;
mod many;
mod names;
mod outcome;
mod pair;
mod progress;
mod readings;
mod results;
mod seeds;
mod trace;

pub use child::{Child, follow_parent};
pub(crate) use child::{is_orphan, remove_orphaned};
pub(crate) use experiment::{Condition, Experiment, Overrides};
pub(crate) use knowledge::Knowledge;
pub(crate) use many::{Job, Schedule, carry_out};
pub(crate) use outcome::Outcome;
pub(crate) use pair::Pair;
pub use pair::runtime_directory;
pub(crate) use progress::{Bars, Progress};
pub(crate) use readings::{Reading, Unit};
pub(crate) use results::Results;
pub use seeds::Seeds;
pub(crate) use trace::{Trace, TracedStep, Trial};

/// Made-up reports, for tests of whatever reads them.
#[cfg(test)]
pub(crate) use results::tests;
