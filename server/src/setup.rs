//! What a learner starts from.

use pschema_learner::curriculum::Curriculum;
use pschema_learner::mechanisms::Mechanisms;
use pschema_learner::parameters::Parameters;
use pschema_learner::{Learner, LearnerError};

/// How a learner learns.
#[derive(Clone, Debug, PartialEq)]
pub struct LearnerSettings {
    /// Its numbers and switches.
    pub parameters: Parameters,
    /// The mechanisms beyond the paper that are on.
    pub mechanisms: Mechanisms,
    /// [`Parameters::heard_decays`], where somebody asked for it; none leaves it to the mechanisms.
    pub heard_decays: Option<bool>,
}

impl LearnerSettings {
    /// The paper's parameters, but that words do not wear out what they say of a learner with curiosity: it is drawn elsewhere anyway, and what it is told
    /// many times it is to do as well as what it was told once.
    #[must_use]
    pub fn of(mechanisms: Mechanisms) -> Self {
        let mut settings = Self { parameters: Parameters::default(), mechanisms, heard_decays: None };
        settings.settle();
        settings
    }

    /// Sets what the mechanisms decide where nobody asked for anything.
    pub(crate) fn settle(&mut self) {
        self.parameters.heard_decays = self.heard_decays.unwrap_or(!self.mechanisms.is_curious());
    }
}

/// The full profile.
impl Default for LearnerSettings {
    fn default() -> Self {
        Self::of(Mechanisms::FULL)
    }
}

/// What a learner starts from.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Decides its draws.
    pub seed: u64,
    /// How it learns.
    pub learner: LearnerSettings,
    /// What it is led through.
    pub curriculum: Curriculum,
}

impl Setup {
    /// What `learner` started from, with `seed`, or goes on under now.
    pub(crate) fn of(learner: &Learner, seed: u64) -> Self {
        let memory = learner.memory();
        let (parameters, mechanisms) = (memory.parameters().clone(), memory.content().mechanisms);
        let heard_decays = Some(parameters.heard_decays);
        let settings = LearnerSettings { parameters, mechanisms, heard_decays };
        Self { seed, learner: settings, curriculum: learner.curriculum().clone() }
    }

    /// A learner that knows nothing.
    ///
    /// # Errors
    /// When a parameter is out of range or the curriculum can't be followed.
    pub fn begin(self) -> Result<Learner, LearnerError> {
        let Self { seed, learner: LearnerSettings { parameters, mechanisms, .. }, curriculum } = self;
        let mut learner = Learner::new(seed, parameters, curriculum)?;
        learner.set_mechanisms(mechanisms);
        Ok(learner)
    }
}
