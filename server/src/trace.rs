//! What was decided in each step, kept for figures: a ring of records that is cheap to share with those who
//! look, so that being looked at delays nothing.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use pschema_learner::decision::{Decision, Reason, Subject};
use pschema_learner::effect::Effect;
use pschema_learner::memory::Memory;
use pschema_learner::observation::{Observation, TypeId};
use pschema_learner::probability::Count;
use pschema_learner::progress::StageEffect;
use pschema_learner::schema::{Form, SchemaId};
use pschema_learner::vocabulary::PrimitiveId;

/// Records kept: the last of them. Scenario 3 of the paper takes about 25,000 steps.
pub(crate) const RECORDS_KEPT_MAX: usize = 65_536;
/// Observations that one record keeps.
pub(crate) const PERCEIVED_MAX: usize = 16;
/// Post-conditions of a schema that are looked at for what it predicts.
const PREDICTIONS_MAX: usize = 256;
/// Records in one shared chunk.
const CHUNK_LEN: usize = 256;

const _: () = assert!(RECORDS_KEPT_MAX.is_multiple_of(CHUNK_LEN));

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
#[derive(Clone, Debug, Default)]
pub(crate) struct Trace {
    chunks: VecDeque<Arc<Vec<Arc<Record>>>>,
    /// Records that are no longer kept.
    dropped: u64,
    /// Records in the chunks.
    kept: usize,
    actions: u64,
    /// Quiet actions in a row.
    quiet: u32,
}

impl Trace {
    /// Keeps a record of a step. `memory` is as the step left it; `perceived` is what the body reported.
    pub(crate) fn keep(
        &mut self,
        memory: &Memory,
        effects: &[Effect],
        decision: Option<&Decision>,
        perceived: &[Observation],
        latency: Duration,
    ) {
        let mut record = record(memory, decision, perceived, latency);
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
        let idle = decision.is_none() && effects.iter().all(|e| matches!(e, Effect::StepEnded { .. }));
        if !idle {
            self.push(record);
        }
    }

    fn push(&mut self, record: Record) {
        if self.kept == RECORDS_KEPT_MAX
            && let Some(oldest) = self.chunks.pop_front()
        {
            self.kept -= oldest.len();
            self.dropped += oldest.len() as u64;
        }
        if self.kept.is_multiple_of(CHUNK_LEN) {
            self.chunks.push_back(Arc::new(Vec::with_capacity(CHUNK_LEN)));
        }
        if let Some(last) = self.chunks.back_mut() {
            // Copies a chunk's pointers, not its records, and only when somebody still looks at it.
            Arc::make_mut(last).push(Arc::new(record));
            self.kept += 1;
        }
    }

    /// How many records there have been.
    pub(crate) fn total(&self) -> u64 {
        self.dropped + self.kept as u64
    }

    /// At most `max` records from the number `from` on, or from the first that is kept; with the number of the
    /// first.
    pub(crate) fn from(&self, from: u64, max: usize) -> (u64, impl Iterator<Item = &Record>) {
        let first = from.clamp(self.dropped, self.total());
        let skipped = usize::try_from(first - self.dropped).unwrap_or(usize::MAX);
        let chunks = self.chunks.iter().skip(skipped / CHUNK_LEN).flat_map(|chunk| chunk.iter());
        (first, chunks.skip(skipped % CHUNK_LEN).take(max).map(Arc::as_ref))
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
    Record {
        step: content.step,
        stage: progress.stage,
        trial: progress.report().map_or(0, |report| report.trials),
        drawn: Vec::new(),
        trial_met: None,
        actions: 0,
        schemas_total: u32::try_from(content.schemas.len()).unwrap_or(u32::MAX),
        schemas_generalised: content.generalised_count,
        perceived: perceived.iter().take(PERCEIVED_MAX).cloned().collect(),
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
    use super::*;

    fn at(step: u64) -> Record {
        Record {
            step,
            stage: 0,
            trial: 0,
            drawn: Vec::new(),
            trial_met: None,
            actions: 0,
            schemas_total: 0,
            schemas_generalised: 0,
            perceived: Box::default(),
            decision: None,
            quiet_actions: 0,
            habituating: false,
            latency: Duration::ZERO,
        }
    }

    fn steps(trace: &Trace, from: u64, max: usize) -> (u64, Vec<u64>) {
        let (first, records) = trace.from(from, max);
        (first, records.map(|record| record.step).collect())
    }

    #[test]
    fn the_last_records_are_kept_and_the_first_that_is_left_is_said() {
        let mut trace = Trace::default();
        let many = RECORDS_KEPT_MAX as u64 + 10;
        for step in 0..many {
            trace.push(at(step));
        }
        assert_eq!(trace.total(), many);
        let (first, kept) = steps(&trace, 0, usize::MAX);
        // Room is made by the chunk.
        assert_eq!(first, CHUNK_LEN as u64);
        assert_eq!((kept[0], kept.len() as u64), (first, many - first));
        assert!(kept.is_sorted());
        assert_eq!(steps(&trace, many - 2, 10), (many - 2, vec![many - 2, many - 1]));
        assert_eq!(steps(&trace, many + 5, 10), (many, vec![]));
        assert_eq!(steps(&trace, first + 300, 2), (first + 300, vec![first + 300, first + 301]));
    }

    #[test]
    fn a_clone_keeps_what_it_saw() {
        let mut trace = Trace::default();
        (0..300).for_each(|step| trace.push(at(step)));
        let seen = trace.clone();
        trace.push(at(300));
        assert_eq!((seen.total(), trace.total()), (300, 301));
        assert_eq!(steps(&seen, 299, 9), (299, vec![299]));
    }
}
