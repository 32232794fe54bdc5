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
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::failure::Failure;

pub(crate) use provenance::Provenance;
pub(crate) use section::{Group, Section};

/// The page's file.
const PAGE: &str = "index.html";

/// Sees to it that a report can be written into `folder`.
pub(crate) fn prepare(folder: &Path) -> Result<(), Failure> {
    fs::create_dir_all(folder).map_err(|error| cannot("create", folder, &error))?;
    let page = folder.join(PAGE);
    // What was there before stays until there is something better.
    let opened = fs::OpenOptions::new().append(true).create(true).open(&page);
    opened.map(drop).map_err(|error| cannot("write", &page, &error))
}

/// Writes the report into `folder`, and says where its page is.
pub(crate) fn write(
    folder: &Path,
    sections: &[Section<'_>],
    provenance: &Provenance,
) -> Result<PathBuf, Failure> {
    prepare(folder)?;
    for section in sections {
        let name = file_name(&section.design.name);
        save(&folder.join(format!("{name}.steps.csv")), |to| raw::steps(to, section))?;
        save(&folder.join(format!("{name}.trials.csv")), |to| raw::trials(to, section))?;
    }
    save(&folder.join("runs.jsonl"), |to| raw::runs_lines(to, sections))?;
    save(&folder.join("comparison.csv"), |to| raw::comparison(to, sections))?;
    let page = folder.join(PAGE);
    save(&page, |to| to.write_all(page::page(sections, provenance).as_bytes()))?;
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
