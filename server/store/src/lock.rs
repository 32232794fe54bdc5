//! The lock of a data directory: one daemon has it at a time.

use std::fs::{self, File, OpenOptions, Permissions, TryLockError};
use std::io::{Read, Seek, SeekFrom, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::Path;

use pschema_process::Anchor;

use crate::error::StoreError;

/// The name of the lock file.
pub(crate) const FILE: &str = "LOCK";

/// The mode of the lock's file.
const OWNERS_ALONE: u32 = 0o600;

/// Takes the lock of `directory` for the learner `name`: the open file, which has the lock, and its place, for another process can
/// take a lock of its own when the file is removed. The kernel lets the lock go when the file is closed, and so when the process
/// ends, however it ends.
pub(crate) fn take(directory: &Path, name: &str) -> Result<(File, Anchor), StoreError> {
    let path = directory.join(FILE);
    let disk = |what| StoreError::disk(what, path.display().to_string());
    let mut options = OpenOptions::new();
    // Whoever can open the file can hold its lock, and would keep every daemon away.
    options.read(true).write(true).create(true).truncate(false).mode(OWNERS_ALONE);
    let mut file = options.open(&path).map_err(disk("open"))?;
    match file.try_lock() {
        Ok(()) => (),
        Err(TryLockError::WouldBlock) => {
            let holder = holder(&mut file);
            return Err(StoreError::Locked { path: directory.display().to_string(), holder });
        }
        Err(TryLockError::Error(error)) => return Err(disk("lock")(error)),
    }
    if file.metadata().is_ok_and(|found| found.mode() & 0o777 != OWNERS_ALONE) {
        // Made by an older daemon. Where it belongs to another user it stays as that user wants it.
        file.set_permissions(Permissions::from_mode(OWNERS_ALONE)).ok();
    }
    let holder = format!("learner {name}, process {}\n", std::process::id());
    file.set_len(0).map_err(disk("write"))?;
    file.seek(SeekFrom::Start(0)).map_err(disk("write"))?;
    file.write_all(holder.as_bytes()).map_err(disk("write"))?;
    let anchor = Anchor::of(&file, &path).map_err(disk("examine"))?;
    Ok((file, anchor))
}

/// The process that holds the lock, as far as it can be known: as it said itself in the file, unless the kernel names another
/// process, which has said nothing.
fn holder(file: &mut File) -> String {
    let mut said = String::new();
    // The holder's name helps; without it the refusal is as good.
    let read = Read::by_ref(file).take(256).read_to_string(&mut said);
    let said = read.ok().map(|_| said.trim().to_owned()).filter(|said| !said.is_empty());
    let locking = file.metadata().ok().and_then(|found| locking_process(found.ino()));
    match (said, locking) {
        (said, Some(process)) if !names(said.as_deref(), process) => described(process),
        (Some(said), _) => said,
        (None, _) => "another process".to_owned(),
    }
}

fn names(said: Option<&str>, process: u32) -> bool {
    said.is_some_and(|said| said.ends_with(&format!("process {process}")))
}

/// The process that has locked the file of this inode. None where the kernel does not tell, or it is one of another container.
fn locking_process(inode: u64) -> Option<u32> {
    let locks = fs::read_to_string("/proc/locks").ok()?;
    // 1: FLOCK  ADVISORY  WRITE 4711 08:01:1234 0 EOF
    locks.lines().find_map(|line| {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [_, "FLOCK", _, _, process, file, ..] = words.as_slice() else { return None };
        let (_, of_file) = file.rsplit_once(':')?;
        let process = process.parse().ok().filter(|process| *process != 0);
        process.filter(|_| of_file.parse() == Ok(inode))
    })
}

fn described(process: u32) -> String {
    let place = Path::new("/proc").join(process.to_string());
    let name = fs::read_to_string(place.join("comm")).unwrap_or_default();
    let name = if name.is_empty() { String::new() } else { format!(" ({})", name.trim()) };
    let user =
        fs::metadata(&place).map_or_else(|_| String::new(), |found| format!(" of user {}", found.uid()));
    format!("process {process}{name}{user}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lock_is_its_owners_alone_whatever_it_was() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("LOCK");
        let mode = || path.metadata().unwrap().mode() & 0o777;
        drop(take(directory.path(), "one").unwrap());
        assert_eq!(mode(), OWNERS_ALONE);
        fs::set_permissions(&path, Permissions::from_mode(0o666)).unwrap();
        drop(take(directory.path(), "one").unwrap());
        assert_eq!(mode(), OWNERS_ALONE);
    }

    #[test]
    fn who_holds_the_lock_is_told() {
        let directory = tempfile::tempdir().unwrap();
        let refused = || take(directory.path(), "late").unwrap_err().to_string();
        let held = take(directory.path(), "early").unwrap();
        assert!(refused().contains(&format!("in use by learner early, process {}:", std::process::id())));
        drop(held);
        // Another program holds it, and what the file says is of a daemon that ended.
        let path = directory.path().join("LOCK");
        fs::write(&path, "learner early, process 1\n").unwrap();
        let file = File::open(&path).unwrap();
        file.lock().unwrap();
        match locking_process(file.metadata().unwrap().ino()) {
            Some(process) => {
                assert_eq!(process, std::process::id());
                let told = refused();
                assert!(told.contains(&format!("in use by process {process} (")), "{told}");
                assert!(told.contains(" of user "), "{told}");
            }
            // A kernel that does not tell.
            None => assert!(refused().contains("in use by learner early, process 1:")),
        }
    }
}
