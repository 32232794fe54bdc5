//! The table `[experiment]` of a curriculum's file.

use std::collections::BTreeMap;

use serde::{Deserialize, Deserializer, Serialize};

/// A repeatable run, and what it is judged by.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(crate) struct Design {
    /// The curriculum's own name.
    #[serde(skip)]
    pub(crate) name: String,
    /// The curriculum as a daemon is told it: a built-in name or a file.
    #[serde(skip)]
    pub(crate) curriculum: String,
    /// What it is about, for people.
    pub(crate) title: String,
    /// The body's world: a built-in name or a file.
    pub(crate) world: String,
    /// The body.
    #[serde(default)]
    pub(crate) body: BodyKind,
    /// What was learnt before: the run goes on from the memory of that one.
    pub(crate) after: Option<Earlier>,
    /// How long a run takes, about, on two cores. Decides the order in which several are run.
    #[serde(default = "a_minute")]
    pub(crate) seconds: u32,
    /// What is put before the robot, for people: `blue block`.
    #[serde(default = "an_object")]
    pub(crate) object: String,
    /// What the paper reports of it.
    pub(crate) published: Option<Published>,
    /// Why our figures differ from the published ones, where they do.
    pub(crate) why: Option<String>,
    /// The observation type whose prediction makes a schema one of touching, for the lower part of figure 6.
    pub(crate) touching: Option<String>,
    /// The stage that figure 6 begins with; the first one when none is named.
    pub(crate) figure_from: Option<String>,
    /// The stage that figure 6 ends with; the last one when none is named.
    pub(crate) figure_to: Option<String>,
    /// Labels of figure 6, at the first step of a stage or trial.
    #[serde(default, deserialize_with = "peaks")]
    pub(crate) peaks: Vec<Peak>,
    /// What the map of the visual fields shows.
    pub(crate) map: Option<FieldMap>,
    /// What is read off a run beside the schemas and placements.
    #[serde(default, rename = "measure")]
    pub(crate) measures: Vec<Measure>,
    /// What the run as it stands is called beside its variants.
    #[serde(default = "as_it_is")]
    pub(crate) base: String,
    /// The same run with something changed.
    #[serde(default, rename = "variant")]
    pub(crate) variants: Vec<Variant>,
    /// The same run with one of the curriculum's values changed, again and again: its name, and what it is set to.
    #[serde(default)]
    pub(crate) sweep: BTreeMap<String, Vec<f64>>,
    /// Its stages, in order.
    #[serde(skip)]
    pub(crate) stages: Vec<String>,
}

fn a_minute() -> u32 {
    60
}

fn an_object() -> String {
    "object".to_owned()
}

fn as_it_is() -> String {
    "as it is".to_owned()
}

/// Which body a run is carried out with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum BodyKind {
    /// The simulated arm.
    #[default]
    Sim,
    /// The Adept arm, on an emulator of its controller.
    Adept,
}

impl BodyKind {
    /// Its name, as it is written.
    #[must_use]
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Sim => "sim",
            Self::Adept => "adept",
        }
    }
}

/// A run whose memory another goes on from, in the same world.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(crate) struct Earlier {
    /// Its curriculum: a built-in name or a file.
    pub(crate) curriculum: String,
    /// Its body.
    #[serde(default)]
    pub(crate) body: BodyKind,
}

/// What the paper reports of a run.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(crate) struct Published {
    /// Schemas produced.
    pub(crate) schemas_total: Option<u32>,
    /// Object placements that learning took.
    pub(crate) placements: Option<u32>,
    /// Where it stands in the paper.
    #[serde(skip_serializing)]
    pub(crate) table: Option<String>,
}

/// A label of figure 6.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Peak {
    /// The label.
    pub(crate) label: String,
    /// The stage at whose beginning it stands …
    pub(crate) stage: String,
    /// … or of which trial of it, from 1.
    pub(crate) trial: Option<u32>,
}

/// Peaks by their labels: `{ a = "first touches", b = { stage = "first touches", trial = 2 } }`.
fn peaks<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<Peak>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged, expecting = "a peak is a stage, or { stage = \"NAME\", trial = N }")]
    enum PeakPlace {
        Stage(String),
        Trial { stage: String, trial: u32 },
    }
    let places = BTreeMap::<String, PeakPlace>::deserialize(from)?;
    let peak = |(label, place)| match place {
        PeakPlace::Stage(stage) => Peak { label, stage, trial: None },
        PeakPlace::Trial { stage, trial } => Peak { label, stage, trial: Some(trial) },
    };
    Ok(places.into_iter().map(peak).collect())
}

/// What the map of the visual fields shows, in the names that the body declares.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(crate) struct FieldMap {
    /// The type of what is placed, such as `object`.
    pub(crate) object: String,
    /// The type of what reaches for it, such as `finger`.
    pub(crate) effector: String,
    /// The property of both that says where they are, such as `field`.
    pub(crate) place: String,
    /// The type that is observed when the one has reached the other; [`Design::touching`] when none is named.
    pub(crate) reached: Option<String>,
}

/// Something read off a run.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(crate) struct Measure {
    /// What it is, for people.
    pub(crate) name: String,
    /// How it is read off.
    pub(crate) of: Quantity,
    /// The stages it is about; all that only measure, when none is named.
    #[serde(default, rename = "stage", deserialize_with = "one_or_several")]
    pub(crate) stages: Vec<String>,
    /// For [`Quantity::Precision`]: the stages in which the response is wrong.
    #[serde(default, deserialize_with = "one_or_several")]
    pub(crate) against: Vec<String>,
    /// For [`Quantity::Schemas`]: a pre-condition that counts, as it prints.
    pub(crate) pre: Option<String>,
    /// For [`Quantity::Schemas`]: a post-condition that counts.
    pub(crate) post: Option<String>,
    /// For [`Quantity::Schemas`]: a post-condition of those that do not count.
    pub(crate) except_post: Option<String>,
    /// For [`Quantity::ValueSum`] and [`Quantity::ValueMean`]: the observation type whose numbers are added up.
    pub(crate) value: Option<String>,
    /// What the paper says of it.
    pub(crate) published: Option<String>,
    /// Why ours differs, where it does.
    pub(crate) why: Option<String>,
}

/// `"probe"` or `["probe", "again"]`.
fn one_or_several<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<String>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged, expecting = "stages are one name, or a list of names")]
    enum Names {
        One(String),
        Several(Vec<String>),
    }
    Ok(match Names::deserialize(from)? {
        Names::One(name) => vec![name],
        Names::Several(names) => names,
    })
}

/// How a measure is read off a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Quantity {
    /// Schemas in memory.
    SchemasTotal,
    /// Generalised schemas in memory.
    SchemasGeneralised,
    /// Counter-examples made.
    CounterExamples,
    /// Placements until there was a generalised schema.
    Placements,
    /// Placements of all learning stages.
    PlacementsAll,
    /// Actions in the stages named; in all, when none is named.
    Actions,
    /// Schemas made in the stages named; in all, when none is named.
    SchemasNew,
    /// The share of trials that ended with what they waited for.
    MetShare,
    /// The share of trials that did so with the first action.
    FirstTryShare,
    /// Actions that the trials which did so took, the median of them.
    ActionsToMet,
    /// The share of decisions in which the schema chosen is one of touching, see [`Design::touching`].
    TouchingShare,
    /// Of all trials that ended with what they waited for in `stages` and `against`, the share in `stages`.
    Precision,
    /// Schemas in memory with these conditions.
    Schemas,
    /// What came of a value in the stages named; in all, when none is named.
    ValueSum,
    /// The same for each action.
    ValueMean,
    /// The 99th percentile of the time of a step, in µs.
    StepUsP99,
}

/// The same run with something changed.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(crate) struct Variant {
    /// What it is called.
    pub(crate) name: String,
    /// Parameters of the learner.
    #[serde(default)]
    pub(crate) learner: toml::Table,
    /// Values of the curriculum.
    #[serde(default)]
    pub(crate) values: BTreeMap<String, f64>,
    /// Another curriculum, when it is that which is changed.
    pub(crate) curriculum: Option<String>,
    /// Another world.
    pub(crate) world: Option<String>,
    /// Noise of the body, by name.
    #[serde(default)]
    pub(crate) noise: BTreeMap<String, f64>,
}

impl Variant {
    /// Settings for the daemon: `learner.PARAMETER=VALUE`, `values.NAME=NUMBER`.
    pub(crate) fn settings(&self) -> Vec<String> {
        let learner = self.learner.iter().map(|(name, value)| format!("learner.{name}={value}"));
        let values = self.values.iter().map(|(name, value)| format!("values.{name}={value:?}"));
        learner.chain(values).collect()
    }
}
