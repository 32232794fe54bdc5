//! A learner, and beside it the state that its host keeps for it: words that wait to be heard, the last decisions, the
//! times of steps. The daemon and the in-process runner are two hosts of the same mind.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};

use pschema_inspect::{AchieveOrder, StageState};
use pschema_learner::decision::Decision;
use pschema_learner::effect::Effect;
use pschema_learner::memory::Content;
use pschema_learner::notation;
use pschema_learner::progress::{StageCommand, StageCommandError, StageEffect};
use pschema_learner::pursuit::{PursueError, PursuitEffect};
use pschema_learner::schema::SchemaId;
use pschema_learner::vocabulary::BodyId;
use pschema_learner::vocabulary::limits::SYMBOLS_MAX;
use pschema_learner::{Learner, LearnerError, Step};
use pschema_protocol::wire::message::RawFrame;

use crate::goal::{self, Asked, GoalTextError};
use crate::session::{FrameOutcome, Session, WORDS_WAITING_MAX, no_word};
use crate::setup::Setup;
use crate::view::{Account, Host, Senses, View, state};

/// Why there is nothing to do, to predict or to plan.
pub(crate) const NO_BODY: &str =
    "no body is attached, so there is nothing to act in: start one, such as `pschema sim`";

/// How many decisions can be explained: the last of them.
pub const DECISIONS_KEPT_MAX: usize = 64;
/// How many steps a single action may take to be decided on. Where a trial begins, surroundings are arranged first.
const SINGLE_STEPS_MAX: u32 = 8;

/// Why words can't be said.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SayError {
    /// No word was given.
    #[error("there is nothing to say: give at least one word")]
    Nothing,
    /// One of the texts is no word.
    #[error("{0}")]
    Word(String),
    /// Too many words would be waiting.
    #[error(
        "{waiting} words are waiting to be heard, and at most {WORDS_WAITING_MAX} can: is a body attached?"
    )]
    Waiting {
        /// How many there would be.
        waiting: usize,
    },
    /// The learner takes no more steps.
    #[error("nobody would hear it: the learner is {state}; see `pschema stage`")]
    Holding {
        /// The state of the curriculum that makes it so.
        state: StageState,
    },
    /// Memory has no room for another word.
    #[error("the learner knows {SYMBOLS_MAX} words and symbols, which is all it can hold")]
    Full,
}

/// Why a goal can't be taken up or called off.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GoalError {
    /// One of the goal's patterns can't be read, or asks for what the body never senses.
    #[error(transparent)]
    Text(#[from] GoalTextError),
    /// The learner can't pursue the goal.
    #[error(transparent)]
    Pursue(#[from] PursueError),
    /// No goal has that number, or other goals were taken up since.
    #[error("goal {number} is over and forgotten, or never was")]
    Unknown {
        /// The number given.
        number: u64,
    },
}

/// Why a learner can't take a single action.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SingleStepError {
    /// The curriculum can't go on.
    #[error("there is no step to take: the learner is stuck: {reason}")]
    Stuck {
        /// Why it can't.
        reason: String,
    },
    /// No body is attached to carry the action out.
    #[error("{NO_BODY}")]
    NoBody,
    /// The curriculum is over.
    #[error("there is no step to take: the curriculum is over; `pschema stage set NAME` goes back")]
    Over,
}

/// One action that an operator asked for while the learner is held.
#[derive(Clone, Copy, Debug)]
struct SingleAction {
    /// The session of the body that is to carry it out. No other body may.
    session: u64,
    /// How many more steps may be taken until the action is decided on.
    steps_left: u32,
}

impl SingleAction {
    /// The order after `step`: none once an action was decided on, or no more steps may be taken.
    fn after(self, step: &Step) -> Option<Self> {
        let steps_left = self.steps_left.saturating_sub(1);
        (step.decision.is_none() && steps_left > 0).then_some(Self { steps_left, ..self })
    }
}

/// A learner and the state that its host keeps for it.
///
/// ```
/// use pschema_learner::curriculum::{Afterwards, Curriculum};
/// use pschema_server::{Setup, config, mind::Mind};
///
/// let (curriculum, learner) = config::lesson("free", Default::default(), &[])?;
/// let mut mind = Mind::new(Setup { seed: 7, learner, curriculum })?;
/// mind.say(&["touch".to_owned()])?;
/// assert_eq!(mind.learner().memory().content().step, 0, "the word waits for the first frame");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Mind {
    learner: Learner,
    setup: Arc<Setup>,
    /// Words that wait to be heard.
    words: Vec<String>,
    single: Option<SingleAction>,
    decisions: Arc<VecDeque<Arc<Decision>>>,
    account: Account,
    /// The last problem that the host had in obeying the learner.
    problem: Option<Arc<str>>,
}

impl Mind {
    /// A learner that knows nothing.
    ///
    /// # Errors
    /// When a parameter is out of range or the curriculum can't be followed.
    pub fn new(setup: Setup) -> Result<Self, LearnerError> {
        let seed = setup.seed;
        Ok(Self::resume(setup.begin()?, seed))
    }

    /// Goes on with a learner that began with `seed`.
    #[must_use]
    pub fn resume(learner: Learner, seed: u64) -> Self {
        Self {
            setup: Arc::new(Setup::of(&learner, seed)),
            learner,
            words: Vec::new(),
            single: None,
            decisions: Arc::default(),
            account: Account::default(),
            problem: None,
        }
    }

    /// The learner.
    #[must_use]
    pub fn learner(&self) -> &Learner {
        &self.learner
    }

    /// The learner, without the state beside it.
    pub(crate) fn into_learner(self) -> Learner {
        self.learner
    }

    /// The learner, for a body to attach to.
    pub(crate) fn learner_mut(&mut self) -> &mut Learner {
        &mut self.learner
    }

    /// Whether the learner wants nothing of any body until an operator gives an order.
    pub(crate) fn is_waiting(&self) -> bool {
        self.learner.is_waiting() && self.single.is_none()
    }

    /// The body that the curriculum leads, once it has begun.
    pub(crate) fn student(&self) -> Option<BodyId> {
        self.learner.memory().content().progress.student
    }

    /// Serves one frame of the body of `session`; see [`Session::frame`]. Words that wait are heard with the frame if the
    /// body is the student, or if the student is not attached.
    pub fn serve(&mut self, session: &mut Session, raw: &RawFrame, student_attached: bool) -> FrameOutcome {
        let listens = !student_attached || self.student() == Some(session.body());
        let mut none = Vec::new();
        let words = if listens { &mut self.words } else { &mut none };
        let single = self.single.filter(|single| single.session == session.number());
        let outcome = session.frame(&mut self.learner, raw, words, single.is_some());
        if let (Some(single), Some(step)) = (single, &outcome.step) {
            self.single = single.after(step);
        }
        if let Some(problem) = &outcome.problem {
            tracing::error!(session = session.number(), %problem, "the body could not be told what to do");
            self.problem = Some(problem.to_string().into());
        }
        outcome
    }

    /// Logs, counts and records a step that took `latency` from the frame's arrival to the decision. A host calls this after
    /// it has sent the reply, so that the body does not wait for it.
    pub fn stepped(&mut self, session: &Session, step: Step, latency: Duration) {
        self.account.latencies.count(latency, Instant::now());
        let Step { effects, decision, .. } = step;
        let memory = self.learner.memory();
        self.account.growth.count(memory.content().schemas.len(), latency);
        let (perceived, failure) = (session.perceived(), session.failure_at(memory.content().step));
        self.account.trace.keep(memory, &effects, decision.as_ref(), perceived, failure, latency);
        log(memory.content(), &effects);
        if let Some(decision) = decision {
            let decisions = Arc::make_mut(&mut self.decisions);
            if decisions.len() == DECISIONS_KEPT_MAX {
                decisions.pop_front();
            }
            decisions.push_back(Arc::new(decision));
        }
    }

    /// The trace of decisions.
    pub(crate) fn trace_mut(&mut self) -> &mut crate::trace::Trace {
        &mut self.account.trace
    }

    /// Counts a reply that left `latency` after its frame came.
    pub(crate) fn committed(&mut self, latency: Duration) {
        self.account.commits.count(latency, Instant::now());
    }

    /// Says words, which are heard with the next frame.
    ///
    /// # Errors
    /// When one of them can't be said; none of them is heard then.
    pub fn say(&mut self, words: &[String]) -> Result<(), SayError> {
        if words.is_empty() {
            return Err(SayError::Nothing);
        }
        if let Some(problem) = words.iter().find_map(|word| no_word(word)) {
            return Err(SayError::Word(problem));
        }
        let waiting = self.words.len().saturating_add(words.len());
        if waiting > WORDS_WAITING_MAX {
            return Err(SayError::Waiting { waiting });
        }
        // While the learner is held words wait, and are heard with its next step.
        if self.learner.is_through() {
            let progress = &self.learner.memory().content().progress;
            return Err(SayError::Holding { state: state(progress, self.problem.as_deref()) });
        }
        if self.learner.memory().content().vocabulary.symbols().len().saturating_add(waiting) > SYMBOLS_MAX {
            return Err(SayError::Full);
        }
        self.words.extend_from_slice(words);
        Ok(())
    }

    /// Looks whether the names that the curriculum uses are those of the body of `session`, which is led by it or would be the
    /// first. If one is not, the curriculum is stuck before it begins: it would be obeyed in silence, and look like a finding.
    /// Returns what that changed in memory.
    pub fn examine(&mut self, session: &Session) -> Vec<Effect> {
        let content = self.learner.memory().content();
        let body = session.body();
        let acts = content.vocabulary.bodies().get(usize::from(body.0));
        let acts = acts.is_some_and(|body| !body.repertoire.is_empty());
        if !acts || self.student().is_some_and(|student| student != body) {
            return Vec::new();
        }
        let Some(problem) = session.misnamed(&self.learner) else { return Vec::new() };
        let reason = format!("curriculum {:?}, {problem}", self.learner.curriculum().name);
        let effects = self.learner.stick(body, reason);
        log(self.learner.memory().content(), &effects);
        effects
    }

    /// Obeys an operator's order to the curriculum; returns what the order changed in memory.
    ///
    /// # Errors
    /// When there is no such stage.
    pub fn stage(&mut self, command: &StageCommand) -> Result<Vec<Effect>, StageCommandError> {
        let effects = self.learner.stage(command)?;
        log(self.learner.memory().content(), &effects);
        self.problem = None;
        self.single = None;
        Ok(effects)
    }

    /// Holds the learner, but for one action of the body of `session`; returns what the hold changed in memory.
    ///
    /// # Errors
    /// When the learner has no action to take, or there is no body.
    pub fn single_step(&mut self, session: Option<&Session>) -> Result<Vec<Effect>, SingleStepError> {
        if self.learner.is_through() {
            let stuck = self.learner.memory().content().progress.stuck.clone();
            return Err(stuck.map_or(SingleStepError::Over, |reason| SingleStepError::Stuck { reason }));
        }
        let session = session.ok_or(SingleStepError::NoBody)?;
        let effects = self.learner.set_held(true);
        log(self.learner.memory().content(), &effects);
        self.problem = None;
        self.single = Some(SingleAction { session: session.number(), steps_left: SINGLE_STEPS_MAX });
        Ok(effects)
    }

    /// Takes up a goal, whose patterns are given as they print: the body of `session` pursues it with at most `actions_max`
    /// actions. Returns what that changed in memory.
    ///
    /// # Errors
    /// When a pattern can't be read or asks for what the body never senses, or the learner can't pursue it.
    pub fn achieve(&mut self, session: &Session, order: &AchieveOrder) -> Result<Vec<Effect>, GoalError> {
        let AchieveOrder { goal, again, most, actions_max } = order;
        let (again, most, actions_max) = (*again, most.as_deref(), *actions_max);
        let vocabulary = &self.learner.memory().content().vocabulary;
        let asked = Asked { goal, again, most };
        let goal = goal::wanted(vocabulary, Some(session.description().as_ref()), asked)?;
        let effects = self.learner.pursue(session.body(), goal, actions_max)?;
        log(self.learner.memory().content(), &effects);
        Ok(effects)
    }

    /// Calls off the goal of this number, and returns what that changed in memory. A goal that is over stays as it ended.
    ///
    /// # Errors
    /// When the last goal that was taken up has another number.
    pub fn cancel(&mut self, number: u64) -> Result<Vec<Effect>, GoalError> {
        let known = self.learner.memory().content().pursuit.as_ref().filter(|known| known.number == number);
        if known.ok_or(GoalError::Unknown { number })?.under_way() {
            let effects = self.learner.cancel_goal()?;
            log(self.learner.memory().content(), &effects);
            return Ok(effects);
        }
        Ok(Vec::new())
    }

    /// The learner as it is now, to be inspected. `shown` is the session of the body that questions are about.
    #[must_use]
    pub(crate) fn view(&self, name: Arc<str>, shown: Option<&Session>, host: Host) -> View {
        View {
            name,
            content: self.learner.memory().content().clone(),
            setup: self.setup.clone(),
            decisions: self.decisions.clone(),
            senses: shown.map(|session| Senses {
                last: session.input().clone(),
                before: session.input_before().clone(),
            }),
            declared: shown.map(|session| session.description().clone()),
            host: Some(host),
            account: self.account.clone(),
            taken: Instant::now(),
            problem: self.problem.clone(),
        }
    }
}

/// Logs the changes that people follow: stages, goals and generalisations.
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
