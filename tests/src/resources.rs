//! The resources of a process, as the kernel counts them, and the files of a daemon's epoch in shared memory.

use std::fs;
use std::path::Path;

/// Open descriptors of process `pid`.
///
/// # Panics
/// When there is no such process.
#[must_use]
pub fn descriptors(pid: u32) -> usize {
    let open = fs::read_dir(format!("/proc/{pid}/fd"));
    open.unwrap_or_else(|error| panic!("descriptors of {pid}: {error}")).count()
}

/// Resident memory of process `pid` that is its own (not shared memory, not files), in bytes.
///
/// # Panics
/// When there is no such process.
#[must_use]
pub fn own_memory(pid: u32) -> u64 {
    let path = format!("/proc/{pid}/status");
    let status = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    let line = status.lines().find_map(|line| line.strip_prefix("RssAnon:"));
    let kibibytes = line.and_then(|line| line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok());
    kibibytes.unwrap_or_else(|| panic!("{path} has no RssAnon")) * 1024
}

/// The prefix in shared memory of the daemon of `learner` in `runtime`.
///
/// # Panics
/// When no daemon has been there.
#[must_use]
pub fn prefix_of(runtime: &Path, learner: &str) -> String {
    let path = runtime.join(learner).join("domain");
    let record = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path:?}: {error}"));
    let prefix = record.lines().find_map(|line| line.strip_prefix("prefix = "));
    prefix.unwrap_or_else(|| panic!("{record:?} has no prefix")).to_owned()
}

/// Names in shared memory that begin with `prefix`, in order.
///
/// # Panics
/// When shared memory can't be listed.
#[must_use]
pub fn shared_files(prefix: &str) -> Vec<String> {
    let entries = fs::read_dir("/dev/shm").unwrap_or_else(|error| panic!("/dev/shm: {error}"));
    let names = entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned());
    let mut names: Vec<_> = names.filter(|name| name.starts_with(prefix)).collect();
    names.sort();
    names
}
