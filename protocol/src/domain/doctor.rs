//! An examination of the machine, and of the files that dead daemons left.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use super::record::is_prefix;
use super::shared_memory::{SHARED_MEMORY, SHARED_MEMORY_NEEDED, names, shared_memory_available};
use super::{DomainError, DomainRecord, LearnerName, Place, RuntimeDir};

/// The files of an epoch whose daemon is dead.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StaleEpoch {
    /// The learner; none if no record names the epoch any more.
    pub learner: Option<String>,
    /// The prefix of its files in shared memory.
    pub prefix: String,
    /// How many files are left in shared memory.
    pub files: usize,
    /// How many bytes they take.
    pub bytes: u64,
}

/// A file or directory that another user could use, or has made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Exposure {
    /// The file or directory.
    pub path: PathBuf,
    /// What is wrong with the file.
    pub problem: String,
    /// What to do about it.
    pub mend: String,
}

/// The state of the machine, as far as a daemon depends on it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MachineState {
    /// Bytes of shared memory free.
    pub shared_memory_available: u64,
    /// Bytes of shared memory a daemon needs.
    pub shared_memory_needed: u64,
    /// Learners that a daemon serves now.
    pub served: Vec<LearnerName>,
    /// The files that dead daemons left. A learner's next daemon removes those of that learner; files of no learner can be
    /// removed by hand from `/dev/shm`.
    pub stale: Vec<StaleEpoch>,
    /// The files that are not closed to other users as they should be.
    pub exposed: Vec<Exposure>,
}

/// Looks at `runtime` and at shared memory, and changes nothing.
///
/// # Errors
/// What the operating system said when either cannot be listed.
pub fn examine(runtime: &RuntimeDir) -> Result<MachineState, DomainError> {
    let mut served = Vec::new();
    let mut stale = Vec::new();
    let mut known = BTreeSet::new();
    let all = by_prefix()?;
    let mut exposed: Vec<_> = open_shared_memory(Path::new(SHARED_MEMORY)).into_iter().collect();
    for learner in learners(runtime)? {
        let place = Place::new(runtime.clone(), learner.clone());
        let record = DomainRecord::read(&place.record_path());
        let own = [place.directory(), place.lock_path(), place.record_path()];
        exposed.extend(own.iter().filter_map(|path| not_private(path)));
        if let Ok(record) = &record {
            exposed.extend(in_shared_memory(&record.prefix)?);
        }
        if let Ok(record) = &record {
            known.insert(record.prefix.clone());
        }
        if place.is_served() {
            served.push(learner);
        } else if let Ok(record) = record {
            stale.push(left(Some(learner.to_string()), &record.prefix, &all));
        }
    }
    let unknown = all.keys().filter(|prefix| !known.contains(*prefix));
    stale.extend(unknown.map(|prefix| left(None, prefix, &all)));
    Ok(MachineState {
        shared_memory_available: shared_memory_available()?,
        shared_memory_needed: SHARED_MEMORY_NEEDED,
        served,
        stale,
        exposed,
    })
}

/// Shared memory in which a user may remove the files of another; none if it is as it should be.
fn open_shared_memory(directory: &Path) -> Option<Exposure> {
    let found = fs::metadata(directory).ok()?;
    let open = found.mode() & 0o022 != 0 && found.mode() & 0o1000 == 0;
    open.then(|| Exposure {
        path: directory.to_owned(),
        problem: format!("others can remove what is yours there (mode {:o})", found.mode() & 0o7777),
        mend: format!("run `sudo chmod 1777 {}`", directory.display()),
    })
}

/// A file or directory that other users can use, or that is another's; none if it is private, or is not there.
fn not_private(path: &Path) -> Option<Exposure> {
    let found = fs::symlink_metadata(path).ok()?;
    let user = rustix::process::geteuid().as_raw();
    let told = |problem: String, mend: String| Some(Exposure { path: path.to_owned(), problem, mend });
    if found.is_symlink() {
        return told("it is a symbolic link".to_owned(), "remove it".to_owned());
    }
    if found.uid() != user {
        return told(
            format!("it belongs to user {}", found.uid()),
            "remove it, as its owner or as root".to_owned(),
        );
    }
    if found.mode() & 0o077 != 0 {
        let mend = format!("run `chmod go= {}`", path.display());
        return told(format!("it is open to others (mode {:o})", found.mode() & 0o777), mend);
    }
    None
}

/// The files under an epoch's prefix that other users can use, or have made.
fn in_shared_memory(prefix: &str) -> Result<Vec<Exposure>, DomainError> {
    let directory = Path::new(SHARED_MEMORY);
    let named = names(directory)?.filter(|name| is_prefix(prefix) && name.starts_with(prefix));
    let exposed = named.filter_map(|name| not_private(&directory.join(name)));
    let user = rustix::process::geteuid().as_raw();
    let told = |mut one: Exposure| {
        let strange = fs::symlink_metadata(&one.path).is_ok_and(|found| found.uid() != user);
        if strange {
            one.mend = "it is of no account to the daemon; ask that user, or remove it as root".to_owned();
        }
        one
    };
    Ok(exposed.map(told).collect())
}

fn learners(runtime: &RuntimeDir) -> Result<Vec<LearnerName>, DomainError> {
    let names = names(runtime.path())?.filter_map(|name| LearnerName::new(&name).ok());
    let mut names: Vec<_> = names.collect();
    names.sort();
    Ok(names)
}

/// The files that an epoch left, looked up among `all` of this user.
fn left(learner: Option<String>, prefix: &str, all: &BTreeMap<String, (usize, u64)>) -> StaleEpoch {
    let (files, bytes) = all.get(prefix).copied().unwrap_or_default();
    StaleEpoch { learner, prefix: prefix.to_owned(), files, bytes }
}

/// For each prefix that looks like an epoch's: how many files of this user there are in shared memory, and their bytes. If no
/// record in this runtime directory names a prefix, a live daemon in another may still use it.
fn by_prefix() -> Result<BTreeMap<String, (usize, u64)>, DomainError> {
    let user = rustix::process::geteuid().as_raw();
    let directory = Path::new(SHARED_MEMORY);
    let mut all = BTreeMap::<String, (usize, u64)>::new();
    for name in names(directory)? {
        let Some(prefix) = name.get(..13).filter(|prefix| is_prefix(prefix)) else { continue };
        let Ok(found) = fs::symlink_metadata(directory.join(&name)) else { continue };
        if found.uid() == user {
            let (files, bytes) = all.entry(prefix.to_owned()).or_default();
            *files += 1;
            *bytes = bytes.saturating_add(found.len());
        }
    }
    Ok(all)
}
