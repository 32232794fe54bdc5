//! `pschema doctor`: what is wrong with this machine, and how to mend it.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, OpenOptions};
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::thread::available_parallelism;
use std::time::Duration;

use clap::Args;
use pschema_protocol::domain::{
    self, Exposure, LearnerName, MachineState, OwnedDomain, Place, RuntimeDir, StaleEpoch,
};
use serde::Serialize;

use crate::failure::Failure;
use crate::output::{self, Style};
use crate::render::schema::wrapped;
use crate::render::words::{bytes, count};

#[derive(Clone, Copy, Debug, Args)]
#[command(after_help = "Example:\n  pschema doctor --clean")]
pub(crate) struct DoctorArgs {
    /// Remove what dead daemons left behind
    #[arg(long)]
    clean: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

const SHARED_MEMORY: &str = "/dev/shm";

/// Files younger than this may be of a daemon that has made and not yet mapped them.
const YOUNG: Duration = Duration::from_secs(10);

/// One thing looked at.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Check {
    /// What was looked at.
    name: &'static str,
    /// Whether it is as it should be.
    ok: bool,
    /// How it is, for people.
    found: String,
    /// How to mend it; none where nothing is wrong.
    mend: Option<String>,
}

/// The state of a machine.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct Findings {
    /// Whether nothing is wrong.
    ok: bool,
    /// Everything that was looked at.
    checks: Vec<Check>,
    /// The files of dead daemons that were removed.
    cleaned: Vec<String>,
}

fn fine(name: &'static str, found: impl Into<String>) -> Check {
    Check { name, ok: true, found: found.into(), mend: None }
}

fn wrong(name: &'static str, found: impl Into<String>, mend: impl Into<String>) -> Check {
    Check { name, ok: false, found: found.into(), mend: Some(mend.into()) }
}

pub(crate) fn run(args: DoctorArgs) -> Result<(), Failure> {
    let findings = examine(args.clean)?;
    output::show(args.json, &findings, |findings| text(findings, Style::of_stdout()))?;
    let wrong = findings.checks.iter().filter(|check| !check.ok).count();
    match wrong {
        0 => Ok(()),
        n => Err(Failure::Failed(format!("{} to mend, see above", count(n as u64, "thing")))),
    }
}

fn examine(clean: bool) -> Result<Findings, Failure> {
    let mut checks = vec![versions(), cores()];
    let mut cleaned = Vec::new();
    let runtime = match RuntimeDir::from_environment() {
        Ok(runtime) => runtime,
        Err(error) => {
            checks.push(wrong("runtime directory", error.to_string(), "as said; everything else needs it"));
            return Ok(Findings { ok: false, checks, cleaned });
        }
    };
    checks
        .push(fine("runtime directory", format!("{}, yours and closed to others", runtime.path().display())));
    checks.push(writable(Path::new(SHARED_MEMORY)));
    let mut machine = domain::examine(&runtime)?;
    if clean {
        cleaned = sweep(&runtime, &machine.stale)?;
        machine = domain::examine(&runtime)?;
    }
    checks.extend([space(&machine), daemons(&machine)]);
    checks.extend(access(&machine));
    checks.extend(left_behind(&machine.stale));
    checks.push(removal_at_logout(Path::new("/"), rustix::process::geteuid().as_raw()));
    Ok(Findings { ok: checks.iter().all(|check| check.ok), checks, cleaned })
}

fn versions() -> Check {
    let (transport, protocol) = (pschema_protocol::transport::VERSION, pschema_protocol::wire::VERSION);
    let own = env!("CARGO_PKG_VERSION");
    fine("versions", format!("pschema {own}, protocol {protocol}, iceoryx2 {transport}"))
}

/// A daemon and a body each keep a processor busy; on one they take turns, which is slow and not wrong.
fn cores() -> Check {
    match available_parallelism() {
        Ok(n) if n.get() > 1 => fine("processors", n.to_string()),
        Ok(_) => fine("processors", "1: daemon and body will take turns; two are several times faster"),
        Err(error) => fine("processors", format!("unknown ({error})")),
    }
}

/// Whether files can be made in shared memory, by making one.
fn writable(directory: &Path) -> Check {
    let path = directory.join(format!("pschema-doctor-{}", std::process::id()));
    let directory = directory.display();
    if let Err(error) = OpenOptions::new().write(true).create_new(true).open(&path) {
        let mend = format!("mount it: `sudo mount -t tmpfs -o mode=1777 tmpfs {directory}`");
        return wrong("shared memory", format!("cannot make a file in {directory}: {error}"), mend);
    }
    match fs::remove_file(&path) {
        Ok(()) => fine("shared memory", format!("{directory} is writable")),
        Err(error) => {
            wrong("shared memory", format!("cannot remove {}: {error}", path.display()), "remove it")
        }
    }
}

fn space(machine: &MachineState) -> Check {
    let (available, needed) = (machine.shared_memory_available, machine.shared_memory_needed);
    let found = format!("{} free, a daemon needs {}", bytes(available), bytes(needed));
    if available >= needed {
        return fine("its space", found);
    }
    let mend = format!("remove what is left there, or `sudo mount -o remount,size=1G {SHARED_MEMORY}`");
    wrong("its space", found, mend)
}

/// Whether everything is the user's own and closed to others.
fn access(machine: &MachineState) -> Vec<Check> {
    if machine.exposed.is_empty() {
        return vec![fine("access", "files of daemons are yours and closed to others")];
    }
    let told = |one: &Exposure| {
        wrong("access", format!("{}: {}", one.path.display(), one.problem), one.mend.clone())
    };
    machine.exposed.iter().map(told).collect()
}

fn daemons(machine: &MachineState) -> Check {
    let served: Vec<_> = machine.served.iter().map(LearnerName::as_str).collect();
    fine("daemons", if served.is_empty() { "none running".to_owned() } else { served.join(", ") })
}

fn left_behind(stale: &[StaleEpoch]) -> Vec<Check> {
    let told = |stale: &StaleEpoch| {
        let (files, size) = (count(stale.files as u64, "file"), bytes(stale.bytes));
        let place = format!("{SHARED_MEMORY}/{}*", stale.prefix);
        match fate(stale, sees_all_processes()) {
            Fate::Used => None,
            Fate::Unknown => Some(fine(
                "left behind",
                format!(
                    "perhaps {files} ({size}) under {place}, of no learner here: whether a daemon uses them can't be judged, \
                     for not all processes are seen from here; ask `pschema doctor` on the machine itself, outside of any container"
                ),
            )),
            Fate::Dead => {
                let whose = match &stale.learner {
                    Some(name) => format!("learner {name}"),
                    None => "an unknown learner".to_owned(),
                };
                let found = format!("a dead daemon of {whose} left {files} ({size}) under {place}");
                Some(wrong("left behind", found, "run `pschema doctor --clean`"))
            }
        }
    };
    let mut checks: Vec<_> = stale.iter().filter_map(told).collect();
    if checks.is_empty() {
        checks.push(fine("left behind", "nothing"));
    }
    checks
}

/// What is known of the daemon whose files were found, and which serves no learner of this runtime directory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fate {
    /// It is dead, and its files are nobody's.
    Dead,
    /// It lives, in another runtime directory.
    Used,
    /// It may live: hands off.
    Unknown,
}

/// The fate of the daemon that made some files. A daemon that a record here names let its lock go, which the kernel tells in every
/// container; that of files which no record here names may be of another runtime directory, and then a process maps them. It is
/// looked for among the processes that are seen here. When in doubt, it lives.
fn fate(stale: &StaleEpoch, sees_all: bool) -> Fate {
    if stale.learner.is_some() {
        return Fate::Dead;
    }
    match mapped_prefixes() {
        Some(mapped) if mapped.contains(&stale.prefix) => Fate::Used,
        Some(_) if sees_all && is_young(&stale.prefix) => Fate::Used,
        Some(_) if sees_all => Fate::Dead,
        _ => Fate::Unknown,
    }
}

/// Whether all processes of the machine are seen here: this process is in its first namespace of processes, whose number is the same
/// on every Linux. Shared memory may be that of the machine in a container, too, whose processes are some of its alone.
fn sees_all_processes() -> bool {
    fs::read_link("/proc/self/ns/pid").is_ok_and(|namespace| namespace == Path::new("pid:[4026531836]"))
}

/// The setting by which systemd-logind removes the shared memory of a user whose last session ends, living daemons or not. It is
/// on unless said otherwise, and leaves system users alone. `root` is where the files of the system are.
fn removal_at_logout(root: &Path, user: u32) -> Check {
    const NAME: &str = "at logout";
    if !root.join("run/systemd/seats").is_dir() {
        return fine(NAME, "no logind here that would remove shared memory");
    }
    let (removes, told_by) = removes_ipc(root);
    if !removes {
        return fine(NAME, "shared memory stays (RemoveIPC=no)");
    }
    if user <= system_users_max(root) {
        return fine(NAME, "shared memory stays: you are a system user");
    }
    if lingers(root, user) {
        return fine(NAME, "shared memory stays: you linger");
    }
    // Nothing is wrong as long as the user is there.
    fine(
        NAME,
        format!(
            "logind removes a living daemon's shared memory when your last session ends ({told_by}): for a daemon that is to stay, \
             linger (`sudo loginctl enable-linger`), run it as a system user, or say RemoveIPC=no in /etc/systemd/logind.conf"
        ),
    )
}

/// Whether logind removes shared memory, and what says so. Of several settings the last one counts: those of its main file, then of
/// the files beside it by their names; a file hides those of its name in the directories that come after its own.
fn removes_ipc(root: &Path) -> (bool, String) {
    const DIRECTORIES: [&str; 4] = ["etc/systemd", "run/systemd", "usr/local/lib/systemd", "usr/lib/systemd"];
    let main = DIRECTORIES.map(|directory| root.join(directory).join("logind.conf"));
    let mut dropped_in = BTreeMap::new();
    for directory in DIRECTORIES.iter().rev() {
        let entries =
            fs::read_dir(root.join(directory).join("logind.conf.d")).into_iter().flatten().flatten();
        let settings = entries.filter(|entry| entry.path().extension().is_some_and(|end| end == "conf"));
        dropped_in.extend(settings.map(|entry| (entry.file_name(), entry.path())));
    }
    let main = main.into_iter().find(|path| path.exists());
    let mut says = (true, "its default".to_owned());
    for path in main.into_iter().chain(dropped_in.into_values()) {
        let text = fs::read_to_string(&path).unwrap_or_default();
        let settings = text.lines().filter_map(|line| line.trim().split_once('='));
        for (_, value) in settings.filter(|(key, _)| key.trim() == "RemoveIPC") {
            let removes = match value.trim().to_ascii_lowercase().as_str() {
                "1" | "yes" | "y" | "true" | "t" | "on" => true,
                "0" | "no" | "n" | "false" | "f" | "off" => false,
                // logind says in its log that it cannot read it, and goes on without.
                _ => continue,
            };
            says = (removes, path.display().to_string());
        }
    }
    says
}

/// The highest number of a system user.
fn system_users_max(root: &Path) -> u32 {
    let settings = fs::read_to_string(root.join("etc/login.defs")).unwrap_or_default();
    let said = settings.lines().find_map(|line| line.trim().strip_prefix("SYS_UID_MAX"));
    said.and_then(|number| number.trim().parse().ok()).unwrap_or(999)
}

/// Whether a user's sessions are taken to go on when nobody is logged in.
fn lingers(root: &Path, user: u32) -> bool {
    let users = fs::read_to_string(root.join("etc/passwd")).unwrap_or_default();
    let name = users.lines().find_map(|line| {
        let mut fields = line.split(':');
        let (name, number) = (fields.next()?, fields.nth(1)?);
        (number.parse() == Ok(user)).then(|| name.to_owned())
    });
    name.is_some_and(|name| root.join("var/lib/systemd/linger").join(name).exists())
}

fn files(prefix: &str) -> Vec<std::path::PathBuf> {
    let entries = fs::read_dir(SHARED_MEMORY).into_iter().flatten().flatten();
    let own = entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(prefix));
    own.map(|entry| entry.path()).collect()
}

/// Whether one of its files was made just now; also when the clock was set back since and says that it was made later.
fn is_young(prefix: &str) -> bool {
    let made = |path: &std::path::PathBuf| fs::metadata(path).ok()?.modified().ok();
    files(prefix).iter().filter_map(made).any(|made| made.elapsed().map_or(true, |age| age < YOUNG))
}

/// The beginnings, as long as prefixes are, of the names of all files in shared memory that a process of this user
/// maps; none when one of these processes cannot be looked into.
fn mapped_prefixes() -> Option<BTreeSet<String>> {
    let user = rustix::process::geteuid().as_raw();
    let mut prefixes = BTreeSet::new();
    for process in fs::read_dir("/proc").ok()?.flatten() {
        let own = fs::metadata(process.path()).is_ok_and(|found| found.is_dir() && found.uid() == user);
        let number = process.file_name().to_string_lossy().parse::<u32>();
        // The init process often has privileges that forbid to look into it, and is none of ours.
        if !own || number.is_err() || number == Ok(1) {
            continue;
        }
        match fs::read_to_string(process.path().join("maps")) {
            Ok(maps) => prefixes.extend(maps.lines().filter_map(mapped_prefix)),
            Err(error) if error.kind() == std::io::ErrorKind::PermissionDenied => return None,
            // It has ended meanwhile.
            Err(_) => {}
        }
    }
    Some(prefixes)
}

fn mapped_prefix(line: &str) -> Option<String> {
    let (_, name) = line.split_once("/dev/shm/")?;
    name.get(..PREFIX_BYTES).map(str::to_owned)
}

/// `ps`, ten digits, `-`.
const PREFIX_BYTES: usize = 13;

/// Removes what dead daemons left.
fn sweep(runtime: &RuntimeDir, stale: &[StaleEpoch]) -> Result<Vec<String>, Failure> {
    let mut cleaned = Vec::new();
    let sees_all = sees_all_processes();
    for stale in stale.iter().filter(|stale| fate(stale, sees_all) == Fate::Dead) {
        match &stale.learner {
            // Taking a learner removes what was left of it; giving it up again leaves nothing.
            Some(name) => drop(OwnedDomain::create(Place::new(runtime.clone(), LearnerName::new(name)?))?),
            None => remove(&stale.prefix)?,
        }
        cleaned.push(format!("{SHARED_MEMORY}/{}* ({})", stale.prefix, bytes(stale.bytes)));
    }
    Ok(cleaned)
}

fn remove(prefix: &str) -> Result<(), Failure> {
    for path in files(prefix) {
        match fs::remove_file(&path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(Failure::Failed(format!("cannot remove {}: {error}", path.display())));
            }
            _ => {}
        }
    }
    Ok(())
}

fn text(findings: &Findings, style: Style) -> String {
    let mut text = String::new();
    for removed in &findings.cleaned {
        text.push_str(&format!("removed {removed}\n"));
    }
    for check in &findings.checks {
        let verdict = if check.ok { style.good("ok   ") } else { style.bad("wrong") };
        text.push_str(&format!("{verdict}  {:<17}  {}\n", check.name, check.found));
        if let Some(mend) = &check.mend {
            text.push_str(&wrapped(&format!("-> {mend}"), "       "));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_finding_says_how_to_mend_it() {
        let checks = vec![fine("processors", "2"), wrong("its space", "1.0 MiB free", "free some")];
        let findings = Findings { ok: false, checks, cleaned: Vec::new() };
        assert_eq!(
            text(&findings, Style::plain()),
            "ok     processors         2\nwrong  its space          1.0 MiB free\n       -> free some\n"
        );
    }

    #[test]
    fn a_directory_that_cannot_be_written_is_wrong() {
        let check = writable(Path::new("/proc"));
        assert!(!check.ok && check.mend.is_some(), "{check:?}");
        let directory = tempfile::tempdir().unwrap();
        assert!(writable(directory.path()).ok);
        assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0, "the trial file is removed");
    }

    #[test]
    fn a_mapped_file_is_known_by_its_prefix() {
        let line = "7f00-7f01 rw-s 00000000 00:1a 5 /dev/shm/ps0123456789-abc.data";
        assert_eq!(mapped_prefix(line).as_deref(), Some("ps0123456789-"));
        assert_eq!(mapped_prefix("7f00-7f01 r-xp 00000000 08:01 9 /usr/lib/libc.so"), None);
        assert_eq!(mapped_prefix("7f00-7f01 rw-s 00000000 00:1a 5 /dev/shm/short"), None);
    }

    #[test]
    fn what_a_record_names_is_dead_and_what_nobody_maps_is_too() {
        let stale = |learner: Option<&str>| StaleEpoch {
            learner: learner.map(str::to_owned),
            prefix: "ps0000000000-".to_owned(),
            files: 0,
            bytes: 0,
        };
        assert_eq!(fate(&stale(None), true), Fate::Dead);
        assert_eq!(fate(&stale(Some("demo")), false), Fate::Dead);
    }

    /// In a container that shares the machine's shared memory, a living daemon outside was called dead.
    #[test]
    fn what_cannot_be_judged_is_left_alone_and_no_cleaning_is_advised() {
        let stale = StaleEpoch { learner: None, prefix: "ps0000000000-".to_owned(), files: 3, bytes: 4096 };
        assert_eq!(fate(&stale, false), Fate::Unknown);
    }

    #[test]
    fn the_last_setting_of_logind_counts_and_system_users_are_left_alone() {
        let root = tempfile::tempdir().unwrap();
        let stays = |user| !removal_at_logout(root.path(), user).found.contains("logind removes");
        let write = |path: &str, text: &str| {
            let path = root.path().join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        };
        assert!(stays(1000), "there is no logind");
        fs::create_dir_all(root.path().join("run/systemd/seats")).unwrap();
        let by_default = removal_at_logout(root.path(), 1000).found;
        assert!(
            by_default.contains("logind removes") && by_default.contains("(its default)"),
            "{by_default}"
        );
        assert!(stays(0) && stays(999));
        write("etc/login.defs", "# users\nSYS_UID_MAX   499\n");
        assert!(!stays(999) && stays(499));
        write("etc/systemd/logind.conf", "[Login]\n#RemoveIPC=yes\nRemoveIPC = no\n");
        assert!(stays(1000));
        write("usr/lib/systemd/logind.conf.d/50-lab.conf", "[Login]\nRemoveIPC=yes\n");
        let said = removal_at_logout(root.path(), 1000).found;
        assert!(said.contains("logind removes") && said.contains("50-lab.conf"), "{said}");
        write("etc/systemd/logind.conf.d/50-lab.conf", "");
        assert!(stays(1000), "it hides the other of its name");
        write("etc/systemd/logind.conf.d/60-lab.conf", "[Login]\nRemoveIPC=on\nRemoveIPC=perhaps\n");
        assert!(!stays(1000));
        write("etc/passwd", "root:x:0:0::/:/bin/sh\nann:x:1000:1000::/home/ann:/bin/sh\n");
        write("var/lib/systemd/linger/ann", "");
        assert!(stays(1000) && !stays(1001));
    }
}
