//! Recordings of a running learner: every step in order, and every new schema.

mod lines;

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use pschema_inspect::{Live, LiveQuery, SchemaQuery, TraceRecord};
use pschema_protocol::domain::Place;

use crate::failure::Failure;
use crate::learner::Learner;

pub(crate) use lines::JsonLinesFile;
#[cfg(test)]
pub(crate) use lines::RecordingEntry;

/// The pause when no step has come.
const PAUSE: Duration = Duration::from_millis(30);
/// Newest schemas that come with each page of steps; if more were made, they are asked for.
const NEWEST_MAX: u32 = 100;

/// The counts of a recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct RecordingSummary {
    /// Steps that were written.
    pub(crate) steps: u64,
    /// Steps that the daemon no longer had when they were asked for.
    pub(crate) steps_missed: u64,
    /// The first step, if any.
    pub(crate) first_step: Option<u64>,
    /// The last step, if any.
    pub(crate) last_step: Option<u64>,
    /// New schemas that were written.
    pub(crate) schemas: u64,
}

/// Writes down the steps of the learner at `place`, those that its daemon still has included, until `steps_max` have been
/// written, `stop` is set or the daemon ends.
pub(crate) fn record(
    place: &Place,
    to: &mut JsonLinesFile,
    steps_max: u64,
    stop: &AtomicBool,
) -> Result<RecordingSummary, Failure> {
    let mut learner = Learner::connect_at(place)?;
    let mut recorded = RecordingSummary::default();
    let followed = follow(&mut learner, to, steps_max, stop, &mut recorded);
    // What was written stays, however it ended.
    to.finish()?;
    match followed {
        // The daemon has ended, and what it did is written down.
        Err(Failure::NoDaemon(_)) | Ok(()) => Ok(recorded),
        Err(failure) => Err(failure),
    }
}

fn follow(
    learner: &mut Learner,
    to: &mut JsonLinesFile,
    steps_max: u64,
    stop: &AtomicBool,
    recorded: &mut RecordingSummary,
) -> Result<(), Failure> {
    let (mut from, mut known) = (0, None);
    while !stop.load(Ordering::Relaxed) && recorded.steps < steps_max {
        let query = LiveQuery { trace_from: from, candidates_max: 1, terms_max: 0, newest_max: NEWEST_MAX };
        let live = learner.ask(query)?;
        recorded.steps_missed += live.trace.from.saturating_sub(from);
        let left = usize::try_from(steps_max - recorded.steps).unwrap_or(usize::MAX);
        let records = &live.trace.records[..live.trace.records.len().min(left)];
        from = live.trace.from + records.len() as u64;
        steps(&live, records, to, recorded)?;
        schemas(&live, learner, &mut known, to, recorded)?;
        if from >= live.trace.total {
            to.flush()?;
            std::thread::sleep(PAUSE);
        }
    }
    Ok(())
}

fn steps(
    live: &Live,
    records: &[TraceRecord],
    to: &mut JsonLinesFile,
    recorded: &mut RecordingSummary,
) -> Result<(), Failure> {
    for record in records {
        let stage = live.trace.stages.get(record.stage as usize).map_or("", String::as_str);
        to.step(record, stage)?;
        recorded.steps += 1;
        recorded.first_step.get_or_insert(record.step);
        recorded.last_step = Some(record.step);
    }
    Ok(())
}

/// Writes schemas that were not there before.
fn schemas(
    live: &Live,
    learner: &mut Learner,
    known: &mut Option<u32>,
    to: &mut JsonLinesFile,
    recorded: &mut RecordingSummary,
) -> Result<(), Failure> {
    let total = live.status.schemas_total;
    let mut from = known.replace(total).unwrap_or(total);
    while from < total {
        let oldest_shown = live.newest.last().map_or(u32::MAX, |schema| schema.id);
        let listed = if from >= oldest_shown {
            live.newest.iter().rev().filter(|schema| schema.id >= from).cloned().collect()
        } else {
            // More were made at once than are shown to those who watch.
            let query = SchemaQuery { offset: from, limit: total - from, ..SchemaQuery::default() };
            learner.ask(query)?.schemas
        };
        let Some(last) = listed.last().map(|schema| schema.id) else { break };
        for schema in listed.iter().filter(|schema| schema.id < total) {
            to.schema(live.status.step, schema)?;
            recorded.schemas += 1;
        }
        from = last.saturating_add(1);
    }
    Ok(())
}
