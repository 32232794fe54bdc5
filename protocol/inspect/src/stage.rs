//! What a curriculum has done, and how near a learner is to the end of a developmental stage: saturation (paper, II-F),
//! habituation (II-G) and trials.

use std::fmt;

use serde::{Deserialize, Serialize};

/// What a curriculum is doing.
///
/// In JSON, as in print, a string: `acting`, `saturated`, `habituating`, `held`, `finished`, `waiting for a body`, or
/// `stuck: ` and why.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub enum StageState {
    /// The learner acts, and the stage has not saturated.
    Acting,
    /// Nothing new or exciting has come for as long as the stage asks.
    Saturated,
    /// The stage is saturated, and its schemas are repeated until they are known well enough.
    Habituating,
    /// An operator ordered it to wait.
    Held,
    /// The last stage is over.
    Finished,
    /// No body is attached.
    WaitingForBody,
    /// The curriculum can't go on, and why.
    Stuck(String),
}

impl StageState {
    /// The state without its reason.
    #[must_use]
    pub fn as_str(&self) -> &'static str {
        match self {
            Self::Acting => "acting",
            Self::Saturated => "saturated",
            Self::Habituating => "habituating",
            Self::Held => "held",
            Self::Finished => "finished",
            Self::WaitingForBody => "waiting for a body",
            Self::Stuck(_) => "stuck",
        }
    }
}

impl fmt::Display for StageState {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stuck(why) => write!(to, "stuck: {why}"),
            state => to.write_str(state.as_str()),
        }
    }
}

impl From<StageState> for String {
    fn from(state: StageState) -> Self {
        state.to_string()
    }
}

impl TryFrom<String> for StageState {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        use StageState::{Acting, Finished, Habituating, Held, Saturated, WaitingForBody};
        if let Some(why) = text.strip_prefix("stuck: ") {
            return Ok(Self::Stuck(why.to_owned()));
        }
        let states = [Acting, Saturated, Habituating, Held, Finished, WaitingForBody];
        let known = states.into_iter().find(|state| state.as_str() == text);
        known.ok_or_else(|| format!("{text:?} is not the state of a stage"))
    }
}

/// How near a stage is to saturation: nothing new and nothing exciting for some actions in a row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SaturationStatus {
    /// Quiet actions in a row up to now: no schema was made and the top excitation was below `saturation_below`.
    pub quiet_actions: u32,
    /// How many the stage asks for; 1 or more.
    pub quiet_actions_wanted: u32,
    /// The excitation that the top one must be below; compare `excitation_top` of the status.
    pub saturation_below: f64,
}

/// What a stage asks of its schemas before the next constraint is lifted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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

/// What a curriculum has done so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Report {
    /// The curriculum's name.
    pub curriculum: String,
    /// The learner's seed.
    pub seed: u64,
    /// The present stage.
    pub stage: String,
    /// What the curriculum is doing.
    pub stage_state: StageState,
    /// Whether the last stage is over.
    pub finished: bool,
    /// Why it can't go on, if it can't.
    pub stuck: Option<String>,
    /// Steps taken.
    pub step: u64,
    /// Schemas now.
    pub schemas_total: u32,
    /// Those with constants only.
    pub schemas_concrete: u32,
    /// Those with variables.
    pub schemas_generalised: u32,
    /// Actions carried out in all stages.
    pub actions_total: u64,
    /// Median step latency since the daemon began.
    pub step_latency_us_p50: f64,
    /// 99th percentile of it.
    pub step_latency_us_p99: f64,
    /// Digest of everything learnt, once the curriculum has come to its end: it costs time in proportion to
    /// memory, and those who watch a run ask often. The status always has it.
    pub memory_digest: Option<String>,
    /// The stages entered so far.
    pub stages: Vec<StageSummary>,
}

/// One stage of a curriculum.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct StageSummary {
    /// Its name.
    pub name: String,
    /// Whether anything was learnt in it, or only measured.
    pub learning: bool,
    /// Actions carried out.
    pub actions: u64,
    /// Schemas made.
    pub schemas_new: u32,
    /// Generalised ones among them.
    pub generalised_new: u32,
    /// Counter-examples among them.
    pub counter_examples_new: u32,
    /// Trials begun.
    pub trials: u32,
    /// Trials that ended with what they were waiting for.
    pub trials_met: u32,
    /// Of these, those that needed one action.
    pub trials_met_first: u32,
    /// Generalised schemas in memory at the end of each trial.
    pub generalised_after_trial: Vec<u32>,
    /// Actions of each trial that is over.
    pub actions_of_trial: Vec<u32>,
    /// What was drawn for each trial (table positions).
    pub drawn: Vec<i64>,
    /// Whether it ended by saturation.
    pub saturated: bool,
    /// Whether it is over.
    pub ended: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_travels_as_it_prints() {
        let stuck = StageState::Stuck("the body has no command: \"place\"".to_owned());
        for state in [StageState::Held, StageState::WaitingForBody, stuck] {
            let text = serde_json::to_string(&state).unwrap();
            assert_eq!(text, format!("{:?}", state.to_string()));
            assert_eq!(serde_json::from_str::<StageState>(&text).unwrap(), state);
        }
        assert!(serde_json::from_str::<StageState>("\"stuck\"").is_err());
    }
}
