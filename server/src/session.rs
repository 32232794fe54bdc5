//! The session of one attached body: its frames are checked, translated, given to the learner, and replied to. A session
//! knows no transport, no clock and no file, so that the daemon and the in-process runner both use it.

use std::collections::{BTreeSet, VecDeque};
use std::sync::Arc;

use pschema_inspect::{BodyState, BodyStatus, DeclarationWarning, FailedOutcome, OrderFailure};
use pschema_learner::curriculum::SceneCommand;
use pschema_learner::effect::Effect;
use pschema_learner::notation::brief;
use pschema_learner::observation::Observation;
use pschema_learner::vocabulary::{BodyId, DeclarationError, Vocabulary, limits::SYMBOLS_MAX};
use pschema_learner::{ActionOutcome, Frame, Learner, Output, Step};
use pschema_protocol::body::Outcome;
use pschema_protocol::description::{Action, Description, Property, ValueKind};
use pschema_protocol::refusal::Refusal;
use pschema_protocol::wire::check;
use pschema_protocol::wire::decode::SessionChecks;
use pschema_protocol::wire::message::{Introduction, RawFrame, Reply, SensorFrame};

use crate::names::Names;
use crate::suitability::Suitability;
use crate::translate::{TranslateError, Translation, declaration};

/// How long a body rests when there is nothing to do in the world as it is, in milliseconds. A change of the world is
/// noticed within this time.
pub const HOLD_WAIT_MS: u32 = 20;
/// How long a body rests when the learner waits for an operator, in milliseconds. An order wakes it earlier.
pub const WAITING_WAIT_MS: u32 = 200;

/// How many words may wait to be heard; more are refused.
pub const WORDS_WAITING_MAX: usize = 64;
/// The longest word, in bytes.
pub const WORD_BYTES_MAX: usize = 64;

/// Why a body can't be attached.
#[derive(Debug, thiserror::Error)]
pub enum AttachError {
    /// The declaration can't be translated for the learner.
    #[error(transparent)]
    Translate(#[from] TranslateError),
    /// The declaration contradicts what the learner knows.
    #[error(transparent)]
    Declaration(#[from] DeclarationError),
    /// The body describes itself otherwise than before, or is in another world than a body of its kind under another name.
    #[error(
        "it {told}. What was learnt would be of something else; if that is meant, start the daemon with --accept-changes, or \
         begin another memory"
    )]
    Changed {
        /// What it does, with each part that differs: as it was, or is there, and as it is.
        told: String,
    },
    /// Memory has no room for the body's symbols.
    #[error(
        "the learner knows {known} symbols and the body brings {more}: more than the limit of {SYMBOLS_MAX}"
    )]
    Symbols {
        /// How many symbols the learner knows.
        known: usize,
        /// How many others the body declares.
        more: usize,
    },
}

/// What keeps `text` from being heard as a word; none if nothing does.
#[must_use]
pub fn no_word(text: &str) -> Option<String> {
    if !(1..=WORD_BYTES_MAX).contains(&text.len()) || text.chars().any(char::is_whitespace) {
        let text = brief(text);
        return Some(format!("{text:?} is no word: give 1 to {WORD_BYTES_MAX} bytes without spaces"));
    }
    check::unwritable(text).map(|problem| format!("that is no word: {problem}"))
}

/// The outcome of a frame.
#[derive(Debug)]
pub struct FrameOutcome {
    /// The reply to the body.
    pub reply: Reply,
    /// The step that the learner took on the frame; none if the frame was refused or needed none.
    pub step: Option<Step>,
    /// A problem on the daemon's side, which the body can't solve: for the log and the status.
    pub problem: Option<TranslateError>,
    /// What became certain with this frame that keeps the body's declaration from being learnt: for the log; the status has it.
    pub warnings: Vec<DeclarationWarning>,
}

/// The session of an attached body.
#[derive(Debug)]
pub struct Session {
    checks: SessionChecks,
    /// What the body declares. Views share it.
    description: Arc<Description>,
    body: BodyId,
    translation: Translation,
    /// Scene commands of the present arrangement that are still to be sent.
    to_arrange: VecDeque<Action>,
    /// Set when the learner's last request could not be put into the body's words: the body was never told of it.
    unsaid: bool,
    /// The frame that the last step was taken on.
    input: Arc<Frame>,
    /// The frame of the step before it.
    before: Arc<Frame>,
    /// The body's status, as tools are told of it. Views share it.
    status: Arc<BodyStatus>,
    /// How often the last failure of the status came in a row, for the same reason each time.
    failures_alike: u64,
    /// Whether what the body declares can be learnt.
    suitability: Suitability,
}

impl Session {
    /// Attaches a body whose hello passed every check: the learner takes in what it declares. `number` is above zero and
    /// used for no other session. Returns also what the declaration changed in memory.
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
        for symbol in observed_symbols(description) {
            effects.extend(learner.symbol(symbol).1);
        }
        let vocabulary = &learner.memory().content().vocabulary;
        let translation = Translation::new(description, body, vocabulary)?;
        let nothing_yet = Arc::new(Frame { body, outcome: None, observations: Vec::new() });
        let status = BodyStatus {
            id: number,
            name: description.name.clone(),
            kind: description.kind.clone(),
            pid: hello.pid,
            state: BodyState::Attached,
            frames: 0,
            frames_refused: 0,
            last_refusal: None,
            last_failure: None,
            episodes_ended: 0,
            episodes_cut: 0,
            warnings: Vec::new(),
        };
        let session = Self {
            checks: SessionChecks::new(number, description.clone()),
            description: Arc::new(description.clone()),
            body,
            translation,
            to_arrange: VecDeque::new(),
            unsaid: false,
            input: nothing_yet.clone(),
            before: nothing_yet,
            status: Arc::new(status),
            failures_alike: 0,
            suitability: Suitability::default(),
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

    /// What the body declares.
    #[must_use]
    pub fn description(&self) -> &Arc<Description> {
        &self.description
    }

    /// The body's status, as tools are told of it.
    #[must_use]
    pub fn status(&self) -> &Arc<BodyStatus> {
        &self.status
    }

    /// The body's last status, once the session is over: the body `left` or was `lost`.
    #[must_use]
    pub(crate) fn into_status(mut self, state: BodyState) -> Arc<BodyStatus> {
        Arc::make_mut(&mut self.status).state = state;
        self.status
    }

    /// What is wrong, for this body, with the names in the learner's curriculum and parameters, if anything is.
    #[must_use]
    pub(crate) fn misnamed(&self, learner: &Learner) -> Option<String> {
        let memory = learner.memory();
        let names = Names {
            description: self.checks.description(),
            translation: &self.translation,
            vocabulary: &memory.content().vocabulary,
        };
        names.mistake(learner.curriculum(), memory.parameters())
    }

    /// The frame that the last step was taken on; before the first step, one in which nothing is perceived.
    #[must_use]
    pub fn input(&self) -> &Arc<Frame> {
        &self.input
    }

    /// The frame of the step before the last.
    #[must_use]
    pub fn input_before(&self) -> &Arc<Frame> {
        &self.before
    }

    /// What the body perceived in the last step, by constrained senses too.
    #[must_use]
    pub fn perceived(&self) -> &[Observation] {
        &self.input.observations
    }

    /// The order that the body did not carry out, as the learner was told in this `step`; none if it was told of none.
    #[must_use]
    pub fn failure_at(&self, step: u64) -> Option<&OrderFailure> {
        self.status.last_failure.as_ref().filter(|failure| failure.step == step)
    }

    /// How often the last failure came in a row, for the same reason each time.
    pub(crate) fn failures_alike(&self) -> u64 {
        self.failures_alike
    }

    /// Serves one frame. A frame that is refused changes nothing but the counters. If the learner takes a step on the frame,
    /// it hears `words` with it, and they are removed from the list. With `single` the step is a [`Learner::single_step`],
    /// which the learner takes although an operator holds it.
    pub fn frame(
        &mut self,
        learner: &mut Learner,
        raw: &RawFrame,
        words: &mut Vec<String>,
        single: bool,
    ) -> FrameOutcome {
        let outcome = match self.checks.check(raw) {
            Ok(frame) => {
                Arc::make_mut(&mut self.status).frames += 1;
                self.taken(learner, &frame, words, single)
            }
            Err(refusal) => self.refused(&refusal),
        };
        self.checks.replied(&outcome.reply);
        outcome
    }

    /// Counts a frame of this body that was refused, by the session or by the transport.
    pub fn count_refused(&mut self, refusal: &Refusal) {
        let status = Arc::make_mut(&mut self.status);
        status.frames_refused += 1;
        status.last_refusal = Some(refusal.to_string());
    }

    fn refused(&mut self, refusal: &Refusal) -> FrameOutcome {
        self.count_refused(refusal);
        let reply = Reply::Refused { code: refusal.code(), reason: refusal.to_string() };
        FrameOutcome { reply, step: None, problem: None, warnings: Vec::new() }
    }

    fn taken(
        &mut self,
        learner: &mut Learner,
        frame: &SensorFrame<'_>,
        words: &mut Vec<String>,
        single: bool,
    ) -> FrameOutcome {
        let mut outcome = frame.report.as_ref().map(|report| outcome(&report.outcome));
        if let Some(next) = self.to_arrange.pop_front() {
            if outcome == Some(ActionOutcome::Done) {
                return FrameOutcome {
                    reply: Reply::Arrange(next),
                    step: None,
                    problem: None,
                    warnings: Vec::new(),
                };
            }
            // A command that fails spoils the arrangement: the commands after it are not sent.
            self.to_arrange.clear();
        }
        if std::mem::take(&mut self.unsaid) {
            outcome = Some(ActionOutcome::Refused);
        }
        let rests = if single { learner.is_through_with(self.body) } else { learner.rests(self.body) };
        if outcome.is_none() && rests {
            // The body answers no request and the learner has none. Memory must not depend on how often a body asks.
            let reply = Reply::Wait { ms: WAITING_WAIT_MS };
            return FrameOutcome { reply, step: None, problem: None, warnings: Vec::new() };
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
        let input = Arc::new(Frame { body: self.body, outcome, observations });
        self.before = std::mem::replace(&mut self.input, input);
        let mut step = if single { learner.single_step(&self.input) } else { learner.step(&self.input) };
        if let Some(report) = &frame.report {
            self.count_outcome(&report.outcome, learner.memory().content().step);
        }
        let warnings = self.judged(learner, &step.output);
        // New words are part of what the frame changed in memory. In a single step they come after the effect that lets
        // the learner go.
        let first = usize::from(single);
        step.effects.splice(first..first, met);
        let (reply, problem) = match self.reply(&step.output) {
            Ok(reply) => (reply, None),
            Err(problem) => {
                self.unsaid = true;
                (wait(), Some(problem))
            }
        };
        FrameOutcome { reply, step: Some(step), problem, warnings }
    }

    /// What the frame of the step and the action that follows show about the body's declaration, for the first time.
    fn judged(&mut self, learner: &Learner, output: &Output) -> Vec<DeclarationWarning> {
        let action = if let Output::Act(primitive) = output { Some(*primitive) } else { None };
        let content = learner.memory().content();
        let own_is_no_condition = !content.mechanisms.claims;
        let found = self.suitability.note(&content.vocabulary, &self.input, action, own_is_no_condition);
        if !found.is_empty() {
            Arc::make_mut(&mut self.status).warnings.extend(found.iter().cloned());
        }
        found
    }

    /// Counts an outcome for the status if an episode is over with it, and keeps it if it is that of an order which the body did not carry
    /// out.
    fn count_outcome(&mut self, outcome: &Outcome, step: u64) {
        let failed = match outcome {
            Outcome::Done => return,
            // That an episode is over is no failure of the body.
            Outcome::EpisodeEnded => return Arc::make_mut(&mut self.status).episodes_ended += 1,
            Outcome::EpisodeCut => return Arc::make_mut(&mut self.status).episodes_cut += 1,
            Outcome::Refused(_) => FailedOutcome::Refused,
            Outcome::Failed(_) => FailedOutcome::Failed,
            Outcome::TimedOut => FailedOutcome::TimedOut,
        };
        let failure = OrderFailure { outcome: failed, reason: outcome.reason().map(escaped), step };
        let alike = |last: &OrderFailure| (last.outcome, &last.reason) == (failure.outcome, &failure.reason);
        let again = self.status.last_failure.as_ref().is_some_and(alike);
        self.failures_alike = if again { self.failures_alike + 1 } else { 1 };
        Arc::make_mut(&mut self.status).last_failure = Some(failure);
    }

    fn reply(&mut self, output: &Output) -> Result<Reply, TranslateError> {
        match output {
            Output::Hold => Ok(wait()),
            Output::Act(primitive) => Ok(Reply::Act(self.translation.action(*primitive)?.clone())),
            Output::Arrange(commands) => self.arrange(commands),
        }
    }

    /// Begins an arrangement. All its commands are translated before the first one is sent.
    fn arrange(&mut self, commands: &[SceneCommand]) -> Result<Reply, TranslateError> {
        let commands = commands.iter().map(|command| self.translation.scene_command(command));
        let mut commands = commands.collect::<Result<VecDeque<_>, _>>()?;
        let Some(first) = commands.pop_front() else {
            // An arrangement without commands is done at once; the next frame says so.
            return Ok(wait());
        };
        self.to_arrange = commands;
        Ok(Reply::Arrange(first))
    }
}

fn wait() -> Reply {
    Reply::Wait { ms: HOLD_WAIT_MS }
}

/// A body's words with their control characters escaped, so that they steer no terminal and begin no line of a log.
fn escaped(words: &str) -> String {
    words.chars().fold(String::new(), |mut safe, c| {
        if c.is_control() {
            safe.extend(c.escape_default())
        } else {
            safe.push(c)
        }
        safe
    })
}

fn outcome(reported: &Outcome) -> ActionOutcome {
    match reported {
        Outcome::Done => ActionOutcome::Done,
        Outcome::Refused(_) => ActionOutcome::Refused,
        Outcome::Failed(_) => ActionOutcome::Failed,
        Outcome::TimedOut => ActionOutcome::TimedOut,
        Outcome::EpisodeEnded => ActionOutcome::EpisodeEnded,
        Outcome::EpisodeCut => ActionOutcome::EpisodeCut,
    }
}

/// The symbols that the body's observations may have.
fn observed_symbols(description: &Description) -> impl Iterator<Item = &String> {
    symbols(description.observation_types.iter().flat_map(|declared| &declared.properties))
}

fn symbols<'a>(properties: impl Iterator<Item = &'a Property>) -> impl Iterator<Item = &'a String> {
    properties.flat_map(
        |property| if let ValueKind::Symbol { symbols } = &property.kind { &symbols[..] } else { &[] },
    )
}

/// How many symbols of the description the learner does not know yet. Known symbols are not counted, so that a body
/// which the learner knows can come back to a full memory.
fn new_symbols(description: &Description, vocabulary: &Vocabulary) -> usize {
    // The symbols of primitives are among those of the actions' parameters.
    let in_actions = symbols(description.actions.iter().flat_map(|declared| &declared.parameters));
    let all: BTreeSet<_> = observed_symbols(description).chain(in_actions).collect();
    all.into_iter().filter(|symbol| vocabulary.symbol_named(symbol).is_none()).count()
}

#[cfg(test)]
mod tests {
    use pschema_learner::notation;

    use super::*;

    /// Whether a pattern with this name in each of its places, and an action with it, are read as they were written.
    fn comes_back(name: &str) -> bool {
        let pattern = notation::by_names(name, [(name, name)]);
        let Some((kind, parts)) = notation::words(&pattern) else { return false };
        let pairs: Vec<_> = parts.map(|part| part.pair).collect();
        let action = format!("{name}({name}={name})");
        let action =
            action.split_once('(').and_then(|(action, rest)| Some((action, rest.strip_suffix(')')?)));
        kind == name
            && pairs == [Some((name, name))]
            && !name.starts_with('$')
            && action.is_some_and(|(action, rest)| action == name && !rest.contains([',', '(', ')']))
    }

    /// `a{b=c}` and `$x` were taken as names once, and no pattern could name them.
    #[test]
    fn whatever_is_taken_as_a_word_can_be_written_in_a_pattern() {
        let letters = ["a", "é", "語", "{", "}", "(", ")", ",", "=", "$", "&", "/", "'", "\"", "-", "3"];
        let directions = ["\u{200f}", "\u{202e}", "\u{feff}", "\u{ad}", "\u{a0}", "\u{7}", "\u{1b}", " "];
        let blank = ["\u{3164}", "\u{2800}", "\u{fe0f}", "\u{34f}", "\u{e01ef}"];
        let hidden = [&directions[..], &blank[..]].concat();
        let all: Vec<&str> = letters.iter().chain(&hidden).copied().collect();
        let (mut taken, mut refused) = (0, 0);
        for one in &all {
            for two in &all {
                for three in &all {
                    let word = [*one, *two, *three].concat();
                    match no_word(&word) {
                        None => {
                            taken += 1;
                            assert!(comes_back(&word), "{word:?}");
                            assert!(!hidden.iter().any(|hidden| word.contains(hidden)), "{word:?}");
                        }
                        Some(problem) => {
                            refused += 1;
                            assert!(!problem.chars().any(char::is_control), "{problem}");
                        }
                    }
                }
            }
        }
        assert!(taken > 500 && refused > 5_000, "{taken} taken, {refused} refused");
        let long = no_word(&"long".repeat(2_500)).unwrap();
        assert!(long.len() < 250 && long.contains("(10000 bytes)"), "{long}");
    }
}
