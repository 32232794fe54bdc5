//! The answer for those who watch. Its cost does not grow with the number of schemas, only with the number of different
//! observations that they refer to, which are few.

use std::collections::{BTreeMap, BTreeSet};

use pschema_inspect::codec::Problem;
use pschema_inspect::{
    Candidate, ExcitationTerm, Live, LiveQuery, SchemaSummary, TermRole, WorldObservation,
};
use pschema_learner::observation::Observation;

use super::question::Inspect;
use super::{explain, schemas, status, text, trace};
use crate::view::View;

/// Schemas in one answer.
const NEWEST_MAX: u32 = 100;
/// Candidates in one answer.
const CANDIDATES_MAX: u32 = 32;
/// Observations of the world state in one answer: no screen shows more.
const PERCEIVED_MAX: usize = 256;

impl Inspect for LiveQuery {
    fn answer(&self, view: &View) -> Result<Live, Problem> {
        let candidates_max = self.candidates_max.clamp(1, CANDIDATES_MAX);
        let decision = explain::decision(view, None).ok();
        let mut explanation =
            decision.map(|decision| explain::explanation(&view.content, decision, candidates_max));
        let terms_max = usize::try_from(self.terms_max).unwrap_or(usize::MAX);
        for candidate in explanation.iter_mut().flat_map(|explanation| &mut explanation.candidates) {
            summarise(candidate, terms_max);
        }
        let mut status = status::status(view);
        status.world.truncate(PERCEIVED_MAX);
        Ok(Live {
            status,
            observations: observations(view),
            explanation,
            newest: newest(view, self.newest_max),
            trace: trace::page(view, self.trace_from),
        })
    }
}

/// Keeps the greatest terms and adds the others up to one. Their sum stays the excitation times the distance.
fn summarise(candidate: &mut Candidate, terms_max: usize) {
    if candidate.terms.len() <= terms_max {
        return;
    }
    candidate.terms.sort_by(|a, b| b.value.total_cmp(&a.value));
    let value: f64 = candidate.terms.drain(terms_max..).map(|term| term.value).sum();
    candidate.terms.push(ExcitationTerm {
        observation: None,
        seen: None,
        role: TermRole::Rest,
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

/// The observations of the world state, each with whether it is new and how often it had attention.
fn observations(view: &View) -> Vec<WorldObservation> {
    let Some(senses) = &view.senses else { return Vec::new() };
    let perceived = &senses.last.observations;
    let content = &view.content;
    let shown = &perceived[..perceived.len().min(PERCEIVED_MAX)];
    let before: BTreeSet<&Observation> = senses.before.observations.iter().collect();
    let mut wanted: BTreeMap<&Observation, u32> = shown.iter().map(|one| (one, 0)).collect();
    let mut unknown = wanted.len();
    // Memory's index of observations is private to the learner, so its list is searched.
    for (known, count) in content.observations.iter().zip(content.attention.iter()) {
        if unknown == 0 {
            break;
        }
        if let Some(attention) = wanted.get_mut(known) {
            *attention = *count;
            unknown -= 1;
        }
    }
    let told = |one: &Observation| WorldObservation {
        observation: text::observation(&content.vocabulary, one),
        new: !before.contains(one),
        attention: wanted.get(one).copied().unwrap_or_default(),
    };
    shown.iter().map(told).collect()
}
