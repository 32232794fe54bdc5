//! All that is known of a run when it is over.

use pschema_inspect::Report;

use crate::design::Design;
use crate::failure::Failure;
use crate::learner::Asks;

use super::experiment::Condition;
use super::knowledge::Knowledge;
use super::readings::Reader;
use super::results::Results;
use super::trace::Trace;

/// All that is known of a run.
#[derive(Clone, Debug)]
pub(crate) struct Outcome {
    /// What it is judged by.
    pub(crate) results: Results,
    /// Every step.
    pub(crate) trace: Trace,
    /// What it left in memory.
    pub(crate) learnt: Knowledge,
}

impl Outcome {
    /// Asks for what is still to be known of a run that is over.
    pub(super) fn ask(
        design: &Design,
        condition: &Condition,
        report: &Report,
        mut trace: Trace,
        wall_s: f64,
        asked: &mut impl Asks,
    ) -> Result<Self, Failure> {
        trace.fetch(asked, design)?;
        let readings = Reader { design, report, trace: &trace }.readings(asked)?;
        let results = Results::new(design, condition, report, readings, wall_s);
        Ok(Self { results, trace, learnt: Knowledge::ask(asked)? })
    }
}
