//! What somebody who watches a learner is shown, all of one moment.

use serde::{Deserialize, Serialize};

use super::{
    BodyStatus, Explanation, GoalSummary, HabituationStatus, ObservationText, SaturationStatus,
    SchemaSummary, TracePage, TrialStatus,
};

/// What is wanted of a [`Live`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LiveQuery {
    /// The number of the first record of the trace wanted, as in [`super::Request::Trace`].
    pub trace_from: u64,
    /// Candidates of the last decision to list, the most excited first; at most 32.
    pub candidates_max: u32,
    /// Terms of each candidate to list one by one, the greatest first; the others are added up as one of role `rest`.
    pub terms_max: u32,
    /// Newest schemas to list; at most 100.
    pub newest_max: u32,
}

/// A learner at one moment, for those who watch it. Cheap to answer at any size of memory: what takes a look at all of
/// memory is in [`super::Status`] (its digest) and [`super::SchemaQuery`] (the most used).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Live {
    /// The learner's name.
    pub name: String,
    /// Since the daemon's start.
    pub uptime_s: f64,
    /// Steps taken in the life of this memory.
    pub step: u64,
    /// The last step known to be on disk; none while memory is kept in RAM only.
    pub durable_step: Option<u64>,
    /// The curriculum.
    pub curriculum: String,
    /// The present stage.
    pub stage: String,
    /// As in [`super::Status::stage_state`].
    pub stage_state: String,
    /// How near the stage is to saturation; none where it does not end so, or the curriculum is over.
    pub saturation: Option<SaturationStatus>,
    /// What the stage asks of its schemas once it is saturated; none where it asks nothing, or the curriculum is over.
    pub habituation: Option<HabituationStatus>,
    /// The present trial; none where the stage has none, or the curriculum is over.
    pub trial: Option<TrialStatus>,
    /// The goal that is pursued, if any.
    pub goal: Option<GoalSummary>,
    /// Schemas in memory.
    pub schemas_total: u32,
    /// Those with variables.
    pub schemas_generalised: u32,
    /// Steps a second, over the last 10 seconds.
    pub steps_per_s: f64,
    /// Time of a decision (a frame's arrival to the action chosen), median of the last 4,096.
    pub step_latency_us_p50: f64,
    /// The same, 99th percentile.
    pub step_latency_us_p99: f64,
    /// From a frame's arrival until its reply has left, median of the last 4,096.
    pub commit_latency_us_p50: f64,
    /// The same, 99th percentile.
    pub commit_latency_us_p99: f64,
    /// Resident memory of the daemon.
    pub memory_bytes: u64,
    /// Bodies attached now or before.
    pub bodies: Vec<BodyStatus>,
    /// What is perceived now, by the body that the curriculum leads.
    pub world: Vec<Perceived>,
    /// Why the last action was chosen; none before the first.
    pub explanation: Option<Explanation>,
    /// The newest schemas, the newest first.
    pub newest: Vec<SchemaSummary>,
    /// What was decided in the steps asked for.
    pub trace: TracePage,
}

/// One observation of the world state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Perceived {
    /// What is observed.
    pub observation: ObservationText,
    /// As it prints.
    pub text: String,
    /// Whether it was not observed in the frame before.
    pub new: bool,
    /// N of equation (1): how often it has been attended to.
    pub attention: u32,
}
