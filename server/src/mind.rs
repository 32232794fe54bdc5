//! The learner with what a host of it needs: words waiting to be heard, the last decisions, step times. The
//! daemon and the in-process runner are two hosts of the same mind.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};

use pschema_inspect::{BodyState, BodyStatus, RefusalCount, StageState, StorageStatus};
use pschema_learner::curriculum::Curriculum;
use pschema_learner::decision::Decision;
use pschema_learner::effect::Effect;
use pschema_learner::memory::Content;
use pschema_learner::notation::{self, PatternError};
use pschema_learner::observation::Observation;
use pschema_learner::parameters::Parameters;
use pschema_learner::progress::{StageCommand, StageCommandError, StageEffect};
use pschema_learner::pursuit::{PursueError, PursuitEffect};
use pschema_learner::schema::SchemaId;
use pschema_learner::vocabulary::BodyId;
use pschema_learner::vocabulary::limits::SYMBOLS_MAX;
use pschema_learner::{Learner, LearnerError, Step};
use pschema_protocol::wire::message::RawFrame;

use crate::growth::Growth;
use crate::latency::Latencies;
use crate::session::{Served, Session, WORD_BYTES_MAX, WORDS_WAITING_MAX, is_through};
use crate::trace::Trace;

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
    /// The learner takes no more steps.
    #[error("nobody would hear it: the learner is {state}; see `pschema stage`")]
    Holding {
        /// Why.
        state: StageState,
    },
    /// Memory has no room for another word.
    #[error("the learner knows {SYMBOLS_MAX} words and symbols, which is all it can hold")]
    Full,
}

/// Why a goal can't be taken up or called off.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GoalError {
    /// One of its patterns can't be read.
    #[error(transparent)]
    Pattern(#[from] PatternError),
    /// The learner can't pursue it.
    #[error(transparent)]
    Pursue(#[from] PursueError),
    /// There has been no goal of that number, or others since.
    #[error("goal {number} is over and forgotten, or never was")]
    Unknown {
        /// The number given.
        number: u64,
    },
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
    commits: Latencies,
    growth: Growth,
    trace: Trace,
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
        Ok(Self::host(Learner::new(seed, parameters, curriculum)?, seed))
    }

    /// Goes on with a learner that began with `seed`.
    #[must_use]
    pub fn resume(learner: Learner, seed: u64) -> Self {
        Self::host(learner, seed)
    }

    fn host(learner: Learner, seed: u64) -> Self {
        Self {
            curriculum: Arc::new(learner.curriculum().clone()),
            learner,
            seed,
            words: Vec::new(),
            decisions: VecDeque::with_capacity(DECISIONS_KEPT_MAX),
            latencies: Latencies::default(),
            commits: Latencies::default(),
            growth: Growth::default(),
            trace: Trace::default(),
            started: Instant::now(),
            problem: None,
        }
    }

    /// The learner.
    #[must_use]
    pub fn learner(&self) -> &Learner {
        &self.learner
    }

    /// The learner alone.
    pub(crate) fn into_learner(self) -> Learner {
        self.learner
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
        let served = session.frame(&mut self.learner, raw, words);
        if let Some(problem) = &served.problem {
            tracing::error!(session = session.number(), %problem, "the body could not be told what to do");
            self.problem = Some(problem.to_string());
        }
        served
    }

    /// Takes account of a step that took `latency` from the frame's arrival until it was decided. It is logged, counted
    /// and kept only now, so that the body does not wait for that.
    pub fn stepped(&mut self, session: &Session, step: Step, latency: Duration) {
        self.latencies.count(latency, Instant::now());
        let Step { effects, decision, .. } = step;
        let memory = self.learner.memory();
        self.growth.count(memory.content().schemas.len(), latency);
        self.trace.keep(memory, &effects, decision.as_ref(), session.perceived(), latency);
        log(memory.content(), &effects);
        if let Some(decision) = decision {
            if self.decisions.len() == DECISIONS_KEPT_MAX {
                self.decisions.pop_front();
            }
            self.decisions.push_back(Arc::new(decision));
        }
    }

    /// Counts a reply that has left so long after its frame came.
    pub(crate) fn committed(&mut self, latency: Duration) {
        self.commits.count(latency, Instant::now());
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
        // While it is held words wait: the next step hears them.
        if is_through(&self.learner) {
            return Err(SayError::Holding { state: self.state(true) });
        }
        if self.learner.memory().content().vocabulary.symbols().len().saturating_add(waiting) > SYMBOLS_MAX {
            return Err(SayError::Full);
        }
        self.words.extend_from_slice(words);
        Ok(())
    }

    /// Obeys an operator's developmental control; returns what it changed.
    ///
    /// # Errors
    /// When there is no such stage.
    pub fn stage(&mut self, command: &StageCommand) -> Result<Vec<Effect>, StageCommandError> {
        let effects = self.learner.stage(command)?;
        log(self.learner.memory().content(), &effects);
        self.problem = None;
        Ok(effects)
    }

    /// Gives the curriculum an order that it always takes, for one frame or after it.
    pub(crate) fn once(&mut self, command: &StageCommand) -> Vec<Effect> {
        self.learner.stage(command).unwrap_or_else(|error| {
            tracing::error!(%error, ?command, "an order was not taken");
            Vec::new()
        })
    }

    /// Takes up a goal, given as patterns as they print: `body` pursues it with at most `actions_max` actions.
    ///
    /// # Errors
    /// When a pattern can't be read, or the learner can't pursue it.
    pub fn achieve(
        &mut self,
        body: BodyId,
        goal: &[String],
        actions_max: u32,
    ) -> Result<Vec<Effect>, GoalError> {
        let goal = notation::parse_goal(&self.learner.memory().content().vocabulary, goal)?;
        let effects = self.learner.pursue(body, goal, actions_max)?;
        log(self.learner.memory().content(), &effects);
        Ok(effects)
    }

    /// Calls off the goal of this number. One that is over stays as it ended.
    ///
    /// # Errors
    /// When it is not the goal that is pursued or was the last to be.
    pub fn cancel(&mut self, number: u64) -> Result<Vec<Effect>, GoalError> {
        let known = self.learner.memory().content().pursuit.as_ref().filter(|known| known.number == number);
        if known.ok_or(GoalError::Unknown { number })?.under_way() {
            let effects = self.learner.cancel_goal()?;
            log(self.learner.memory().content(), &effects);
            return Ok(effects);
        }
        Ok(Vec::new())
    }

    /// Why the curriculum can't go on, if it can't.
    fn stuck(&self) -> Option<String> {
        let reason = self.learner.memory().content().progress.stuck.as_ref()?;
        let detail = self.problem.as_ref().map_or(String::new(), |problem| format!(" ({problem})"));
        Some(format!("{reason}{detail}"))
    }

    /// What the curriculum is doing.
    #[must_use]
    pub fn state(&self, attached: bool) -> StageState {
        if let Some(reason) = self.stuck() {
            return StageState::Stuck(reason);
        }
        let progress = &self.learner.memory().content().progress;
        if progress.held {
            StageState::Held
        } else if progress.finished {
            StageState::Finished
        } else if !attached {
            StageState::WaitingForBody
        } else if progress.habituating {
            StageState::Habituating
        } else if progress.report().is_some_and(|report| report.saturated) {
            StageState::Saturated
        } else {
            StageState::Acting
        }
    }

    /// Everything there is to inspect, as it is now.
    #[must_use]
    pub fn view(&self, host: HostFacts) -> View {
        let now = Instant::now();
        let attached = host.bodies.iter().any(|body| body.state == BodyState::Attached);
        View {
            content: self.learner.memory().content().clone(),
            curriculum: self.curriculum.clone(),
            parameters: self.learner.memory().parameters().clone(),
            seed: self.seed,
            decisions: self.decisions.iter().cloned().collect(),
            state: self.state(attached),
            stuck: self.stuck(),
            uptime_s: now.saturating_duration_since(self.started).as_secs_f64(),
            steps_per_s: self.latencies.rate(now, self.started),
            latencies: self.latencies.clone(),
            commits: self.commits.clone(),
            growth: self.growth.clone(),
            trace: self.trace.clone(),
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
    /// The body that goals and predictions are about, and what it perceived last.
    pub perceived: Option<(BodyId, Vec<Observation>)>,
    /// What it perceived in the step before.
    pub before: Vec<Observation>,
    /// How memory is kept; none when in RAM only.
    pub storage: Option<StorageStatus>,
    /// What was refused, by reason.
    pub refused: Vec<RefusalCount>,
}

/// A learner as it was at one moment, to be inspected at leisure: shares memory's chunks, so that making it
/// delays nothing.
#[derive(Clone, Debug)]
pub struct View {
    pub(crate) content: Content,
    pub(crate) curriculum: Arc<Curriculum>,
    pub(crate) parameters: Parameters,
    pub(crate) seed: u64,
    pub(crate) decisions: Vec<Arc<Decision>>,
    pub(crate) state: StageState,
    pub(crate) stuck: Option<String>,
    pub(crate) uptime_s: f64,
    pub(crate) steps_per_s: f64,
    pub(crate) latencies: Latencies,
    pub(crate) commits: Latencies,
    pub(crate) growth: Growth,
    pub(crate) trace: Trace,
    pub(crate) host: HostFacts,
}

impl View {
    /// A learner as it was at an earlier moment, of which memory is known, what `host` says, and perhaps the last decision.
    /// What it was doing is said as if a body had been attached.
    #[must_use]
    pub fn past(learner: Learner, seed: u64, decision: Option<Decision>, mut host: HostFacts) -> Self {
        let mut mind = Mind::host(learner, seed);
        mind.decisions.extend(decision.map(Arc::new));
        let vocabulary = &mind.learner.memory().content().vocabulary;
        if let Some((_, perceived)) = &host.perceived {
            host.world = perceived.iter().map(|one| notation::observation(vocabulary, one)).collect();
        }
        Self { state: mind.state(true), ..mind.view(host) }
    }

    /// A learner as it is now, without a host: what it decided last, if given, and what `host` says.
    #[must_use]
    pub fn of(learner: &Learner, seed: u64, decision: Option<Decision>, host: HostFacts) -> Self {
        Self {
            content: learner.memory().content().clone(),
            curriculum: Arc::new(learner.curriculum().clone()),
            parameters: learner.memory().parameters().clone(),
            seed,
            decisions: decision.into_iter().map(Arc::new).collect(),
            state: StageState::Acting,
            stuck: None,
            uptime_s: 0.0,
            steps_per_s: 0.0,
            latencies: Latencies::default(),
            commits: Latencies::default(),
            growth: Growth::default(),
            trace: Trace::default(),
            host,
        }
    }
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
            Effect::Pursuit(PursuitEffect::Begun { goal, actions_max, .. }) => {
                tracing::info!(goal = %notation::goal(&content.vocabulary, goal), actions_max, step = content.step, "goal taken up");
            }
            Effect::Pursuit(PursuitEffect::Ended(ending)) => {
                tracing::info!(?ending, step = content.step, "goal over");
            }
            Effect::Retired { generalised } => {
                tracing::info!(schema = generalised.0, "generalised schema retired")
            }
            _ => (),
        }
    }
}
