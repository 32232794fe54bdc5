//! The memory that the process takes, and how much it may take.

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use rustix::param::page_size;

/// How often it is looked how much memory the process takes while that is far from what it may take. One look takes some
/// microseconds.
const LOOK_EVERY: Duration = Duration::from_millis(10);

/// Looks how much memory the process takes: each time it is asked while that is near what it may take, else now and then.
#[derive(Debug, Default)]
pub(crate) struct Gauge {
    /// When it is looked again; none: at once.
    next: Option<Instant>,
}

impl Gauge {
    /// What `bytes` says, if it is time to look; from `near_at` bytes on it always is.
    pub(crate) fn read(&mut self, now: Instant, near_at: u64, bytes: impl FnOnce() -> u64) -> Option<u64> {
        if self.next.is_some_and(|next| now < next) {
            return None;
        }
        let bytes = bytes();
        self.next = (bytes < near_at).then(|| now + LOOK_EVERY);
        Some(bytes)
    }
}

/// Resident memory of this process in bytes; 0 where the kernel does not say.
pub(crate) fn bytes() -> u64 {
    let pages = fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let resident = pages.split(' ').nth(1).and_then(|pages| pages.parse::<u64>().ok());
    resident.unwrap_or(0).saturating_mul(page_size() as u64)
}

/// The limit where none is given: half of the machine's memory, or of the least that the control groups of the process
/// allow. The other half is for the bodies, for what questions take, and for a snapshot, which keeps its own copy of what
/// changes while it is written. None where the kernel does not say.
pub(crate) fn default_max() -> Option<u64> {
    let machine = kibibytes(&fs::read_to_string("/proc/meminfo").unwrap_or_default(), "MemTotal:");
    let groups = fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    let group = group_max(Path::new("/sys/fs/cgroup"), &groups);
    machine.into_iter().chain(group).min().map(|bytes| bytes / 2)
}

/// The figure of a line of the kernel's such as `VmRSS:  1024 kB`, in bytes.
fn kibibytes(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

/// The least memory that the process's control groups and those above them allow, in bytes. `groups` is `/proc/self/cgroup`, and
/// `root` the place where control groups are mounted: those of version 2, or in a folder for each the controllers of version 1.
fn group_max(root: &Path, groups: &str) -> Option<u64> {
    let limits = groups.lines().filter_map(|line| {
        let (controllers, group) = line.split_once(':')?.1.split_once(':')?;
        let (mounted, file) = match controllers {
            "" => (root.to_owned(), "memory.max"),
            _ if controllers.split(',').any(|one| one == "memory") => {
                (root.join("memory"), "memory.limit_in_bytes")
            }
            _ => return None,
        };
        let limit = |group: &Path| {
            let text = fs::read_to_string(mounted.join(group).join(file)).ok()?;
            // `max` is no limit; in version 1 a number is none that is larger than any machine.
            text.trim().parse::<u64>().ok()
        };
        // A container may see the root of its group alone.
        Path::new(group.strip_prefix('/')?).ancestors().filter_map(limit).min()
    });
    limits.min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_process_and_the_machine_have_some_memory() {
        let (taken, max) = (bytes(), default_max().unwrap());
        assert!(taken > 1 << 20, "{taken}");
        assert!(max > taken, "{max} and {taken}");
    }

    /// In the tenth of a second between two looks a memory that grew fast had overrun its limit by a hundred megabytes.
    #[test]
    fn near_the_limit_each_frame_is_looked_at_and_far_from_it_few_are() {
        let (begun, mut gauge, near_at) = (Instant::now(), Gauge::default(), 750);
        let (mut looks_far, mut looks_near) = (0, 0);
        // One byte and a tenth of a millisecond for each frame.
        for frame in 0..1_000 {
            let seen = gauge.read(begun + Duration::from_micros(frame * 100), near_at, || frame);
            assert!(seen.is_none_or(|bytes| bytes == frame));
            *if frame < near_at { &mut looks_far } else { &mut looks_near } += u64::from(seen.is_some());
        }
        assert_eq!(looks_far, 8);
        // The first of them was at most one pause late.
        assert!(looks_near > 1_000 - near_at - 100, "{looks_near}");
    }

    #[test]
    fn the_least_limit_of_all_groups_above_counts() {
        let root = tempfile::tempdir().unwrap();
        let group = root.path().join("system.slice/pschema.service");
        fs::create_dir_all(&group).unwrap();
        let groups = "1:name=systemd:/else\n0::/system.slice/pschema.service\n";
        assert_eq!(group_max(root.path(), groups), None, "none says anything");
        fs::write(group.join("memory.max"), "max\n").unwrap();
        assert_eq!(group_max(root.path(), groups), None);
        fs::write(root.path().join("system.slice/memory.max"), "2000000\n").unwrap();
        assert_eq!(group_max(root.path(), groups), Some(2_000_000));
        fs::write(group.join("memory.max"), "3000000\n").unwrap();
        assert_eq!(group_max(root.path(), groups), Some(2_000_000));
        fs::write(root.path().join("memory.max"), "1000\n").unwrap();
        assert_eq!(group_max(root.path(), groups), Some(1000));
        assert_eq!(group_max(root.path(), "0::/\n"), Some(1000), "as a container sees it");
    }

    #[test]
    fn limits_of_the_first_version_of_control_groups_count() {
        let root = tempfile::tempdir().unwrap();
        let memory = root.path().join("memory");
        fs::create_dir_all(memory.join("docker/4711")).unwrap();
        let groups = "5:cpu,memory:/docker/4711\n4:devices:/docker/4711\n0::/system.slice\n";
        assert_eq!(group_max(root.path(), groups), None);
        fs::write(memory.join("memory.limit_in_bytes"), "9223372036854771712\n").unwrap();
        fs::write(memory.join("docker/4711/memory.limit_in_bytes"), "4000000\n").unwrap();
        assert_eq!(group_max(root.path(), groups), Some(4_000_000));
        // In the container the group is the root of what is mounted.
        fs::remove_dir_all(memory.join("docker")).unwrap();
        fs::write(memory.join("memory.limit_in_bytes"), "5000000\n").unwrap();
        assert_eq!(group_max(root.path(), groups), Some(5_000_000));
        // Of two versions beside each other the least counts.
        fs::create_dir(root.path().join("system.slice")).unwrap();
        fs::write(root.path().join("system.slice/memory.max"), "3000000\n").unwrap();
        assert_eq!(group_max(root.path(), groups), Some(3_000_000));
    }
}
