//! Changes of files that are durable when they are done, with an error that names the file.

use crate::error::StoreError;
use crate::storage::Storage;

/// Makes those of `directories` that are not there.
pub(crate) fn create_all(storage: &dyn Storage, directories: &[&str]) -> Result<(), StoreError> {
    directories
        .iter()
        .try_for_each(|name| storage.directory(name).map_err(StoreError::disk("create", storage.path(name))))
}

/// Makes durable which files are in each of `directories`.
pub(crate) fn sync_all(storage: &dyn Storage, directories: &[&str]) -> Result<(), StoreError> {
    directories.iter().try_for_each(|name| {
        storage.sync_directory(name).map_err(StoreError::disk("make durable", storage.path(name)))
    })
}

/// Puts a file with just these bytes in place of any file `name`, and makes that durable: the bytes are written to the file
/// `temporary` first, which is in the same directory, so that `name` is never half written.
pub(crate) fn replace(
    storage: &dyn Storage,
    name: &str,
    temporary: &str,
    bytes: &[u8],
) -> Result<(), StoreError> {
    let disk = |what| StoreError::disk(what, storage.path(temporary));
    let mut file = storage.create(temporary).map_err(disk("create"))?;
    file.write_at(bytes, 0).map_err(disk("write"))?;
    file.sync().map_err(disk("make durable"))?;
    storage.rename(temporary, name).map_err(disk("rename"))?;
    let directory = name.rsplit_once('/').map_or("", |(directory, _)| directory);
    storage.sync_directory(directory).map_err(disk("make durable"))
}
