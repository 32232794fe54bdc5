//! The status of the daemon and its learner, and the report of the curriculum.

use std::collections::BTreeMap;

use pschema_inspect::codec::Problem;
use pschema_inspect::{Report, ReportQuery, StageSummary, Status, StatusQuery};
use pschema_learner::digest::digest;
use pschema_learner::progress::StageReport;

use super::question::Inspect;
use super::{goals, stage};
use crate::resident;
use crate::view::View;

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
        name: view.name.to_string(),
        pid: std::process::id(),
        uptime_s: view.uptime_s(),
        step: view.content.step,
        durable_step: view.storage().map(|storage| storage.durable_step),
        storage: view.storage().cloned(),
        profile: view.content.mechanisms.profile(),
        curriculum: view.setup.curriculum.name.clone(),
        stage: stage_name(view),
        stage_state: view.state(),
        saturation: stage::saturation(view),
        habituation: stage::habituation(view),
        trial: stage::trial(view),
        schemas_total: total,
        schemas_concrete: concrete,
        schemas_generalised: generalised,
        bodies: view.bodies(),
        steps_per_s: view.steps_per_s(),
        step_latency_us_p50: view.account.latencies.recent_us(0.5),
        step_latency_us_p99: view.account.latencies.recent_us(0.99),
        commit_latency_us_p50: view.account.commits.recent_us(0.5),
        commit_latency_us_p99: view.account.commits.recent_us(0.99),
        memory_bytes: resident::bytes(),
        memory_max_bytes: view.memory_max(),
        memory_full: view.content.full,
        growth: view.account.growth.rows(),
        memory_digest: None,
        excitation_top: excitation_top(view),
        world: view.world(),
        goal: goals::summary(view),
        refused: view.refusals(),
        log_lines_lost: pschema_process::lost_lines(),
    }
}

/// The report of what the curriculum has done so far.
#[must_use]
pub fn report(view: &View) -> Report {
    let progress = &view.content.progress;
    let (total, concrete, generalised) = counts(view);
    let stuck = view.stuck();
    let learning: BTreeMap<&str, bool> =
        view.setup.curriculum.stages.iter().map(|stage| (stage.name.as_str(), stage.learning)).collect();
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
        curriculum: view.setup.curriculum.name.clone(),
        seed: view.setup.seed,
        stage: stage_name(view),
        stage_state: view.state(),
        finished: progress.finished,
        stuck: stuck.clone(),
        step: view.content.step,
        schemas_total: total,
        schemas_concrete: concrete,
        schemas_generalised: generalised,
        actions_total: progress.reports.iter().map(|report| report.actions).sum(),
        step_latency_us_p50: view.account.latencies.all_us(0.5),
        step_latency_us_p99: view.account.latencies.all_us(0.99),
        memory_digest: (progress.finished || stuck.is_some()).then(|| digest(&view.content)),
        stages: progress.reports.iter().map(|report| summary(report)).collect(),
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
    let first = || view.setup.curriculum.stages.first().map(|stage| stage.name.clone());
    progress.report().map(|report| report.name.clone()).or_else(first).unwrap_or_default()
}

fn excitation_top(view: &View) -> f64 {
    let last = view.decisions.back();
    last.and_then(|decision| decision.candidates.first()).map_or(0.0, |candidate| candidate.excitation)
}
