//! What a `doctor` wants to know of the machine and of what daemons left behind.

use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

use super::record::is_prefix;
use super::{DomainError, LearnerName, Place, RuntimeDir, SHARED_MEMORY_NEEDED, sweep};

/// An epoch whose daemon is dead.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stale {
    /// The learner, or none for files that no record names any more.
    pub learner: Option<String>,
    /// The prefix of its files in shared memory.
    pub prefix: String,
    /// How many files it left there.
    pub files: usize,
    /// How many bytes they take.
    pub bytes: u64,
}

/// The state of the machine, for a daemon.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Facts {
    /// Bytes of shared memory free.
    pub shared_memory_available: u64,
    /// Bytes of shared memory a daemon needs.
    pub shared_memory_needed: u64,
    /// Learners that a daemon serves now.
    pub served: Vec<LearnerName>,
    /// What dead daemons left. Starting the learner's daemon removes its own; files without a learner can
    /// be removed by hand from `/dev/shm`.
    pub stale: Vec<Stale>,
    /// Version of iceoryx2 that this build, and so everything on its domains, uses.
    pub transport: &'static str,
    /// Version of the protocol that this build speaks.
    pub protocol: u32,
}

/// Looks at `runtime` and at shared memory. Changes nothing.
///
/// # Errors
/// What the operating system said when either cannot be listed.
pub fn examine(runtime: &RuntimeDir) -> Result<Facts, DomainError> {
    let mut served = Vec::new();
    let mut stale = Vec::new();
    let mut known = BTreeSet::new();
    for learner in learners(runtime)? {
        let place = Place::new(runtime.clone(), learner.clone());
        let record = super::DomainRecord::read(&place.record_path());
        if let Ok(record) = &record {
            known.insert(record.prefix.clone());
        }
        if place.is_served() {
            served.push(learner);
        } else if let Ok(record) = record {
            stale.push(left(Some(learner.to_string()), &record.prefix)?);
        }
    }
    for prefix in unknown_prefixes(&known)? {
        stale.push(left(None, &prefix)?);
    }
    Ok(Facts {
        shared_memory_available: sweep::shared_memory_available()?,
        shared_memory_needed: SHARED_MEMORY_NEEDED,
        served,
        stale,
        transport: crate::transport::VERSION,
        protocol: crate::wire::VERSION,
    })
}

fn learners(runtime: &RuntimeDir) -> Result<Vec<LearnerName>, DomainError> {
    let names = sweep::names(runtime.path())?.filter_map(|name| LearnerName::new(&name).ok());
    let mut names: Vec<_> = names.collect();
    names.sort();
    Ok(names)
}

fn left(learner: Option<String>, prefix: &str) -> Result<Stale, DomainError> {
    let files = sweep::shared_memory_files(prefix)?;
    let bytes = files.iter().filter_map(|path| fs::metadata(path).ok()).map(|found| found.len()).sum();
    Ok(Stale { learner, prefix: prefix.to_owned(), files: files.len(), bytes })
}

/// Prefixes of this user's files in shared memory that look like ours and that no record in this runtime
/// directory names. They may be of a live daemon in another runtime directory.
fn unknown_prefixes(known: &BTreeSet<String>) -> Result<BTreeSet<String>, DomainError> {
    let user = rustix::process::geteuid().as_raw();
    let directory = Path::new(sweep::SHARED_MEMORY);
    let own = |name: &String| fs::metadata(directory.join(name)).is_ok_and(|found| found.uid() == user);
    let names = sweep::names(directory)?.filter(own);
    let prefixes = names.filter_map(|name| name.get(..13).map(str::to_owned));
    Ok(prefixes.filter(|prefix| is_prefix(prefix) && !known.contains(prefix)).collect())
}
