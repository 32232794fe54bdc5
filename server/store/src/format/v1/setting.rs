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
#[serde(deny_unknown_fields)]
pub(crate) struct Setting {
    pub(crate) parameters: Parameters,
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
        association_weight: f64,
        excite_by_post_conditions: bool,
        babbling_excitation: f64,
        generalisation: bool,
        generalisation_share_min: f64,
        generalisation_support_min: u64,
        prediction_ratio_min: f64,
        association_low_min: f64,
        attention: bool,
        heard_decays: bool,
        chain_length_max: u32,
        chain_expansions_max: u32,
        type_overrides: Vec<TypeOverride>,
    }

    /// An observation type whose part in learning differs from what its flags say.
    struct TypeOverride = numbers::TypeOverride {
        name: String,
        precondition: Option<bool>,
        postcondition: Option<bool>,
    }

    /// The stages that a learner is led through.
    struct Curriculum = live::Curriculum {
        name: String,
        afterwards: Afterwards,
        pools: Vec<Pool>,
        stages: Vec<Stage>,
    }

    /// What happens after the last stage.
    enum Afterwards = live::Afterwards {
        Continue,
        Hold,
    }

    /// Numbers to draw from.
    struct Pool = live::Pool {
        name: String,
        from: i64,
        to: i64,
    }

    /// One stage.
    struct Stage = live::Stage {
        name: String,
        learning: bool,
        trials: u32,
        trial_actions_max: u32,
        lift: Lift,
        saturation: Option<Saturation>,
        habituation: Option<Habituation>,
        until: Option<NamedObservation>,
        until_absent: Option<Absence>,
        arrange: Vec<SceneCommand>,
        say: Vec<Utterance>,
    }

    /// Which senses are lifted.
    enum Lift = live::Lift {
        All,
        Types(names: Vec<String>),
    }

    /// When a stage is saturated.
    struct Saturation = live::Saturation {
        excitation_below: f64,
        actions: u32,
    }

    /// When a stage is habituated to.
    struct Habituation = live::Habituation {
        executions_min: u32,
        interval_max: f64,
    }

    /// Something that may be observed.
    struct NamedObservation = live::NamedObservation {
        kind: String,
        properties: Vec<Argument>,
    }

    /// Something that was not observed for a while.
    struct Absence = live::Absence {
        actions: u32,
        observation: NamedObservation,
    }

    /// A request to the surroundings.
    struct SceneCommand = live::SceneCommand {
        command: String,
        arguments: Vec<Argument>,
    }

    /// What a teacher says.
    struct Utterance = live::Utterance {
        probability: f64,
        times_max: u32,
        heard: Vec<NamedObservation>,
        when: Option<NamedObservation>,
        unless: Option<NamedObservation>,
    }

    /// What is given for a property or an argument.
    enum ArgumentValue = live::Argument {
        Integer(number: i64),
        Symbol(symbol: String),
        Draw(pool: String),
    }
}

/// A property or an argument with its value. TOML reads better with names than with pairs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Argument {
    name: String,
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
