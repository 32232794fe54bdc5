//! Where a curriculum stands, as part of memory, and the effects that move it.

use std::sync::Arc;

use crate::nouns::vocabulary::BodyId;

/// Stage reports kept; older ones are dropped.
pub const REPORTS_MAX: usize = 256;

/// Where a curriculum stands (II-F): part of memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Progress {
    /// The body that the curriculum arranges things for: the first body with a repertoire that sent a frame.
    pub student: Option<BodyId>,
    /// The numbers left in each pool; the number that is drawn next is the last.
    pub pools: Vec<Arc<Vec<i64>>>,
    /// The stage, as an index into the curriculum.
    pub stage: usize,
    /// Whether the curriculum has begun.
    pub begun: bool,
    /// Whether the last stage is over.
    pub finished: bool,
    /// Whether an operator holds the learner.
    pub held: bool,
    /// Why the curriculum can't go on, if it can't.
    pub stuck: Option<String>,
    /// Whether the present trial has been arranged and not yet ended.
    pub trial_open: bool,
    /// The number of actions in the present trial.
    pub trial_actions: u32,
    /// The number of actions in a row in the present trial after which the observation of `Stage::until_absent` was not made.
    pub absent_actions: u32,
    /// Whether no frame has come since the present trial was begun.
    pub trial_fresh: bool,
    /// How often each utterance of the stage was said in the present trial; empty before the first.
    pub said: Vec<u32>,
    /// The number of actions in a row that brought no schema and left nothing exciting.
    pub quiet_actions: u32,
    /// Whether the stage is saturated and being habituated to.
    pub habituating: bool,
    /// One report for each stage entered, the present one last.
    pub reports: Vec<Arc<StageReport>>,
}

/// A report of what happened in one stage.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StageReport {
    /// The stage's name.
    pub name: String,
    /// The step in which it began.
    pub first_step: u64,
    /// The number of actions that were carried out.
    pub actions: u64,
    /// The number of concrete schemas that were made.
    pub concrete_new: u32,
    /// The number of generalised schemas that were made.
    pub generalised_new: u32,
    /// The number of counter-examples among the concrete ones (IV-A).
    pub counter_examples_new: u32,
    /// The number of trials that were begun.
    pub trials: u32,
    /// The number of trials that ended by `Stage::until` or `Stage::until_absent`.
    pub trials_met: u32,
    /// The number of those that needed one action.
    pub trials_met_first: u32,
    /// The number of actions of each trial that is over.
    pub actions_of_trial: Vec<u32>,
    /// The number of generalised schemas in memory at the end of each trial.
    pub generalised_after_trial: Vec<u32>,
    /// The numbers that were drawn, in order.
    pub drawn: Vec<i64>,
    /// Whether it ended by saturation.
    pub saturated: bool,
    /// Whether it is over.
    pub ended: bool,
}

/// A change of where the curriculum stands.
#[derive(Clone, Debug, PartialEq)]
pub enum StageEffect {
    /// The curriculum began for this body, with its pools in this order.
    Begun {
        /// The body it arranges things for.
        student: BodyId,
        /// The pools, shuffled.
        pools: Vec<Vec<i64>>,
        /// The state of the generator after shuffling.
        random: u64,
    },
    /// A stage was entered.
    Entered {
        /// Its index in the curriculum.
        stage: usize,
        /// Its name.
        name: String,
    },
    /// A trial was begun.
    TrialBegun {
        /// The numbers that were drawn for it, each with the index of its pool, in the order in which they were drawn.
        drawn: Vec<(usize, i64)>,
    },
    /// An action was carried out.
    Acted {
        /// Concrete schemas made from it.
        concrete_new: u32,
        /// Generalised schemas made from it.
        generalised_new: u32,
        /// Counter-examples among the concrete ones.
        counter_examples_new: u32,
        /// Whether the stage has `Stage::until_absent`, and its observation was not made.
        absent: bool,
    },
    /// A frame came in a trial of a stage in which a teacher speaks.
    Spoken {
        /// The utterances that were said, by their places in the stage.
        utterances: Vec<usize>,
        /// The state of the generator after the draws for them.
        random: u64,
    },
    /// The top excitation after an action was below the saturation level, or not.
    Quiet(bool),
    /// The trial ended.
    TrialEnded {
        /// Whether it ended by `Stage::until` or `Stage::until_absent`.
        met: bool,
        /// The number of generalised schemas in memory.
        generalised: u32,
    },
    /// The stage is saturated; from now on the learner habituates.
    Saturated,
    /// The stage is over.
    Ended,
    /// The last stage is over.
    Finished,
    /// An operator holds the learner, or lets it go on.
    Held(bool),
    /// The surroundings can't be arranged as the curriculum asks.
    Stuck(String),
    /// The curriculum is given up for another, which begins with the next frame of a body that can act.
    Left,
}

/// The activity of a learner, as far as its curriculum decides it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Activity {
    /// The curriculum can't go on; [`Progress::stuck`] says why.
    Stuck,
    /// An operator holds the learner.
    Held,
    /// The last stage is over.
    Finished,
    /// The stage is saturated, and its schemas are executed until they are known well enough.
    Habituating,
    /// The stage is saturated.
    Saturated,
    /// The stage goes on.
    Acting,
}

impl Progress {
    /// The activity of the learner.
    #[must_use]
    pub fn activity(&self) -> Activity {
        if self.stuck.is_some() {
            Activity::Stuck
        } else if self.held {
            Activity::Held
        } else if self.finished {
            Activity::Finished
        } else if self.habituating {
            Activity::Habituating
        } else if self.report().is_some_and(|report| report.saturated) {
            Activity::Saturated
        } else {
            Activity::Acting
        }
    }

    /// The report of the present stage.
    #[must_use]
    pub fn report(&self) -> Option<&StageReport> {
        self.reports.last().map(Arc::as_ref)
    }

    /// Moves by an effect that was checked, in the step of this number.
    pub(crate) fn apply(&mut self, effect: &StageEffect, step: u64) {
        match effect {
            StageEffect::Begun { student, pools, random: _ } => {
                self.student = Some(*student);
                self.pools = pools.iter().cloned().map(Arc::new).collect();
                self.begun = true;
            }
            StageEffect::Entered { stage, name } => {
                self.stage = *stage;
                self.finished = false;
                self.stuck = None;
                self.close_stage();
                let report = StageReport { name: name.clone(), first_step: step, ..StageReport::default() };
                self.reports.push(Arc::new(report));
                if self.reports.len() > REPORTS_MAX {
                    self.reports.remove(0);
                }
            }
            StageEffect::TrialBegun { drawn } => {
                for (pool, _) in drawn {
                    self.pools.get_mut(*pool).and_then(|pool| Arc::make_mut(pool).pop());
                }
                self.close_trial();
                self.trial_open = true;
                self.trial_fresh = true;
                self.trial_actions = 0;
                self.in_report(|report| {
                    report.trials = report.trials.saturating_add(1);
                    report.drawn.extend(drawn.iter().map(|(_, number)| *number));
                });
            }
            StageEffect::Acted { concrete_new, generalised_new, counter_examples_new, absent } => {
                self.trial_actions = self.trial_actions.saturating_add(1);
                self.absent_actions = if *absent { self.absent_actions.saturating_add(1) } else { 0 };
                self.in_report(|report| {
                    report.actions = report.actions.saturating_add(1);
                    for (total, new) in [
                        (&mut report.concrete_new, concrete_new),
                        (&mut report.generalised_new, generalised_new),
                        (&mut report.counter_examples_new, counter_examples_new),
                    ] {
                        *total = total.saturating_add(*new);
                    }
                });
            }
            StageEffect::Spoken { utterances, random: _ } => {
                self.trial_fresh = false;
                for at in utterances {
                    if self.said.len() <= *at {
                        self.said.resize(*at + 1, 0);
                    }
                    self.said[*at] = self.said[*at].saturating_add(1);
                }
            }
            StageEffect::Quiet(quiet) => {
                self.quiet_actions = if *quiet { self.quiet_actions.saturating_add(1) } else { 0 };
            }
            StageEffect::TrialEnded { met, generalised } => {
                let actions = self.trial_actions;
                let first = actions == 1;
                self.close_trial();
                self.in_report(|report| {
                    report.actions_of_trial.push(actions);
                    report.trials_met = report.trials_met.saturating_add(u32::from(*met));
                    report.trials_met_first =
                        report.trials_met_first.saturating_add(u32::from(*met && first));
                    report.generalised_after_trial.push(*generalised);
                });
            }
            StageEffect::Saturated => {
                self.habituating = true;
                self.in_report(|report| report.saturated = true);
            }
            StageEffect::Ended => self.in_report(|report| report.ended = true),
            StageEffect::Finished => {
                self.close_stage();
                self.finished = true;
            }
            StageEffect::Held(held) => self.held = *held,
            StageEffect::Stuck(reason) => self.stuck = Some(reason.clone()),
            // An operator who holds the learner goes on holding it.
            StageEffect::Left => *self = Self { held: self.held, ..Self::default() },
        }
    }

    fn close_stage(&mut self) {
        self.close_trial();
        self.trial_actions = 0;
    }

    fn close_trial(&mut self) {
        self.trial_open = false;
        self.trial_fresh = false;
        self.said.clear();
        self.absent_actions = 0;
        self.quiet_actions = 0;
        self.habituating = false;
    }

    fn in_report(&mut self, change: impl FnOnce(&mut StageReport)) {
        if let Some(report) = self.reports.last_mut() {
            change(Arc::make_mut(report));
        }
    }
}

/// An operator's developmental control.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StageCommand {
    /// End the present stage and enter the next.
    Next,
    /// Wait, until [`StageCommand::Resume`].
    Hold,
    /// Go on.
    Resume,
    /// Enter the stage of this name.
    Set(String),
}

/// Why a stage command can't be obeyed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StageCommandError {
    /// No stage has that name.
    #[error("no stage is named {name:?}; the curriculum has {known}")]
    Unknown {
        /// The name given.
        name: String,
        /// The names there are.
        known: String,
    },
    /// The present stage is the last.
    #[error("{name:?} is the last stage; name one to go back to")]
    Last {
        /// The present stage.
        name: String,
    },
}
