//! Where the curriculum stands, as the reference learner keeps it.

use pschema_learner::progress::StageEffect;
use pschema_learner::random::Random;
use pschema_learner::vocabulary::BodyId;

use super::memory::Memory;

/// Where the curriculum stands.
#[derive(Clone, Debug, Default)]
pub(crate) struct Standing {
    pub(crate) student: Option<BodyId>,
    pub(crate) pools: Vec<Vec<i64>>,
    pub(crate) begun: bool,
    pub(crate) entered: bool,
    pub(crate) finished: bool,
    pub(crate) held: bool,
    pub(crate) stuck: bool,
    pub(crate) stage: usize,
    pub(crate) trials: u32,
    pub(crate) trial_open: bool,
    pub(crate) trial_actions: u32,
    /// Actions in a row after which what the trial ends without was not observed.
    pub(crate) absent_actions: u32,
    /// Whether no frame of the student has come since the trial was begun.
    pub(crate) fresh: bool,
    /// What was said in the trial, each time.
    pub(crate) said: Vec<usize>,
    pub(crate) quiet_actions: u32,
    pub(crate) habituating: bool,
    /// The step in which the stage was entered.
    pub(crate) first_step: u64,
}

impl Memory {
    pub(crate) fn staged(&mut self, effect: &StageEffect) {
        let standing = &mut self.standing;
        match effect {
            StageEffect::Begun { student, pools, random } => {
                standing.begun = true;
                standing.student = Some(*student);
                standing.pools.clone_from(pools);
                self.random = Random::from_seed(*random);
            }
            StageEffect::Entered { stage, .. } => {
                *standing = Standing {
                    student: standing.student,
                    pools: std::mem::take(&mut standing.pools),
                    begun: standing.begun,
                    entered: true,
                    held: standing.held,
                    stage: *stage,
                    first_step: self.step,
                    ..Standing::default()
                };
                self.pending.fill(None);
            }
            StageEffect::TrialBegun { drawn } => {
                for (pool, number) in drawn {
                    assert_eq!(standing.pools[*pool].pop(), Some(*number));
                }
                standing.trials += 1;
                standing.trial_open = true;
                standing.trial_actions = 0;
                standing.quiet_actions = 0;
                standing.absent_actions = 0;
                standing.said.clear();
                standing.fresh = true;
            }
            StageEffect::Acted { absent, .. } => {
                standing.trial_actions += 1;
                standing.absent_actions = if *absent { standing.absent_actions + 1 } else { 0 };
            }
            StageEffect::Spoken { utterances, random } => {
                standing.fresh = false;
                standing.said.extend(utterances);
                self.random = Random::from_seed(*random);
            }
            StageEffect::Quiet(true) => standing.quiet_actions += 1,
            StageEffect::Quiet(false) => standing.quiet_actions = 0,
            StageEffect::TrialEnded { .. } => {
                standing.trial_open = false;
                standing.quiet_actions = 0;
                standing.habituating = false;
            }
            StageEffect::Saturated => standing.habituating = true,
            StageEffect::Ended => {}
            StageEffect::Finished => {
                standing.finished = true;
                standing.trial_open = false;
                standing.trial_actions = 0;
                standing.quiet_actions = 0;
                standing.habituating = false;
            }
            StageEffect::Held(held) => standing.held = *held,
            StageEffect::Stuck(_) => standing.stuck = true,
            StageEffect::Left => {
                *standing = Standing { held: standing.held, ..Standing::default() };
            }
        }
    }
}
