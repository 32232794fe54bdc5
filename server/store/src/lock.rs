//! The lock of a data directory: one daemon has it at a time.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::Path;

use pschema_process::Anchor;

use crate::error::StoreError;

/// The name of the lock file.
pub(crate) const FILE: &str = "LOCK";

/// Takes the lock of `directory` for the learner `name`: the open file, which has the lock, and its place, for another process can
/// take a lock of its own when the file is removed. The kernel lets the lock go when the file is closed, and so when the process
/// ends, however it ends.
pub(crate) fn take(directory: &Path, name: &str) -> Result<(File, Anchor), StoreError> {
    let path = directory.join(FILE);
    let disk = |what| StoreError::disk(what, path.display().to_string());
    let mut options = OpenOptions::new();
    let mut file =
        options.read(true).write(true).create(true).truncate(false).open(&path).map_err(disk("open"))?;
    match file.try_lock() {
        Ok(()) => (),
        Err(TryLockError::WouldBlock) => {
            let mut holder = String::new();
            // The holder's name helps; without it the refusal is as good.
            let read = Read::by_ref(&mut file).take(256).read_to_string(&mut holder);
            let known = read.is_ok_and(|length| length > 0);
            let holder = if known { holder.trim().to_owned() } else { "another process".to_owned() };
            return Err(StoreError::Locked { path: directory.display().to_string(), holder });
        }
        Err(TryLockError::Error(error)) => return Err(disk("lock")(error)),
    }
    let holder = format!("learner {name}, process {}\n", std::process::id());
    file.set_len(0).map_err(disk("write"))?;
    file.seek(SeekFrom::Start(0)).map_err(disk("write"))?;
    file.write_all(holder.as_bytes()).map_err(disk("write"))?;
    let anchor = Anchor::of(&file, &path).map_err(disk("examine"))?;
    Ok((file, anchor))
}
