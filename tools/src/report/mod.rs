//! The report of some runs: one page to look at, which needs nothing beside it, and the raw figures.

pub(crate) mod comparison;
mod excitation;
mod field_map;
pub(crate) mod figures;
mod growth;
mod page;
mod plot;
mod provenance;
mod raw;
mod scale;
mod section;
mod stages;
mod sweep;
mod table;
mod timing;

use std::fs;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use pschema_process::{Occupied, OutputFile, no_directory};

use crate::design::Design;
use crate::failure::Failure;

pub(crate) use provenance::Provenance;
pub(crate) use section::{Group, Section};

/// The page's file.
const PAGE: &str = "index.html";

/// The raw figures of all designs, beside those of each design.
const RUNS: &str = "runs.jsonl";
const COMPARISON: &str = "comparison.csv";

/// Sees to it that the report of these designs can be written into `folder`.
pub(crate) fn prepare<'a>(
    folder: &Path,
    designs: impl IntoIterator<Item = &'a Design>,
    occupied: Occupied,
) -> Result<(), Failure> {
    create(folder)?;
    let of_designs = designs.into_iter().flat_map(|design| [steps_name(design), trials_name(design)]);
    for name in [PAGE, RUNS, COMPARISON].map(str::to_owned).into_iter().chain(of_designs) {
        // What was there before stays until there is something better.
        OutputFile::prepare(&folder.join(name), occupied, &Arc::default())?;
    }
    Ok(())
}

fn create(folder: &Path) -> Result<(), Failure> {
    let failed =
        |error: std::io::Error| Failure::Failed(format!("cannot create {}: {error}", folder.display()));
    fs::create_dir_all(folder).map_err(|error| failed(no_directory(folder, error)))
}

fn steps_name(design: &Design) -> String {
    format!("{}.steps.csv", file_name(&design.name))
}

fn trials_name(design: &Design) -> String {
    format!("{}.trials.csv", file_name(&design.name))
}

/// Writes the report into `folder`, over what is there: whether that may be was found out by [`prepare`]. Says where its page is.
pub(crate) fn write(
    folder: &Path,
    sections: &[Section<'_>],
    provenance: &Provenance,
) -> Result<PathBuf, Failure> {
    create(folder)?;
    for section in sections {
        save(&folder.join(steps_name(section.design)), |to| raw::steps(to, section))?;
        save(&folder.join(trials_name(section.design)), |to| raw::trials(to, section))?;
    }
    save(&folder.join(RUNS), |to| raw::runs_lines(to, sections))?;
    save(&folder.join(COMPARISON), |to| raw::comparison(to, sections))?;
    let page = folder.join(PAGE);
    save(&page, |to| to.write_all(page::page(sections, provenance).as_bytes()))?;
    Ok(page)
}

fn save(path: &Path, fill: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> Result<(), Failure> {
    let failed = |error: std::io::Error| Failure::Failed(format!("cannot write {}: {error}", path.display()));
    let mut file = BufWriter::new(OutputFile::prepare(path, Occupied::Replaced, &Arc::default())?);
    fill(&mut file).map_err(failed)?;
    Ok(file.into_inner().map_err(|error| failed(error.into_error()))?.finish()?)
}

/// A curriculum's name as part of a file's name, whatever is in it.
fn file_name(name: &str) -> String {
    let sound = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
    let name: String = name.chars().take(64).map(|c| if sound(c) { c } else { '_' }).collect();
    if name.is_empty() { "experiment".to_owned() } else { name }
}

#[cfg(test)]
mod tests;
