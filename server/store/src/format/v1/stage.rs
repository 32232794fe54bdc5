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
        ..pools,
        ..reports,
    }

    /// What happened in a stage.
    struct StageReport = live::StageReport {
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
}
