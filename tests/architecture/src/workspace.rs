//! The crates of this workspace, as cargo and their sources tell them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use serde_json::Value;

use crate::source::{self, Imports};

/// A crate of the workspace.
#[derive(Debug)]
pub struct Member {
    /// Crates of the workspace that it is built on, those of its tests left out.
    pub built_on: BTreeSet<String>,
    /// Every crate that ends up in a program that uses it, those of its tests and of its build left out.
    pub linked: BTreeSet<String>,
    /// What its library and its programs import, one after another.
    pub imports: Vec<Imports>,
}

/// Every crate of the workspace, by its name.
pub fn members() -> &'static BTreeMap<String, Member> {
    static MEMBERS: OnceLock<BTreeMap<String, Member>> = OnceLock::new();
    MEMBERS.get_or_init(read)
}

/// The root of the repository.
pub fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).unwrap_or(here).to_owned()
}

fn read() -> BTreeMap<String, Member> {
    let mut cargo = Command::new(env!("CARGO"));
    // Only what is built here: crates for other systems need not have been fetched.
    let here = format!("{}-unknown-linux-gnu", std::env::consts::ARCH);
    cargo.args(["metadata", "--format-version", "1", "--offline", "--locked", "--filter-platform", &here]);
    cargo.current_dir(root());
    let output = cargo.output().unwrap_or_else(|error| panic!("{cargo:?}: {error}"));
    assert!(output.status.success(), "{cargo:?}: {}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}"));
    let graph = Graph::of(&metadata);
    let packages = list(&metadata["packages"]);
    let ours =
        packages.iter().filter(|package| list(&metadata["workspace_members"]).contains(&package["id"]));
    ours.map(|package| (text(&package["name"]).to_owned(), graph.member(package))).collect()
}

/// Which package is built on which.
struct Graph<'a> {
    names: BTreeMap<&'a str, &'a str>,
    built_on: BTreeMap<&'a str, Vec<&'a str>>,
    ours: BTreeSet<&'a str>,
}

impl<'a> Graph<'a> {
    fn of(metadata: &'a Value) -> Self {
        let packages = list(&metadata["packages"]).iter();
        let names = packages.map(|package| (text(&package["id"]), text(&package["name"]))).collect();
        let is_shipped = |used: &&Value| list(&used["dep_kinds"]).iter().any(|kind| kind["kind"].is_null());
        let built_on = list(&metadata["resolve"]["nodes"]).iter().map(|node| {
            let used = list(&node["deps"]).iter().filter(is_shipped);
            (text(&node["id"]), used.map(|used| text(&used["pkg"])).collect())
        });
        let ours = list(&metadata["workspace_members"]).iter().map(text).collect();
        Self { names, built_on: built_on.collect(), ours }
    }

    fn member(&self, package: &'a Value) -> Member {
        let id = text(&package["id"]);
        let ours = self.built_on[id].iter().filter(|used| self.ours.contains(*used));
        // Those that only a feature brings are declared too.
        let declared = list(&package["dependencies"]).iter().filter(|used| used["kind"].is_null());
        let foreign = declared.map(|used| text(&used["name"]).replace('-', "_")).collect();
        let is_shipped = |target: &&Value| {
            list(&target["kind"]).iter().any(|kind| kind == "lib" || kind == "bin" || kind == "cdylib")
        };
        let roots =
            list(&package["targets"]).iter().filter(is_shipped).map(|target| text(&target["src_path"]));
        Member {
            built_on: ours.map(|used| self.names[used].to_owned()).collect(),
            linked: self.linked(id),
            imports: roots.map(|root| imports(Path::new(root), &foreign)).collect(),
        }
    }

    fn linked(&self, id: &'a str) -> BTreeSet<String> {
        let (mut linked, mut waiting) = (BTreeSet::new(), vec![id]);
        while let Some(next) = waiting.pop() {
            for used in &self.built_on[next] {
                if linked.insert(self.names[used].to_owned()) {
                    waiting.push(used);
                }
            }
        }
        linked
    }
}

/// Reads a crate of the workspace; its files are named from the root of the repository.
fn imports(path: &Path, foreign: &BTreeSet<String>) -> Imports {
    let root = root();
    let path = path.strip_prefix(&root).unwrap_or(path);
    source::read(path, &|file| std::fs::read_to_string(root.join(file)).ok(), foreign)
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}
