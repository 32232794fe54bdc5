//! Developmental control and goals: what moves them, and where they stand.

use pschema_learner::progress as live;
use pschema_learner::pursuit;
use pschema_learner::vocabulary::BodyId;
use serde::{Deserialize, Serialize};

use super::effect::ChainLink;
use super::observation::{Pattern, back, list};
use super::{Impossible, index};

/// Utterances that one stage may have, whatever a curriculum allows at present.
const UTTERANCES_MAX: u32 = 65_536;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum StageEffect {
    Begun { student: u16, pools: Vec<Vec<i64>>, random: u64 },
    Entered { stage: u64, name: String },
    TrialBegun { drawn: Vec<(u64, i64)> },
    Acted { concrete_new: u32, generalised_new: u32, counter_examples_new: u32, absent: bool },
    Spoken { utterances: Vec<u32>, random: u64 },
    Quiet(bool),
    TrialEnded { met: bool, generalised: u32 },
    Saturated,
    Ended,
    Finished,
    Held(bool),
    Stuck(String),
    Left,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Because {
    First,
    NotReached,
    NextNotAllowed,
    NotCarriedOut,
    Interrupted,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Ending {
    Achieved,
    NothingLeadsThere,
    ActionsUsedUp,
    Constrained,
    Cancelled,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PlanMade {
    after_actions: u32,
    because: Because,
    chain: Vec<ChainLink>,
    probability: f64,
    truncated: bool,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum PursuitEffect {
    Begun { body: u16, goal: Vec<Pattern>, actions_max: u32 },
    Planned(PlanMade),
    Acted,
    Ended(Ending),
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Pursuit {
    number: u64,
    pub(super) body: u16,
    pub(super) goal: Vec<Pattern>,
    actions_max: u32,
    actions: u32,
    plans_made: u32,
    plans: Vec<PlanMade>,
    ended: Option<Ending>,
}

/// Without its pools and reports, which are blocks of their own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Progress {
    student: Option<u16>,
    stage: u64,
    begun: bool,
    finished: bool,
    held: bool,
    stuck: Option<String>,
    trial_open: bool,
    trial_actions: u32,
    absent_actions: u32,
    trial_fresh: bool,
    said: Vec<u32>,
    quiet_actions: u32,
    habituating: bool,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct StageReport {
    name: String,
    first_step: u64,
    actions: u64,
    concrete_new: u32,
    generalised_new: u32,
    counter_examples_new: u32,
    trials: u32,
    trials_met: u32,
    trials_met_first: u32,
    actions_of_trial: Vec<u32>,
    generalised_after_trial: Vec<u32>,
    drawn: Vec<i64>,
    saturated: bool,
    ended: bool,
}

impl From<&live::StageEffect> for StageEffect {
    fn from(effect: &live::StageEffect) -> Self {
        use live::StageEffect as Live;
        match effect {
            Live::Begun { student, pools, random } => {
                Self::Begun { student: student.0, pools: pools.clone(), random: *random }
            }
            Live::Entered { stage, name } => Self::Entered { stage: *stage as u64, name: name.clone() },
            Live::TrialBegun { drawn } => {
                let drawn = drawn.iter().map(|(pool, number)| (*pool as u64, *number)).collect();
                Self::TrialBegun { drawn }
            }
            Live::Acted { concrete_new, generalised_new, counter_examples_new, absent } => Self::Acted {
                concrete_new: *concrete_new,
                generalised_new: *generalised_new,
                counter_examples_new: *counter_examples_new,
                absent: *absent,
            },
            Live::Spoken { utterances, random } => {
                let number = |at: &usize| u32::try_from(*at).unwrap_or(u32::MAX);
                Self::Spoken { utterances: utterances.iter().map(number).collect(), random: *random }
            }
            Live::Quiet(quiet) => Self::Quiet(*quiet),
            Live::TrialEnded { met, generalised } => {
                Self::TrialEnded { met: *met, generalised: *generalised }
            }
            Live::Saturated => Self::Saturated,
            Live::Ended => Self::Ended,
            Live::Finished => Self::Finished,
            Live::Held(held) => Self::Held(*held),
            Live::Stuck(reason) => Self::Stuck(reason.clone()),
            Live::Left => Self::Left,
        }
    }
}

impl TryFrom<StageEffect> for live::StageEffect {
    type Error = Impossible;

    fn try_from(effect: StageEffect) -> Result<Self, Impossible> {
        Ok(match effect {
            StageEffect::Begun { student, pools, random } => {
                Self::Begun { student: BodyId(student), pools, random }
            }
            StageEffect::Entered { stage, name } => Self::Entered { stage: index(stage), name },
            StageEffect::TrialBegun { drawn } => {
                let drawn = drawn.into_iter().map(|(pool, number)| (index(pool), number)).collect();
                Self::TrialBegun { drawn }
            }
            StageEffect::Acted { concrete_new, generalised_new, counter_examples_new, absent } => {
                Self::Acted { concrete_new, generalised_new, counter_examples_new, absent }
            }
            StageEffect::Spoken { utterances, random } => {
                if utterances.iter().any(|at| *at >= UTTERANCES_MAX) {
                    return Err(Impossible("an utterance"));
                }
                Self::Spoken { utterances: utterances.into_iter().map(|at| at as usize).collect(), random }
            }
            StageEffect::Quiet(quiet) => Self::Quiet(quiet),
            StageEffect::TrialEnded { met, generalised } => Self::TrialEnded { met, generalised },
            StageEffect::Saturated => Self::Saturated,
            StageEffect::Ended => Self::Ended,
            StageEffect::Finished => Self::Finished,
            StageEffect::Held(held) => Self::Held(held),
            StageEffect::Stuck(reason) => Self::Stuck(reason),
            StageEffect::Left => Self::Left,
        })
    }
}

impl From<&pursuit::PlanRecord> for PlanMade {
    fn from(plan: &pursuit::PlanRecord) -> Self {
        let because = match plan.because {
            pursuit::PlanCause::First => Because::First,
            pursuit::PlanCause::NotReached => Because::NotReached,
            pursuit::PlanCause::NextNotAllowed => Because::NextNotAllowed,
            pursuit::PlanCause::NotCarriedOut => Because::NotCarriedOut,
            pursuit::PlanCause::Interrupted => Because::Interrupted,
        };
        Self {
            after_actions: plan.after_actions,
            because,
            chain: list(&plan.chain),
            probability: plan.probability,
            truncated: plan.truncated,
        }
    }
}

impl From<PlanMade> for pursuit::PlanRecord {
    fn from(plan: PlanMade) -> Self {
        let because = match plan.because {
            Because::First => pursuit::PlanCause::First,
            Because::NotReached => pursuit::PlanCause::NotReached,
            Because::NextNotAllowed => pursuit::PlanCause::NextNotAllowed,
            Because::NotCarriedOut => pursuit::PlanCause::NotCarriedOut,
            Because::Interrupted => pursuit::PlanCause::Interrupted,
        };
        Self {
            after_actions: plan.after_actions,
            because,
            chain: back(plan.chain),
            probability: plan.probability,
            truncated: plan.truncated,
        }
    }
}

impl From<pursuit::Ending> for Ending {
    fn from(ending: pursuit::Ending) -> Self {
        match ending {
            pursuit::Ending::Achieved => Self::Achieved,
            pursuit::Ending::NothingLeadsThere => Self::NothingLeadsThere,
            pursuit::Ending::ActionsUsedUp => Self::ActionsUsedUp,
            pursuit::Ending::Constrained => Self::Constrained,
            pursuit::Ending::Cancelled => Self::Cancelled,
        }
    }
}

impl From<Ending> for pursuit::Ending {
    fn from(ending: Ending) -> Self {
        match ending {
            Ending::Achieved => Self::Achieved,
            Ending::NothingLeadsThere => Self::NothingLeadsThere,
            Ending::ActionsUsedUp => Self::ActionsUsedUp,
            Ending::Constrained => Self::Constrained,
            Ending::Cancelled => Self::Cancelled,
        }
    }
}

impl From<&pursuit::PursuitEffect> for PursuitEffect {
    fn from(effect: &pursuit::PursuitEffect) -> Self {
        use pursuit::PursuitEffect as Live;
        match effect {
            Live::Begun { body, goal, actions_max } => {
                Self::Begun { body: body.0, goal: list(goal), actions_max: *actions_max }
            }
            Live::Planned(plan) => Self::Planned(plan.into()),
            Live::Acted => Self::Acted,
            Live::Ended(ending) => Self::Ended((*ending).into()),
        }
    }
}

impl From<PursuitEffect> for pursuit::PursuitEffect {
    fn from(effect: PursuitEffect) -> Self {
        match effect {
            PursuitEffect::Begun { body, goal, actions_max } => {
                Self::Begun { body: BodyId(body), goal: back(goal), actions_max }
            }
            PursuitEffect::Planned(plan) => Self::Planned(plan.into()),
            PursuitEffect::Acted => Self::Acted,
            PursuitEffect::Ended(ending) => Self::Ended(ending.into()),
        }
    }
}

impl PlanMade {
    pub(super) fn chain(&self) -> &[ChainLink] {
        &self.chain
    }
}

impl Pursuit {
    /// Every link of every chain in it.
    pub(super) fn chains(&self) -> impl Iterator<Item = &ChainLink> {
        self.plans.iter().flat_map(|plan| &plan.chain)
    }
}

impl From<&pursuit::Pursuit> for Pursuit {
    fn from(live: &pursuit::Pursuit) -> Self {
        Self {
            number: live.number,
            body: live.body.0,
            goal: list(&live.goal),
            actions_max: live.actions_max,
            actions: live.actions,
            plans_made: live.plans_made,
            plans: list(&live.plans),
            ended: live.ended.map(Ending::from),
        }
    }
}

impl From<Pursuit> for pursuit::Pursuit {
    fn from(disk: Pursuit) -> Self {
        Self {
            number: disk.number,
            body: BodyId(disk.body),
            goal: back(disk.goal),
            actions_max: disk.actions_max,
            actions: disk.actions,
            plans_made: disk.plans_made,
            plans: back(disk.plans),
            ended: disk.ended.map(pursuit::Ending::from),
        }
    }
}

impl From<&live::StageReport> for StageReport {
    fn from(report: &live::StageReport) -> Self {
        let report = report.clone();
        Self {
            name: report.name,
            first_step: report.first_step,
            actions: report.actions,
            concrete_new: report.concrete_new,
            generalised_new: report.generalised_new,
            counter_examples_new: report.counter_examples_new,
            trials: report.trials,
            trials_met: report.trials_met,
            trials_met_first: report.trials_met_first,
            actions_of_trial: report.actions_of_trial,
            generalised_after_trial: report.generalised_after_trial,
            drawn: report.drawn,
            saturated: report.saturated,
            ended: report.ended,
        }
    }
}

impl From<StageReport> for live::StageReport {
    fn from(report: StageReport) -> Self {
        Self {
            name: report.name,
            first_step: report.first_step,
            actions: report.actions,
            concrete_new: report.concrete_new,
            generalised_new: report.generalised_new,
            counter_examples_new: report.counter_examples_new,
            trials: report.trials,
            trials_met: report.trials_met,
            trials_met_first: report.trials_met_first,
            actions_of_trial: report.actions_of_trial,
            generalised_after_trial: report.generalised_after_trial,
            drawn: report.drawn,
            saturated: report.saturated,
            ended: report.ended,
        }
    }
}

impl From<&live::Progress> for Progress {
    fn from(progress: &live::Progress) -> Self {
        Self {
            student: progress.student.map(|body| body.0),
            stage: progress.stage as u64,
            begun: progress.begun,
            finished: progress.finished,
            held: progress.held,
            stuck: progress.stuck.clone(),
            trial_open: progress.trial_open,
            trial_actions: progress.trial_actions,
            absent_actions: progress.absent_actions,
            trial_fresh: progress.trial_fresh,
            said: progress.said.clone(),
            quiet_actions: progress.quiet_actions,
            habituating: progress.habituating,
        }
    }
}

impl From<Progress> for live::Progress {
    fn from(progress: Progress) -> Self {
        Self {
            student: progress.student.map(BodyId),
            // These follow in blocks of their own.
            pools: Vec::new(),
            reports: Vec::new(),
            stage: index(progress.stage),
            begun: progress.begun,
            finished: progress.finished,
            held: progress.held,
            stuck: progress.stuck,
            trial_open: progress.trial_open,
            trial_actions: progress.trial_actions,
            absent_actions: progress.absent_actions,
            trial_fresh: progress.trial_fresh,
            said: progress.said,
            quiet_actions: progress.quiet_actions,
            habituating: progress.habituating,
        }
    }
}
