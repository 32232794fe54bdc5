//! What a learner starts from.

use pschema_learner::Learner;
use pschema_learner::curriculum::Curriculum;
use pschema_learner::parameters::Parameters;

/// What a learner starts from.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Decides its draws.
    pub seed: u64,
    /// Its numbers and switches.
    pub parameters: Parameters,
    /// What it is led through.
    pub curriculum: Curriculum,
}

impl Setup {
    /// What `learner` started from, with `seed`, or goes on under now.
    pub(crate) fn of(learner: &Learner, seed: u64) -> Self {
        let parameters = learner.memory().parameters().clone();
        Self { seed, parameters, curriculum: learner.curriculum().clone() }
    }
}
