//! Batches of the journal as people read them.

use std::sync::Arc;

use pschema_learner::effect::{Effect, Score};
use pschema_learner::notation;
use pschema_learner::observation::{Observation, Pattern};
use pschema_learner::progress::StageEffect;
use pschema_learner::pursuit::{Ending, Goal, PlanCause, PursuitEffect};
use pschema_learner::vocabulary::{BodyId, Vocabulary};
use pschema_learner::{ActionOutcome, Frame};

use crate::format::mirror::Mirror;
use crate::format::v1::{Cause, Record};
use crate::frame::HEAD_LEN;
use crate::journal::{JournalFrame, segment_name};
use crate::manifest::profile;
use crate::storage::Storage;

/// What one step, one order or one attachment changed.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Batch {
    /// The number of its frame in the journal.
    pub frame: u64,
    /// Steps taken, this one included.
    pub step: u64,
    /// The time of the change by the machine's clock, in milliseconds since 1970.
    pub at_unix_ms: u64,
    /// What led to the change.
    pub cause: BatchCause,
    /// How many effects of each kind there are, in the order in which the kinds came.
    pub effects: Vec<EffectCount>,
    /// The effects in words, if they were asked for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub told: Vec<EffectText>,
    /// The file that it is in.
    pub file: String,
    /// Where it begins in the file, in bytes.
    pub offset: u64,
    /// The length of its frame in bytes, with the head.
    pub bytes: u64,
}

/// What led to a batch.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum BatchCause {
    /// A body attached.
    Attached {
        /// Its name.
        body: String,
    },
    /// An operator's order.
    Order {
        /// The order as it was given.
        order: String,
    },
    /// A body's frame.
    Frame {
        /// The body.
        body: String,
        /// How the last action went; none when the body was sent to do nothing.
        outcome: Option<&'static str>,
        /// The observations that it perceived, as they print.
        perceived: Vec<String>,
    },
    /// Memory goes on under other parameters or another curriculum.
    Changed {
        /// The curriculum.
        curriculum: String,
    },
}

/// Effects of one kind.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct EffectCount {
    /// The name of the kind.
    pub kind: &'static str,
    /// How many there are.
    pub count: u32,
}

/// One effect in words.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct EffectText {
    /// The name of the kind.
    pub kind: &'static str,
    /// The effect in words.
    pub text: String,
}

/// A vocabulary, to put effects into words.
#[derive(Clone, Debug)]
pub(super) struct Wording(pub(super) Arc<Vocabulary>);

impl Batch {
    /// The batch that a record holds; none if it holds none.
    pub(super) fn of(
        storage: &dyn Storage,
        shown: &JournalFrame<'_>,
        record: Record,
        words: &Wording,
        in_words: bool,
    ) -> Option<Self> {
        let Record::Batch { step, at_unix_ms, cause, effects } = record else { return None };
        let mut batch = Self {
            frame: shown.place.number,
            step,
            at_unix_ms,
            cause: words.cause(cause),
            effects: Vec::new(),
            told: Vec::new(),
            file: storage.path(&segment_name(shown.segment)),
            offset: shown.offset as u64,
            bytes: (HEAD_LEN + shown.payload.len()) as u64,
        };
        for effect in effects {
            let effect: Effect = effect.live();
            let kind = kind(&effect);
            match batch.effects.iter_mut().find(|counted| counted.kind == kind) {
                Some(counted) => counted.count = counted.count.saturating_add(1),
                None => batch.effects.push(EffectCount { kind, count: 1 }),
            }
            if in_words {
                batch.told.push(EffectText { kind, text: words.effect(&effect) });
            }
        }
        Some(batch)
    }
}

/// The name of the kind of an effect.
pub(super) fn kind(effect: &Effect) -> &'static str {
    match effect {
        Effect::Declared(_) => "declared",
        Effect::SymbolsMet(_) => "symbols_met",
        Effect::Attempted { .. } => "attempted",
        Effect::Executed { .. } => "executed",
        Effect::OutcomeAdded { .. } => "outcome_added",
        Effect::Created { .. } => "created",
        Effect::Generalised { .. } => "generalised",
        Effect::Supported { .. } => "supported",
        Effect::Retired { .. } => "retired",
        Effect::Associated { .. } => "associated",
        Effect::Happened(_) => "happened",
        Effect::Attended(_) => "attended",
        Effect::Stage(_) => "stage",
        Effect::Pursuit(_) => "pursuit",
        Effect::StepEnded { .. } => "step_ended",
        Effect::Full(_) => "full",
        Effect::Described { .. } => "described",
        Effect::Mechanisms(_) => "mechanisms",
        Effect::Experienced(_) => "experienced",
        Effect::Followed { .. } => "followed",
        Effect::Supposed { .. } => "supposed",
        Effect::Dropped { .. } => "dropped",
    }
}

impl Wording {
    fn cause(&self, cause: Cause) -> BatchCause {
        match cause {
            Cause::Declared(body) => BatchCause::Attached { body },
            Cause::Order(order) => BatchCause::Order { order },
            Cause::Step(input) => {
                let Frame { body, outcome, observations } = input.live();
                let outcome = outcome.map(|outcome| match outcome {
                    ActionOutcome::Done => "done",
                    ActionOutcome::Refused => "refused",
                    ActionOutcome::Failed => "failed",
                    ActionOutcome::TimedOut => "timed_out",
                    ActionOutcome::EpisodeEnded => "episode_ended",
                    ActionOutcome::EpisodeCut => "episode_cut",
                });
                let perceived = observations.iter().map(|one| self.observation(one)).collect();
                BatchCause::Frame { body: self.body(body), outcome, perceived }
            }
            Cause::Changed(setting) => BatchCause::Changed { curriculum: setting.curriculum.name.clone() },
        }
    }

    fn body(&self, body: BodyId) -> String {
        let known = self.0.bodies().get(usize::from(body.0));
        known.map_or_else(|| format!("body {}", body.0), |body| body.name.clone())
    }

    fn observation(&self, observation: &Observation) -> String {
        notation::observation(&self.0, observation)
    }

    fn list(&self, observations: &[Observation]) -> String {
        notation::side(observations.iter().map(|one| self.observation(one)))
    }

    fn patterns(&self, patterns: &[Pattern]) -> String {
        notation::side(patterns.iter().map(|one| notation::pattern(&self.0, one)))
    }

    fn goal(&self, goal: &Goal) -> String {
        match goal {
            Goal::Observed(patterns) => self.patterns(patterns),
            Goal::Again(patterns) => format!("{} again", self.patterns(patterns)),
            Goal::Most(_) => notation::goal(&self.0, goal),
        }
    }

    /// An effect as a sentence.
    fn effect(&self, effect: &Effect) -> String {
        match effect {
            Effect::Declared(declaration) => format!(
                "body {} declares {} observation types, {} actions, a repertoire of {}",
                declaration.body,
                declaration.observation_types.len(),
                declaration.actions.len(),
                declaration.repertoire.len()
            ),
            Effect::SymbolsMet(symbols) => format!("symbols met for the first time: {}", symbols.join(", ")),
            Effect::Attempted { primitive, carried_out } => {
                let action = notation::primitive(&self.0, *primitive);
                if *carried_out {
                    format!("{action} was carried out")
                } else {
                    format!("{action} was asked for, and not carried out")
                }
            }
            Effect::Executed { schema, success, post, .. } => executed(schema.0, *success, post),
            Effect::OutcomeAdded { schema, observation, absent } => {
                let outcome = notation::outcome(self.observation(observation), *absent);
                format!("schema {} gains the outcome {outcome}", schema.0)
            }
            Effect::Created { pre, action, post, contradicts, .. } => {
                let post =
                    post.iter().map(|(what, absent)| notation::outcome(self.observation(what), *absent));
                let exception = contradicts.map_or(String::new(), |id| format!(", an exception to {}", id.0));
                let action = notation::primitive(&self.0, *action);
                format!(
                    "a schema is made: {} / {action} / {}{exception}",
                    self.list(pre),
                    notation::side(post)
                )
            }
            Effect::Generalised { pre, target, post, examples, .. } => {
                let post = post
                    .iter()
                    .map(|(what, absent)| notation::outcome(notation::pattern(&self.0, what), *absent));
                let (pre, target, post) = (self.patterns(pre), self.patterns(target), notation::side(post));
                let examples: Vec<_> = examples.iter().map(|id| id.0.to_string()).collect();
                format!(
                    "a generalised schema is made: {pre} / achieve {target} / {post}, of examples {}",
                    examples.join(", ")
                )
            }
            Effect::Supported { generalised, example } => {
                format!("generalised schema {} has example {} as well", generalised.0, example.0)
            }
            Effect::Retired { generalised } => {
                format!("generalised schema {} fails too often and is retired", generalised.0)
            }
            Effect::Associated { schema, observation, .. } => {
                format!("schema {} is associated with {}", schema.0, self.observation(observation))
            }
            Effect::Happened(events) => format!("happened: {}", self.list(events)),
            Effect::Attended(observations) => format!("attended to: {}", self.list(observations)),
            Effect::Stage(effect) => self.stage(effect),
            Effect::Pursuit(effect) => self.pursuit(effect),
            Effect::StepEnded { body, pending, .. } => {
                let body = self.body(*body);
                match pending {
                    None => format!("body {body} is sent to do nothing"),
                    Some(execution) => {
                        let action = notation::primitive(&self.0, execution.action);
                        let why = execution
                            .schema
                            .map_or("no schema yet".to_owned(), |id| format!("schema {}", id.0));
                        format!("body {body} is sent to {action}, for {why}")
                    }
                }
            }
            Effect::Full(true) => "memory is full: nothing new is taken in".to_owned(),
            Effect::Full(false) => "memory has room again".to_owned(),
            Effect::Described { body, text } => {
                format!("body {} describes itself: {}", self.body(*body), text.trim_end().replace('\n', "; "))
            }
            Effect::Mechanisms(mechanisms) => format!("the learner has the profile {}", profile(*mechanisms)),
            Effect::Experienced(one) if one.is_beginning() => {
                format!("a new episode begins for body {}", self.body(one.body))
            }
            Effect::Experienced(one) if one.is_end() => {
                let action = notation::primitive(&self.0, one.primitive);
                format!("evidence is taken in that {action} leads nowhere where the episode ended")
            }
            Effect::Experienced(experience) => {
                let action = notation::primitive(&self.0, experience.primitive);
                format!("evidence is taken in of {action}")
            }
            Effect::Followed { body, on } => {
                let supposed = on.iter().filter(|on| **on).count();
                format!("body {} supposes {supposed} of {} synthetic items", self.body(*body), on.len())
            }
            Effect::Supposed { primitive, updates, .. } => {
                let action = notation::primitive(&self.0, *primitive);
                format!("a synthetic item tells what comes of {action}, by {} events", updates.len())
            }
            Effect::Dropped { item } => format!("no claim asks for synthetic item {item}: it is dropped"),
        }
    }

    fn stage(&self, effect: &StageEffect) -> String {
        match effect {
            StageEffect::Begun { student, .. } => {
                format!("the curriculum begins for body {}", self.body(*student))
            }
            StageEffect::Entered { name, .. } => format!("stage {name:?} is entered"),
            StageEffect::TrialBegun { drawn } => {
                let drawn: Vec<_> = drawn.iter().map(|(_, number)| number.to_string()).collect();
                match drawn.len() {
                    0 => "a trial begins".to_owned(),
                    _ => format!("a trial begins, with {} drawn", drawn.join(", ")),
                }
            }
            StageEffect::Acted { .. } => "an action counts in the stage".to_owned(),
            StageEffect::Spoken { utterances, .. } => match utterances.len() {
                0 => "the teacher says nothing".to_owned(),
                count => format!("the teacher speaks, {count} times"),
            },
            StageEffect::Quiet(true) => "the action brought nothing new or exciting".to_owned(),
            StageEffect::Quiet(false) => "the action brought something new or exciting".to_owned(),
            StageEffect::TrialEnded { met: true, .. } => "the trial ends with what it was for".to_owned(),
            StageEffect::TrialEnded { met: false, .. } => "the trial ends without what it was for".to_owned(),
            StageEffect::Saturated => "the stage is saturated".to_owned(),
            StageEffect::Ended => "the stage is over".to_owned(),
            StageEffect::Finished => "the curriculum is over".to_owned(),
            StageEffect::Held(true) => "an operator holds the learner".to_owned(),
            StageEffect::Held(false) => "an operator lets the learner go on".to_owned(),
            StageEffect::Stuck(why) => format!("the curriculum can't go on: {why}"),
            StageEffect::Left => "the curriculum is left for another".to_owned(),
        }
    }

    fn pursuit(&self, effect: &PursuitEffect) -> String {
        match effect {
            PursuitEffect::Begun { body, goal, actions_max } => {
                let (body, goal) = (self.body(*body), self.goal(goal));
                format!("body {body} pursues {goal}, with at most {actions_max} actions")
            }
            PursuitEffect::Planned(plan) => {
                let because = match plan.because {
                    PlanCause::First => "the first plan",
                    PlanCause::NotReached => "a new plan, for the goal was not reached",
                    PlanCause::NextNotAllowed => "a new plan, for the next schema was not allowed",
                    PlanCause::NotCarriedOut => "a new plan, for an action was not carried out",
                    PlanCause::Interrupted => "a new plan, for the last was interrupted",
                };
                let schemas: Vec<_> = plan.chain.iter().map(|link| link.schema.0.to_string()).collect();
                let way = match &plan.policy {
                    Some(policy) => format!("a policy of {} contexts", policy.rows.len()),
                    None => format!("schemas {}", schemas.join(", ")),
                };
                match plan.policy.as_ref().and_then(|policy| policy.worth()) {
                    Some(worth) => format!("{because}: {way}, which expects {worth:.2}"),
                    None => format!("{because}: {way}, probability {:.2}", plan.probability),
                }
            }
            PursuitEffect::Revised(policy) => match policy.worth() {
                Some(worth) => {
                    format!(
                        "the policy is made anew, of {} contexts, and expects {worth:.2}",
                        policy.rows.len()
                    )
                }
                None => format!("the policy is made anew, of {} contexts", policy.rows.len()),
            },
            PursuitEffect::Came(more) => format!("{more:.2} came for the goal"),
            PursuitEffect::Acted => "an action counts for the goal".to_owned(),
            PursuitEffect::Ended(ending) => {
                let ending = match ending {
                    Ending::Achieved => "achieved",
                    Ending::NothingLeadsThere => "given up: nothing known leads there",
                    Ending::ActionsUsedUp => "given up: its actions are used up",
                    Ending::Constrained => "given up: the stage constrains what it speaks of",
                    Ending::Cancelled => "called off",
                    Ending::FurtherThanLooked => "given up: nothing leads there as far as was looked",
                    Ending::NothingBringsAny => "given up: nothing known brings any",
                };
                format!("the goal is {ending}")
            }
        }
    }
}

fn executed(schema: u32, success: bool, post: &[Score]) -> String {
    let held = post.iter().filter(|seen| **seen == Score::Held).count();
    let known = post.iter().filter(|seen| **seen != Score::Constrained).count();
    let verdict = if success { "as predicted" } else { "not as predicted" };
    let outcomes = if known == 1 { "outcome" } else { "outcomes" };
    format!("schema {schema} was executed, {verdict}: {held} of {known} {outcomes} held")
}
