//! A curriculum: the stages a learner is led through, as plain data. `stages.rs` follows it.

/// A list of stages to go through, and where the experimenter's choices come from.
#[derive(Clone, Debug, PartialEq)]
pub struct Curriculum {
    /// Its name.
    pub name: String,
    /// Sets of numbers to draw from, shuffled by the seed when the curriculum begins.
    pub pools: Vec<Pool>,
    /// The stages in order; never empty.
    pub stages: Vec<Stage>,
    /// What happens after the last stage.
    pub afterwards: Afterwards,
}

/// What happens after the last stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Afterwards {
    /// The learner goes on as in the last stage.
    Continue,
    /// The learner waits.
    Hold,
}

/// A set of numbers, each drawn once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pool {
    /// Its name.
    pub name: String,
    /// The smallest number in it.
    pub from: i64,
    /// The largest number in it.
    pub to: i64,
}

/// One developmental step.
#[derive(Clone, Debug, PartialEq)]
pub struct Stage {
    /// Its name.
    pub name: String,
    /// The observation types that are lifted; all others are constrained.
    pub lift: Lift,
    /// Whether anything is learnt; false to measure without teaching.
    pub learning: bool,
    /// How often the surroundings are arranged; 0 when they are left alone.
    pub trials: u32,
    /// What is arranged at the start of each trial.
    pub arrange: Vec<SceneCommand>,
    /// A trial ends when this is observed.
    pub until: Option<NamedObservation>,
    /// A trial ends when this has not been observed for a while.
    pub until_absent: Option<Absence>,
    /// A trial ends after this many actions; 0 for no such end.
    pub trial_actions_max: u32,
    /// When there is little novel left; none: the stage ends with its last trial, or never without trials.
    pub saturation: Option<Saturation>,
    /// What must be tried again before the next constraint is lifted (II-G).
    pub habituation: Option<Habituation>,
    /// What a teacher says while a trial goes on.
    pub say: Vec<Utterance>,
}

impl Stage {
    /// Whether the trials end when there is little novel left, and not by what is observed or done.
    #[must_use]
    pub fn ends_by_saturation(&self) -> bool {
        self.saturation.is_some()
            && self.until.is_none()
            && self.until_absent.is_none()
            && self.trial_actions_max == 0
    }
}

/// Something that was not observed after so many actions in a row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Absence {
    /// What was not observed.
    pub observation: NamedObservation,
    /// After how many actions in a row; 1 or more.
    pub actions: u32,
}

/// What a teacher says in the trials of a stage (paper, II-F: "speaking to it as it performs actions"). It is heard in the very frame
/// that gives the occasion.
#[derive(Clone, Debug, PartialEq)]
pub struct Utterance {
    /// What is heard: one of these, drawn when there are several.
    pub heard: Vec<NamedObservation>,
    /// Said when this is observed; without it in the first frame after the trial has begun.
    pub when: Option<NamedObservation>,
    /// Not said when this is observed.
    pub unless: Option<NamedObservation>,
    /// How probable it is to be said when there is occasion, in 0..=1.
    pub probability: f64,
    /// How often it is said in one trial at most.
    pub times_max: u32,
}

/// Which senses are lifted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Lift {
    /// All of them.
    All,
    /// Those of these names.
    Types(Vec<String>),
}

/// Something that may be observed: a type, and the properties it must have.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedObservation {
    /// The observation type's name.
    pub kind: String,
    /// Property names with the values they must have; integers and symbols.
    pub properties: Vec<(String, Argument)>,
}

/// A request to the surroundings, by the names that the body declared.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneCommand {
    /// The command's name.
    pub command: String,
    /// Parameter names with their values.
    pub arguments: Vec<(String, Argument)>,
}

/// A value in a curriculum.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Argument {
    /// A whole number.
    Integer(i64),
    /// A symbol.
    Symbol(String),
    /// The next number from the pool of this name; in a command as sent, never.
    Draw(String),
}

/// When a stage is saturated: nothing new and nothing exciting for a while.
#[derive(Clone, Debug, PartialEq)]
pub struct Saturation {
    /// The top excitation must be below this …
    pub excitation_below: f64,
    /// … and no schema made, for this many actions in a row.
    pub actions: u32,
}

/// When a stage is habituated to: each of its schemas that can be executed here has been executed often
/// enough, or its success probability is known well enough.
#[derive(Clone, Debug, PartialEq)]
pub struct Habituation {
    /// Executions that are enough.
    pub executions_min: u32,
    /// Width of the interval of the success probability that is enough, in 0..=1; 0 to ask for executions.
    pub interval_max: f64,
}

/// Why a curriculum can't be followed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CurriculumError {
    /// There is nothing to follow.
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
        /// The pools there are.
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
        /// How many there may be.
        max: i64,
    },
    /// A trial that nothing ends.
    #[error(
        "the trials of stage {0:?} never end: give it `until`, `until_absent`, `trial_actions_max` or `saturation`"
    )]
    Endless(String),
    /// A level or width out of range.
    #[error("stage {stage:?}: {what} = {value} is outside {range}")]
    Setting {
        /// The stage.
        stage: String,
        /// Which setting.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        range: &'static str,
    },
}

/// Entries of one stage's [`Stage::say`].
pub const UTTERANCES_MAX: usize = 64;

/// Numbers in one pool.
pub const POOL_NUMBERS_MAX: i64 = 100_000;

impl Curriculum {
    /// Checks that it can be followed to its end.
    ///
    /// # Errors
    /// The first thing that stands in the way.
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
