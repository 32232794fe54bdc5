//! `status --data`: the fields of `status` that are about memory, of memory as it was.

use pschema_inspect::{GoalSummary, HabituationStatus, SaturationStatus, StageState, Status, TrialStatus};
use pschema_store::past::{Past, PastError};
use serde::Serialize;

use super::journal::moment;
use super::status;
use super::table::Columns;
use super::words::{bytes, plain};

/// Memory as it was. Fields that `status` has too mean the same here.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct PastStatus<'a> {
    /// The learner's name.
    name: &'a str,
    /// The learner's seed.
    seed: u64,
    /// The data directory.
    directory: String,
    /// The step.
    step: u64,
    /// The last frame of the journal that belongs to the step.
    frame: u64,
    /// When the step was taken, by the machine's clock, in milliseconds since 1970.
    at_unix_ms: Option<u64>,
    /// The first step that can be returned to.
    oldest_step: u64,
    /// Bytes of the journal.
    journal_bytes: u64,
    /// What the learner did beyond the paper: `paper` for nothing, `full` for all it can, or the names of the mechanisms that were
    /// on.
    profile: &'a str,
    /// The curriculum.
    curriculum: &'a str,
    /// The stage of the curriculum.
    stage: &'a str,
    /// What the stage was doing.
    stage_state: &'a StageState,
    /// How near the stage was to saturation; none in a stage that does not end so.
    saturation: &'a Option<SaturationStatus>,
    /// How near the stage was to habituation; none in a stage without.
    habituation: &'a Option<HabituationStatus>,
    /// The trial of the stage; none in a stage without.
    trial: &'a Option<TrialStatus>,
    /// Schemas in memory.
    schemas_total: u32,
    /// Those with constants only.
    schemas_concrete: u32,
    /// Those with variables.
    schemas_generalised: u32,
    /// Digest of everything learnt.
    memory_digest: &'a Option<String>,
    /// Excitation of the most excited candidate of the last decision.
    excitation_top: f64,
    /// What was perceived last, as it prints.
    world: &'a [String],
    /// The goal that was pursued, if there was one.
    goal: &'a Option<GoalSummary>,
}

impl<'a> PastStatus<'a> {
    /// The status of memory in the directory of `past`, after the batch in this frame.
    pub(crate) fn new(
        status: &'a Status,
        past: &Past,
        frame: u64,
        at_unix_ms: Option<u64>,
    ) -> Result<Self, PastError> {
        let files = past.files()?;
        Ok(Self {
            name: &status.name,
            seed: past.seed(),
            directory: past.directory().display().to_string(),
            step: status.step,
            frame,
            at_unix_ms,
            oldest_step: files.oldest_step,
            journal_bytes: files.segments.iter().map(|segment| segment.bytes).sum(),
            profile: &status.profile,
            curriculum: &status.curriculum,
            stage: &status.stage,
            stage_state: &status.stage_state,
            saturation: &status.saturation,
            habituation: &status.habituation,
            trial: &status.trial,
            schemas_total: status.schemas_total,
            schemas_concrete: status.schemas_concrete,
            schemas_generalised: status.schemas_generalised,
            memory_digest: &status.memory_digest,
            excitation_top: status.excitation_top,
            world: &status.world,
            goal: &status.goal,
        })
    }
}

/// Memory as it was, as a table.
pub(crate) fn past_status(p: &PastStatus<'_>, s: &Status) -> String {
    let mut facts = Columns::new(&[]);
    facts.fact("learner", format!("{}, seed {}: read from disk", plain(p.name), p.seed));
    let when = p.at_unix_ms.map_or(String::new(), |at| format!(", taken {} UTC", moment(at)));
    facts.fact("step", format!("{}{when}", p.step));
    status::learnt(s, &mut facts);
    let (directory, journal, oldest) = (plain(&p.directory), bytes(p.journal_bytes), p.oldest_step);
    facts.fact("data", format!("{directory}; journal {journal}, back to step {oldest}"));
    status::doing(s, &mut facts);
    facts.text(&[0])
}
