//! The design of an experiment: the table `[experiment]` of a curriculum. It says in which world the curriculum is run, what
//! the paper reports of the run, what is measured, and with what it is compared. Neither the daemon nor the learner sees any
//! of this.

mod check;
mod place;
mod table;

use std::collections::BTreeMap;
use std::path::Path;

use pschema_server::config::{BUILT_IN, ConfigError, Source, lesson, named};
use serde::Deserialize;

use check::check;
pub(crate) use table::*;

/// Why there is no design to be had of a curriculum.
#[derive(Debug, thiserror::Error)]
pub(crate) enum DesignError {
    /// The curriculum, or its table, is wrong or not there.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// A pipe, which can be read once only.
    #[error("{name} can't be read again and again, as by each process of each run: write it to a file")]
    Pipe {
        /// Its name.
        name: String,
    },
    /// A curriculum without the table.
    #[error(
        "{name} is a curriculum and no experiment: give it a table [experiment] with at least `title` and `world`"
    )]
    NoExperiment {
        /// The curriculum.
        name: String,
    },
}

/// A curriculum's file, as far as a design goes by it. The rest of it is the business of the daemon that runs it.
#[derive(Deserialize)]
struct CurriculumFile {
    name: String,
    #[serde(default)]
    stage: Vec<StageName>,
    #[serde(default)]
    values: BTreeMap<String, f64>,
    experiment: Option<Design>,
}

#[derive(Deserialize)]
struct StageName {
    name: String,
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
    let is_built_in = BUILT_IN.iter().any(|(known, _)| *known == name);
    if !is_built_in {
        read_again(name)?;
    }
    let (source_name, text) = named(name)?;
    let source = Source::new(&source_name, &text);
    // A mistake elsewhere in the file should be said now, not later.
    lesson(name, Default::default(), &[])?;
    let file: CurriculumFile = source.parse()?;
    let mut design = file.experiment.ok_or_else(|| DesignError::NoExperiment { name: name.to_owned() })?;
    (design.name, design.curriculum) = (file.name, name.to_owned());
    design.stages = file.stage.into_iter().map(|stage| stage.name).collect();
    // A world or a curriculum that a file names is looked for beside that file.
    if let Some(folder) = Path::new(name).parent().filter(|_| !is_built_in) {
        let earlier = design.after.iter_mut().map(|earlier| &mut earlier.curriculum);
        let variants = design.variants.iter_mut().flat_map(|v| v.curriculum.iter_mut().chain(&mut v.world));
        let named = [&mut design.world].into_iter().chain(earlier).chain(variants);
        for file in named.filter(|name| name.ends_with(".toml")) {
            *file = folder.join(&*file).display().to_string();
        }
    }
    check(&design, &file.values, &text).map_err(|mistake| source.wrong(mistake))?;
    Ok(design)
}

/// An error when `name`, which is a built-in text or a file, is stdin or a pipe: what is read once is gone.
pub(crate) fn read_again(name: &str) -> Result<(), DesignError> {
    let path = Path::new(name);
    if name == "-" || path.exists() && !path.is_file() {
        return Err(DesignError::Pipe { name: name.to_owned() });
    }
    Ok(())
}

#[cfg(test)]
mod tests;
