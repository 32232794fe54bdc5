//! Memory and decisions as answers to tools. Pure: a view in, an answer out; lists are filtered, ordered and
//! cut here, so that no answer is longer than a tool asked for.

mod explain;
mod goals;
mod graph;
mod live;
mod schemas;
mod stage;
mod text;
mod trace;
mod why_not;

use std::collections::BTreeMap;

use pschema_inspect::{Answer, Report, Request, StageSummary, Status};
use pschema_learner::digest::digest;
use pschema_learner::progress::StageReport;

use crate::growth::resident_bytes;
use crate::mind::View;

pub(crate) use goals::NO_BODY;

/// Schemas in one list.
pub const LIST_MAX: u32 = 10_000;

/// The answer to a question. Orders are not obeyed here: a daemon does so before it asks.
#[must_use]
pub fn answer(view: &View, request: &Request) -> Answer {
    match request {
        Request::Status => Answer::Status(Box::new(status(view))),
        Request::Schemas(query) => match schemas::list(view, query) {
            Ok(list) => Answer::Schemas(list),
            Err(problem) => Answer::Error(problem),
        },
        Request::Show { id } => match schemas::detail(view, *id) {
            Some(detail) => Answer::Schema(Box::new(detail)),
            None => Answer::Error(no_schema(view, *id)),
        },
        Request::Explain { step, candidates_max } => match explain::explain(view, *step, *candidates_max) {
            Ok(explanation) => Answer::Explanation(Box::new(explanation)),
            Err(problem) => Answer::Error(problem),
        },
        Request::Report | Request::Say { .. } | Request::Stage(_) => Answer::Report(Box::new(report(view))),
        Request::Shutdown => Answer::Done,
        Request::Trace { from } => Answer::Trace(Box::new(trace::page(view, *from))),
        Request::Predict { action } => match goals::predict(view, action) {
            Ok(prediction) => Answer::Prediction(Box::new(prediction)),
            Err(problem) => Answer::Error(problem),
        },
        Request::Plan { goal } => match goals::plan(view, goal) {
            Ok(plan) => Answer::Plan(Box::new(plan)),
            Err(problem) => Answer::Error(problem),
        },
        Request::Live(query) => Answer::Live(Box::new(live::live(view, query))),
        Request::Achieve { .. } | Request::Pursuit | Request::Cancel { .. } => match goals::pursuit(view) {
            Ok(pursuit) => Answer::Pursuit(Box::new(pursuit)),
            Err(problem) => Answer::Error(problem),
        },
        Request::Graph(query) => match graph::graph(view, query) {
            Ok(graph) => Answer::Graph(Box::new(graph)),
            Err(problem) => Answer::Error(problem),
        },
        Request::WhyNot { schema, step } => match why_not::why_not(view, *schema, *step) {
            Ok(why) => Answer::WhyNot(Box::new(why)),
            Err(problem) => Answer::Error(problem),
        },
    }
}

fn no_schema(view: &View, id: u32) -> String {
    match view.content.schemas.len() {
        0 => format!("there is no schema {id}: nothing has been learnt yet"),
        count => format!("there is no schema {id}: they are numbered 0 to {}", count - 1),
    }
}

/// How the daemon and its learner are.
fn status(view: &View) -> Status {
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
        memory_digest: digest(&view.content),
        excitation_top: excitation_top(view),
        world: view.host.world.clone(),
        goal: goals::summary(view),
        refused: view.host.refused.clone(),
    }
}

/// What the curriculum has done so far.
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

/// Schemas in all, concrete and generalised.
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
