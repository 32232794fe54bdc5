//! A curriculum: the stages that a learner is led through (paper, II-F), as plain data. `cycle/stages.rs` follows it.

use crate::nouns::probability::Count;

/// The stages that a learner is led through, one after another, each of which lifts other senses: the paper's *lift constraint, act,
/// saturate* (II-F).
///
/// ```
/// use pschema_learner::curriculum::{Afterwards, Curriculum, Lift, Saturation, Stage};
///
/// // The finger alone, until nothing is new or exciting any more; then everything.
/// let babbling = Stage {
///     lift: Lift::Types(vec!["finger".to_owned()]),
///     saturation: Some(Saturation { excitation_below: 1.0, actions: 5 }),
///     ..Stage::free("babbling")
/// };
/// let curriculum = Curriculum { stages: vec![babbling, Stage::free("play")], ..Curriculum::free("two stages") };
/// assert_eq!(curriculum.check(), Ok(()));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Curriculum {
    /// The curriculum's name, for people.
    pub name: String,
    /// Sets of numbers to draw from, shuffled by the learner's seed when the curriculum begins.
    pub pools: Vec<Pool>,
    /// The stages in order: at least one, each with a name of its own.
    pub stages: Vec<Stage>,
    /// Whether the learner goes on after the last stage.
    pub afterwards: Afterwards,
}

/// Whether a learner goes on after the last stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Afterwards {
    /// The learner goes on as in the last stage.
    Continue,
    /// The learner asks nothing of its body any more, until an operator enters a stage.
    Hold,
}

/// A set of numbers, each of which is drawn once in the life of a curriculum: places for a block, for instance.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pool {
    /// The pool's name, by which [`Argument::Draw`] names it.
    pub name: String,
    /// The smallest number in the pool.
    pub from: i64,
    /// The largest number in the pool, `from` or more; at most [`POOL_NUMBERS_MAX`] numbers in all.
    pub to: i64,
}

/// One developmental stage (paper, II-F).
#[derive(Clone, Debug, PartialEq)]
pub struct Stage {
    /// The stage's name; no two stages of a curriculum have the same.
    pub name: String,
    /// The observation types that the stage lifts. Observations of all other types are not perceived.
    pub lift: Lift,
    /// Whether the learner learns in this stage; false to measure without teaching.
    pub learning: bool,
    /// How often the surroundings are arranged; 0 when they are left alone.
    pub trials: u32,
    /// The requests to the surroundings at the start of each trial, in order.
    pub arrange: Vec<SceneCommand>,
    /// A trial ends when this is observed.
    pub until: Option<NamedObservation>,
    /// A trial ends when this has not been observed for some actions.
    pub until_absent: Option<Absence>,
    /// A trial ends after so many actions; 0 for no such end.
    pub trial_actions_max: u32,
    /// The stage (or a trial that nothing else ends) ends when there is little novel left. Without it the stage ends with its last
    /// trial, or never when it has no trials.
    pub saturation: Option<Saturation>,
    /// How well the stage's schemas must be known before the next constraint is lifted (II-G).
    pub habituation: Option<Habituation>,
    /// The utterances of a teacher while a trial goes on (II-F); at most [`UTTERANCES_MAX`].
    pub say: Vec<Utterance>,
}

impl Stage {
    /// A stage of this name that lifts every sense and asks for nothing: the learner plays, and never leaves it. Other stages are
    /// written as their difference from this one.
    #[must_use]
    pub fn free(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            lift: Lift::All,
            learning: true,
            trials: 0,
            arrange: Vec::new(),
            until: None,
            until_absent: None,
            trial_actions_max: 0,
            saturation: None,
            habituation: None,
            say: Vec::new(),
        }
    }

    /// Whether the trials end when there is little novel left, and not by an observation or by a number of actions.
    #[must_use]
    pub fn ends_by_saturation(&self) -> bool {
        self.saturation.is_some()
            && self.until.is_none()
            && self.until_absent.is_none()
            && self.trial_actions_max == 0
    }
}

/// An observation that was not made after so many actions in a row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Absence {
    /// The observation.
    pub observation: NamedObservation,
    /// The number of actions in a row after which it was not made; 1 or more.
    pub actions: u32,
}

/// Words of a teacher in the trials of a stage (paper, II-F: "speaking to it as it performs actions"). The learner hears them in the
/// very frame that gives the occasion.
#[derive(Clone, Debug, PartialEq)]
pub struct Utterance {
    /// The observation that the learner then makes: one of these, drawn when there are several; at least one.
    pub heard: Vec<NamedObservation>,
    /// The utterance has its occasion in frames in which this is observed; without it, in the first frame after the trial has begun.
    pub when: Option<NamedObservation>,
    /// The utterance has no occasion in frames in which this is observed.
    pub unless: Option<NamedObservation>,
    /// The probability that the teacher takes an occasion, in 0..=1.
    pub probability: f64,
    /// How often the utterance is said in one trial at most; 1 or more.
    pub times_max: u32,
}

/// The observation types that a stage lifts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Lift {
    /// All of them.
    All,
    /// The types of these names. A name that no body declared lifts nothing.
    Types(Vec<String>),
}

/// An observation by the names that bodies declared: a type, and properties that it must have beside any others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedObservation {
    /// The name of the observation type.
    pub kind: String,
    /// The names of properties with the values that they must have: integers and symbols.
    pub properties: Vec<(String, Argument)>,
}

/// A request to the surroundings, by the names that the body declared.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneCommand {
    /// The name of the command.
    pub command: String,
    /// The names of its parameters with their values.
    pub arguments: Vec<(String, Argument)>,
}

/// A value in a curriculum.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Argument {
    /// A whole number.
    Integer(i64),
    /// A symbol.
    Symbol(String),
    /// The next number from the pool of this name. A command that is sent to a body has the number in its place.
    Draw(String),
}

/// When a stage is saturated (II-F): after some actions in a row that brought nothing new and left nothing exciting.
#[derive(Clone, Debug, PartialEq)]
pub struct Saturation {
    /// The highest excitation by equation (1) must be below this, in the unit of `Parameters::babbling_excitation`; finite, 0 or more.
    pub excitation_below: f64,
    /// For how many actions in a row it must be so, and no schema be made; 1 or more.
    pub actions: u32,
}

/// When a stage is habituated to (II-G): each schema that was made in it and can be executed here has been executed often enough, or
/// its success probability is known well enough.
#[derive(Clone, Debug, PartialEq)]
pub struct Habituation {
    /// The number of executions that is enough.
    pub executions_min: u32,
    /// The width of the 95 % interval of the success probability that is enough, in 0..=1; 0 so that only executions count.
    pub interval_max: f64,
}

impl Habituation {
    /// Whether a schema with these executions is still to be tried.
    #[must_use]
    pub fn wants(&self, executions: Count) -> bool {
        let (low, high) = executions.interval();
        executions.trials < self.executions_min && high - low > self.interval_max
    }
}

/// Why a curriculum can't be followed to its end.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CurriculumError {
    /// It has no stages.
    #[error("a curriculum needs at least one stage")]
    Empty,
    /// Two stages of one name could not be told apart.
    #[error("stage {0:?} occurs twice; give each stage a name of its own")]
    Twice(String),
    /// A stage draws from a pool that is not there.
    #[error("stage {stage:?} draws from pool {pool:?}, which is not among the pools ({known})")]
    Pool {
        /// The stage.
        stage: String,
        /// The pool it names.
        pool: String,
        /// The names of the pools there are.
        known: String,
    },
    /// A pool without numbers, or with too many.
    #[error("pool {name:?} holds {from}..={to}; it must hold between 1 and {max} numbers")]
    Range {
        /// The pool.
        name: String,
        /// Its smallest number.
        from: i64,
        /// Its largest number.
        to: i64,
        /// How many numbers there may be.
        max: i64,
    },
    /// Nothing ends the trials of this stage.
    #[error(
        "the trials of stage {0:?} never end: give it `until`, `until_absent`, `trial_actions_max` or `saturation`"
    )]
    Endless(String),
    /// A setting of a stage is out of its range.
    #[error("stage {stage:?}: {what} = {value} is outside {range}")]
    Setting {
        /// The stage.
        stage: String,
        /// The name of the setting.
        what: &'static str,
        /// The value of the setting.
        value: f64,
        /// The range of the setting.
        range: &'static str,
    },
}

/// How many utterances one stage may have.
pub const UTTERANCES_MAX: usize = 64;

/// How many numbers one pool may have.
pub const POOL_NUMBERS_MAX: i64 = 100_000;

impl Curriculum {
    /// A curriculum of this name with one stage that lifts every sense and asks for nothing.
    #[must_use]
    pub fn free(name: impl Into<String>) -> Self {
        let stages = vec![Stage::free("free")];
        Self { name: name.into(), pools: Vec::new(), stages, afterwards: Afterwards::Continue }
    }

    /// Checks that the curriculum can be followed to its end.
    ///
    /// # Errors
    /// The first mistake in it.
    pub fn check(&self) -> Result<(), CurriculumError> {
        if self.stages.is_empty() {
            return Err(CurriculumError::Empty);
        }
        for pool in &self.pools {
            let count = pool.to.checked_sub(pool.from).and_then(|span| span.checked_add(1));
            if !count.is_some_and(|count| (1..=POOL_NUMBERS_MAX).contains(&count)) {
                let Pool { name, from, to } = pool.clone();
                return Err(CurriculumError::Range { name, from, to, max: POOL_NUMBERS_MAX });
            }
        }
        for (at, stage) in self.stages.iter().enumerate() {
            if self.stages[..at].iter().any(|earlier| earlier.name == stage.name) {
                return Err(CurriculumError::Twice(stage.name.clone()));
            }
            self.check_stage(stage)?;
        }
        Ok(())
    }

    fn check_stage(&self, stage: &Stage) -> Result<(), CurriculumError> {
        let arguments = stage.arrange.iter().flat_map(|command| &command.arguments);
        for (_, argument) in arguments {
            if let Argument::Draw(pool) = argument
                && !self.pools.iter().any(|known| known.name == *pool)
            {
                let known: Vec<_> = self.pools.iter().map(|pool| pool.name.as_str()).collect();
                return Err(CurriculumError::Pool {
                    stage: stage.name.clone(),
                    pool: pool.clone(),
                    known: known.join(", "),
                });
            }
        }
        let ended = stage.until.is_some() || stage.until_absent.is_some() || stage.trial_actions_max > 0;
        if stage.trials > 0 && !ended && stage.saturation.is_none() {
            return Err(CurriculumError::Endless(stage.name.clone()));
        }
        let wrong = |what, value, range| {
            Err(CurriculumError::Setting { stage: stage.name.clone(), what, value, range })
        };
        if let Some(saturation) = &stage.saturation {
            if !(saturation.excitation_below.is_finite() && saturation.excitation_below >= 0.0) {
                return wrong("saturation.excitation_below", saturation.excitation_below, "0..");
            }
            if saturation.actions == 0 {
                return wrong("saturation.actions", 0.0, "1..");
            }
        }
        if stage.until_absent.as_ref().is_some_and(|absence| absence.actions == 0) {
            return wrong("until_absent.actions", 0.0, "1..");
        }
        if stage.say.len() > UTTERANCES_MAX {
            return wrong("entries of say", stage.say.len() as f64, "0..=64");
        }
        for Utterance { heard, probability, times_max, .. } in &stage.say {
            if heard.is_empty() {
                return wrong("words to say", 0.0, "1..");
            }
            if !(0.0..=1.0).contains(probability) {
                return wrong("say.probability", *probability, "0..=1");
            }
            if *times_max == 0 {
                return wrong("say.times", 0.0, "1..");
            }
        }
        match &stage.habituation {
            Some(rule) if !(0.0..=1.0).contains(&rule.interval_max) => {
                wrong("habituation.interval_max", rule.interval_max, "0..=1")
            }
            _ => Ok(()),
        }
    }
}
