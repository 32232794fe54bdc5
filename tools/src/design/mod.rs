//! The design of an experiment: the table `[experiment]` of a curriculum. It says in which world the curriculum is run, what
//! the paper reports of the run, what is measured, and with what it is compared. Neither the daemon nor the learner sees any
//! of this.

mod written;

use std::path::Path;

use pschema_learner::parameters::Parameters;
use pschema_server::config::{BUILT_IN, ConfigError, Mistake, Source, lesson, named};
use serde::{Deserialize, Serialize};

use written::{WrittenFile, checked};

/// Why there is no design to be had of a curriculum.
#[derive(Debug, thiserror::Error)]
pub(crate) enum DesignError {
    /// The curriculum, or its table, is wrong or not there.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// A curriculum without the table.
    #[error(
        "{name} is a curriculum and no experiment: give it a table [experiment] with at least `title` and `world`"
    )]
    NoExperiment {
        /// The curriculum.
        name: String,
    },
}

/// A repeatable run, and what it is judged by.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Design {
    /// The curriculum's own name.
    pub(crate) name: String,
    /// The curriculum as a daemon is told it: a built-in name or a file.
    pub(crate) curriculum: String,
    /// What it is about, for people.
    pub(crate) title: String,
    /// The body's world: a built-in name or a file.
    pub(crate) world: String,
    /// The body.
    pub(crate) body: BodyKind,
    /// What was learnt before: the run goes on from the memory of that one.
    pub(crate) after: Option<Earlier>,
    /// How long a run takes, about, on two cores. Decides the order in which several are run.
    pub(crate) seconds: u32,
    /// What is put before the robot, for people: `blue block`.
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
    pub(crate) peaks: Vec<Peak>,
    /// What the map of the visual fields shows.
    pub(crate) map: Option<FieldMap>,
    /// What is read off a run beside the schemas and placements.
    pub(crate) measures: Vec<Measure>,
    /// What the run as it stands is called beside its variants.
    pub(crate) base: String,
    /// The same run with something changed.
    pub(crate) variants: Vec<Variant>,
    /// The same run with one of the curriculum's values changed, again and again.
    pub(crate) sweep: Option<Sweep>,
    /// Its stages, in order.
    pub(crate) stages: Vec<String>,
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
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Earlier {
    /// Its curriculum: a built-in name or a file.
    pub(crate) curriculum: String,
    /// Its body.
    pub(crate) body: BodyKind,
}

/// What the paper reports of a run.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
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

/// What the map of the visual fields shows, in the names that the body declares.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
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
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Measure {
    /// What it is, for people.
    pub(crate) name: String,
    /// How it is read off.
    pub(crate) of: Quantity,
    /// The stages it is about; all that only measure, when none is named.
    pub(crate) stages: Vec<String>,
    /// For [`Quantity::Precision`]: the stages in which the response is wrong.
    pub(crate) against: Vec<String>,
    /// For [`Quantity::Schemas`]: a pre-condition that counts, as it prints.
    pub(crate) pre: Option<String>,
    /// For [`Quantity::Schemas`]: a post-condition that counts.
    pub(crate) post: Option<String>,
    /// For [`Quantity::Schemas`]: a post-condition of those that do not count.
    pub(crate) except_post: Option<String>,
    /// What the paper says of it.
    pub(crate) published: Option<String>,
    /// Why ours differs, where it does.
    pub(crate) why: Option<String>,
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
    /// The 99th percentile of the time of a step, in µs.
    StepUsP99,
}

/// The same run with something changed.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Variant {
    /// What it is called.
    pub(crate) name: String,
    /// Settings for the daemon: `learner.PARAMETER=VALUE`, `values.NAME=NUMBER`.
    pub(crate) settings: Vec<String>,
    /// Another curriculum, when it is that which is changed.
    pub(crate) curriculum: Option<String>,
    /// Another world.
    pub(crate) world: Option<String>,
    /// Noise of the body, by name.
    pub(crate) noise: Vec<(String, f64)>,
}

/// The same run with one of the curriculum's values changed.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sweep {
    /// The value's name.
    pub(crate) name: String,
    /// What it is set to.
    pub(crate) values: Vec<f64>,
}

/// The experiments that come with the daemon, the quickest first.
///
/// # Errors
/// Never, as long as the built-in curricula are sound, which a test sees to.
pub(crate) fn designs() -> Result<Vec<Design>, DesignError> {
    let mut all = Vec::new();
    for (name, _) in BUILT_IN {
        match design(name) {
            Ok(design) => all.push(design),
            Err(DesignError::NoExperiment { .. }) => (),
            Err(error) => return Err(error),
        }
    }
    all.sort_by_key(|design| design.seconds);
    Ok(all)
}

/// The experiment that the curriculum `name` (built in, or a file) is.
///
/// # Errors
/// When there is no such curriculum, it is no experiment, or what is wrong in its table and where.
pub(crate) fn design(name: &str) -> Result<Design, DesignError> {
    let (source_name, text) = named(name)?;
    let source = Source::new(&source_name, &text);
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
        return Err(DesignError::NoExperiment { name: name.to_owned() });
    };
    let design = checked(name, &file, written, &beside).map_err(|mistake| source.wrong(mistake))?;
    if let (Some(earlier), Some(written)) = (&design.after, &written.get_ref().after) {
        lesson(&earlier.curriculum, Parameters::default(), &[])
            .map_err(|error| source.wrong(Mistake::new(written.span(), error.to_string())))?;
    }
    for (variant, written) in design.variants.iter().zip(&written.get_ref().variant) {
        let curriculum = variant.curriculum.as_deref().unwrap_or(name);
        lesson(curriculum, Parameters::default(), &variant.settings)
            .map_err(|error| source.wrong(Mistake::new(written.span(), error.to_string())))?;
    }
    Ok(design)
}

#[cfg(test)]
mod tests;
