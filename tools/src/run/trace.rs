//! The steps of a run, as they are fetched page by page from whoever keeps them.

use std::collections::BTreeSet;
use std::sync::Arc;

use pschema_inspect::{ObservationText, Reason, TracePage, TraceQuery, TraceRecord, ValueText};

use crate::design::{Design, FieldMap};
use crate::failure::Failure;
use crate::learner::Asks;
use crate::render::words::notation;

/// Every step of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Trace {
    /// Names of the stages, which rows refer to by index.
    pub(crate) stages: Vec<String>,
    /// The steps, in order.
    pub(crate) rows: Vec<StepRecord>,
    /// Steps that were no longer kept when they were asked for.
    pub(crate) lost: u64,
    /// The number of the record to ask for next.
    next: u64,
    /// Texts that occur again and again.
    texts: BTreeSet<Arc<str>>,
}

/// One step.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct StepRecord {
    pub(crate) step: u64,
    pub(crate) stage: usize,
    /// From 1; 0 for none.
    pub(crate) trial: u32,
    /// What was drawn for a trial begun.
    pub(crate) drawn: Vec<i64>,
    /// How a trial ended, if one did.
    pub(crate) trial_met: Option<bool>,
    /// Carried out so far.
    pub(crate) actions: u64,
    pub(crate) schemas_total: u32,
    pub(crate) schemas_generalised: u32,
    /// As it prints.
    pub(crate) perceived: Arc<str>,
    /// Where what is placed is seen, and where what reaches for it, by the experiment's map.
    pub(crate) object_at: Option<i64>,
    pub(crate) effector_at: Option<i64>,
    /// Whether the one has reached the other, by what is perceived.
    pub(crate) reached: bool,
    pub(crate) heard: Arc<str>,
    pub(crate) decision: Option<StepDecision>,
    pub(crate) quiet_actions: u32,
    pub(crate) habituating: bool,
    pub(crate) latency_us: f64,
}

/// What a step decided.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct StepDecision {
    pub(crate) excitation_top: f64,
    pub(crate) excitation: f64,
    pub(crate) schema: Option<u32>,
    pub(crate) generalised: bool,
    pub(crate) distance: u32,
    pub(crate) action: Arc<str>,
    pub(crate) reason: Reason,
    pub(crate) predicts: Arc<str>,
    /// Whether the schema is one of those that figure 6 tells apart.
    pub(crate) touching: bool,
}

impl Trace {
    /// Fetches what has been added since the last time.
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
        self.rows.last().map_or(0, |row| row.step)
    }

    fn take(&mut self, page: TracePage, design: &Design) {
        self.lost += page.from.saturating_sub(self.next);
        self.next = page.from + page.records.len() as u64;
        self.stages = page.stages;
        for record in page.records {
            let row = self.row(record, design);
            self.rows.push(row);
        }
    }

    fn row(&mut self, record: TraceRecord, design: &Design) -> StepRecord {
        let place = |kind: fn(&FieldMap) -> &String| {
            let map = design.map.as_ref()?;
            let seen = record.perceived.iter().find(|one| one.kind == *kind(map))?;
            integer(seen, &map.place)
        };
        let (object_at, effector_at) = (place(|map| &map.object), place(|map| &map.effector));
        let reached = design.map.as_ref().and_then(|map| map.reached.as_ref()).or(design.touching.as_ref());
        let reached = reached.is_some_and(|kind| record.perceived.iter().any(|one| one.kind == *kind));
        let perceived: Vec<_> = record.perceived.iter().map(notation).collect();
        let decision = record.decision.map(|decision| StepDecision {
            excitation_top: decision.excitation_top,
            excitation: decision.excitation,
            schema: decision.schema,
            generalised: decision.generalised,
            distance: decision.distance,
            touching: design.touching.as_ref().is_some_and(|kind| decision.predicts.contains(kind)),
            action: self.text(&decision.action),
            reason: decision.reason,
            predicts: self.text(&decision.predicts.join(" ")),
        });
        StepRecord {
            step: record.step,
            stage: usize::try_from(record.stage).unwrap_or(usize::MAX),
            trial: record.trial,
            drawn: record.drawn,
            trial_met: record.trial_met,
            actions: record.actions,
            schemas_total: record.schemas_total,
            schemas_generalised: record.schemas_generalised,
            perceived: self.text(&perceived.join(" & ")),
            object_at,
            effector_at,
            reached,
            heard: self.text(&record.heard.join(" ")),
            decision,
            quiet_actions: record.quiet_actions,
            habituating: record.habituating,
            latency_us: record.latency_us,
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
        // A trial is open from the row that arranges it to the row that ends it; both rows may be one.
        let mut open: Option<Trial> = None;
        for row in &self.rows {
            if let Some(trial) = &mut open {
                trial.see(row);
                if let Some(met) = row.trial_met {
                    trial.met = Some(met);
                    trials.extend(open.take());
                }
            }
            if row.trial > 0
                && open.is_none()
                && trials.last().is_none_or(|last| last.key() != (row.stage, row.trial))
            {
                open = Some(Trial::begun(row));
            }
        }
        trials.extend(open);
        trials
    }
}

/// One placement, or utterance, and what came of it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Trial {
    pub(crate) stage: usize,
    /// From 1.
    pub(crate) number: u32,
    pub(crate) drawn: Vec<i64>,
    /// Carried out before it began.
    pub(crate) begun_at: u64,
    /// Carried out in it.
    pub(crate) actions: u64,
    /// Whether what it was waiting for was observed; none if it never ended.
    pub(crate) met: Option<bool>,
    /// Where the object was first seen.
    pub(crate) object_at: Option<i64>,
    /// After how many of its actions the effector had reached the object, if it had.
    pub(crate) reached_after: Option<u64>,
    /// Whether the effector was seen where the object is, or was.
    pub(crate) covered: bool,
}

impl Trial {
    fn begun(row: &StepRecord) -> Self {
        Self {
            stage: row.stage,
            number: row.trial,
            drawn: row.drawn.clone(),
            begun_at: row.actions,
            actions: 0,
            met: None,
            // The object is only put down after this row, unless there was nothing to arrange.
            object_at: if row.drawn.is_empty() { row.object_at } else { None },
            reached_after: None,
            covered: false,
        }
    }

    fn key(&self) -> (usize, u32) {
        (self.stage, self.number)
    }

    fn see(&mut self, row: &StepRecord) {
        self.actions = row.actions.saturating_sub(self.begun_at);
        if self.actions == 0 || self.object_at.is_none() {
            self.object_at = row.object_at.or(self.object_at);
        }
        if row.reached && self.actions > 0 && self.reached_after.is_none() {
            self.reached_after = Some(self.actions);
        }
        self.covered |= self.actions > 0 && self.object_at.is_some() && row.effector_at == self.object_at;
    }
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

    fn row(trial: u32, actions: u64, met: Option<bool>) -> StepRecord {
        let none: Arc<str> = "".into();
        StepRecord {
            step: actions,
            stage: 0,
            trial,
            drawn: Vec::new(),
            trial_met: met,
            actions,
            schemas_total: 0,
            schemas_generalised: 0,
            perceived: none.clone(),
            object_at: Some(4),
            effector_at: None,
            reached: false,
            heard: none,
            decision: None,
            quiet_actions: 0,
            habituating: false,
            latency_us: 0.0,
        }
    }

    fn trials(rows: Vec<StepRecord>) -> Vec<Trial> {
        Trace { rows, ..Trace::default() }.trials()
    }

    #[test]
    fn one_step_may_end_a_trial_and_begin_the_next() {
        let touched =
            StepRecord { reached: true, effector_at: Some(4), drawn: vec![9], ..row(2, 7, Some(true)) };
        let all = trials(vec![
            row(0, 5, None),
            StepRecord { drawn: vec![8], object_at: None, ..row(1, 5, None) },
            row(1, 5, None),
            row(1, 6, None),
            touched,
            StepRecord { object_at: Some(3), ..row(2, 7, None) },
            row(2, 9, Some(false)),
        ]);
        let told: Vec<_> = all.iter().map(|t| (t.number, &t.drawn[..], t.actions, t.met)).collect();
        assert_eq!(told, [(1, &[8][..], 2, Some(true)), (2, &[9][..], 2, Some(false))]);
        let seen: Vec<_> = all.iter().map(|t| (t.object_at, t.reached_after, t.covered)).collect();
        assert_eq!(seen, [(Some(4), Some(2), true), (Some(3), None, false)]);
    }

    #[test]
    fn a_trial_that_never_ended_is_told_as_such() {
        let all = trials(vec![row(1, 0, None), row(1, 3, None)]);
        assert_eq!(all.iter().map(|t| (t.actions, t.met)).collect::<Vec<_>>(), [(3, None)]);
        assert!(trials(vec![row(0, 1, None)]).is_empty());
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
