//! The table `[experiment]` of a curriculum: what makes a run of it an experiment. In which world it is run, what the
//! paper reports of it, what is measured, and with what it is compared. The learner never sees any of this.

mod written;

use std::path::Path;

use pschema_learner::parameters::Parameters;
use serde::Deserialize;

use super::curriculum::{BUILT_IN, named};
use super::{ConfigError, Mistake, Source, lesson};
use written::{WrittenFile, checked};

/// A repeatable run, and what it is judged by.
#[derive(Clone, Debug, PartialEq)]
pub struct Experiment {
    /// The curriculum's own name.
    pub name: String,
    /// The curriculum as a daemon is told it: a built-in name or a file.
    pub curriculum: String,
    /// What it is about, for people.
    pub title: String,
    /// The body's world: a built-in name or a file.
    pub world: String,
    /// The body.
    pub body: BodyKind,
    /// What was learnt before: the run goes on from the memory of that one.
    pub after: Option<Earlier>,
    /// How long a run takes, about, on two cores. Decides the order in which several are run.
    pub seconds: u32,
    /// What is put before the robot, for people: `blue block`.
    pub object: String,
    /// What the paper reports of it.
    pub published: Option<Published>,
    /// Why our figures differ from the published ones, where they do.
    pub why: Option<String>,
    /// The observation type whose prediction makes a schema one of touching, for the lower part of figure 6.
    pub touching: Option<String>,
    /// The stage that figure 6 begins with; the first one when none is named.
    pub figure_from: Option<String>,
    /// The stage that figure 6 ends with; the last one when none is named.
    pub figure_to: Option<String>,
    /// Labels of figure 6, at the first step of a stage or trial.
    pub peaks: Vec<Peak>,
    /// What the map of the visual fields shows.
    pub map: Option<FieldMap>,
    /// What is read off a run beside the schemas and placements.
    pub measures: Vec<Measure>,
    /// What the run as it stands is called beside its variants.
    pub base: String,
    /// The same run with something changed.
    pub variants: Vec<Variant>,
    /// The same run with one of the curriculum's values changed, again and again.
    pub sweep: Option<Sweep>,
    /// Its stages, in order.
    pub stages: Vec<String>,
}

/// Which body a run is carried out with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum BodyKind {
    /// The simulated arm.
    #[default]
    Sim,
    /// The Adept arm, on an emulator of its controller.
    Adept,
}

impl BodyKind {
    /// Its name, as it is written.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Sim => "sim",
            Self::Adept => "adept",
        }
    }
}

/// A run whose memory another goes on from, in the same world.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Earlier {
    /// Its curriculum: a built-in name or a file.
    pub curriculum: String,
    /// Its body.
    pub body: BodyKind,
}

/// What the paper reports of a run.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Published {
    /// Schemas produced.
    pub schemas_total: Option<u32>,
    /// Object placements that learning took.
    pub placements: Option<u32>,
    /// Where it stands in the paper.
    pub table: Option<String>,
}

/// A label of figure 6.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Peak {
    /// The label.
    pub label: String,
    /// The stage at whose beginning it stands …
    pub stage: String,
    /// … or of which trial of it, from 1.
    pub trial: Option<u32>,
}

/// What the map of the visual fields shows, in the names that the body declares.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FieldMap {
    /// The type of what is placed, such as `object`.
    pub object: String,
    /// The type of what reaches for it, such as `finger`.
    pub effector: String,
    /// The property of both that says where they are, such as `field`.
    pub place: String,
    /// The type that is observed when the one has reached the other; [`Experiment::touching`] when none is named.
    pub reached: Option<String>,
}

/// Something read off a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Measure {
    /// What it is, for people.
    pub name: String,
    /// How it is read off.
    pub of: Of,
    /// The stages it is about; all that only measure, when none is named.
    pub stages: Vec<String>,
    /// For [`Of::Precision`]: the stages in which the response is wrong.
    pub against: Vec<String>,
    /// For [`Of::Schemas`]: a pre-condition that counts, as it prints.
    pub pre: Option<String>,
    /// For [`Of::Schemas`]: a post-condition that counts.
    pub post: Option<String>,
    /// For [`Of::Schemas`]: a post-condition of those that do not count.
    pub except_post: Option<String>,
    /// What the paper says of it.
    pub published: Option<String>,
    /// Why ours differs, where it does.
    pub why: Option<String>,
}

/// How a measure is read off a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Of {
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
    /// The share of decisions in which the schema chosen is one of touching, see [`Experiment::touching`].
    TouchingShare,
    /// Of all trials that ended with what they waited for in `stages` and `against`, the share in `stages`.
    Precision,
    /// Schemas in memory with these conditions.
    Schemas,
    /// The 99th percentile of the time of a step, in µs.
    StepUsP99,
}

/// The same run with something changed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Variant {
    /// What it is called.
    pub name: String,
    /// Settings for the daemon: `learner.PARAMETER=VALUE`, `values.NAME=NUMBER`.
    pub settings: Vec<String>,
    /// Another curriculum, when it is that which is changed.
    pub curriculum: Option<String>,
    /// Another world.
    pub world: Option<String>,
    /// Noise of the body, by name.
    pub noise: Vec<(String, f64)>,
}

/// The same run with one of the curriculum's values changed.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// The value's name.
    pub name: String,
    /// What it is set to.
    pub values: Vec<f64>,
}

/// The experiments that come with the daemon, the quickest first.
///
/// # Errors
/// Never, as long as the built-in curricula are sound, which a test sees to.
pub fn experiments() -> Result<Vec<Experiment>, ConfigError> {
    let mut all = Vec::new();
    for (name, _) in BUILT_IN {
        match experiment(name) {
            Ok(experiment) => all.push(experiment),
            Err(ConfigError::NoExperiment { .. }) => (),
            Err(error) => return Err(error),
        }
    }
    all.sort_by_key(|experiment| experiment.seconds);
    Ok(all)
}

/// The experiment that the curriculum `name` (built in, or a file) is.
///
/// # Errors
/// When there is no such curriculum, it is no experiment, or what is wrong in its table and where.
pub fn experiment(name: &str) -> Result<Experiment, ConfigError> {
    let (source_name, text) = named(name)?;
    let source = Source { name: &source_name, text: &text };
    let is_built_in = BUILT_IN.iter().any(|(known, _)| *known == name);
    // A world or a curriculum that a file names is looked for beside that file.
    let beside = |other: &str| match Path::new(name).parent() {
        Some(folder) if !is_built_in && other.ends_with(".toml") => folder.join(other).display().to_string(),
        _ => other.to_owned(),
    };
    // The rest of the file is the business of the daemon that runs it; but it should be said now, not later.
    lesson(name, Parameters::default(), &[])?;
    let file: WrittenFile = source.parse()?;
    let Some(written) = &file.experiment else {
        return Err(ConfigError::NoExperiment { name: name.to_owned() });
    };
    let experiment = checked(name, &file, written, &beside).map_err(|mistake| source.wrong(mistake))?;
    if let (Some(earlier), Some(written)) = (&experiment.after, &written.get_ref().after) {
        lesson(&earlier.curriculum, Parameters::default(), &[])
            .map_err(|error| source.wrong(Mistake::new(written.span(), error.to_string())))?;
    }
    for (variant, written) in experiment.variants.iter().zip(&written.get_ref().variant) {
        let curriculum = variant.curriculum.as_deref().unwrap_or(name);
        lesson(curriculum, Parameters::default(), &variant.settings)
            .map_err(|error| source.wrong(Mistake::new(written.span(), error.to_string())))?;
    }
    Ok(experiment)
}

#[cfg(test)]
mod tests;
