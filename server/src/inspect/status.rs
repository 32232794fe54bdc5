//! The status of the daemon and its learner, and the report of the curriculum.

use std::collections::BTreeMap;

use pschema_inspect::codec::Problem;
use pschema_inspect::{Report, ReportQuery, StageSummary, Status, StatusQuery};
use pschema_learner::digest::digest;
use pschema_learner::progress::StageReport;

use super::question::Inspect;
use super::{goals, stage};
use crate::growth::resident_bytes;
use crate::mind::View;

impl Inspect for StatusQuery {
    fn answer(&self, view: &View) -> Result<Status, Problem> {
        Ok(Status { memory_digest: Some(digest(&view.content)), ..status(view) })
    }
}

impl Inspect for ReportQuery {
    fn answer(&self, view: &View) -> Result<Report, Problem> {
        Ok(report(view))
    }
}

/// The status without the digest of memory, which takes time in proportion to memory.
pub(super) fn status(view: &View) -> Status {
    let (total, concrete, generalised) = counts(view);
    Status {
        name: view.host.name.clone(),
        pid: std::process::id(),
        uptime_s: view.uptime_s,
        step: view.content.step,
        durable_step: view.host.storage.as_ref().map(|storage| storage.durable_step),
        storage: view.host.storage.clone(),
        curriculum: view.curriculum.name.clone(),
        stage: stage_name(view),
        stage_state: view.state.clone(),
        saturation: stage::saturation(view),
        habituation: stage::habituation(view),
        trial: stage::trial(view),
        schemas_total: total,
        schemas_concrete: concrete,
        schemas_generalised: generalised,
        bodies: view.host.bodies.clone(),
        steps_per_s: view.steps_per_s,
        step_latency_us_p50: view.latencies.recent_us(0.5),
        step_latency_us_p99: view.latencies.recent_us(0.99),
        commit_latency_us_p50: view.commits.recent_us(0.5),
        commit_latency_us_p99: view.commits.recent_us(0.99),
        memory_bytes: resident_bytes(),
        growth: view.growth.rows(),
        memory_digest: None,
        excitation_top: excitation_top(view),
        world: view.host.world.clone(),
        goal: goals::summary(view),
        refused: view.host.refused.clone(),
    }
}

/// The report of what the curriculum has done so far.
#[must_use]
pub fn report(view: &View) -> Report {
    let progress = &view.content.progress;
    let (total, concrete, generalised) = counts(view);
    let learning: BTreeMap<&str, bool> =
        view.curriculum.stages.iter().map(|stage| (stage.name.as_str(), stage.learning)).collect();
    let summary = |report: &StageReport| StageSummary {
        name: report.name.clone(),
        learning: learning.get(report.name.as_str()).copied().unwrap_or(true),
        actions: report.actions,
        schemas_new: report.concrete_new.saturating_add(report.generalised_new),
        generalised_new: report.generalised_new,
        counter_examples_new: report.counter_examples_new,
        trials: report.trials,
        trials_met: report.trials_met,
        trials_met_first: report.trials_met_first,
        generalised_after_trial: report.generalised_after_trial.clone(),
        actions_of_trial: report.actions_of_trial.clone(),
        drawn: report.drawn.clone(),
        saturated: report.saturated,
        ended: report.ended,
    };
    Report {
        curriculum: view.curriculum.name.clone(),
        seed: view.seed,
        stage: stage_name(view),
        stage_state: view.state.clone(),
        finished: progress.finished,
        stuck: view.stuck.clone(),
        step: view.content.step,
        schemas_total: total,
        schemas_concrete: concrete,
        schemas_generalised: generalised,
        actions_total: progress.reports.iter().map(|report| report.actions).sum(),
        step_latency_us_p50: view.latencies.all_us(0.5),
        step_latency_us_p99: view.latencies.all_us(0.99),
        memory_digest: (progress.finished || view.stuck.is_some()).then(|| digest(&view.content)),
        stages: progress.reports.iter().map(summary).collect(),
    }
}

/// The numbers of all schemas, of concrete and of generalised ones.
fn counts(view: &View) -> (u32, u32, u32) {
    let total = u32::try_from(view.content.schemas.len()).unwrap_or(u32::MAX);
    let generalised = view.content.generalised_count;
    (total, total.saturating_sub(generalised), generalised)
}

fn stage_name(view: &View) -> String {
    let progress = &view.content.progress;
    let first = || view.curriculum.stages.first().map(|stage| stage.name.clone());
    progress.report().map(|report| report.name.clone()).or_else(first).unwrap_or_default()
}

fn excitation_top(view: &View) -> f64 {
    let last = view.decisions.last();
    last.and_then(|decision| decision.candidates.first()).map_or(0.0, |candidate| candidate.excitation)
}
