//! Where a curriculum stands, and what moves it.

use pschema_learner::progress as live;

use crate::format::mirror::mirror;

mirror! {
    /// A change of where the curriculum stands.
    enum StageEffect = live::StageEffect {
        Begun { student: u16, pools: Vec<Vec<i64>>, random: u64 },
        Entered { stage: u64, name: String },
        TrialBegun { drawn: Vec<(u64, i64)> },
        Acted { concrete_new: u32, generalised_new: u32, counter_examples_new: u32, absent: bool },
        Spoken { utterances: Vec<u64>, random: u64 },
        Quiet(quiet: bool),
        TrialEnded { met: bool, generalised: u32 },
        Saturated,
        Ended,
        Finished,
        Held(held: bool),
        Stuck(reason: String),
        Left,
    }

    /// Where the curriculum stands. Pools and reports can be long, so that each of them is an item of its own.
    struct Progress = live::Progress {
        /// The body that the curriculum arranges things for.
        student: Option<u16>,
        /// The stage, from 0.
        stage: u64,
        /// Whether the curriculum has begun.
        begun: bool,
        /// Whether the last stage is over.
        finished: bool,
        /// Whether an operator holds the learner.
        held: bool,
        /// Why the curriculum can't go on, if it can't.
        stuck: Option<String>,
        /// Whether the present trial has been arranged and not yet ended.
        trial_open: bool,
        /// The number of actions in the present trial.
        trial_actions: u32,
        /// After how many actions in a row the observation of `until_absent` was not made.
        absent_actions: u32,
        /// Whether no frame has come since the present trial was begun.
        trial_fresh: bool,
        /// How often each utterance of the stage was said in the present trial; empty before the first.
        said: Vec<u32>,
        /// The number of actions in a row that brought no schema and left nothing exciting.
        quiet_actions: u32,
        /// Whether the stage is saturated and being habituated to.
        habituating: bool,
        ..pools,
        ..reports,
    }

    /// What happened in a stage.
    struct StageReport = live::StageReport {
        /// The name of the stage.
        name: String,
        /// The step in which it was entered.
        first_step: u64,
        /// Actions taken in it.
        actions: u64,
        /// Concrete schemas made in it.
        concrete_new: u32,
        /// Generalised schemas made in it.
        generalised_new: u32,
        /// Counter-examples among the concrete ones.
        counter_examples_new: u32,
        /// Trials begun.
        trials: u32,
        /// Trials that ended by `until` or `until_absent`.
        trials_met: u32,
        /// Those of them that needed one action.
        trials_met_first: u32,
        /// The number of actions of each trial that is over.
        actions_of_trial: Vec<u32>,
        /// The number of generalised schemas in memory at the end of each trial.
        generalised_after_trial: Vec<u32>,
        /// The numbers that were drawn, in their order.
        drawn: Vec<i64>,
        /// Whether it ended by saturation.
        saturated: bool,
        /// Whether it is over.
        ended: bool,
    }
}
