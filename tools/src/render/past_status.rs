//! `status --data`: the fields of `status` that are about memory, of memory as it was.

use pschema_inspect::{GoalSummary, HabituationStatus, SaturationStatus, StageState, Status, TrialStatus};
use pschema_store::past::Files;
use serde::Serialize;

use super::journal::moment;
use super::status;
use super::table::Columns;
use super::words::{bytes, plain};

/// The output of `status --data --json`. Fields that `status` has too mean the same here.
#[derive(Debug, Serialize)]
pub(crate) struct PastStatus<'a> {
    name: &'a str,
    seed: u64,
    directory: String,
    step: u64,
    frame: u64,
    at_unix_ms: Option<u64>,
    oldest_step: u64,
    journal_bytes: u64,
    curriculum: &'a str,
    stage: &'a str,
    stage_state: &'a StageState,
    saturation: &'a Option<SaturationStatus>,
    habituation: &'a Option<HabituationStatus>,
    trial: &'a Option<TrialStatus>,
    schemas_total: u32,
    schemas_concrete: u32,
    schemas_generalised: u32,
    memory_digest: Option<&'a str>,
    excitation_top: f64,
    world: &'a [String],
    goal: &'a Option<GoalSummary>,
}

impl<'a> PastStatus<'a> {
    pub(crate) fn new(
        status: &'a Status,
        directory: String,
        seed: u64,
        frame: u64,
        at_unix_ms: Option<u64>,
        files: Files,
    ) -> Self {
        Self {
            name: &status.name,
            seed,
            directory,
            step: status.step,
            frame,
            at_unix_ms,
            oldest_step: files.oldest_step,
            journal_bytes: files.segments.iter().map(|segment| segment.bytes).sum(),
            curriculum: &status.curriculum,
            stage: &status.stage,
            stage_state: &status.stage_state,
            saturation: &status.saturation,
            habituation: &status.habituation,
            trial: &status.trial,
            schemas_total: status.schemas_total,
            schemas_concrete: status.schemas_concrete,
            schemas_generalised: status.schemas_generalised,
            memory_digest: status.memory_digest.as_deref(),
            excitation_top: status.excitation_top,
            world: &status.world,
            goal: &status.goal,
        }
    }
}

/// Memory as it was, as a table.
pub(crate) fn past_status(p: &PastStatus<'_>, s: &Status) -> String {
    let mut facts = Columns::new(&[]);
    facts.row(["learner", &format!("{}, seed {}: read from disk", plain(p.name), p.seed)]);
    let when = p.at_unix_ms.map_or(String::new(), |at| format!(", taken {} UTC", moment(at)));
    facts.row(["step", &format!("{}{when}", p.step)]);
    status::learnt(s, &mut facts);
    let (directory, journal, oldest) = (plain(&p.directory), bytes(p.journal_bytes), p.oldest_step);
    facts.row(["data", &format!("{directory}; journal {journal}, back to step {oldest}")]);
    status::doing(s, &mut facts);
    facts.text(&[0])
}
