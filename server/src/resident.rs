//! The memory that the process takes, and how much it may take.

use std::fs;
use std::path::Path;

/// Resident memory of this process in bytes; 0 where the kernel does not say.
pub(crate) fn bytes() -> u64 {
    kibibytes(&fs::read_to_string("/proc/self/status").unwrap_or_default(), "VmRSS:").unwrap_or(0)
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

/// The least memory that the process's control group and those above it allow, in bytes. `groups` is `/proc/self/cgroup`,
/// and `root` the place where version 2 of control groups is mounted.
fn group_max(root: &Path, groups: &str) -> Option<u64> {
    let own = groups.lines().find_map(|line| line.strip_prefix("0::/"))?;
    let limit = |group: &Path| {
        let text = fs::read_to_string(root.join(group).join("memory.max")).ok()?;
        // `max` is no limit.
        text.trim().parse::<u64>().ok()
    };
    Path::new(own).ancestors().filter_map(limit).min()
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
}
