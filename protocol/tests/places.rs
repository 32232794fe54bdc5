//! Where daemon, bodies and tools meet: files, room in shared memory, places for peers.
#![allow(clippy::unwrap_used)] // A test panics to fail.

mod support;

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use pschema_protocol::body::run;
use pschema_protocol::client::{Client, ClientError};
use pschema_protocol::domain::{LearnerName, Place, RuntimeDir};
use pschema_protocol::limits::{BODIES_MAX, TOOLS_MAX};
use pschema_protocol::transport::TransportError;
use support::{
    Counter, Daemon, PATIENCE, Runtime, assert_swept, attach, counter_description, echo, options,
    shared_files, until,
};

#[test]
fn places_are_limited_and_come_free() {
    let runtime = Runtime::new();
    let place = runtime.place("full");
    let daemon = Daemon::start(place.clone(), 0, echo);
    let mut clients: Vec<_> = (0..TOOLS_MAX).map(|_| Client::connect(&place, PATIENCE).unwrap()).collect();
    let error = Client::connect(&place, Duration::ZERO).unwrap_err();
    assert!(matches!(error, ClientError::Transport(TransportError::Full { .. })), "{error}");
    clients.pop();
    clients.push(Client::connect(&place, PATIENCE).unwrap());
    for client in &mut clients {
        assert_eq!(client.request(b"here").unwrap(), b"here");
    }
    let none = AtomicBool::new(false);
    let description = counter_description();
    let attach = || pschema_protocol::transport::body_link::BodyLink::attach(&place, &description, &none);
    let bodies: Vec<_> = (0..BODIES_MAX).map(|_| attach().unwrap()).collect();
    let error = attach().unwrap_err();
    assert!(matches!(error, TransportError::Full { limit: BODIES_MAX, .. }), "{error}");
    drop(bodies);
    attach().unwrap();
    until("bodies gone", || daemon.gone.load(Ordering::Relaxed) == BODIES_MAX as u64 + 1);
    daemon.stop();
}

#[test]
fn what_no_record_names_is_swept_and_the_living_are_left_alone() {
    let runtime = Runtime::new();
    let living = Daemon::start(runtime.place("living"), 10, echo);
    // Not of this runtime directory, as far as anyone knows, but for its root.
    let prefix = format!("ps{:010x}-", u64::from(std::process::id()));
    let root = runtime.path().join(format!(".{prefix}"));
    std::fs::create_dir_all(root.join("nodes")).unwrap();
    std::fs::write(format!("/dev/shm/{prefix}left"), "over").unwrap();
    let other = Daemon::start(runtime.place("other"), 10, echo);
    assert_swept(&runtime.path(), &prefix);
    for (name, daemon) in [("living", living), ("other", other)] {
        assert_eq!(run(Counter::new(), &options(&runtime.place(name))).unwrap().frames, 10);
        daemon.stop();
    }
}

#[test]
fn the_longest_runtime_path_allowed_is_short_enough_for_sockets() {
    let parent = tempfile::Builder::new().prefix("ps").tempdir_in("/tmp").unwrap();
    let mut path = parent.path().to_owned();
    path.push("x".repeat(33 - path.as_os_str().len() - 1));
    assert_eq!(path.as_os_str().len(), 33);
    let learner = LearnerName::new(&"n".repeat(32)).unwrap();
    let place = Place::new(RuntimeDir::at(&path).unwrap(), learner);
    let daemon = Daemon::start(place.clone(), 10, echo);
    assert_eq!(run(Counter::new(), &options(&place)).unwrap().frames, 10);
    daemon.stop();
}

#[test]
fn shared_memory_is_reserved_before_it_is_used() {
    use std::os::unix::fs::MetadataExt;
    let runtime = Runtime::new();
    let place = runtime.place("space");
    let daemon = Daemon::start(place.clone(), 10, echo);
    let _link = attach(&place);
    let _client = Client::connect(&place, PATIENCE).unwrap();
    let mut segments = 0;
    let mut total = 0;
    for name in shared_files(&daemon.prefix) {
        let Ok(found) = std::fs::metadata(format!("/dev/shm/{name}")) else { continue };
        total += found.size();
        if name.ends_with(".data") {
            segments += 1;
            assert!(
                found.blocks() * 512 >= found.size(),
                "{name}: {} of {} bytes",
                found.blocks() * 512,
                found.size()
            );
        }
    }
    // Three of the daemon, one of the body, one of the tool; that of the hello is gone again.
    assert_eq!(segments, 5);
    println!("{total} bytes of shared memory");
    drop(_link);
    daemon.stop();
}
