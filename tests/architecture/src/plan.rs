//! What `ARCHITECTURE.md` says about the house: which crate may use which, where crates of others are named, and the storeys
//! of the larger crates. The page is the only place where this is written down.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

/// The plan of the house.
#[derive(Debug, PartialEq, Eq)]
pub struct Plan {
    /// For each crate of the workspace, the crates of the workspace that it is built on.
    pub crates: BTreeMap<String, BTreeSet<String>>,
    /// For some crates of others, the files and folders in which they may be named.
    pub named_only_in: BTreeMap<String, Vec<PathBuf>>,
    /// For each crate that has storeys, by its source folder, the storeys from the top down.
    pub storeys: BTreeMap<PathBuf, Vec<Storey>>,
}

/// One storey of a crate: its files import from this storey and from those below it.
#[derive(Debug, PartialEq, Eq)]
pub struct Storey {
    /// Its name in the plan.
    pub name: String,
    /// Its files, and folders that are in it with all that they hold.
    pub rooms: Vec<PathBuf>,
}

impl Plan {
    /// Reads the page.
    ///
    /// # Panics
    /// When a table or the block of storeys is missing, or can't be read.
    pub fn read(page: &str) -> Self {
        let crates = table(page, "| crate |").map(|(cells, line)| {
            let [name, built_on, ..] = &cells[..] else {
                panic!("the map's line {line:?} has no second column")
            };
            let name =
                quoted(name).next().unwrap_or_else(|| panic!("the map's line {line:?} names no crate"));
            (name.to_owned(), quoted(built_on).map(|short| format!("pschema-{short}")).collect())
        });
        let named_only_in = table(page, "| crate of others |").map(|(cells, line)| {
            let [name, places, ..] = &cells[..] else { panic!("line {line:?} has no second column") };
            let name = quoted(name).next().unwrap_or_else(|| panic!("line {line:?} names no crate"));
            (name.to_owned(), quoted(places).map(PathBuf::from).collect())
        });
        Self { crates: crates.collect(), named_only_in: named_only_in.collect(), storeys: storeys(page) }
    }
}

/// The rows of the table whose heading begins so, each as its cells and as it stands on the page.
fn table<'a>(page: &'a str, heading: &str) -> impl Iterator<Item = (Vec<&'a str>, &'a str)> {
    let mut lines = page.lines().skip_while(move |line| !line.starts_with(heading));
    assert!(lines.next().is_some(), "ARCHITECTURE.md has no table that begins with {heading:?}");
    let rows = lines.skip(1).take_while(|line| line.starts_with('|'));
    rows.map(|line| (line.trim_matches('|').split('|').map(str::trim).collect(), line))
}

/// What stands between backticks.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

/// The block of storeys: a line for each crate, and under it, indented, a line for each storey with its rooms.
fn storeys(page: &str) -> BTreeMap<PathBuf, Vec<Storey>> {
    let (_, block) = page.split_once("```storeys\n").expect("ARCHITECTURE.md has no block of storeys");
    let (block, _) = block.split_once("```").expect("ARCHITECTURE.md does not close its block of storeys");
    let mut storeys: BTreeMap<PathBuf, Vec<Storey>> = BTreeMap::new();
    let mut folder = PathBuf::new();
    for line in block.lines().filter(|line| !line.trim().is_empty()) {
        let mut words = line.split_whitespace();
        let first = words.next().unwrap_or_default();
        if line.starts_with(' ') {
            let rooms = words.map(|room| folder.join(room)).collect();
            storeys.entry(folder.clone()).or_default().push(Storey { name: first.to_owned(), rooms });
        } else {
            folder = PathBuf::from(first);
        }
    }
    storeys
}
