//! What a memory lives under: the learner's parameters and its curriculum, whole. In the manifest as TOML, in journal and
//! snapshots as everything else.

use pschema_learner::curriculum as live;
use pschema_learner::parameters as numbers;
use serde::{Deserialize, Serialize};

use super::observation::{back, list};
use super::{Impossible, index};

/// Pools of a curriculum, as in what people write.
const POOLS_MAX: usize = 64;

/// Parameters and curriculum.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Setting {
    pub(crate) parameters: Parameters,
    pub(crate) curriculum: Curriculum,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Parameters {
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

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct TypeOverride {
    name: String,
    precondition: Option<bool>,
    postcondition: Option<bool>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Curriculum {
    pub(crate) name: String,
    afterwards: Afterwards,
    pools: Vec<Pool>,
    stages: Vec<Stage>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Afterwards {
    Continue,
    Hold,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Pool {
    name: String,
    from: i64,
    to: i64,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Stage {
    name: String,
    learning: bool,
    trials: u32,
    trial_actions_max: u32,
    lift: Lift,
    saturation: Option<Saturation>,
    habituation: Option<Habituation>,
    until: Option<Until>,
    until_absent: Option<Absence>,
    arrange: Vec<SceneCommand>,
    say: Vec<Utterance>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Lift {
    All,
    Types(Vec<String>),
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Saturation {
    excitation_below: f64,
    actions: u32,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Habituation {
    executions_min: u32,
    interval_max: f64,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Until {
    kind: String,
    properties: Vec<Named>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Absence {
    actions: u32,
    observation: Until,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct SceneCommand {
    command: String,
    arguments: Vec<Named>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Utterance {
    probability: f64,
    times_max: u32,
    heard: Vec<Until>,
    when: Option<Until>,
    unless: Option<Until>,
}

/// A property or an argument with its value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Named {
    name: String,
    value: Argument,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Argument {
    Integer(i64),
    Symbol(String),
    Draw(String),
}

impl Setting {
    /// These parameters and this curriculum.
    pub(crate) fn new(parameters: &numbers::Parameters, curriculum: &live::Curriculum) -> Self {
        Self { parameters: parameters.into(), curriculum: curriculum.into() }
    }

    /// The same as the learner has it.
    pub(crate) fn live(self) -> Result<(numbers::Parameters, live::Curriculum), Impossible> {
        let parameters = numbers::Parameters::from(self.parameters);
        let curriculum = live::Curriculum::from(self.curriculum);
        parameters.check().map_err(|_| Impossible("a parameter"))?;
        curriculum.check().map_err(|_| Impossible("a curriculum"))?;
        if curriculum.pools.len() > POOLS_MAX {
            return Err(Impossible("a pool"));
        }
        Ok((parameters, curriculum))
    }
}

impl Curriculum {
    /// How many stages it has.
    pub(crate) fn stages(&self) -> usize {
        self.stages.len()
    }
}

impl From<&numbers::Parameters> for Parameters {
    fn from(live: &numbers::Parameters) -> Self {
        // Named one by one, so that a parameter that is added can't be forgotten here.
        let numbers::Parameters {
            association_weight,
            excite_by_post_conditions,
            babbling_excitation,
            generalisation,
            generalisation_share_min,
            generalisation_support_min,
            prediction_ratio_min,
            association_low_min,
            attention,
            heard_decays,
            chain_length_max,
            chain_expansions_max,
            type_overrides,
        } = live;
        Self {
            association_weight: *association_weight,
            excite_by_post_conditions: *excite_by_post_conditions,
            babbling_excitation: *babbling_excitation,
            generalisation: *generalisation,
            generalisation_share_min: *generalisation_share_min,
            generalisation_support_min: *generalisation_support_min as u64,
            prediction_ratio_min: *prediction_ratio_min,
            association_low_min: *association_low_min,
            attention: *attention,
            heard_decays: *heard_decays,
            chain_length_max: *chain_length_max,
            chain_expansions_max: *chain_expansions_max,
            type_overrides: list(type_overrides),
        }
    }
}

impl From<Parameters> for numbers::Parameters {
    fn from(disk: Parameters) -> Self {
        Self {
            association_weight: disk.association_weight,
            excite_by_post_conditions: disk.excite_by_post_conditions,
            babbling_excitation: disk.babbling_excitation,
            generalisation: disk.generalisation,
            generalisation_share_min: disk.generalisation_share_min,
            generalisation_support_min: index(disk.generalisation_support_min),
            prediction_ratio_min: disk.prediction_ratio_min,
            association_low_min: disk.association_low_min,
            attention: disk.attention,
            heard_decays: disk.heard_decays,
            chain_length_max: disk.chain_length_max,
            chain_expansions_max: disk.chain_expansions_max,
            type_overrides: back(disk.type_overrides),
        }
    }
}

impl From<&numbers::TypeOverride> for TypeOverride {
    fn from(live: &numbers::TypeOverride) -> Self {
        let numbers::TypeOverride { name, precondition, postcondition } = live.clone();
        Self { name, precondition, postcondition }
    }
}

impl From<TypeOverride> for numbers::TypeOverride {
    fn from(TypeOverride { name, precondition, postcondition }: TypeOverride) -> Self {
        Self { name, precondition, postcondition }
    }
}

impl From<&live::Curriculum> for Curriculum {
    fn from(live::Curriculum { name, pools, stages, afterwards }: &live::Curriculum) -> Self {
        let afterwards = match afterwards {
            live::Afterwards::Continue => Afterwards::Continue,
            live::Afterwards::Hold => Afterwards::Hold,
        };
        Self { name: name.clone(), afterwards, pools: list(pools), stages: list(stages) }
    }
}

impl From<Curriculum> for live::Curriculum {
    fn from(Curriculum { name, afterwards, pools, stages }: Curriculum) -> Self {
        let afterwards = match afterwards {
            Afterwards::Continue => live::Afterwards::Continue,
            Afterwards::Hold => live::Afterwards::Hold,
        };
        Self { name, afterwards, pools: back(pools), stages: back(stages) }
    }
}

impl From<&live::Pool> for Pool {
    fn from(live: &live::Pool) -> Self {
        let live::Pool { name, from, to } = live.clone();
        Self { name, from, to }
    }
}

impl From<Pool> for live::Pool {
    fn from(Pool { name, from, to }: Pool) -> Self {
        Self { name, from, to }
    }
}

impl From<&live::Stage> for Stage {
    fn from(live: &live::Stage) -> Self {
        let live::Stage {
            name,
            lift,
            learning,
            trials,
            arrange,
            until,
            until_absent,
            trial_actions_max,
            saturation,
            habituation,
            say,
        } = live;
        let lift = match lift {
            live::Lift::All => Lift::All,
            live::Lift::Types(names) => Lift::Types(names.clone()),
        };
        Self {
            name: name.clone(),
            learning: *learning,
            trials: *trials,
            trial_actions_max: *trial_actions_max,
            lift,
            saturation: saturation
                .as_ref()
                .map(|rule| Saturation { excitation_below: rule.excitation_below, actions: rule.actions }),
            habituation: habituation.as_ref().map(|rule| Habituation {
                executions_min: rule.executions_min,
                interval_max: rule.interval_max,
            }),
            until: until.as_ref().map(Until::from),
            until_absent: until_absent.as_ref().map(|absence| Absence {
                actions: absence.actions,
                observation: (&absence.observation).into(),
            }),
            arrange: list(arrange),
            say: list(say),
        }
    }
}

impl From<Stage> for live::Stage {
    fn from(disk: Stage) -> Self {
        let lift = match disk.lift {
            Lift::All => live::Lift::All,
            Lift::Types(names) => live::Lift::Types(names),
        };
        Self {
            name: disk.name,
            lift,
            learning: disk.learning,
            trials: disk.trials,
            arrange: back(disk.arrange),
            until: disk.until.map(live::NamedObservation::from),
            until_absent: disk.until_absent.map(|absence| live::Absence {
                observation: absence.observation.into(),
                actions: absence.actions,
            }),
            trial_actions_max: disk.trial_actions_max,
            saturation: disk.saturation.map(|rule| live::Saturation {
                excitation_below: rule.excitation_below,
                actions: rule.actions,
            }),
            habituation: disk.habituation.map(|rule| live::Habituation {
                executions_min: rule.executions_min,
                interval_max: rule.interval_max,
            }),
            say: back(disk.say),
        }
    }
}

impl From<&live::NamedObservation> for Until {
    fn from(live::NamedObservation { kind, properties }: &live::NamedObservation) -> Self {
        Self { kind: kind.clone(), properties: named(properties) }
    }
}

impl From<Until> for live::NamedObservation {
    fn from(Until { kind, properties }: Until) -> Self {
        Self { kind, properties: named_back(properties) }
    }
}

impl From<&live::SceneCommand> for SceneCommand {
    fn from(live::SceneCommand { command, arguments }: &live::SceneCommand) -> Self {
        Self { command: command.clone(), arguments: named(arguments) }
    }
}

impl From<SceneCommand> for live::SceneCommand {
    fn from(SceneCommand { command, arguments }: SceneCommand) -> Self {
        Self { command, arguments: named_back(arguments) }
    }
}

impl From<&live::Utterance> for Utterance {
    fn from(live: &live::Utterance) -> Self {
        let live::Utterance { heard, when, unless, probability, times_max } = live;
        Self {
            probability: *probability,
            times_max: *times_max,
            heard: list(heard),
            when: when.as_ref().map(Until::from),
            unless: unless.as_ref().map(Until::from),
        }
    }
}

impl From<Utterance> for live::Utterance {
    fn from(Utterance { probability, times_max, heard, when, unless }: Utterance) -> Self {
        let (when, unless) =
            (when.map(live::NamedObservation::from), unless.map(live::NamedObservation::from));
        Self { heard: back(heard), when, unless, probability, times_max }
    }
}

fn named(live: &[(String, live::Argument)]) -> Vec<Named> {
    let one = |(name, value): &(String, live::Argument)| {
        let value = match value {
            live::Argument::Integer(number) => Argument::Integer(*number),
            live::Argument::Symbol(symbol) => Argument::Symbol(symbol.clone()),
            live::Argument::Draw(pool) => Argument::Draw(pool.clone()),
        };
        Named { name: name.clone(), value }
    };
    live.iter().map(one).collect()
}

fn named_back(disk: Vec<Named>) -> Vec<(String, live::Argument)> {
    let one = |Named { name, value }| {
        let value = match value {
            Argument::Integer(number) => live::Argument::Integer(number),
            Argument::Symbol(symbol) => live::Argument::Symbol(symbol),
            Argument::Draw(pool) => live::Argument::Draw(pool),
        };
        (name, value)
    };
    disk.into_iter().map(one).collect()
}
