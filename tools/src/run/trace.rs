//! The steps of a run, as they are fetched page by page from whoever keeps them.

use std::collections::BTreeSet;
use std::sync::Arc;

use pschema_inspect::{ObservationText, TracePage, TraceQuery, TraceRecord, ValueText};

use crate::design::{Design, FieldMap};
use crate::failure::Failure;
use crate::learner::Asks;
use crate::render::words::notation;

/// Every step of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Trace {
    /// Names of the stages, to which records refer by index.
    pub(crate) stages: Vec<String>,
    /// The steps, in order.
    pub(crate) steps: Vec<TracedStep>,
    /// Steps that were no longer kept when they were asked for.
    pub(crate) lost: u64,
    /// The number of the record to ask for next.
    next: u64,
    /// Texts that occur again and again.
    texts: BTreeSet<Arc<str>>,
}

/// One step: its record, with what the experiment's design reads off it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TracedStep {
    /// The record. Its observations have become `perceived`, which takes a fraction of the space.
    pub(crate) record: TraceRecord,
    /// The observations as they print.
    pub(crate) perceived: Arc<str>,
    /// The place of the object, by the experiment's map.
    pub(crate) object_at: Option<i64>,
    /// The place of the effector that reaches for it.
    pub(crate) effector_at: Option<i64>,
    /// Whether the effector has reached the object, by the observations.
    pub(crate) reached: bool,
    /// Whether the chosen schema is one of touching, which figure 6 tells apart.
    pub(crate) touching: bool,
    /// What came of the value of each measure that has one, in the order of the measures.
    pub(crate) came: Box<[f64]>,
}

impl Trace {
    /// Fetches the steps that have been added since the last time.
    pub(crate) fn fetch(&mut self, asked: &mut impl Asks, design: &Design) -> Result<(), Failure> {
        loop {
            let page = asked.ask(TraceQuery { from: self.next })?;
            let (total, fetched) = (page.total, page.records.len());
            self.take(page, design);
            if fetched == 0 || self.next >= total {
                return Ok(());
            }
        }
    }

    /// The last step fetched; 0 before the first.
    pub(crate) fn last_step(&self) -> u64 {
        self.steps.last().map_or(0, |step| step.record.step)
    }

    /// The name of the stage with this index.
    pub(crate) fn stage(&self, index: u32) -> &str {
        usize::try_from(index).ok().and_then(|at| self.stages.get(at)).map_or("", String::as_str)
    }

    /// The index of the stage of this name.
    pub(crate) fn stage_index(&self, name: &str) -> Option<u32> {
        self.stages.iter().position(|stage| stage == name).and_then(|at| u32::try_from(at).ok())
    }

    fn take(&mut self, page: TracePage, design: &Design) {
        self.lost += page.from.saturating_sub(self.next);
        self.next = page.from + page.records.len() as u64;
        self.stages = page.stages;
        for record in page.records {
            let step = self.step(record, design);
            self.steps.push(step);
        }
    }

    fn step(&mut self, mut record: TraceRecord, design: &Design) -> TracedStep {
        let perceived = std::mem::take(&mut record.perceived);
        let map = design.map.as_ref();
        let place = |kind: fn(&FieldMap) -> &String| {
            let seen = perceived.iter().find(|one| Some(&one.kind) == map.map(kind))?;
            integer(seen, &map?.place)
        };
        let reached = map.and_then(|map| map.reached.as_ref()).or(design.touching.as_ref());
        let predicts = record.decision.as_ref().map_or(&[][..], |decision| &decision.predicts);
        TracedStep {
            object_at: place(|map| &map.object),
            effector_at: place(|map| &map.effector),
            reached: reached.is_some_and(|kind| perceived.iter().any(|one| one.kind == *kind)),
            came: design
                .measures
                .iter()
                .filter_map(|one| Some(sum_of(&perceived, one.value.as_ref()?)))
                .collect(),
            touching: design.touching.as_ref().is_some_and(|kind| predicts.contains(kind)),
            perceived: self.text(&perceived.iter().map(notation).collect::<Vec<_>>().join(" & ")),
            record,
        }
    }

    fn text(&mut self, text: &str) -> Arc<str> {
        if let Some(known) = self.texts.get(text) {
            return Arc::clone(known);
        }
        let text: Arc<str> = text.into();
        self.texts.insert(Arc::clone(&text));
        text
    }

    /// The trials of a run, in order.
    pub(crate) fn trials(&self) -> Vec<Trial> {
        let mut trials: Vec<Trial> = Vec::new();
        // A trial is open from the step that arranges it to the step that ends it; both may be one.
        let mut open: Option<Trial> = None;
        for step in &self.steps {
            let record = &step.record;
            if let Some(trial) = &mut open {
                trial.see(step);
                if let Some(met) = record.trial_met {
                    trial.met = Some(met);
                    trials.extend(open.take());
                }
            }
            let is_new = |last: &Trial| (last.stage, last.number) != (record.stage, record.trial);
            if record.trial > 0 && open.is_none() && trials.last().is_none_or(is_new) {
                open = Some(Trial::begun(step));
            }
        }
        trials.extend(open);
        trials
    }
}

/// One placement, or utterance, and what came of it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Trial {
    /// The index of its stage.
    pub(crate) stage: u32,
    /// From 1.
    pub(crate) number: u32,
    pub(crate) drawn: Vec<i64>,
    /// Actions carried out before it began.
    pub(crate) begun_at: u64,
    /// Actions carried out in it.
    pub(crate) actions: u64,
    /// Whether the awaited observation came; none if the trial never ended.
    pub(crate) met: Option<bool>,
    /// Where the object was first seen.
    pub(crate) object_at: Option<i64>,
    /// After how many of its actions the effector had reached the object, if it had.
    pub(crate) reached_after: Option<u64>,
    /// Whether the effector was seen where the object is, or was.
    pub(crate) covered: bool,
}

impl Trial {
    fn begun(step: &TracedStep) -> Self {
        let record = &step.record;
        Self {
            stage: record.stage,
            number: record.trial,
            drawn: record.drawn.clone(),
            begun_at: record.actions,
            actions: 0,
            met: None,
            // The object is only put down after this step, unless there was nothing to arrange.
            object_at: if record.drawn.is_empty() { step.object_at } else { None },
            reached_after: None,
            covered: false,
        }
    }

    fn see(&mut self, step: &TracedStep) {
        self.actions = step.record.actions.saturating_sub(self.begun_at);
        if self.actions == 0 || self.object_at.is_none() {
            self.object_at = step.object_at.or(self.object_at);
        }
        if step.reached && self.actions > 0 && self.reached_after.is_none() {
            self.reached_after = Some(self.actions);
        }
        self.covered |= self.actions > 0 && self.object_at.is_some() && step.effector_at == self.object_at;
    }
}

/// The sum of the numbers in the observations of a type.
fn sum_of(observations: &[ObservationText], kind: &str) -> f64 {
    let of_kind = observations.iter().filter(|one| one.kind == kind);
    let number = |value: &ValueText| match value {
        #[expect(clippy::cast_precision_loss, reason = "what comes with a frame is far below 2^52")]
        ValueText::Integer(value) => *value as f64,
        ValueText::Real(value) => *value,
        _ => 0.0,
    };
    of_kind
        .flat_map(|one| one.properties.iter().map(|(_, value)| value))
        .map(number)
        .fold(0.0, |sum, one| sum + one)
}

fn integer(observation: &ObservationText, property: &str) -> Option<i64> {
    match observation.properties.get(property)? {
        ValueText::Integer(value) => Some(*value),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design;

    fn step(trial: u32, actions: u64, met: Option<bool>) -> TracedStep {
        let record = TraceRecord {
            step: actions,
            stage: 0,
            trial,
            drawn: Vec::new(),
            trial_met: met,
            actions,
            schemas_total: 0,
            schemas_generalised: 0,
            failure: None,
            perceived: Vec::new(),
            heard: Vec::new(),
            decision: None,
            quiet_actions: 0,
            habituating: false,
            latency_us: 0.0,
        };
        let (perceived, reached, touching) = ("".into(), false, false);
        let came = [].into();
        TracedStep { record, perceived, object_at: Some(4), effector_at: None, reached, touching, came }
    }

    #[test]
    fn what_came_of_a_value_is_added_up() {
        let seen = |kind: &str, value| ObservationText {
            kind: kind.to_owned(),
            properties: [("amount".to_owned(), value)].into_iter().collect(),
        };
        let all = [
            seen("reward", ValueText::Real(0.5)),
            seen("reward", ValueText::Integer(-2)),
            seen("lamp", ValueText::Integer(7)),
            seen("reward", ValueText::Boolean(true)),
        ];
        assert!((sum_of(&all, "reward") + 1.5).abs() < 1e-12);
        assert!(sum_of(&all, "cost").abs() < 1e-12);
    }

    fn drawn(object: i64, mut step: TracedStep) -> TracedStep {
        step.record.drawn = vec![object];
        step
    }

    fn trials(steps: Vec<TracedStep>) -> Vec<Trial> {
        Trace { steps, ..Trace::default() }.trials()
    }

    #[test]
    fn one_step_may_end_a_trial_and_begin_the_next() {
        let touched = TracedStep { reached: true, effector_at: Some(4), ..step(2, 7, Some(true)) };
        let all = trials(vec![
            step(0, 5, None),
            TracedStep { object_at: None, ..drawn(8, step(1, 5, None)) },
            step(1, 5, None),
            step(1, 6, None),
            drawn(9, touched),
            TracedStep { object_at: Some(3), ..step(2, 7, None) },
            step(2, 9, Some(false)),
        ]);
        let told: Vec<_> = all.iter().map(|t| (t.number, &t.drawn[..], t.actions, t.met)).collect();
        assert_eq!(told, [(1, &[8][..], 2, Some(true)), (2, &[9][..], 2, Some(false))]);
        let seen: Vec<_> = all.iter().map(|t| (t.object_at, t.reached_after, t.covered)).collect();
        assert_eq!(seen, [(Some(4), Some(2), true), (Some(3), None, false)]);
    }

    #[test]
    fn a_trial_that_never_ended_is_told_as_such() {
        let all = trials(vec![step(1, 0, None), step(1, 3, None)]);
        assert_eq!(all.iter().map(|t| (t.actions, t.met)).collect::<Vec<_>>(), [(3, None)]);
        assert!(trials(vec![step(0, 1, None)]).is_empty());
    }

    #[test]
    fn records_that_are_no_longer_kept_are_counted_as_lost() {
        let design = design::design("exp1-s1").unwrap();
        let page = |from| TracePage {
            from,
            total: 10,
            kept_max: 4,
            stages: vec!["one".to_owned()],
            records: Vec::new(),
        };
        let mut trace = Trace::default();
        trace.take(page(6), &design);
        assert_eq!((trace.lost, trace.next), (6, 6));
        trace.take(page(6), &design);
        assert_eq!(trace.lost, 6, "lost once");
    }
}
