//! What was decided in each step.

use serde::{Deserialize, Serialize};

use crate::decision::Reason;
use crate::notation::ObservationText;
use crate::status::OrderFailure;

/// Some of the records that a daemon keeps of its learner's steps, in order. Holds everything a figure of a run
/// is drawn from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TracePage {
    /// The number of the first record in `records`. Above the one asked for when that is no longer kept.
    pub from: u64,
    /// How many records there have been; ask on from `from` plus the length of `records` until there.
    pub total: u64,
    /// How many the daemon keeps: the last of them.
    pub kept_max: u64,
    /// Names of the stages, which records refer to by index.
    pub stages: Vec<String>,
    /// The records.
    pub records: Vec<TraceRecord>,
}

/// One step of a learner: what it perceived, what it then decided, and where it stood. The same run has the same
/// records, but for their latencies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TraceRecord {
    /// The step.
    pub step: u64,
    /// The stage in which it ended, as an index into `stages`.
    pub stage: u32,
    /// The trial of that stage, from 1; 0 before the first and in stages without.
    pub trial: u32,
    /// What was drawn for a trial that this step began.
    pub drawn: Vec<i64>,
    /// Whether the trial that this step ended, if it ended one, ended with what it was waiting for.
    pub trial_met: Option<bool>,
    /// Actions of the student carried out so far.
    pub actions: u64,
    /// Schemas in memory.
    pub schemas_total: u32,
    /// Generalised ones among them.
    pub schemas_generalised: u32,
    /// The order before this step, if the body did not carry it out.
    pub failure: Option<OrderFailure>,
    /// What was perceived, words included; at most 16 observations.
    pub perceived: Vec<ObservationText>,
    /// Words heard: their observations' symbols.
    pub heard: Vec<String>,
    /// What was decided; none when nothing was chosen, as when the surroundings were to be arranged.
    pub decision: Option<TraceDecision>,
    /// Quiet actions in a row, that before this step included: nothing new and nothing exciting (saturation, paper
    /// II-F). In the step that ends a stage, those of the stage that it ended.
    pub quiet_actions: u32,
    /// Whether the stage is saturated and being habituated to (paper II-G).
    pub habituating: bool,
    /// Time of the step, from the frame decoded to the reply sent.
    pub latency_us: f64,
}

/// What a step decided.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TraceDecision {
    /// Excitation of the most excited candidate: the curve of the paper's figure 6.
    #[serde(deserialize_with = "crate::number::or_nan")]
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub excitation_top: f64,
    /// Excitation of the chosen candidate.
    #[serde(deserialize_with = "crate::number::or_nan")]
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub excitation: f64,
    /// The chosen schema; none for a primitive that no schema covers here.
    pub schema: Option<u32>,
    /// Whether that schema is generalised.
    pub generalised: bool,
    /// d of equation (1): schemas to be executed, the chosen one included.
    pub distance: u32,
    /// The primitive sent, as it prints.
    pub action: String,
    /// What made the choice.
    pub reason: Reason,
    /// Types of what the chosen schema predicts to be observed, each once, in alphabetical order.
    pub predicts: Vec<String>,
}
