//! A record of each of the last steps, which the figures of experiments are drawn from.

use std::sync::Arc;
use std::time::Duration;

use pschema_inspect::OrderFailure;
use pschema_learner::decision::{Decision, Reason, Subject};
use pschema_learner::effect::Effect;
use pschema_learner::memory::Memory;
use pschema_learner::observation::{Observation, TypeId};
use pschema_learner::probability::Count;
use pschema_learner::progress::StageEffect;
use pschema_learner::schema::{Form, SchemaId};
use pschema_learner::vocabulary::PrimitiveId;

use crate::ring::Ring;

/// Records kept: the last of them. Scenario 3 of the paper takes about 25,000 steps.
pub(crate) const RECORDS_KEPT_MAX: usize = 65_536;
/// Records kept all the same where memory is short. All of them take about 100 MB.
const RECORDS_KEPT_MIN: usize = 1_024;
/// Observations that one record keeps.
pub(crate) const PERCEIVED_MAX: usize = 16;
/// Post-conditions of a schema that are looked at for what it predicts.
const PREDICTIONS_MAX: usize = 256;
/// Records in one shared chunk.
const CHUNK_LEN: usize = 256;

/// One step, in the learner's own numbers.
#[derive(Clone, Debug)]
pub(crate) struct Record {
    pub(crate) step: u64,
    pub(crate) stage: usize,
    pub(crate) trial: u32,
    pub(crate) drawn: Vec<i64>,
    pub(crate) trial_met: Option<bool>,
    pub(crate) actions: u64,
    pub(crate) schemas_total: u32,
    pub(crate) schemas_generalised: u32,
    pub(crate) failure: Option<Box<OrderFailure>>,
    pub(crate) perceived: Box<[Observation]>,
    pub(crate) decision: Option<Decided>,
    pub(crate) quiet_actions: u32,
    pub(crate) habituating: bool,
    pub(crate) latency: Duration,
}

/// What a step decided.
#[derive(Clone, Debug)]
pub(crate) struct Decided {
    pub(crate) excitation_top: f64,
    pub(crate) excitation: f64,
    pub(crate) schema: Option<SchemaId>,
    pub(crate) generalised: bool,
    pub(crate) distance: u32,
    pub(crate) action: PrimitiveId,
    pub(crate) reason: Reason,
    pub(crate) predicts: Box<[TypeId]>,
}

/// The records. A clone shares them.
#[derive(Clone, Debug)]
pub(crate) struct Trace {
    records: Ring<Arc<Record>, RECORDS_KEPT_MAX, CHUNK_LEN>,
    /// How many records may be kept now.
    room: usize,
    actions: u64,
    /// Quiet actions in a row.
    quiet: u32,
}

impl Default for Trace {
    fn default() -> Self {
        Self { records: Ring::default(), room: RECORDS_KEPT_MAX, actions: 0, quiet: 0 }
    }
}

impl Trace {
    /// Gives up the older half of the records, for memory is short, and keeps no more than are left until [`Trace::lengthen`]. Returns
    /// whether there was something to give up.
    pub(crate) fn shorten(&mut self) -> bool {
        let before = self.records.len();
        self.room = (before / 2).max(RECORDS_KEPT_MIN);
        self.records.shorten(self.room);
        self.records.len() < before
    }

    /// Keeps as many records as ever again.
    pub(crate) fn lengthen(&mut self) {
        self.room = RECORDS_KEPT_MAX;
    }

    /// Keeps a record of a step. `memory` is as the step left it; `perceived` is what the body reported, and `failure` the
    /// order before, if the body did not carry it out.
    pub(crate) fn keep(
        &mut self,
        memory: &Memory,
        effects: &[Effect],
        decision: Option<&Decision>,
        perceived: &[Observation],
        failure: Option<&OrderFailure>,
        latency: Duration,
    ) {
        let mut record = record(memory, decision, perceived, latency);
        record.failure = failure.cloned().map(Box::new);
        // Memory has begun to count anew where the stage has ended; the streak that ended it is what is wanted.
        let mut streak = self.quiet;
        for effect in effects {
            match effect {
                Effect::Stage(StageEffect::Acted { .. }) => self.actions += 1,
                Effect::Stage(StageEffect::Quiet(quiet)) => {
                    self.quiet = if *quiet { self.quiet.saturating_add(1) } else { 0 };
                    streak = self.quiet;
                }
                Effect::Stage(StageEffect::Entered { .. }) => self.quiet = 0,
                Effect::Stage(StageEffect::TrialBegun { drawn }) => {
                    record.drawn = drawn.iter().map(|(_, number)| *number).collect();
                    self.quiet = 0;
                }
                Effect::Stage(StageEffect::TrialEnded { met, .. }) => {
                    record.trial_met = Some(*met);
                    self.quiet = 0;
                }
                _ => (),
            }
        }
        record.actions = self.actions;
        record.quiet_actions = streak;
        // A body that rests is asked again and again; that is no step worth a place.
        let nothing = |effect: &Effect| {
            matches!(effect, Effect::StepEnded { .. } | Effect::Stage(StageEffect::Held(_)))
        };
        let idle = decision.is_none() && failure.is_none() && effects.iter().all(nothing);
        if !idle {
            self.records.push(Arc::new(record));
            self.records.shorten(self.room);
        }
    }

    /// How many records there have been.
    pub(crate) fn total(&self) -> u64 {
        self.records.total()
    }

    /// At most `max` records from the number `from` on, or from the first that is kept; with the number of the
    /// first.
    pub(crate) fn from(&self, from: u64, max: usize) -> (u64, impl Iterator<Item = &Record>) {
        let (first, records) = self.records.from(from);
        (first, records.take(max).map(Arc::as_ref))
    }
}

fn record(
    memory: &Memory,
    decision: Option<&Decision>,
    reported: &[Observation],
    latency: Duration,
) -> Record {
    let content = memory.content();
    let progress = &content.progress;
    // What a teacher says is perceived beside what the body reports, and a constrained sense is not.
    let perceived = decision.map_or(reported, |decision| decision.world.observations());
    // A value that comes is in no decision, and in the record of each step all the same.
    let comes = |one: &&Observation| content.vocabulary.is_value(one.kind()) && !perceived.contains(one);
    let values: Vec<_> = reported.iter().filter(comes).take(PERCEIVED_MAX).cloned().collect();
    let others = perceived.iter().take(PERCEIVED_MAX - values.len()).cloned();
    Record {
        step: content.step,
        stage: progress.stage,
        trial: progress.report().map_or(0, |report| report.trials),
        drawn: Vec::new(),
        trial_met: None,
        actions: 0,
        schemas_total: u32::try_from(content.schemas.len()).unwrap_or(u32::MAX),
        schemas_generalised: content.generalised_count,
        failure: None,
        perceived: others.chain(values).collect(),
        decision: decision.and_then(|decision| decided(memory, decision)),
        quiet_actions: 0,
        habituating: progress.habituating,
        latency,
    }
}

fn decided(memory: &Memory, decision: &Decision) -> Option<Decided> {
    let chosen = decision.candidates.get(decision.chosen)?;
    let schema = match chosen.subject {
        Subject::Schema(id) => Some(id),
        Subject::Primitive(_) => None,
    };
    let known = schema.and_then(|id| memory.content().schema(id));
    Some(Decided {
        excitation_top: decision.candidates.first().map_or(0.0, |top| top.excitation),
        excitation: chosen.excitation,
        schema,
        generalised: known.is_some_and(|schema| schema.generalised().is_some()),
        distance: chosen.distance,
        action: decision.action,
        reason: decision.reason,
        predicts: known.map_or_else(Box::default, |schema| predicts(memory, &schema.form)),
    })
}

/// Types of what a schema predicts to be observed: all that a law states, and what followed a concrete schema
/// often enough.
fn predicts(memory: &Memory, form: &Form) -> Box<[TypeId]> {
    let likely = |count: Count| count.ratio() >= memory.parameters().prediction_ratio_min;
    let mut types: Vec<TypeId> = match form {
        Form::Concrete(concrete) => concrete
            .post
            .iter()
            .take(PREDICTIONS_MAX)
            .filter(|post| !post.absent && likely(post.count))
            .map(|post| memory.content().observation(post.what).kind())
            .collect(),
        Form::Generalised(generalised) => {
            let post = generalised.post.iter().take(PREDICTIONS_MAX);
            post.filter(|post| !post.absent).map(|post| post.what.kind()).collect()
        }
    };
    types.sort_unstable();
    types.dedup();
    types.into()
}

#[cfg(test)]
mod tests {
    use pschema_learner::parameters::Parameters;

    use super::*;

    /// Where memory was full the trace still grew, by about 100 MB.
    #[test]
    fn a_trace_gives_its_older_records_up_where_memory_is_short() {
        let memory = Memory::new(1, Parameters::default());
        let failure =
            OrderFailure { outcome: pschema_inspect::FailedOutcome::Refused, reason: None, step: 1 };
        let mut trace = Trace::default();
        let kept = |trace: &Trace| trace.total() - trace.from(0, usize::MAX).0;
        let steps = |trace: &mut Trace, count: usize| {
            (0..count).for_each(|_| trace.keep(&memory, &[], None, &[], Some(&failure), Duration::ZERO));
        };
        steps(&mut trace, 4 * RECORDS_KEPT_MIN);
        let mut left = vec![kept(&trace)];
        while trace.shorten() {
            left.push(kept(&trace));
        }
        assert_eq!(left, [4096, 2048, 1024]);
        assert_eq!(trace.total(), 4096, "records have the numbers that they had");
        steps(&mut trace, 3 * CHUNK_LEN);
        assert!(kept(&trace) <= 1024, "it grows no more: {}", kept(&trace));
        trace.lengthen();
        steps(&mut trace, 2 * RECORDS_KEPT_MIN);
        assert!(kept(&trace) > 2048, "{}", kept(&trace));
    }
}
