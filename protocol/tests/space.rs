//! Shared memory that is full. Whoever writes to a page that isn't there is killed, so everything must be sure of its
//! pages before: tried in a /dev/shm of its own, which a mount namespace gives without any privilege.

#![allow(clippy::unwrap_used)] // A test panics to fail.

mod support;

use std::fs::File;
use std::io::Write;
use std::process::{Command, Stdio};
use std::sync::atomic::Ordering;
use std::time::Instant;

use pschema_protocol::body::{RunEnding, run};
use pschema_protocol::client::{Client, ClientError};
use pschema_protocol::domain::{DomainError, OwnedDomain};
use pschema_protocol::transport::TransportError;
use pschema_protocol::transport::body_link::BodyLink;
use rustix::fs::{FallocateFlags, fallocate, statvfs};
use support::{Counter, Daemon, PATIENCE, Runtime, counter_description, echo, options, until};

const MIB: u64 = 1024 * 1024;

/// Runs one of the ignored tests below where /dev/shm has `mebibytes`.
fn in_small_memory(part: &str, mebibytes: u64) {
    let mount = format!("mount -t tmpfs -o size={mebibytes}m tmpfs /dev/shm && exec \"$0\" \"$@\"");
    let possible = Command::new("unshare").args(["-rm", "true"]).stderr(Stdio::null()).status();
    if !possible.is_ok_and(|status| status.success()) {
        // Past the capture of the test's output.
        let why = "this machine gives no user namespaces (`unshare -rm true` fails)";
        let mut said = std::io::stderr();
        writeln!(said, "SKIPPED {part} with {mebibytes} MiB of shared memory: {why}").unwrap();
        return;
    }
    let output = Command::new("unshare")
        .args(["-rm", "sh", "-c", &mount])
        .arg(std::env::current_exe().unwrap())
        .args([part, "--exact", "--ignored", "--nocapture"])
        .env("PSCHEMA_TEST_PART", "1")
        .output()
        .unwrap();
    let said =
        String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}: {said}", output.status);
    assert!(said.contains("1 passed"), "{said}");
}

/// Whether this is a part, in its own memory, and not someone running the parts by hand.
fn is_part() -> bool {
    std::env::var_os("PSCHEMA_TEST_PART").is_some()
}

fn free() -> u64 {
    let space = statvfs("/dev/shm").unwrap();
    space.f_bavail * space.f_frsize
}

/// A file that takes all but `left` bytes, as long as it is kept.
struct Filler {
    _file: File,
}

impl Filler {
    fn leaving(left: u64) -> Self {
        let file = tempfile::tempfile_in("/dev/shm").unwrap();
        let (begin, mut taken) = (Instant::now(), 0);
        // A peer that left a moment ago may still be giving back its memory.
        while free() > left {
            assert!(begin.elapsed() < PATIENCE, "{} left", free());
            let more = free().saturating_sub(left);
            if more > 0 && fallocate(&file, FallocateFlags::empty(), taken, more).is_ok() {
                taken += more;
            }
        }
        Self { _file: file }
    }
}

#[test]
fn a_daemon_that_finds_too_little_says_so() {
    in_small_memory("part_daemon_with_too_little", 39);
}

#[test]
#[ignore = "a part of another test, with a /dev/shm of its own"]
fn part_daemon_with_too_little() {
    if !is_part() {
        return;
    }
    let runtime = Runtime::new();
    let error = OwnedDomain::create(runtime.place("small")).unwrap_err();
    assert!(matches!(error, DomainError::SharedMemory { .. }), "{error}");
    let said = error.to_string();
    assert!(said.contains("/dev/shm has 408") && said.contains("41943040 are needed: free some"), "{said}");
}

#[test]
fn whoever_comes_when_memory_is_full_is_told_and_nobody_dies() {
    in_small_memory("part_full_memory", 64);
}

#[test]
#[ignore = "a part of another test, with a /dev/shm of its own"]
fn part_full_memory() {
    if !is_part() {
        return;
    }
    let runtime = Runtime::new();
    let place = runtime.place("full");
    let daemon = Daemon::start(place.clone(), u64::MAX, echo);
    let options = options(&place);
    let stop = options.stop.clone();
    let body = std::thread::spawn(move || run(Counter::new(), &options));
    until("frames", || daemon.frames.load(Ordering::Relaxed) > 10);
    let mut early = Client::connect(&place, PATIENCE).unwrap();
    early.request(b"here").unwrap();

    let filler = Filler::leaving(0);
    let frames = daemon.frames.load(Ordering::Relaxed);
    until("frames while it is full", || daemon.frames.load(Ordering::Relaxed) > frames + 200);
    assert_eq!(early.request(b"still here").unwrap(), b"still here");
    let none = std::sync::atomic::AtomicBool::new(false);
    let error = Client::connect(&place, PATIENCE).unwrap_err();
    let full = |error: &TransportError| {
        matches!(
            error,
            TransportError::Domain(DomainError::SharedMemory { .. }) | TransportError::SharedMemory { .. }
        )
    };
    assert!(matches!(&error, ClientError::Transport(error) if full(error)), "{error}");
    assert!(error.to_string().contains("/dev/shm"), "{error}");
    drop(filler);

    // However little memory there is, each peer is served or told. If not, this process would be killed.
    let (mut served, mut told) = (0, 0);
    for step in 0..=40 {
        let filler = Filler::leaving(step * MIB / 8);
        match BodyLink::attach(&place, &counter_description(), &none) {
            Ok(link) => {
                link.detach();
                served += 1;
            }
            Err(error) => {
                assert!(full(&error), "{} KiB: {error}", step * 128);
                told += 1;
            }
        }
        match Client::connect(&place, PATIENCE) {
            Ok(mut client) => assert_eq!(client.request(b"served").unwrap(), b"served"),
            Err(ClientError::Transport(error)) => assert!(full(&error), "{} KiB: {error}", step * 128),
            Err(error) => panic!("{error}"),
        }
        drop(filler);
    }
    println!("{served} served, {told} told");
    assert!(served > 5 && told > 5);
    stop.store(true, Ordering::Relaxed);
    let summary = body.join().unwrap().unwrap();
    assert_eq!((summary.ending, summary.sessions, summary.refused), (RunEnding::Stopped, 1, 0));
    drop(early);
    daemon.stop();
    assert_eq!(std::fs::read_dir("/dev/shm").unwrap().count(), 0);
}
