//! Removing an epoch's files, and what is left of shared memory.

use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use super::{DomainError, DomainRecord, io, record};

/// Where POSIX shared memory lives.
pub(super) const SHARED_MEMORY: &str = "/dev/shm";

/// Removes all of an epoch: its directory and everything in shared memory under its prefix. Processes
/// that still map the latter keep their mappings.
pub(super) fn epoch(root: &Path, prefix: &str) -> Result<(), DomainError> {
    for path in shared_memory_files(prefix)? {
        match fs::remove_file(&path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(io("remove", &path)(error));
            }
            _ => {}
        }
    }
    remove_directory(root)
}

/// Removes epochs that no record in `runtime` names: a peer that was starting while its daemon was
/// replaced can bring back a part of one that was swept.
pub(super) fn orphans(runtime: &Path) -> Result<(), DomainError> {
    // Roots before records: the record of a root that is there now was written before it.
    let roots: Vec<_> =
        names(runtime)?.filter_map(|name| name.strip_prefix('.').map(str::to_owned)).collect();
    let records = names(runtime)?.map(|name| DomainRecord::read(&runtime.join(name).join("domain")));
    let named: Vec<_> = records.flatten().map(|record| record.prefix).collect();
    for prefix in roots.iter().filter(|root| record::is_prefix(root) && !named.contains(root)) {
        tracing::debug!(prefix, "removing what is left of an epoch");
        epoch(&runtime.join(format!(".{prefix}")), prefix)?;
    }
    Ok(())
}

/// The names of what is in a directory, those that are text.
pub(super) fn names(directory: &Path) -> Result<impl Iterator<Item = String> + use<>, DomainError> {
    let entries = fs::read_dir(directory).map_err(io("list", directory))?;
    Ok(entries.flatten().filter_map(|entry| entry.file_name().into_string().ok()))
}

/// A peer that is just leaving removes files of its own, or adds one, while the directory is removed; so
/// more than one try.
fn remove_directory(root: &Path) -> Result<(), DomainError> {
    let mut result = Ok(());
    for _ in 0..5 {
        result = fs::remove_dir_all(root);
        match &result {
            Ok(()) => return Ok(()),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound && !root.exists() => return Ok(()),
            Err(_) => {}
        }
    }
    result.map_err(io("remove", root))
}

/// This user's files in shared memory whose names begin with an epoch's prefix. Everyone may make files there, also
/// under a prefix that they see: what others made is none of the epoch's, and can't be removed.
pub(crate) fn shared_memory_files(prefix: &str) -> Result<Vec<PathBuf>, DomainError> {
    // An empty or foreign prefix would name other people's files.
    if !record::is_prefix(prefix) {
        return Ok(Vec::new());
    }
    let directory = Path::new(SHARED_MEMORY);
    let user = rustix::process::geteuid().as_raw();
    let named = names(directory)?.filter(|name| name.starts_with(prefix)).map(|name| directory.join(name));
    Ok(named.filter(|path| fs::symlink_metadata(path).is_ok_and(|found| found.uid() == user)).collect())
}

/// Bytes of shared memory this user can still take.
pub(super) fn shared_memory_available() -> Result<u64, DomainError> {
    let space = rustix::fs::statvfs(SHARED_MEMORY);
    let space = space.map_err(|error| io("examine", Path::new(SHARED_MEMORY))(error.into()))?;
    Ok(space.f_bavail.saturating_mul(space.f_frsize))
}
