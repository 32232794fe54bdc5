//! Whole runs: a daemon and a body started, watched to the end of their curriculum, and ended.

mod any_body;
mod body;
mod child;
mod experiment;
mod figures;
mod in_process;
mod learnt;
mod many;
mod measures;
mod outcome;
mod pair;
mod progress;
mod seeds;
mod trace;

pub use child::{Child, follow_parent};
pub(crate) use child::{is_orphan, remove_orphaned};
pub(crate) use experiment::{Asked, Condition, Experiment};
pub(crate) use figures::Figures;
pub(crate) use learnt::Learnt;
pub(crate) use many::{How, Job, carry_out};
pub(crate) use measures::{Measure, Unit};
pub(crate) use outcome::Outcome;
pub(crate) use pair::Pair;
pub use pair::runtime_directory;
pub(crate) use progress::{Bars, Progress};
pub(crate) use seeds::Seeds;
#[cfg(test)]
pub(crate) use trace::Decided;
pub(crate) use trace::{Row, Trace, Trial};

/// Made-up reports, for tests of whatever reads them.
#[cfg(test)]
pub(crate) use figures::tests;
