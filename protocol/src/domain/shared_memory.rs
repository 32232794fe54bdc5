//! The files of epochs in shared memory, and how much of it is left.

use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use super::error::io;
use super::{DomainError, record};

/// Where POSIX shared memory lives.
pub(super) const SHARED_MEMORY: &str = "/dev/shm";

/// The shared memory that a daemon with all its bodies and tools reserves, generously rounded up, in bytes.
pub const SHARED_MEMORY_NEEDED: u64 = 40 * 1024 * 1024;

/// The shared memory that a body or a tool needs for itself, rounded up, in bytes.
pub(crate) const PEER_SHARED_MEMORY_NEEDED: u64 = 3 * 1024 * 1024;

/// Makes sure that `needed` bytes of shared memory are free. iceoryx2 writes to a file that it makes before we can reserve its
/// pages, and a process that writes where there is no memory is killed.
pub(crate) fn require_shared_memory(needed: u64) -> Result<(), DomainError> {
    let available = shared_memory_available()?;
    if available < needed { Err(DomainError::SharedMemory { available, needed }) } else { Ok(()) }
}

/// The names of the files and directories in a directory, as far as they are text.
pub(super) fn names(directory: &Path) -> Result<impl Iterator<Item = String> + use<>, DomainError> {
    let entries = fs::read_dir(directory).map_err(io("list", directory))?;
    Ok(entries.flatten().filter_map(|entry| entry.file_name().into_string().ok()))
}

/// This user's files in shared memory whose names begin with an epoch's prefix. Other users may make files there too, also under
/// a prefix that they see; those are none of the epoch's, and can't be removed.
pub(crate) fn shared_memory_files(prefix: &str) -> Result<Vec<PathBuf>, DomainError> {
    // An empty prefix, or one of another program, would name other people's files.
    if !record::is_prefix(prefix) {
        return Ok(Vec::new());
    }
    let directory = Path::new(SHARED_MEMORY);
    let user = rustix::process::geteuid().as_raw();
    let named = names(directory)?.filter(|name| name.starts_with(prefix)).map(|name| directory.join(name));
    Ok(named.filter(|path| fs::symlink_metadata(path).is_ok_and(|found| found.uid() == user)).collect())
}

/// How many bytes of shared memory this user can still take.
pub(super) fn shared_memory_available() -> Result<u64, DomainError> {
    let space = rustix::fs::statvfs(SHARED_MEMORY);
    let space = space.map_err(|error| io("examine", Path::new(SHARED_MEMORY))(error.into()))?;
    Ok(space.f_bavail.saturating_mul(space.f_frsize))
}
