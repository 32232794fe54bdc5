//! The trace of the learner's steps, page by page.

use pschema_inspect::codec::{MESSAGE_BYTES_MAX, Problem};
use pschema_inspect::{TraceDecision, TracePage, TraceQuery, TraceRecord};
use pschema_learner::decision::Reason;
use pschema_learner::notation;
use pschema_learner::observation::{Observation, TypeId, Value};
use pschema_learner::vocabulary::Vocabulary;

use super::question::Inspect;
use super::text;
use crate::trace::{Decided, RECORDS_KEPT_MAX, Record};
use crate::view::View;

/// Records in one page.
pub(crate) const PAGE_MAX: usize = 256;
/// No record is longer: 16 observations of 8 properties, each with names of at most 64 bytes, all of them words, and each
/// of their letters a quotation mark, which JSON writes as two. The reason of a failure adds less than 2 KiB.
const RECORD_BYTES_MAX: usize = 48 * 1024;

// The rest is room for the names of the stages.
const _: () = assert!(PAGE_MAX * RECORD_BYTES_MAX <= MESSAGE_BYTES_MAX / 4 * 3);

impl Inspect for TraceQuery {
    fn answer(&self, view: &View) -> Result<TracePage, Problem> {
        Ok(page(view, self.from))
    }
}

/// The records from the number `from` on.
pub(super) fn page(view: &View, from: u64) -> TracePage {
    let vocabulary = &view.content.vocabulary;
    let (from, records) = view.account.trace.from(from, PAGE_MAX);
    TracePage {
        from,
        total: view.account.trace.total(),
        kept_max: RECORDS_KEPT_MAX as u64,
        stages: view.setup.curriculum.stages.iter().map(|stage| stage.name.clone()).collect(),
        records: records.map(|one| record(vocabulary, one)).collect(),
    }
}

fn record(vocabulary: &Vocabulary, from: &Record) -> TraceRecord {
    TraceRecord {
        step: from.step,
        stage: u32::try_from(from.stage).unwrap_or(u32::MAX),
        trial: from.trial,
        drawn: from.drawn.clone(),
        trial_met: from.trial_met,
        actions: from.actions,
        schemas_total: from.schemas_total,
        schemas_generalised: from.schemas_generalised,
        failure: from.failure.as_deref().cloned(),
        perceived: from.perceived.iter().map(|one| text::observation(vocabulary, one)).collect(),
        heard: from.perceived.iter().flat_map(|one| heard(vocabulary, one)).collect(),
        decision: from.decision.as_ref().map(|decided| decision(vocabulary, decided)),
        quiet_actions: from.quiet_actions,
        habituating: from.habituating,
        latency_us: from.latency.as_secs_f64() * 1e6,
    }
}

/// The symbols of an observation that comes from others, such as a word; none of any other observation.
fn heard(vocabulary: &Vocabulary, observation: &Observation) -> Vec<String> {
    let kind = vocabulary.types().get(usize::from(observation.kind().0));
    if !kind.is_some_and(|kind| kind.declared.heard) {
        return Vec::new();
    }
    let symbols = observation.properties().iter().filter(|(_, value)| matches!(value, Value::Symbol(_)));
    symbols.map(|(property, value)| notation::value(vocabulary, *property, *value)).collect()
}

fn decision(vocabulary: &Vocabulary, from: &Decided) -> TraceDecision {
    let name = |kind: &TypeId| {
        vocabulary.types().get(usize::from(kind.0)).map(|kind| kind.declared.name.clone()).unwrap_or_default()
    };
    let mut predicts: Vec<_> = from.predicts.iter().map(name).collect();
    predicts.sort_unstable();
    TraceDecision {
        excitation_top: from.excitation_top,
        excitation: from.excitation,
        schema: from.schema.map(|schema| schema.0),
        generalised: from.generalised,
        distance: from.distance,
        action: notation::primitive(vocabulary, from.action),
        reason: reason(from.reason),
        predicts,
    }
}

/// The reason of a choice, for tools.
pub(super) fn reason(reason: Reason) -> pschema_inspect::Reason {
    match reason {
        Reason::Excitation => pschema_inspect::Reason::Excitation,
        Reason::Tie => pschema_inspect::Reason::Tie,
        Reason::Chain => pschema_inspect::Reason::Chain,
        Reason::Goal => pschema_inspect::Reason::Goal,
    }
}
