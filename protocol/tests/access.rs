//! Access of other users: every file that is made is closed to them, and files that they made first are refused or ignored.

#![allow(clippy::unwrap_used)] // A test panics to fail.

mod support;

use std::fs::{self, File, Permissions};
use std::io::Write;
use std::os::unix::fs::{MetadataExt, PermissionsExt, chown, symlink};
use std::path::{Path, PathBuf};

use pschema_protocol::body::run;
use pschema_protocol::client::Client;
use pschema_protocol::domain::{DomainError, LearnerName, OwnedDomain, Place, RuntimeDir, examine};
use support::{Counter, Daemon, PATIENCE, Runtime, attach, echo, options, shared_files, until};

/// Another user than the one that runs the tests: `nobody`.
const STRANGER: u32 = 65534;

/// Gives `path` to another user. Only root can; where these tests run as another, what needs it is not tested, which is
/// said past the capture of the test's output.
fn given_to_a_stranger(path: &Path, test: &str) -> bool {
    if chown(path, Some(STRANGER), None).is_ok() {
        return true;
    }
    let mut said = std::io::stderr();
    writeln!(said, "SKIPPED a part of {test}: only root can give files to another user").unwrap();
    false
}

fn walk(directory: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(directory).unwrap().flatten() {
        found.push(entry.path());
        if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            walk(&entry.path(), found);
        }
    }
}

#[test]
fn everything_made_is_the_users_own_and_closed_to_others() {
    let runtime = Runtime::new();
    let place = runtime.place("modes");
    let daemon = Daemon::start(place.clone(), u64::MAX, echo);
    let _body = attach(&place);
    let mut tool = Client::connect(&place, PATIENCE).unwrap();
    tool.request(b"here").unwrap();
    let user = rustix::process::geteuid().as_raw();
    let top = fs::metadata(runtime.path()).unwrap();
    assert_eq!((top.mode() & 0o7777, top.uid()), (0o700, user));
    let mut inside = Vec::new();
    walk(&runtime.path(), &mut inside);
    let mut sockets = 0;
    for path in &inside {
        let Ok(found) = fs::symlink_metadata(path) else { continue };
        assert_eq!(found.uid(), user, "{path:?}");
        // iceoryx2 makes its directories 0750; nobody else gets as far as these.
        let allowed = if found.is_dir() { 0o750 } else { 0o600 };
        assert_eq!(found.mode() & 0o777 & !allowed, 0, "{path:?} has mode {:o}", found.mode());
        sockets += usize::from(!found.is_dir() && !found.is_file());
    }
    assert!(inside.len() > 10 && sockets > 0, "{inside:?}");
    for name in ["modes", "modes/lock", "modes/domain"] {
        let mode = fs::metadata(runtime.path().join(name)).unwrap().mode() & 0o777;
        assert_eq!(mode, if name == "modes" { 0o700 } else { 0o600 }, "{name}");
    }
    // Below /dev/shm nothing else protects: not a bit for others, neither in the file that counts nodes.
    let shared = shared_files(&daemon.prefix);
    assert!(shared.iter().any(|name| name.ends_with(".global_mgmt")), "{shared:?}");
    for name in &shared {
        let Ok(found) = fs::symlink_metadata(Path::new("/dev/shm").join(name)) else { continue };
        assert_eq!(found.uid(), user, "{name}");
        assert_eq!(found.mode() & 0o177, 0, "{name} has mode {:o}", found.mode());
    }
    drop((_body, tool));
    daemon.stop();
}

#[test]
fn a_runtime_directory_that_others_prepared_is_refused_with_what_to_do() {
    const TEST: &str = "a_runtime_directory_that_others_prepared_is_refused_with_what_to_do";
    let parent = tempfile::Builder::new().prefix("ps").tempdir_in("/tmp").unwrap();
    let at = |name: &str| parent.path().join(name);
    let refused = |path: &Path, complaint: &str| {
        let error = RuntimeDir::at(path).unwrap_err().to_string();
        assert!(error.contains(complaint) && error.contains(path.to_str().unwrap()), "{error}");
    };
    fs::create_dir(at("open")).unwrap();
    fs::set_permissions(at("open"), Permissions::from_mode(0o755)).unwrap();
    refused(&at("open"), "run `chmod 700` on it");
    File::create(at("file")).unwrap();
    refused(&at("file"), "is not a directory: remove it");
    fs::create_dir(at("own")).unwrap();
    fs::set_permissions(at("own"), Permissions::from_mode(0o700)).unwrap();
    symlink(at("own"), at("link")).unwrap();
    refused(&at("link"), "symbolic link");
    symlink(at("nowhere"), at("dangling")).unwrap();
    refused(&at("dangling"), "symbolic link");
    assert!(!at("nowhere").exists(), "nothing is made through a link");
    fs::create_dir(at("shared")).unwrap();
    fs::set_permissions(at("shared"), Permissions::from_mode(0o777)).unwrap();
    refused(&at("shared/run"), "chmod go-w");

    fs::create_dir(at("foreign")).unwrap();
    fs::set_permissions(at("foreign"), Permissions::from_mode(0o700)).unwrap();
    if given_to_a_stranger(&at("foreign"), TEST) {
        refused(&at("foreign"), "belongs to user 65534");
        refused(&at("foreign/run"), "belongs to user 65534, who could put another in its place");
    }
}

#[test]
fn a_learners_files_that_others_prepared_are_refused() {
    let runtime = Runtime::new();
    let place = runtime.place("squat");
    let directory = runtime.path().join("squat");
    let elsewhere = tempfile::Builder::new().prefix("ps").tempdir_in("/tmp").unwrap();
    symlink(elsewhere.path(), &directory).unwrap();
    let error = OwnedDomain::create(place.clone()).unwrap_err().to_string();
    assert!(error.contains("symbolic link") && error.contains("run/squat"), "{error}");
    fs::remove_file(&directory).unwrap();
    fs::create_dir(&directory).unwrap();
    fs::set_permissions(&directory, Permissions::from_mode(0o770)).unwrap();
    let error = OwnedDomain::create(place.clone()).unwrap_err().to_string();
    assert!(error.contains("mode 770"), "{error}");
    fs::set_permissions(&directory, Permissions::from_mode(0o700)).unwrap();

    // The file behind the link, to which a lock or a record would be written, is left as it is.
    let victim = elsewhere.path().join("victim");
    fs::write(&victim, "precious").unwrap();
    for name in ["lock", "domain.new"] {
        symlink(&victim, directory.join(name)).unwrap();
        let error = OwnedDomain::create(place.clone()).unwrap_err();
        assert!(
            matches!(&error, DomainError::Io { doing: "open", path, .. } if path.ends_with(name)),
            "{error}"
        );
        assert_eq!(fs::read_to_string(&victim).unwrap(), "precious", "{name}");
        fs::remove_file(directory.join(name)).unwrap();
    }
    // A record that was forged can't have files of others removed.
    fs::write(
        directory.join("domain"),
        "protocol = 2\nepoch = 1\npid = 1\nprefix = ../../victim\nstate = ready\n",
    )
    .unwrap();
    let daemon = Daemon::start(place.clone(), 10, echo);
    assert_eq!(run(Counter::new(), &options(&place)).unwrap().frames, 10);
    daemon.stop();
}

/// Everyone sees the names in /dev/shm and can make more of them. Files of a stranger under an epoch's prefix once kept
/// the next daemon from starting, for they can't be removed, and the dead from being cleaned up.
#[test]
fn a_strangers_files_in_shared_memory_are_of_no_account() {
    const TEST: &str = "a_strangers_files_in_shared_memory_are_of_no_account";
    let runtime = Runtime::new();
    let place = runtime.place("names");
    let daemon = Daemon::start(place.clone(), u64::MAX, echo);
    let own = shared_files(&daemon.prefix);
    let counts = own.iter().find(|name| name.ends_with(".global_mgmt")).unwrap();
    let planted: Vec<_> = [format!("{}empty", daemon.prefix), format!("{}0.data", daemon.prefix)]
        .iter()
        .map(|name| Path::new("/dev/shm").join(name))
        .collect();
    let mut strange = true;
    for path in &planted {
        File::create(path).unwrap();
        fs::set_permissions(path, Permissions::from_mode(0o666)).unwrap();
        strange &= given_to_a_stranger(path, TEST);
    }
    // The dead are still found and cleaned up.
    let body = attach(&place);
    drop(body);
    until("the body to be missed", || daemon.gone.load(std::sync::atomic::Ordering::Relaxed) == 1);
    let seen = daemon.stop();
    assert_eq!(
        planted.iter().all(|path| path.exists()),
        strange,
        "what is ours is removed, what is not is left"
    );
    // Files that a stranger prepares for the next start, under names seen before, have another prefix.
    let prepared = Path::new("/dev/shm").join(counts);
    File::create(&prepared).unwrap();
    fs::set_permissions(&prepared, Permissions::from_mode(0o666)).unwrap();
    given_to_a_stranger(&prepared, TEST);
    let next = Daemon::start(place.clone(), 10, echo);
    assert_ne!(next.prefix, seen.prefix);
    assert_eq!(run(Counter::new(), &options(&place)).unwrap().frames, 10);
    next.stop();
    for path in planted.iter().chain([&prepared]) {
        fs::remove_file(path).ok();
    }
}

#[test]
fn what_is_open_to_others_is_found_by_who_examines_it() {
    const TEST: &str = "what_is_open_to_others_is_found_by_who_examines_it";
    let runtime = Runtime::new();
    let place = runtime.place("open");
    let daemon = Daemon::start(place.clone(), 10, echo);
    // Of other tests there may be files in shared memory; here none is looked at but this learner's.
    let exposed = || examine(place.runtime()).unwrap().exposed;
    assert_eq!(exposed(), []);
    let lock = runtime.path().join("open/lock");
    let segment = shared_files(&daemon.prefix).into_iter().find(|name| name.ends_with(".data")).unwrap();
    let segment = Path::new("/dev/shm").join(segment);
    for path in [&lock, &segment] {
        fs::set_permissions(path, Permissions::from_mode(0o644)).unwrap();
        let found = exposed();
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!((&found[0].path, found[0].problem.as_str()), (path, "it is open to others (mode 644)"));
        assert_eq!(found[0].mend, format!("run `chmod go= {}`", path.display()));
        fs::set_permissions(path, Permissions::from_mode(0o600)).unwrap();
    }
    let planted = Path::new("/dev/shm").join(format!("{}planted", daemon.prefix));
    File::create(&planted).unwrap();
    if given_to_a_stranger(&planted, TEST) {
        let found = exposed();
        assert!(
            found[0].problem.contains("user 65534") && found[0].mend.contains("of no account"),
            "{found:?}"
        );
    }
    fs::remove_file(&planted).unwrap();
    assert_eq!(exposed(), []);
    daemon.stop();
}

#[test]
fn prefixes_cannot_be_guessed_from_those_before() {
    let runtime = Runtime::new();
    let name = LearnerName::new("random").unwrap();
    let mut seen = std::collections::BTreeSet::new();
    let mut bits = [0_u32; 40];
    for _ in 0..200 {
        let place = Place::new(RuntimeDir::at(&runtime.path()).unwrap(), name.clone());
        let prefix = OwnedDomain::create(place).unwrap().record().prefix.clone();
        let number = u64::from_str_radix(&prefix[2..12], 16).unwrap();
        (0..40).for_each(|bit| bits[bit] += u32::from(number >> bit & 1 == 1));
        assert!(seen.insert(prefix), "a prefix came twice");
    }
    // Each bit is drawn: by chance, 60 to 140 of 200 fail once in 10^8.
    assert!(bits.iter().all(|ones| (60..=140).contains(ones)), "{bits:?}");
}
