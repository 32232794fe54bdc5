//! One attached body: its frames are checked, translated, given to the learner, and replied to. Pure of
//! transport, clock and file: the daemon and the in-process runner both live on it.

use std::collections::{BTreeSet, VecDeque};

use pschema_learner::curriculum::{Afterwards, SceneCommand};
use pschema_learner::effect::Effect;
use pschema_learner::notation;
use pschema_learner::observation::Observation;
use pschema_learner::vocabulary::{BodyId, DeclarationError, Vocabulary, limits::SYMBOLS_MAX};
use pschema_learner::{ActionOutcome, Frame, Learner, Output, Step};
use pschema_protocol::body::Outcome;
use pschema_protocol::description::{Action, Description, ValueKind};
use pschema_protocol::refusal::Refusal;
use pschema_protocol::wire::decode::SessionChecks;
use pschema_protocol::wire::message::{Introduction, RawFrame, Reply, SensorFrame};

use crate::translate::{TranslateError, Translation, declaration};

/// How long a body rests when there is nothing to do in the world as it is, in milliseconds: how soon a
/// change of the world is noticed.
pub const HOLD_WAIT_MS: u32 = 20;
/// How long a body rests when the learner waits for an operator, in milliseconds. An order rouses it earlier.
pub const WAITING_WAIT_MS: u32 = 200;

/// Words waiting to be heard, beyond which no more are taken.
pub const WORDS_WAITING_MAX: usize = 64;
/// Longest word, in bytes.
pub const WORD_BYTES_MAX: usize = 64;

/// Why a body can't be attached.
#[derive(Debug, thiserror::Error)]
pub enum AttachError {
    /// What it declares can't be said in the learner's words.
    #[error(transparent)]
    Translate(#[from] TranslateError),
    /// What it declares contradicts what the learner knows.
    #[error(transparent)]
    Declaration(#[from] DeclarationError),
    /// Memory has no room for its symbols.
    #[error(
        "the learner knows {known} symbols and the body brings {more}: more than the limit of {SYMBOLS_MAX}"
    )]
    Symbols {
        /// Symbols known.
        known: usize,
        /// Symbols the body declares.
        more: usize,
    },
}

/// What is counted of a session.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Frames taken.
    pub frames: u64,
    /// Frames refused.
    pub frames_refused: u64,
    /// Why the last refused frame was.
    pub last_refusal: Option<String>,
}

/// What came of a frame.
#[derive(Debug)]
pub struct Served {
    /// What the body is told.
    pub reply: Reply,
    /// The learner's step, if the frame led to one.
    pub step: Option<Step>,
    /// What went wrong on the daemon's side and the body can't mend: for the log and the status.
    pub problem: Option<TranslateError>,
}

/// An attached body.
#[derive(Debug)]
pub struct Session {
    checks: SessionChecks,
    body: BodyId,
    translation: Translation,
    /// Scene commands of the present arrangement that are still to be sent.
    to_arrange: VecDeque<Action>,
    /// What the learner asked for last and the body was never told, for it could not be.
    unsaid: bool,
    /// What the last step was taken on.
    input: Frame,
    /// What was perceived in the step before it.
    before: Vec<Observation>,
    counters: Counters,
}

impl Session {
    /// Attaches a body whose hello passed every check: the learner takes its declaration. `number` is above
    /// zero and used once.
    ///
    /// # Errors
    /// [`AttachError`]; the learner's memory is then unchanged.
    pub fn attach(
        number: u64,
        hello: &Introduction,
        learner: &mut Learner,
    ) -> Result<(Self, Vec<Effect>), AttachError> {
        let description = &hello.description;
        let declared = declaration(description)?;
        let vocabulary = &learner.memory().content().vocabulary;
        let known = vocabulary.symbols().len();
        let more = new_symbols(description, vocabulary);
        if known.saturating_add(more) > SYMBOLS_MAX {
            return Err(AttachError::Symbols { known, more });
        }
        let (body, mut effects) = learner.declare(declared)?;
        for symbol in every_symbol(description) {
            effects.extend(learner.symbol(symbol).1);
        }
        let vocabulary = &learner.memory().content().vocabulary;
        let translation = Translation::new(description, body, vocabulary)?;
        let session = Self {
            checks: SessionChecks::new(number, description.clone()),
            body,
            translation,
            to_arrange: VecDeque::new(),
            unsaid: false,
            input: Frame { body, outcome: None, observations: Vec::new() },
            before: Vec::new(),
            counters: Counters::default(),
        };
        Ok((session, effects))
    }

    /// The session's number.
    #[must_use]
    pub fn number(&self) -> u64 {
        self.checks.number()
    }

    /// The body, as the learner knows it.
    #[must_use]
    pub fn body(&self) -> BodyId {
        self.body
    }

    /// The body, as it described itself.
    #[must_use]
    pub fn description(&self) -> &Description {
        self.checks.description()
    }

    /// What has been counted.
    #[must_use]
    pub fn counters(&self) -> &Counters {
        &self.counters
    }

    /// What the last step was taken on.
    #[must_use]
    pub fn input(&self) -> &Frame {
        &self.input
    }

    /// What the body perceived in the last step, constrained senses included.
    #[must_use]
    pub fn perceived(&self) -> &[Observation] {
        &self.input.observations
    }

    /// What the body perceived in the step before the last.
    #[must_use]
    pub fn perceived_before(&self) -> &[Observation] {
        &self.before
    }

    /// What the body perceived in the last step, as it prints.
    #[must_use]
    pub fn world(&self, learner: &Learner) -> Vec<String> {
        let vocabulary = &learner.memory().content().vocabulary;
        self.perceived().iter().map(|one| notation::observation(vocabulary, one)).collect()
    }

    /// Serves one frame. A frame that is refused changes nothing but the counters. `words` are heard with
    /// it, and taken, when the learner makes a step of it.
    pub fn frame(&mut self, learner: &mut Learner, raw: &RawFrame, words: &mut Vec<String>) -> Served {
        let served = match self.checks.check(raw) {
            Ok(frame) => {
                self.counters.frames += 1;
                self.taken(learner, &frame, words)
            }
            Err(refusal) => self.refused(&refusal),
        };
        self.checks.replied(&served.reply);
        served
    }

    /// Counts a frame of this body that was refused, here or before it came here.
    pub fn count_refused(&mut self, refusal: &Refusal) {
        self.counters.frames_refused += 1;
        self.counters.last_refusal = Some(refusal.to_string());
    }

    fn refused(&mut self, refusal: &Refusal) -> Served {
        self.count_refused(refusal);
        let reply = Reply::Refused { code: refusal.code(), reason: refusal.to_string() };
        Served { reply, step: None, problem: None }
    }

    fn taken(&mut self, learner: &mut Learner, frame: &SensorFrame<'_>, words: &mut Vec<String>) -> Served {
        let mut outcome = frame.report.as_ref().map(|report| outcome(&report.outcome));
        if let Some(next) = self.to_arrange.pop_front() {
            if outcome == Some(ActionOutcome::Done) {
                return Served { reply: Reply::Arrange(next), step: None, problem: None };
            }
            // One command that fails spoils the arrangement; the rest of it is not asked for.
            self.to_arrange.clear();
        }
        if std::mem::take(&mut self.unsaid) {
            outcome = Some(ActionOutcome::Refused);
        }
        if outcome.is_none() && rests(learner, self.body) {
            // Nothing was asked and nothing is wanted: memory must not depend on how often a body asks.
            let reply = Reply::Wait { ms: WAITING_WAIT_MS };
            return Served { reply, step: None, problem: None };
        }
        let mut met = Vec::new();
        let heard: Vec<_> = std::mem::take(words)
            .iter()
            .map(|word| {
                let (symbol, effects) = learner.symbol(word);
                met.extend(effects);
                symbol
            })
            .collect();
        let observations = self.translation.observations(frame.observations, &heard);
        let input = Frame { body: self.body, outcome, observations };
        self.before = std::mem::replace(&mut self.input, input).observations;
        let mut step = learner.step(&self.input);
        // A word met for the first time is part of what the frame changed.
        step.effects.splice(0..0, met);
        let (reply, problem) = match self.reply(&step.output) {
            Ok(reply) => (reply, None),
            Err(problem) => {
                self.unsaid = true;
                (wait(), Some(problem))
            }
        };
        Served { reply, step: Some(step), problem }
    }

    fn reply(&mut self, output: &Output) -> Result<Reply, TranslateError> {
        match output {
            Output::Hold => Ok(wait()),
            Output::Act(primitive) => Ok(Reply::Act(self.translation.action(*primitive)?.clone())),
            Output::Arrange(commands) => self.arrange(commands),
        }
    }

    /// Begins an arrangement: all of it is understood before any of it is sent.
    fn arrange(&mut self, commands: &[SceneCommand]) -> Result<Reply, TranslateError> {
        let commands = commands.iter().map(|command| self.translation.scene_command(command));
        let mut commands = commands.collect::<Result<VecDeque<_>, _>>()?;
        let Some(first) = commands.pop_front() else {
            // Nothing to arrange is done at once: the next frame says so.
            return Ok(wait());
        };
        self.to_arrange = commands;
        Ok(Reply::Arrange(first))
    }
}

/// Whether the learner wants nothing until an operator says otherwise: it is held; or it is stuck, or through with
/// its curriculum, and pursues no goal.
#[must_use]
pub fn is_waiting(learner: &Learner) -> bool {
    let content = learner.memory().content();
    let goal = content.pursuit.as_ref().filter(|pursuit| pursuit.under_way());
    rests(learner, goal.map_or(BodyId(u16::MAX), |pursuit| pursuit.body))
}

/// Whether it will want nothing, held or not, until an operator moves the curriculum on: it is stuck, or through with its
/// curriculum, and pursues no goal.
#[must_use]
pub fn is_through(learner: &Learner) -> bool {
    let content = learner.memory().content();
    let goal = content.pursuit.as_ref().filter(|pursuit| pursuit.under_way());
    idles(learner, goal.map_or(BodyId(u16::MAX), |pursuit| pursuit.body))
}

/// Whether it wants nothing of `body`: a goal keeps only the body awake that pursues it.
fn rests(learner: &Learner, body: BodyId) -> bool {
    learner.memory().content().progress.held || idles(learner, body)
}

fn idles(learner: &Learner, body: BodyId) -> bool {
    let content = learner.memory().content();
    let progress = &content.progress;
    let through = progress.finished && learner.curriculum().afterwards == Afterwards::Hold;
    let pursues = content.pursuit.as_ref().is_some_and(|goal| goal.under_way() && goal.body == body);
    (progress.stuck.is_some() || through) && !pursues
}

fn wait() -> Reply {
    Reply::Wait { ms: HOLD_WAIT_MS }
}

fn outcome(reported: &Outcome) -> ActionOutcome {
    match reported {
        Outcome::Done => ActionOutcome::Done,
        Outcome::Refused(_) => ActionOutcome::Refused,
        Outcome::Failed(_) => ActionOutcome::Failed,
        Outcome::TimedOut => ActionOutcome::TimedOut,
    }
}

fn every_symbol(description: &Description) -> impl Iterator<Item = &String> {
    let properties = description.observation_types.iter().flat_map(|declared| &declared.properties);
    properties
        .filter_map(|property| match &property.kind {
            ValueKind::Symbol { symbols } => Some(symbols),
            _ => None,
        })
        .flatten()
}

/// Symbols of the description that the learner does not know yet. Only these are counted, so that a body it knows
/// can come back to a full memory.
fn new_symbols(description: &Description, vocabulary: &Vocabulary) -> usize {
    // The symbols of primitives are among those of the actions' parameters.
    let parameters = description.actions.iter().flat_map(|declared| &declared.parameters);
    let in_actions = parameters.filter_map(|parameter| match &parameter.kind {
        ValueKind::Symbol { symbols } => Some(symbols),
        _ => None,
    });
    let all: BTreeSet<_> = every_symbol(description).chain(in_actions.flatten()).collect();
    all.into_iter().filter(|symbol| vocabulary.symbol_named(symbol).is_none()).count()
}
