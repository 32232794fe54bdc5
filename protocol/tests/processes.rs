//! Bodies, tools and daemons in processes of their own, stopped and killed.
#![allow(clippy::unwrap_used)] // A test panics to fail.

mod support;

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use pschema_protocol::body::{RunEnding, run};
use pschema_protocol::client::Client;
use pschema_protocol::domain::{LearnerName, Place, RuntimeDir, examine};
use pschema_protocol::limits::BODIES_MAX;
use pschema_protocol::transport::body_link::BodyLink;
use support::{
    Counter, Daemon, PATIENCE, Runtime, as_many, assert_swept, counter_description, echo, options,
    shared_files, until,
};

/// Runs this test program again as another process, with one of the ignored tests below as its part.
struct Process(Child);

impl Process {
    fn spawn(part: &str, place: &Place) -> Self {
        let mut command = Command::new(std::env::current_exe().unwrap());
        command.args([part, "--exact", "--ignored", "--nocapture"]);
        command.env("PSCHEMA_TEST_RUNTIME", place.runtime().path());
        command.env("PSCHEMA_TEST_LEARNER", place.learner().as_str());
        Self(command.stdout(Stdio::piped()).spawn().unwrap())
    }

    /// As [`Process::spawn`], and waits until its part says that it is ready.
    fn start(part: &str, place: &Place) -> Self {
        let mut process = Self::spawn(part, place);
        let lines = BufReader::new(process.0.stdout.take().unwrap()).lines();
        assert!(lines.map(Result::unwrap).any(|line| line.ends_with("ready")), "{part} never was ready");
        process
    }

    fn signal(&self, name: &str) {
        let pid = self.0.id().to_string();
        assert!(Command::new("kill").args([format!("-{name}"), pid]).status().unwrap().success());
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        self.0.kill().unwrap();
        self.0.wait().unwrap();
    }
}

/// The place given to a part; none when someone runs the parts by hand.
fn given_place() -> Option<Place> {
    let runtime = std::env::var_os("PSCHEMA_TEST_RUNTIME")?;
    let learner = std::env::var("PSCHEMA_TEST_LEARNER").unwrap();
    let runtime = RuntimeDir::at(Path::new(&runtime)).unwrap();
    Some(Place::new(runtime, LearnerName::new(&learner).unwrap()))
}

#[test]
#[ignore = "a part of other tests, in a process of its own"]
fn part_body() {
    let Some(place) = given_place() else { return };
    println!("ready");
    run(Counter::new(), &options(&place)).unwrap();
}

#[test]
#[ignore = "a part of other tests, in a process of its own"]
fn part_tool() {
    let Some(place) = given_place() else { return };
    let mut client = Client::connect(&place, PATIENCE).unwrap();
    println!("ready");
    loop {
        client.request(b"4000000").unwrap();
    }
}

#[test]
#[ignore = "a part of other tests, in a process of its own"]
fn part_daemon() {
    let Some(place) = given_place() else { return };
    let _daemon = Daemon::start(place, u64::MAX, echo);
    println!("ready");
    loop {
        std::thread::park();
    }
}

#[test]
fn killed_bodies_are_noticed_and_leave_nothing() {
    let runtime = Runtime::new();
    let place = runtime.place("kill");
    let daemon = Daemon::start(place.clone(), u64::MAX, echo);
    let before = shared_files(&daemon.prefix).len();
    for round in 1..=10 {
        let frames = daemon.frames.load(Ordering::Relaxed);
        let body = Process::start("part_body", &place);
        until("frames", || daemon.frames.load(Ordering::Relaxed) > frames + 50);
        drop(body);
        until("the body to be missed", || daemon.gone.load(Ordering::Relaxed) == round);
    }
    until("its files to be removed", || shared_files(&daemon.prefix).len() <= before);
    let seen = daemon.stop();
    assert_eq!((seen.sessions.len(), seen.gone.len()), (10, 10));
    assert!(seen.gone.iter().all(|(_, farewell)| !farewell), "{:?}", seen.gone);
    assert_swept(&runtime.path(), &seen.prefix);
}

#[test]
fn a_killed_daemon_is_replaced_and_swept_and_its_body_goes_on() {
    let runtime = Runtime::new();
    let place = runtime.place("killd");
    let first = Process::start("part_daemon", &place);
    let prefix = place.served().unwrap().prefix;
    let options = options(&place);
    let stop = options.stop.clone();
    let counter = Counter::new();
    let orders = counter.orders.clone();
    let body = std::thread::spawn(move || run(counter, &options));
    until("orders", || orders.load(Ordering::Relaxed) > 50);
    let mut client = Client::connect(&place, PATIENCE).unwrap();
    assert_eq!(client.request(b"alive").unwrap(), b"alive");
    // Exact even while the dead process is not reaped.
    first.signal("KILL");
    until("the lock to come free", || !place.is_served());
    assert!(client.request(b"dead").unwrap_err().is_no_daemon());
    let facts = examine(place.runtime()).unwrap();
    let stale = facts.stale.iter().find(|stale| stale.prefix == prefix).unwrap();
    assert_eq!(stale.learner.as_deref(), Some("killd"));
    assert!(stale.files > 0 && stale.bytes > 0, "{stale:?}");
    let second = Daemon::start(place.clone(), u64::MAX, echo);
    assert_swept(&runtime.path(), &prefix);
    until("frames", || second.frames.load(Ordering::Relaxed) > 100);
    stop.store(true, Ordering::Relaxed);
    let summary = body.join().unwrap().unwrap();
    assert_eq!((summary.sessions, summary.ending), (2, RunEnding::Stopped));
    let prefix = second.prefix.clone();
    second.stop();
    assert_swept(&runtime.path(), &prefix);
}

#[test]
fn stopped_peers_do_not_keep_the_daemon_from_others() {
    let runtime = Runtime::new();
    let place = runtime.place("stopped");
    let daemon = Daemon::start(place.clone(), u64::MAX, as_many);
    // Stopped when it is known to have attached: its part is ready before that.
    let stopped = Process::start("part_body", &place);
    until("frames of the first body", || daemon.frames.load(Ordering::Relaxed) > 0);
    let mut tools = Vec::new();
    for _ in 0..3 {
        let tool = Process::start("part_tool", &place);
        tool.signal("STOP");
        tools.push(tool);
    }
    stopped.signal("STOP");
    // The last frame of the body may still be under way.
    let frames = daemon.frames.load(Ordering::Relaxed) + 1;
    let working = Process::start("part_body", &place);
    until("frames of the other body", || daemon.frames.load(Ordering::Relaxed) > frames + 200);
    let mut client = Client::connect(&place, PATIENCE).unwrap();
    assert!(client.request(b"1000000").unwrap() == as_many(b"1000000"));
    drop(tools);
    drop((stopped, working));
    until("the bodies to be missed", || daemon.gone.load(Ordering::Relaxed) == 2);
    let seen = daemon.stop();
    assert_swept(&runtime.path(), &seen.prefix);
}

/// Numbers from a seed, for the instants at which processes are killed.
struct Instants(u64);

impl Instants {
    fn new(seed: u64) -> Self {
        println!("seed {seed:#x}");
        Self(seed)
    }

    /// Lets up to `most` pass.
    fn pass(&mut self, most: Duration) {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        std::thread::sleep(most.mul_f64((self.0 >> 40) as f64 / (1 << 24) as f64));
    }
}

#[test]
fn bodies_killed_at_any_instant_take_no_places_with_them() {
    let runtime = Runtime::new();
    let place = runtime.place("storm");
    let daemon = Daemon::start(place.clone(), u64::MAX, echo);
    let mut instants = Instants::new(0xb0d1e5);
    for _ in 0..24 {
        let body = Process::spawn("part_body", &place);
        instants.pass(Duration::from_millis(40));
        drop(body);
    }
    let description = counter_description();
    let none = AtomicBool::new(false);
    let mut links = Vec::new();
    let (mut last, begun) = (String::new(), Instant::now());
    until("all places to be free", || {
        match BodyLink::attach(&place, &description, &none) {
            Ok(link) => links.push(link),
            Err(error) => last = error.to_string(),
        }
        assert!(begun.elapsed() < PATIENCE, "{} attached, then: {last}", links.len());
        links.len() == BODIES_MAX
    });
    let mut client = Client::connect(&place, PATIENCE).unwrap();
    assert_eq!(client.request(b"well").unwrap(), b"well");
    drop(links);
    let seen = daemon.stop();
    assert!(seen.refused.is_empty(), "{:?}", seen.refused);
    assert_swept(&runtime.path(), &seen.prefix);
}

#[test]
fn a_daemon_killed_at_any_instant_can_be_started_again() {
    let runtime = Runtime::new();
    let place = runtime.place("storm");
    let options = options(&place);
    let stop = options.stop.clone();
    let body = std::thread::spawn(move || run(Counter::new(), &options));
    let mut instants = Instants::new(0xdae3);
    let mut prefixes = std::collections::BTreeSet::new();
    for _ in 0..16 {
        let daemon = Process::spawn("part_daemon", &place);
        instants.pass(Duration::from_millis(60));
        // Of one that is not ready yet as well.
        let record = std::fs::read_to_string(runtime.path().join("storm/domain")).unwrap_or_default();
        prefixes.extend(record.lines().find_map(|line| line.strip_prefix("prefix = ").map(str::to_owned)));
        drop(daemon);
    }
    let daemon = Daemon::start(place, u64::MAX, echo);
    until("frames", || daemon.frames.load(Ordering::Relaxed) > 10);
    stop.store(true, Ordering::Relaxed);
    assert_eq!(body.join().unwrap().unwrap().ending, RunEnding::Stopped);
    let last = daemon.stop().prefix;
    for prefix in prefixes.iter().chain([&last]) {
        assert_swept(&runtime.path(), prefix);
    }
}
