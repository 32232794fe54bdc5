//! Leftovers of daemons on the machine: files in shared memory, directories, other processes.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The epochs of daemons seen in a runtime directory, to look later whether anything of them is left.
#[derive(Debug)]
pub struct Leftovers {
    runtime: PathBuf,
    prefixes: BTreeSet<String>,
}

impl Leftovers {
    /// The leftovers of the daemons in `runtime`.
    #[must_use]
    pub fn of(runtime: &Path) -> Self {
        Self { runtime: runtime.to_owned(), prefixes: BTreeSet::new() }
    }

    /// Notes the epochs that are there now. Returns how many epochs were noted so far.
    pub fn note(&mut self) -> usize {
        self.prefixes.extend(epochs(&self.runtime));
        self.prefixes.len()
    }

    /// The names of all files that are left of the noted epochs, and of every other epoch in the directory.
    #[must_use]
    pub fn left(&self) -> Vec<String> {
        let of_ours = |name: &String| self.prefixes.iter().any(|prefix| name.starts_with(prefix));
        let shared = names(Path::new("/dev/shm")).into_iter().filter(of_ours);
        shared.chain(epochs(&self.runtime)).collect()
    }
}

/// Prefixes of the epochs whose directories are in `runtime`.
fn epochs(runtime: &Path) -> Vec<String> {
    names(runtime)
        .iter()
        .filter_map(|name| name.strip_prefix('.'))
        .filter(|name| name.starts_with("ps"))
        .map(str::to_owned)
        .collect()
}

/// The names of the files in a directory; none when there is no such directory.
fn names(directory: &Path) -> Vec<String> {
    let entries = fs::read_dir(directory).into_iter().flatten().flatten();
    entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect()
}

/// The runtime directory that the `pschema demo` with this process id made for itself, once the directory is there.
#[must_use]
pub fn demo_directory(pid: u32) -> Option<PathBuf> {
    let own = names(Path::new("/tmp")).into_iter().filter(|name| name.starts_with("pschema-"));
    own.map(|name| Path::new("/tmp").join(name)).find(|path| path.join(format!("demo-{pid}")).is_dir())
}

/// Live processes whose command line has `word`.
#[must_use]
pub fn processes_with(word: &str) -> Vec<u32> {
    let numbers = names(Path::new("/proc")).into_iter().filter_map(|name| name.parse::<u32>().ok());
    let has = |pid: &u32| {
        // A process that ended and was not waited for has an empty command line.
        let line = fs::read(format!("/proc/{pid}/cmdline")).unwrap_or_default();
        line.split(|byte| *byte == 0).any(|argument| argument == word.as_bytes())
    };
    numbers.filter(has).collect()
}
