//! Reserving shared memory. A segment is a sparse file: if /dev/shm fills up later, writing to a page of it kills the
//! process. When every page is reserved at the start, too little memory is an error with figures instead.

use std::fs::{OpenOptions, Permissions, symlink_metadata};
use std::os::unix::fs::{MetadataExt, PermissionsExt};

use rustix::fs::{FallocateFlags, fallocate};

use super::TransportError;
use crate::domain::{io, shared_memory_files};

/// Reserves the pages of the files of an epoch: those of the port numbered `port`, or all of them.
///
/// # Errors
/// [`TransportError::SharedMemory`] when there are not enough pages.
pub(super) fn reserve(prefix: &str, port: Option<u128>) -> Result<(), TransportError> {
    let port = port.map(|port| port.to_string());
    for path in shared_memory_files(prefix)? {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        if port.as_ref().is_some_and(|port| !name.contains(port.as_str())) {
            continue;
        }
        // A leaving peer has just removed the file: nothing is to be reserved.
        let Ok(file) = OpenOptions::new().read(true).write(true).open(&path) else { continue };
        let Ok(bytes) = file.metadata().map(|found| found.size()) else { continue };
        if bytes == 0 {
            continue;
        }
        fallocate(&file, FallocateFlags::empty(), 0, bytes)
            .map_err(|error| TransportError::SharedMemory { bytes, error: error.into() })?;
    }
    Ok(())
}

/// Closes to other users every file of an epoch that iceoryx2 left open to them. In one of these it counts nodes, and a
/// stranger could set the count back.
///
/// # Errors
/// What the operating system said.
pub(super) fn close_to_others(prefix: &str) -> Result<(), TransportError> {
    for path in shared_memory_files(prefix)? {
        // A leaving peer has just removed the file: it is open to nobody.
        let Ok(found) = symlink_metadata(&path) else { continue };
        if found.is_file() && found.mode() & 0o077 != 0 {
            let mode = found.mode() & 0o700;
            std::fs::set_permissions(&path, Permissions::from_mode(mode))
                .map_err(io("close to others", &path))?;
        }
    }
    Ok(())
}
