//! What a memory lives under: the learner's parameters and its curriculum, whole. The manifest has it as TOML, journal and
//! snapshots have it as they have everything.

use std::fmt::Display;

use pschema_learner::curriculum as live;
use pschema_learner::parameters as numbers;
use serde::{Deserialize, Serialize};

use crate::content_error::ContentError;
use crate::extent::limited;
use crate::format::mirror::{Mirror, mirror};

/// Pools that a curriculum may have, as in the files that people write.
const POOLS_MAX: usize = 64;

/// Parameters and curriculum.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct Setting {
    /// The learner's numbers and switches.
    pub(crate) parameters: Parameters,
    /// The stages that the learner is led through.
    pub(crate) curriculum: Curriculum,
}

impl Setting {
    /// These parameters and this curriculum.
    pub(crate) fn new(parameters: &numbers::Parameters, curriculum: &live::Curriculum) -> Self {
        Self { parameters: Mirror::of(parameters), curriculum: Mirror::of(curriculum) }
    }

    /// The learner's parameters and curriculum, if a learner can live under them.
    pub(crate) fn checked(&self) -> Result<(numbers::Parameters, live::Curriculum), ContentError> {
        let parameters: numbers::Parameters = self.parameters.clone().live();
        let curriculum: live::Curriculum = self.curriculum.clone().live();
        let wrong = |error: &dyn Display| {
            ContentError::new(format!("no learner can live under its settings: {error}"))
        };
        parameters.check().map_err(|error| wrong(&error))?;
        curriculum.check().map_err(|error| wrong(&error))?;
        limited("pools", curriculum.pools.len(), POOLS_MAX)?;
        Ok((parameters, curriculum))
    }
}

mirror! {
    /// The learner's numbers and switches.
    struct Parameters = numbers::Parameters {
        /// ω of equation (1).
        association_weight: f64,
        /// Whether the excitation counts post-conditions.
        excite_by_post_conditions: bool,
        /// The excitation of a primitive for which no schema can be executed.
        babbling_excitation: f64,
        /// Whether generalisation is attempted.
        generalisation: bool,
        /// The share of similar schemas that a generalised one must represent.
        generalisation_share_min: f64,
        /// How many schemas must support a generalisation.
        generalisation_support_min: u64,
        /// The share of trials in which a post-condition must have held for the schema to predict it.
        prediction_ratio_min: f64,
        /// What the lower end of the 95 % interval must reach before an observation is associated.
        association_low_min: f64,
        /// Whether attention is counted.
        attention: bool,
        /// Whether heard observations lose excitation with repetition.
        heard_decays: bool,
        /// The number of schemas in the longest chain that is considered.
        chain_length_max: u32,
        /// The number of contexts that one search for chains may expand.
        chain_expansions_max: u32,
        /// The observation types whose part in learning differs from what their flags say.
        type_overrides: Vec<TypeOverride>,
    }

    /// An observation type whose part in learning differs from what its flags say.
    struct TypeOverride = numbers::TypeOverride {
        /// The name of the observation type.
        name: String,
        /// Whether its observations may be pre-conditions; none as its flags say.
        precondition: Option<bool>,
        /// Whether its observations may be post-conditions; none as its flags say.
        postcondition: Option<bool>,
    }

    /// The stages that a learner is led through.
    struct Curriculum = live::Curriculum {
        /// The name.
        name: String,
        /// Whether the learner goes on after the last stage.
        afterwards: Afterwards,
        /// Sets of numbers to draw from.
        pools: Vec<Pool>,
        /// The stages in order.
        stages: Vec<Stage>,
    }

    /// What happens after the last stage.
    enum Afterwards = live::Afterwards {
        /// It goes on as in the last stage.
        Continue,
        /// It asks nothing of its body any more.
        Hold,
    }

    /// Numbers to draw from.
    struct Pool = live::Pool {
        /// The name.
        name: String,
        /// The smallest number.
        from: i64,
        /// The largest number.
        to: i64,
    }

    /// One stage.
    struct Stage = live::Stage {
        /// The name.
        name: String,
        /// Whether the learner learns in this stage.
        learning: bool,
        /// How often the surroundings are arranged; 0 when they are left alone.
        trials: u32,
        /// A trial ends after so many actions; 0 for no such end.
        trial_actions_max: u32,
        /// The observation types that are perceived.
        lift: Lift,
        /// The stage, or a trial that nothing else ends, ends when there is little novel left.
        saturation: Option<Saturation>,
        /// How well the stage's schemas must be known before it ends.
        habituation: Option<Habituation>,
        /// A trial ends when this is observed.
        until: Option<NamedObservation>,
        /// A trial ends when this has not been observed for some actions.
        until_absent: Option<Absence>,
        /// The requests to the surroundings at the start of each trial.
        arrange: Vec<SceneCommand>,
        /// The utterances of a teacher.
        say: Vec<Utterance>,
    }

    /// Which senses are lifted.
    enum Lift = live::Lift {
        /// All of them.
        All,
        /// The types of these names.
        Types(names: Vec<String>),
    }

    /// When a stage is saturated.
    struct Saturation = live::Saturation {
        /// The highest excitation must be below this.
        excitation_below: f64,
        /// For how many actions in a row.
        actions: u32,
    }

    /// When a stage is habituated to.
    struct Habituation = live::Habituation {
        /// The number of executions that is enough.
        executions_min: u32,
        /// The width of the 95 % interval of the success probability that is enough.
        interval_max: f64,
    }

    /// Something that may be observed.
    struct NamedObservation = live::NamedObservation {
        /// The name of its observation type.
        kind: String,
        /// Properties that it must have, beside any others.
        properties: Vec<Argument>,
    }

    /// Something that was not observed for a while.
    struct Absence = live::Absence {
        /// After how many actions in a row it was not made.
        actions: u32,
        /// The observation.
        observation: NamedObservation,
    }

    /// A request to the surroundings.
    struct SceneCommand = live::SceneCommand {
        /// The name of the command.
        command: String,
        /// Its parameters with their values.
        arguments: Vec<Argument>,
    }

    /// What a teacher says.
    struct Utterance = live::Utterance {
        /// The probability that the teacher takes an occasion.
        probability: f64,
        /// How often it is said in one trial at most.
        times_max: u32,
        /// The observation that the learner then makes: one of these.
        heard: Vec<NamedObservation>,
        /// It has its occasion where this is observed; without it, in the first frame of a trial.
        when: Option<NamedObservation>,
        /// It has no occasion where this is observed.
        unless: Option<NamedObservation>,
    }

    /// What is given for a property or an argument.
    enum ArgumentValue = live::Argument {
        /// A whole number.
        Integer(number: i64),
        /// A symbol.
        Symbol(symbol: String),
        /// The next number from the pool of this name.
        Draw(pool: String),
    }
}

/// A property or an argument with its value. TOML reads better with names than with pairs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct Argument {
    /// The name.
    name: String,
    /// The value.
    value: ArgumentValue,
}

impl Mirror<(String, live::Argument)> for Argument {
    fn of((name, value): &(String, live::Argument)) -> Self {
        Self { name: name.clone(), value: Mirror::of(value) }
    }

    fn live(self) -> (String, live::Argument) {
        (self.name, self.value.live())
    }
}
