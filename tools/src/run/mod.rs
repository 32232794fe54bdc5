//! Whole runs: a daemon and a body started, watched to the end of their curriculum, and ended.

mod child;
mod experiment;
mod figures;
mod in_process;
mod pair;
mod progress;
mod published;
mod seeds;
mod signals;

pub(crate) use child::{follow_parent, is_orphan, remove_orphaned};
pub(crate) use experiment::Experiment;
pub(crate) use figures::Figures;
pub(crate) use in_process::in_process;
pub(crate) use pair::Pair;
pub(crate) use progress::Progress;
pub(crate) use published::Published;
pub(crate) use seeds::Seeds;
pub(crate) use signals::Stop;

/// Made-up reports, for tests of whatever reads them.
#[cfg(test)]
pub(crate) use figures::tests;
