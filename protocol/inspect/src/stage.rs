//! How near a learner is to the end of a developmental stage: saturation (paper, II-F), habituation (II-G) and trials.

use serde::{Deserialize, Serialize};

/// How near a stage is to saturation: nothing new and nothing exciting for some actions in a row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SaturationStatus {
    /// Quiet actions in a row up to now: no schema was made and the top excitation was below `saturation_below`.
    pub quiet_actions: u32,
    /// How many the stage asks for; 1 or more.
    pub quiet_actions_wanted: u32,
    /// The excitation that the top one must be below; compare [`excitation_top`](super::Status::excitation_top).
    pub saturation_below: f64,
}

/// What a stage asks of its schemas before the next constraint is lifted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HabituationStatus {
    /// Schemas made in the stage, and executable here and now, that are still to be executed; none before the stage
    /// is saturated, and where no body perceives anything.
    pub habituation_left: Option<u32>,
    /// Executions that are enough.
    pub executions_min: u32,
    /// Width of the 95 % interval of the success probability that is enough as well, in 0..=1; 0 where only
    /// executions count.
    pub interval_max: f64,
}

/// The present trial of a stage, or the last one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrialStatus {
    /// Its number in the stage, from 1; 0 before the first.
    pub trial: u32,
    /// Trials that the stage has.
    pub trials_wanted: u32,
    /// Whether it has been arranged and is not over.
    pub open: bool,
    /// Actions carried out in it.
    pub actions: u32,
    /// Actions after which it is over; none where that does not end it.
    pub actions_max: Option<u32>,
}
