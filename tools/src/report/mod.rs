//! The report of some runs: one page to look at, which needs nothing beside it, and the raw figures.

mod excitation;
mod field_map;
mod growth;
mod page;
mod plot;
mod provenance;
mod raw;
mod scale;
mod stages;
mod sweep;
mod timing;

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use pschema_server::config;

use crate::design::Design;
use crate::failure::Failure;
use crate::render::comparison::ConditionRuns;
use crate::run::{Condition, Outcome, Results};

pub(crate) use provenance::{Provenance, time};

/// The page's file.
const PAGE: &str = "index.html";

/// One experiment with its runs.
#[derive(Clone, Debug)]
pub(crate) struct Section<'a> {
    /// What the experiment's file says.
    pub(crate) design: &'a Design,
    /// Its runs, by condition.
    pub(crate) groups: Vec<Group<'a>>,
}

/// Runs under one condition, with different seeds.
#[derive(Clone, Debug)]
pub(crate) struct Group<'a> {
    /// The condition.
    pub(crate) condition: &'a Condition,
    /// The runs.
    pub(crate) outcomes: &'a [Outcome],
    /// Their figures.
    pub(crate) figures: Vec<Results>,
    /// The learner's parameters, and the body's noise, as they were.
    pub(crate) parameters: String,
}

impl<'a> Group<'a> {
    /// The runs under a condition.
    pub(crate) fn new(condition: &'a Condition, outcomes: &'a [Outcome]) -> Self {
        let figures = outcomes.iter().map(|outcome| outcome.figures.clone()).collect();
        Self { condition, outcomes, figures, parameters: parameters(condition) }
    }
}

fn parameters(condition: &Condition) -> String {
    let defaults = config::parameters(None);
    let lesson = defaults.and_then(|d| config::lesson(&condition.curriculum, d, &condition.settings));
    let learner = lesson.map_or_else(|error| error.to_string(), |(_, parameters)| format!("{parameters:#?}"));
    let noise = condition.noise.iter().map(|(name, value)| format!("\nnoise of the body: {name} = {value}"));
    learner + &noise.collect::<String>()
}

impl Section<'_> {
    /// The figures of all runs.
    pub(crate) fn figures(&self) -> impl Iterator<Item = &Results> {
        self.groups.iter().flat_map(|group| &group.figures)
    }

    /// The runs by condition.
    pub(crate) fn runs(&self) -> impl Iterator<Item = ConditionRuns<'_>> {
        self.groups.iter().map(|group| ConditionRuns {
            design: self.design,
            condition: group.condition.name.as_deref(),
            figures: &group.figures,
        })
    }

    /// The runs of the experiment as it stands.
    pub(crate) fn base(&self) -> Option<ConditionRuns<'_>> {
        self.runs().next()
    }
}

/// Sees to it that a report can be written into `folder`.
pub(crate) fn prepare(folder: &Path) -> Result<(), Failure> {
    fs::create_dir_all(folder).map_err(|error| cannot("create", folder, &error))?;
    let page = folder.join(PAGE);
    // What was there before stays until there is something better.
    let opened = fs::OpenOptions::new().append(true).create(true).open(&page);
    opened.map(drop).map_err(|error| cannot("write", &page, &error))
}

/// Writes the report into `folder`, and says where its page is.
pub(crate) fn write(folder: &Path, sections: &[Section<'_>], facts: &Provenance) -> Result<PathBuf, Failure> {
    prepare(folder)?;
    for section in sections {
        let name = file_name(&section.design.name);
        save(&folder.join(format!("{name}.steps.csv")), |to| raw::steps(to, section))?;
        save(&folder.join(format!("{name}.trials.csv")), |to| raw::trials(to, section))?;
    }
    save(&folder.join("runs.jsonl"), |to| raw::runs_lines(to, sections))?;
    save(&folder.join("comparison.csv"), |to| raw::comparison(to, sections))?;
    let page = folder.join(PAGE);
    save(&page, |to| to.write_all(page::page(sections, facts).as_bytes()))?;
    Ok(page)
}

fn save(path: &Path, fill: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> Result<(), Failure> {
    let failed = |error: std::io::Error| cannot("write", path, &error);
    let mut file = std::io::BufWriter::new(fs::File::create(path).map_err(failed)?);
    fill(&mut file).and_then(|()| file.flush()).map_err(failed)
}

fn cannot(what: &str, path: &Path, error: &std::io::Error) -> Failure {
    Failure::Failed(format!("cannot {what} {}: {error}", path.display()))
}

/// A curriculum's name as part of a file's name, whatever is in it.
fn file_name(name: &str) -> String {
    let sound = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
    let name: String = name.chars().take(64).map(|c| if sound(c) { c } else { '_' }).collect();
    if name.is_empty() { "experiment".to_owned() } else { name }
}

#[cfg(test)]
mod tests;
