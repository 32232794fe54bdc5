//! All that is known of a run when it is over.

use pschema_inspect::Report;
use pschema_server::config;

use crate::failure::Failure;
use crate::learner::Asks;

use super::experiment::Condition;
use super::figures::Figures;
use super::learnt::Learnt;
use super::measures::Read;
use super::trace::Trace;

/// All that is known of a run.
#[derive(Clone, Debug)]
pub(crate) struct Outcome {
    /// What it is judged by.
    pub(crate) figures: Figures,
    /// Every step.
    pub(crate) trace: Trace,
    /// What it left in memory.
    pub(crate) learnt: Learnt,
}

impl Outcome {
    /// Asks for what is still to be known of a run that is over.
    pub(super) fn ask(
        told: &config::Experiment,
        condition: &Condition,
        report: &Report,
        mut trace: Trace,
        wall_s: f64,
        asked: &mut impl Asks,
    ) -> Result<Self, Failure> {
        trace.fetch(asked, told)?;
        let measures = Read { told, report, trace: &trace }.measures(asked)?;
        let figures = Figures::new(told, condition, report, measures, wall_s);
        Ok(Self { figures, trace, learnt: Learnt::ask(asked)? })
    }
}
