//! Cleaning up after processes that died. It takes up to milliseconds, so it has threads of its own and no frame waits for
//! it.
//!
//! There are two threads, because iceoryx2 0.10 cannot clean up after a process that was killed while it made a file:
//! - The files of a node (`nodes/<node>/*`) are made with mode 0600, filled, and made read-only. iceoryx2 overlooks a file
//!   that is not finished, fails to remove the directory, and never comes to the nodes that are listed after it.
//! - iceoryx2 waits without end for a segment in shared memory that was made and not yet given a size.
//!
//! So the *sweeper* removes files that stay unfinished: a living process finishes a file within microseconds. The *cleaner*
//! lets iceoryx2 clean up while there are no unfinished files. If a file comes up in between and iceoryx2 waits for it, the wait
//! ends when the sweeper removes that file.

use std::collections::BTreeMap;
use std::fs::{self, Metadata};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use pschema_process::Worker;

use super::error::setup;
use super::{TransportError, services};
use crate::domain::{DomainRecord, Place, shared_memory_files};

/// How often both threads look for what dead processes left.
const TICK: Duration = Duration::from_millis(100);
/// How long a file may stay unfinished until its maker is taken for dead.
const UNFINISHED_PATIENCE: Duration = Duration::from_secs(1);

/// The two threads. They end when this is dropped.
#[derive(Debug)]
pub(super) struct Janitor {
    // Dropped in this order: the cleaner may need the sweeper to come to its end.
    _cleaner: Worker,
    _sweeper: Worker,
}

impl Janitor {
    pub(super) fn start(place: &Place, record: &DomainRecord) -> Result<Self, TransportError> {
        let unfinished = Arc::new(AtomicBool::new(false));
        let told = unfinished.clone();
        let (nodes, prefix) = (place.epoch_root(record).join("nodes"), record.prefix.clone());
        let sweep = move |stop: &AtomicBool| {
            let mut files = UnfinishedFiles::default();
            while !stop.load(Ordering::Acquire) {
                told.store(files.sweep(&nodes, &prefix, Instant::now()), Ordering::Release);
                thread::park_timeout(TICK);
            }
        };
        let (place, record) = (place.clone(), record.clone());
        let clean = move |stop: &AtomicBool| clean(&place, &record, &unfinished, stop);
        let failed = "start a janitor's thread";
        let sweeper = Worker::start("sweeper", sweep).map_err(setup(failed))?;
        let cleaner = Worker::start("cleaner", clean).map_err(setup(failed))?;
        Ok(Self { _cleaner: cleaner, _sweeper: sweeper })
    }
}

fn clean(place: &Place, record: &DomainRecord, unfinished: &AtomicBool, stop: &AtomicBool) {
    let node = match services::node::<services::Ipc>(place, record, "janitor") {
        Ok(node) => node,
        Err(error) => {
            tracing::error!(%error, "no janitor: processes that die keep their places until a restart");
            return;
        }
    };
    while !stop.load(Ordering::Acquire) {
        if !unfinished.load(Ordering::Acquire) {
            let found = node.try_cleanup_dead_nodes();
            if found.cleanups + found.failed_cleanups > 0 {
                tracing::debug!(cleaned = found.cleanups, failed = found.failed_cleanups, "dead processes");
            }
        }
        thread::park_timeout(TICK);
    }
}

/// Unfinished files, and when each was first seen. The time that a file itself has is of a clock that jumps.
#[derive(Default)]
struct UnfinishedFiles {
    files: BTreeMap<PathBuf, (u64, Instant)>,
}

impl UnfinishedFiles {
    /// Removes the unfinished files of dead processes. Returns whether there was any unfinished file, removed or not.
    fn sweep(&mut self, nodes: &Path, prefix: &str, now: Instant) -> bool {
        let mut there = BTreeMap::new();
        for (path, inode) in unfinished(nodes, prefix) {
            let since = match self.files.get(&path) {
                Some((same, since)) if *same == inode => *since,
                _ => now,
            };
            if now.saturating_duration_since(since) > UNFINISHED_PATIENCE && fs::remove_file(&path).is_ok() {
                tracing::debug!(path = %path.display(), "removed what a dead process had not finished");
            }
            there.insert(path, (inode, since));
        }
        self.files = there;
        !self.files.is_empty()
    }
}

/// Files that were made and are not finished, with their inodes.
fn unfinished(nodes: &Path, prefix: &str) -> Vec<(PathBuf, u64)> {
    let in_nodes = entries(nodes);
    let is_context = |path: &&PathBuf| path.extension().is_some_and(|end| end == "node_monitor_context");
    let directories = in_nodes.iter().filter(|path| path.is_dir());
    let mut of_nodes: Vec<_> = directories.flat_map(|path| entries(path)).collect();
    of_nodes.extend(in_nodes.iter().filter(is_context).cloned());
    let segments = shared_memory_files(prefix).unwrap_or_default();
    let inode = |path: PathBuf, is_unfinished: fn(&Metadata) -> bool| {
        // A file that is gone by now needs no sweeping.
        let found = fs::symlink_metadata(&path).ok()?;
        (found.is_file() && is_unfinished(&found)).then(|| (path, found.ino()))
    };
    let of_nodes = of_nodes.into_iter().filter_map(|path| inode(path, |found| found.mode() & 0o200 != 0));
    let segments = segments
        .into_iter()
        .filter_map(|path| inode(path, |found| found.mode() & 0o400 == 0 || found.size() == 0));
    of_nodes.chain(segments).collect()
}

fn entries(directory: &Path) -> Vec<PathBuf> {
    // A directory that is not there, or no longer, has no files.
    fs::read_dir(directory).map(|all| all.flatten().map(|entry| entry.path()).collect()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::{File, Permissions};
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn only_what_stays_unfinished_is_removed() {
        let directory = tempfile::tempdir().unwrap();
        let nodes = directory.path().join("nodes");
        fs::create_dir_all(nodes.join("17")).unwrap();
        let make = |name: &str, mode: u32| {
            let path = nodes.join(name);
            File::create(&path).unwrap();
            fs::set_permissions(&path, Permissions::from_mode(mode)).unwrap();
            path
        };
        let kept = [
            make("17/done.port_tag", 0o400),
            make("17.node_monitor", 0o600),
            make("17.node_monitor_context", 0o400),
        ];
        let (mut files, begin) = (UnfinishedFiles::default(), Instant::now());
        let later = begin + 2 * UNFINISHED_PATIENCE;
        assert!(!files.sweep(&nodes, "none", begin) && !files.sweep(&nodes, "none", later));
        let fresh = make("17/fresh.port_tag", 0o600);
        // What its own time says, be it of a clock that was wrong, is of no account.
        File::open(&fresh).unwrap().set_modified(std::time::UNIX_EPOCH).unwrap();
        assert!(files.sweep(&nodes, "none", begin) && fresh.exists());
        fs::set_permissions(&fresh, Permissions::from_mode(0o400)).unwrap();
        assert!(!files.sweep(&nodes, "none", later) && fresh.exists(), "it was finished in time");
        let dead = [make("17/dead.service_tag", 0o600), make("18.node_monitor_context", 0o600)];
        assert!(files.sweep(&nodes, "none", begin) && dead.iter().all(|path| path.exists()));
        assert!(files.sweep(&nodes, "none", later));
        assert!(!dead.iter().any(|path| path.exists()) && kept.iter().all(|path| path.exists()));
        assert!(!files.sweep(&nodes, "none", later));
    }
}
