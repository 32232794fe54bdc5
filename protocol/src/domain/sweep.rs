//! Removing the files of epochs.

use std::fs;
use std::path::Path;

use super::error::io;
use super::shared_memory::{names, shared_memory_files};
use super::{DomainError, DomainRecord, record};

/// Removes all of an epoch: its directory, and every file in shared memory under its prefix. A process that still maps such a
/// file keeps its mapping.
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

/// Removes the epochs that no record in `runtime` names: a peer that was starting while its daemon was replaced can bring
/// back a part of an epoch that was swept.
pub(super) fn orphans(runtime: &Path) -> Result<(), DomainError> {
    // Roots are listed before records are read: whoever makes a root has written its record before.
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

/// Removes the root directory of an epoch, with several tries: a peer that is just leaving may remove a file of its own, or add
/// one, in between.
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
