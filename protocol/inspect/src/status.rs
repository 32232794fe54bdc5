//! How a daemon and its learner are.

use serde::{Deserialize, Serialize};

use crate::closed_set::closed_set;
use crate::goals::GoalSummary;
use crate::stage::{HabituationStatus, SaturationStatus, StageState, TrialStatus};
use crate::warning::DeclarationWarning;

/// How a daemon and its learner are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Status {
    /// The learner's name.
    pub name: String,
    /// The daemon's process.
    pub pid: u32,
    /// Since its start.
    pub uptime_s: f64,
    /// Steps taken in the life of this memory.
    pub step: u64,
    /// The last step known to be on disk; none while memory is kept in RAM only.
    pub durable_step: Option<u64>,
    /// What the learner does beyond the paper: `paper` for nothing, `full` for all it can, or the names of the mechanisms that
    /// are on.
    pub profile: String,
    /// The curriculum.
    pub curriculum: String,
    /// The present stage.
    pub stage: String,
    /// What the curriculum is doing.
    pub stage_state: StageState,
    /// How near the stage is to saturation; none where it does not end so, or the curriculum is over.
    pub saturation: Option<SaturationStatus>,
    /// What the stage asks of its schemas once it is saturated; none where it asks nothing, or the curriculum is over.
    pub habituation: Option<HabituationStatus>,
    /// The present trial; none where the stage has none, or the curriculum is over.
    pub trial: Option<TrialStatus>,
    /// Schemas in memory.
    pub schemas_total: u32,
    /// Those with constants only.
    pub schemas_concrete: u32,
    /// Those with variables.
    pub schemas_generalised: u32,
    /// Bodies attached now or before.
    pub bodies: Vec<BodyStatus>,
    /// Steps a second, over the last 10 seconds.
    pub steps_per_s: f64,
    /// Time of a decision (a frame's arrival to the action chosen), median of the last 4,096.
    pub step_latency_us_p50: f64,
    /// The same, 99th percentile.
    pub step_latency_us_p99: f64,
    /// From a frame's arrival until its reply has left: with memory on disk, once the step is durable. Median of the
    /// last 4,096.
    pub commit_latency_us_p50: f64,
    /// The same, 99th percentile.
    pub commit_latency_us_p99: f64,
    /// Resident memory of the daemon.
    pub memory_bytes: u64,
    /// The resident memory at which the learner stops to take in anything new; none without a limit.
    pub memory_max_bytes: Option<u64>,
    /// Whether it has stopped: it acts, and learns how well known schemas do, and nothing new.
    pub memory_full: bool,
    /// What steps cost as memory grew, since the daemon began: an entry for each doubling of the schemas, the smallest
    /// first.
    pub growth: Vec<GrowthStatus>,
    /// Digest of everything learnt: equal digests are equal memories. It takes time in proportion to memory, and is none
    /// in what is shown to those who watch.
    pub memory_digest: Option<String>,
    /// Top excitation of the last decision.
    #[serde(deserialize_with = "crate::number::or_nan")]
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub excitation_top: f64,
    /// What is perceived now, as it prints.
    pub world: Vec<String>,
    /// The goal that is pursued, if any.
    pub goal: Option<GoalSummary>,
    /// How memory is kept; none while it is in RAM only.
    pub storage: Option<StorageStatus>,
    /// Messages of bodies and tools that were refused since the daemon began, by reason; only those that there were.
    pub refused: Vec<RefusalCount>,
    /// Lines of the daemon's log that were lost, because nobody read its standard error.
    pub log_lines_lost: u64,
}

/// What steps cost while memory had from `schemas` up to twice as many of them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct GrowthStatus {
    /// Schemas from which on this counts: 0, 2, 4, 8 …
    pub schemas: u32,
    /// Steps.
    pub steps: u64,
    /// Time of a decision, median of all of them, to within a sixteenth.
    pub step_latency_us_p50: f64,
    /// The same, 99th percentile.
    pub step_latency_us_p99: f64,
    /// Resident memory of the daemon when the first of these steps was taken.
    pub memory_bytes: u64,
}

/// How many messages were refused for one reason.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RefusalCount {
    /// The number of the refusal, as in `docs/PROTOCOL.md`.
    pub code: u32,
    /// What it is about, in a word or two.
    pub reason: String,
    /// How many.
    pub count: u64,
}

closed_set! {
    /// When an action may leave.
    Durability {
        /// When the step that chose it is on disk.
        Strict = "strict",
        /// At once.
        Relaxed = "relaxed",
    }
}

/// How memory is kept on disk.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct StorageStatus {
    /// The data directory.
    pub directory: String,
    /// When an action may leave.
    pub durability: Durability,
    /// The last step known to be on disk.
    pub durable_step: u64,
    /// How many changes of memory (steps, orders, declarations of bodies) have been made and wait for the disk.
    pub changes_waiting: u64,
    /// Bytes of journal there are.
    pub journal_bytes: u64,
    /// The oldest step that memory can be returned to.
    pub oldest_step: u64,
    /// The step of the last snapshot; none before the first.
    pub snapshot_step: Option<u64>,
}

closed_set! {
    /// Whether a body is there.
    BodyState {
        /// It is attached.
        Attached = "attached",
        /// It took its leave.
        Left = "left",
        /// Its process ended without a farewell.
        Lost = "lost",
    }
}

/// A body as the daemon sees it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BodyStatus {
    /// Its session number.
    pub id: u64,
    /// Its name.
    pub name: String,
    /// Its kind, as it calls it.
    pub kind: String,
    /// Its process.
    pub pid: u32,
    /// Whether it is there.
    pub state: BodyState,
    /// Frames accepted.
    pub frames: u64,
    /// Frames refused.
    pub frames_refused: u64,
    /// Why the last one was refused.
    pub last_refusal: Option<String>,
    /// The last order that the body did not carry out.
    pub last_failure: Option<OrderFailure>,
    /// Episodes that ended in its world since it attached.
    pub episodes_ended: u64,
    /// Episodes that were cut short since then.
    pub episodes_cut: u64,
    /// What keeps its declaration from being learnt, as the frames since it attached showed.
    pub warnings: Vec<DeclarationWarning>,
}

closed_set! {
    /// How an order ended that was not carried out.
    FailedOutcome {
        /// It was not begun.
        Refused = "refused",
        /// It was begun and not completed.
        Failed = "failed",
        /// It was not completed in the time that the body allows.
        TimedOut = "timed-out",
    }
}

/// An order that a body did not carry out.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct OrderFailure {
    /// How it ended.
    pub outcome: FailedOutcome,
    /// The reason, in the body's words, with control characters escaped; none if the body gave none.
    pub reason: Option<String>,
    /// The step in which the learner was told.
    pub step: u64,
}
