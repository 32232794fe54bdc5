//! The learner with what a host of it needs: words waiting to be heard, the last decisions, step times. The
//! daemon and the in-process runner are two hosts of the same mind.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Instant;

use pschema_learner::curriculum::Curriculum;
use pschema_learner::decision::Decision;
use pschema_learner::effect::Effect;
use pschema_learner::memory::Content;
use pschema_learner::notation;
use pschema_learner::parameters::Parameters;
use pschema_learner::progress::{StageCommand, StageCommandError, StageEffect};
use pschema_learner::schema::SchemaId;
use pschema_learner::step::{Learner, LearnerError};
use pschema_learner::vocabulary::limits::SYMBOLS_MAX;
use pschema_protocol::inspect::BodyStatus;
use pschema_protocol::message::RawFrame;

use crate::latency::Latencies;
use crate::session::{Served, Session, WORD_BYTES_MAX, WORDS_WAITING_MAX, is_waiting};

/// Decisions that can be explained: the last of them.
pub const DECISIONS_KEPT_MAX: usize = 64;

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

/// Why words can't be said.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SayError {
    /// There are none.
    #[error("there is nothing to say: give at least one word")]
    Nothing,
    /// One of them is no word.
    #[error("{word:?} is no word: give 1 to {WORD_BYTES_MAX} bytes without spaces")]
    Word {
        /// What was given.
        word: String,
    },
    /// Too many are waiting.
    #[error(
        "{waiting} words are waiting to be heard, and at most {WORDS_WAITING_MAX} can: is a body attached?"
    )]
    Waiting {
        /// How many would wait.
        waiting: usize,
    },
    /// The learner takes no steps now.
    #[error("nobody would hear it: the learner is {state}; see `pschema stage`")]
    Holding {
        /// Why.
        state: String,
    },
    /// Memory has no room for another word.
    #[error("the learner knows {SYMBOLS_MAX} words and symbols, which is all it can hold")]
    Full,
}

/// A learner and what its host keeps beside it.
#[derive(Debug)]
pub struct Mind {
    learner: Learner,
    seed: u64,
    curriculum: Arc<Curriculum>,
    words: Vec<String>,
    decisions: VecDeque<Arc<Decision>>,
    latencies: Latencies,
    started: Instant,
    /// What the host could not do for the learner, last.
    problem: Option<String>,
}

impl Mind {
    /// A learner that knows nothing.
    ///
    /// # Errors
    /// When a parameter is out of range or the curriculum can't be followed.
    pub fn new(setup: Setup) -> Result<Self, LearnerError> {
        let Setup { seed, parameters, curriculum } = setup;
        Ok(Self {
            learner: Learner::new(seed, parameters, curriculum.clone())?,
            seed,
            curriculum: Arc::new(curriculum),
            words: Vec::new(),
            decisions: VecDeque::with_capacity(DECISIONS_KEPT_MAX),
            latencies: Latencies::default(),
            started: Instant::now(),
            problem: None,
        })
    }

    /// The learner.
    #[must_use]
    pub fn learner(&self) -> &Learner {
        &self.learner
    }

    /// The learner, for a body to attach to.
    pub(crate) fn learner_mut(&mut self) -> &mut Learner {
        &mut self.learner
    }

    /// Whether a frame of this body would take the words that wait: it is the student's, or that of any
    /// body while the student is not attached.
    #[must_use]
    pub fn is_listening(&self, session: &Session, student_attached: bool) -> bool {
        !student_attached || self.learner.memory().content().progress.student == Some(session.body())
    }

    /// Serves one frame; see [`Session::frame`]. `listening` says whether words that wait are heard with it.
    pub fn serve(&mut self, session: &mut Session, raw: &RawFrame, listening: bool) -> Served {
        let mut none = Vec::new();
        let words = if listening { &mut self.words } else { &mut none };
        let mut served = session.frame(&mut self.learner, raw, words);
        if let Some(problem) = &served.problem {
            tracing::error!(session = session.number(), %problem, "the body could not be told what to do");
            self.problem = Some(problem.to_string());
        }
        if let Some(step) = &mut served.step {
            log(self.learner.memory().content(), &step.effects);
            if let Some(decision) = step.decision.take() {
                if self.decisions.len() == DECISIONS_KEPT_MAX {
                    self.decisions.pop_front();
                }
                self.decisions.push_back(Arc::new(decision));
            }
        }
        served
    }

    /// Counts a step that began at `began` and has just been replied to.
    pub fn count_step(&mut self, began: Instant) {
        let now = Instant::now();
        self.latencies.count(now.saturating_duration_since(began), now);
    }

    /// Says words, which are heard with the next frame.
    ///
    /// # Errors
    /// When they can't be; none is heard then.
    pub fn say(&mut self, words: &[String]) -> Result<(), SayError> {
        if words.is_empty() {
            return Err(SayError::Nothing);
        }
        let sound = |word: &str| {
            (1..=WORD_BYTES_MAX).contains(&word.len())
                && !word.chars().any(|c| c.is_whitespace() || c.is_control())
        };
        if let Some(word) = words.iter().find(|word| !sound(word)) {
            return Err(SayError::Word { word: word.clone() });
        }
        let waiting = self.words.len().saturating_add(words.len());
        if waiting > WORDS_WAITING_MAX {
            return Err(SayError::Waiting { waiting });
        }
        if is_waiting(&self.learner) {
            return Err(SayError::Holding { state: self.state(true) });
        }
        if self.learner.memory().content().vocabulary.symbols().len().saturating_add(waiting) > SYMBOLS_MAX {
            return Err(SayError::Full);
        }
        self.words.extend_from_slice(words);
        Ok(())
    }

    /// Obeys an operator's developmental control.
    ///
    /// # Errors
    /// When there is no such stage.
    pub fn stage(&mut self, command: &StageCommand) -> Result<(), StageCommandError> {
        let effects = self.learner.stage(command)?;
        log(self.learner.memory().content(), &effects);
        self.problem = None;
        Ok(())
    }

    /// Why the curriculum can't go on, if it can't.
    fn stuck(&self) -> Option<String> {
        let reason = self.learner.memory().content().progress.stuck.as_ref()?;
        let detail = self.problem.as_ref().map_or(String::new(), |problem| format!(" ({problem})"));
        Some(format!("{reason}{detail}"))
    }

    /// What the curriculum is doing, in words.
    #[must_use]
    pub fn state(&self, attached: bool) -> String {
        if let Some(reason) = self.stuck() {
            return format!("stuck: {reason}");
        }
        let progress = &self.learner.memory().content().progress;
        let word = if progress.held {
            "held"
        } else if progress.finished {
            "finished"
        } else if !attached {
            "waiting for a body"
        } else if progress.habituating {
            "habituating"
        } else if progress.report().is_some_and(|report| report.saturated) {
            "saturated"
        } else {
            "acting"
        };
        word.to_owned()
    }

    /// Everything there is to inspect, as it is now.
    #[must_use]
    pub fn view(&self, host: HostFacts) -> View {
        let now = Instant::now();
        let attached = host.bodies.iter().any(|body| body.state == "attached");
        View {
            content: self.learner.memory().content().clone(),
            curriculum: self.curriculum.clone(),
            seed: self.seed,
            decisions: self.decisions.iter().cloned().collect(),
            state: self.state(attached),
            stuck: self.stuck(),
            uptime_s: now.saturating_duration_since(self.started).as_secs_f64(),
            steps_per_s: self.latencies.rate(now, self.started),
            latencies: self.latencies.clone(),
            host,
        }
    }
}

/// What only the host knows.
#[derive(Clone, Debug, Default)]
pub struct HostFacts {
    /// The learner's name.
    pub name: String,
    /// Bodies attached now or before.
    pub bodies: Vec<BodyStatus>,
    /// What is perceived now, as it prints.
    pub world: Vec<String>,
}

/// A learner as it was at one moment, to be inspected at leisure: shares memory's chunks, so that making it
/// delays nothing.
#[derive(Clone, Debug)]
pub struct View {
    pub(crate) content: Content,
    pub(crate) curriculum: Arc<Curriculum>,
    pub(crate) seed: u64,
    pub(crate) decisions: Vec<Arc<Decision>>,
    pub(crate) state: String,
    pub(crate) stuck: Option<String>,
    pub(crate) uptime_s: f64,
    pub(crate) steps_per_s: f64,
    pub(crate) latencies: Latencies,
    pub(crate) host: HostFacts,
}

/// Tells the log what people want to follow: stages and generalisations.
fn log(content: &Content, effects: &[Effect]) {
    for effect in effects {
        match effect {
            Effect::Stage(StageEffect::Entered { name, .. }) => {
                tracing::info!(stage = %name, step = content.step, schemas = content.schemas.len(), "stage entered");
            }
            Effect::Stage(StageEffect::Saturated) => tracing::info!(step = content.step, "stage saturated"),
            Effect::Stage(StageEffect::Finished) => {
                tracing::info!(step = content.step, "curriculum finished")
            }
            Effect::Stage(StageEffect::Stuck(reason)) => tracing::error!(%reason, "the curriculum is stuck"),
            Effect::Generalised { .. } => {
                let last = content.schemas.len().checked_sub(1).and_then(|at| u32::try_from(at).ok());
                let schema = last.and_then(|at| content.schema(SchemaId(at)));
                let schema = schema.map(|schema| notation::schema(content, schema));
                tracing::info!(schema = schema.unwrap_or_default(), step = content.step, "generalised");
            }
            Effect::Retired { generalised } => {
                tracing::info!(schema = generalised.0, "generalised schema retired")
            }
            _ => (),
        }
    }
}
