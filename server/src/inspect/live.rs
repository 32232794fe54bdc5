//! What somebody who watches is shown. Its cost does not grow with the schemas, only with the different observations that
//! they refer to, which are few.

use std::collections::{BTreeMap, BTreeSet};

use pschema_inspect::{Candidate, ExcitationTerm, Live, LiveQuery, Perceived, SchemaSummary};
use pschema_learner::notation;
use pschema_learner::observation::Observation;

use super::{counts, explain, goals, schemas, stage, stage_name, text, trace};
use crate::growth::resident_bytes;
use crate::mind::View;

/// Schemas in one answer.
const NEWEST_MAX: u32 = 100;
/// Candidates in one answer.
const CANDIDATES_MAX: u32 = 32;
/// Observations of the world state in one answer: more are on no screen.
const PERCEIVED_MAX: usize = 256;

/// A learner at one moment.
pub(super) fn live(view: &View, query: &LiveQuery) -> Live {
    let (schemas_total, _, schemas_generalised) = counts(view);
    let candidates_max = query.candidates_max.clamp(1, CANDIDATES_MAX);
    let mut explanation = explain::explain(view, None, candidates_max).ok();
    let terms_max = usize::try_from(query.terms_max).unwrap_or(usize::MAX);
    for candidate in explanation.iter_mut().flat_map(|explanation| &mut explanation.candidates) {
        summarise(candidate, terms_max);
    }
    Live {
        name: view.host.name.clone(),
        uptime_s: view.uptime_s,
        step: view.content.step,
        durable_step: view.host.storage.as_ref().map(|storage| storage.durable_step),
        curriculum: view.curriculum.name.clone(),
        stage: stage_name(view),
        stage_state: view.state.clone(),
        saturation: stage::saturation(view),
        habituation: stage::habituation(view),
        trial: stage::trial(view),
        goal: goals::summary(view),
        schemas_total,
        schemas_generalised,
        steps_per_s: view.steps_per_s,
        step_latency_us_p50: view.latencies.recent_us(0.5),
        step_latency_us_p99: view.latencies.recent_us(0.99),
        commit_latency_us_p50: view.commits.recent_us(0.5),
        commit_latency_us_p99: view.commits.recent_us(0.99),
        memory_bytes: resident_bytes(),
        bodies: view.host.bodies.clone(),
        world: world(view),
        explanation,
        newest: newest(view, query.newest_max),
        trace: trace::page(view, query.trace_from),
    }
}

/// Keeps the greatest terms, and adds the others up as one. The sum stays the excitation times the distance.
fn summarise(candidate: &mut Candidate, terms_max: usize) {
    if candidate.terms.len() <= terms_max {
        return;
    }
    candidate.terms.sort_by(|a, b| b.value.total_cmp(&a.value));
    let value: f64 = candidate.terms.drain(terms_max..).map(|term| term.value).sum();
    candidate.terms.push(ExcitationTerm {
        observation: None,
        seen: None,
        role: "rest".to_owned(),
        shared: 0,
        attention: 0,
        probability: 0.0,
        weight: 0.0,
        value,
    });
}

fn newest(view: &View, max: u32) -> Vec<SchemaSummary> {
    let count = u32::try_from(view.content.schemas.len()).unwrap_or(u32::MAX);
    let newest = (0..count).rev().take(max.min(NEWEST_MAX) as usize);
    newest.filter_map(|id| schemas::line(&view.content, id)).collect()
}

/// What is perceived, and what of it was not in the frame before.
fn world(view: &View) -> Vec<Perceived> {
    let Some((_, perceived)) = &view.host.perceived else { return Vec::new() };
    let content = &view.content;
    let shown = &perceived[..perceived.len().min(PERCEIVED_MAX)];
    let before: BTreeSet<&Observation> = view.host.before.iter().collect();
    let mut wanted: BTreeMap<&Observation, u32> = shown.iter().map(|one| (one, 0)).collect();
    let mut unknown = wanted.len();
    // The index of observations is the learner's alone.
    for (known, count) in content.observations.iter().zip(content.attention.iter()) {
        if unknown == 0 {
            break;
        }
        if let Some(attention) = wanted.get_mut(known) {
            *attention = *count;
            unknown -= 1;
        }
    }
    let perceived = |one: &Observation| Perceived {
        observation: text::observation(&content.vocabulary, one),
        text: notation::observation(&content.vocabulary, one),
        new: !before.contains(one),
        attention: wanted.get(one).copied().unwrap_or_default(),
    };
    shown.iter().map(perceived).collect()
}
