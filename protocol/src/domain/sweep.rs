//! Removing an epoch's files, and what is left of shared memory.

use std::fs;
use std::path::Path;

use super::error::io;
use super::shared_memory::{names, shared_memory_files};
use super::{DomainError, DomainRecord, record};

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
