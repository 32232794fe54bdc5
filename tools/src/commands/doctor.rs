//! `pschema doctor`: what is wrong with this machine, and how to mend it.

use std::collections::BTreeSet;
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
    let dead: Vec<_> = stale.iter().filter(|stale| is_dead(stale)).collect();
    if dead.is_empty() {
        return vec![fine("left behind", "nothing")];
    }
    let told = |stale: &&StaleEpoch| {
        let whose =
            stale.learner.as_ref().map_or("an unknown learner".to_owned(), |name| format!("learner {name}"));
        let (files, size) = (count(stale.files as u64, "file"), bytes(stale.bytes));
        let found =
            format!("a dead daemon of {whose} left {files} ({size}) under {SHARED_MEMORY}/{}*", stale.prefix);
        wrong("left behind", found, "run `pschema doctor --clean`")
    };
    dead.iter().map(told).collect()
}

/// Whether what was found belongs to nobody. An epoch that a record names is known to be dead; files that no
/// record here names may be of a daemon in another runtime directory, whose processes map them. When in doubt, no.
fn is_dead(stale: &StaleEpoch) -> bool {
    let in_use = || mapped_prefixes().is_none_or(|mapped| mapped.contains(&stale.prefix));
    stale.learner.is_some() || !(is_young(&stale.prefix) || in_use())
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
    for stale in stale.iter().filter(|stale| is_dead(stale)) {
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
        assert!(is_dead(&stale(None)));
        assert!(is_dead(&stale(Some("demo"))));
    }
}
