//! Bodies, tools and a daemon over real shared memory, in threads and in processes of their own.
#![allow(clippy::unwrap_used)] // A test panics to fail.

mod support;

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use pschema_protocol::body::{BodyLoop, Directive, Ending, RunError, RunOptions, RunSummary, run};
use pschema_protocol::client::{Client, ClientError};
use pschema_protocol::domain::{DomainError, LearnerName, OwnedDomain, Place, RuntimeDir, examine};
use pschema_protocol::limits::{ANSWER_BYTES_MAX, BODIES_MAX, PAGE_BYTES, TOOLS_MAX};
use pschema_protocol::message::{RawFrame, Reply};
use pschema_protocol::refusal::Refusal;
use pschema_protocol::transport::TransportError;
use pschema_protocol::transport::body_link::BodyLink;
use pschema_protocol::transport::server::{Incoming, ServerTransport};
use pschema_protocol::wire::{FrameHeader, WireReply, purpose, reply};
use support::{Counter, Daemon, PATIENCE, Runtime, counter_description, shared_files, until};

fn echo(bytes: &[u8]) -> Vec<u8> {
    bytes.to_vec()
}

/// Answers a number, as text, with so many bytes.
fn as_many(bytes: &[u8]) -> Vec<u8> {
    let length: usize = std::str::from_utf8(bytes).unwrap().parse().unwrap();
    (0..length).map(|place| (place % 251) as u8).collect()
}

fn options(place: &Place) -> RunOptions {
    let stop = Arc::new(AtomicBool::new(false));
    RunOptions { place: place.clone(), exit_when_daemon_gone: false, stop }
}

/// Nothing of an epoch is left, in shared memory or in the runtime directory.
fn assert_swept(runtime: &Path, prefix: &str) {
    assert_eq!(shared_files(prefix), Vec::<String>::new());
    let left: Vec<_> = std::fs::read_dir(runtime).unwrap().map(|one| one.unwrap().file_name()).collect();
    assert!(!left.iter().any(|name| name.to_string_lossy().contains(prefix)), "{left:?}");
}

#[test]
fn a_thousand_frames_and_nothing_left() {
    let runtime = Runtime::new();
    let place = runtime.place("one");
    let daemon = Daemon::start(place.clone(), 1000, echo);
    let prefix = daemon.prefix.clone();
    assert!(!shared_files(&prefix).is_empty());
    let summary = run(Counter::new(), &options(&place)).unwrap();
    let seen = daemon.stop();
    let expected =
        RunSummary { ending: Ending::Detached, sessions: 1, frames: 1000, orders: 999, refused: 0 };
    assert_eq!(summary, expected);
    assert_eq!((seen.frames, seen.reports, seen.last_count), (1000, 999, 999));
    assert_swept(&runtime.path(), &prefix);
    assert!(matches!(place.served(), Err(DomainError::NotServed { .. })));
}

#[test]
fn a_refused_frame_says_why_and_the_session_goes_on() {
    let runtime = Runtime::new();
    let place = runtime.place("wrong");
    let daemon = Daemon::start(place.clone(), 40, echo);
    let body = Counter { wrong_every: Some(5), ..Counter::new() };
    let summary = run(body, &options(&place)).unwrap();
    let seen = daemon.stop();
    assert_eq!((summary.sessions, summary.frames, summary.refused), (1, 49, 9));
    // Every order is reported although the frames that first reported some were refused.
    assert_eq!((seen.frames, seen.reports, seen.last_count), (40, 39, 39));
    let sentence = "observation 0 (count): property number = -1 is outside 0..=1000000";
    assert!(seen.refused.iter().all(|refusal| refusal.to_string() == sentence), "{:?}", seen.refused);
}

#[test]
fn a_body_that_is_always_wrong_gives_up() {
    let runtime = Runtime::new();
    let daemon = Daemon::start(runtime.place("wrong"), 40, echo);
    let body = Counter { wrong_every: Some(1), ..Counter::new() };
    let error = run(body, &options(&runtime.place("wrong"))).unwrap_err();
    assert!(matches!(error, RunError::FramesRefused { count: 50, .. }), "{error}");
    assert_eq!(daemon.stop().frames, 0);
}

#[test]
fn a_body_goes_on_with_the_next_daemon() {
    let runtime = Runtime::new();
    let place = runtime.place("again");
    let first = Daemon::start(place.clone(), u64::MAX, echo);
    let options = options(&place);
    let stop = options.stop.clone();
    let body = std::thread::spawn(move || run(Counter::new(), &options));
    let mut daemon = first;
    for _ in 0..3 {
        until("frames", || daemon.frames.load(Ordering::Relaxed) > 100);
        let seen = daemon.stop();
        assert_eq!(seen.sessions.len(), 1, "{seen:?}");
        assert_swept(&runtime.path(), &seen.prefix);
        daemon = Daemon::start(place.clone(), u64::MAX, echo);
        assert_ne!(daemon.prefix, seen.prefix);
    }
    until("frames", || daemon.frames.load(Ordering::Relaxed) > 100);
    stop.store(true, Ordering::Relaxed);
    let summary = body.join().unwrap().unwrap();
    assert_eq!((summary.ending, summary.sessions), (Ending::Stopped, 4));
    until("the farewell", || daemon.gone.load(Ordering::Relaxed) == 1);
    let seen = daemon.stop();
    assert_eq!(seen.gone, [(seen.sessions[0], true)]);
    assert_swept(&runtime.path(), &seen.prefix);
}

#[test]
fn a_second_daemon_is_refused_and_learns_by_whom() {
    let runtime = Runtime::new();
    let daemon = Daemon::start(runtime.place("only"), 10, echo);
    let error = OwnedDomain::create(runtime.place("only")).unwrap_err();
    let me = std::process::id().to_string();
    assert!(matches!(&error, DomainError::AlreadyServed { pid, .. } if *pid == me), "{error}");
    // Another learner beside it is no matter.
    let other = Daemon::start(runtime.place("other"), 10, echo);
    assert_ne!(other.prefix, daemon.prefix);
    run(Counter::new(), &options(&runtime.place("only"))).unwrap();
    assert_eq!(daemon.stop().frames, 10);
    assert_eq!(other.stop().frames, 0);
}

#[test]
fn a_description_that_is_not_allowed_is_refused_before_anything_is_sent() {
    struct Wrong;
    impl pschema_protocol::body::Body for Wrong {
        fn describe(&self) -> pschema_protocol::description::Description {
            let mut description = counter_description();
            description.actions.push(description.actions[0].clone());
            description
        }
        fn sense(&mut self, _: &mut pschema_protocol::body::Senses) {}
        fn act(&mut self, _: &pschema_protocol::description::Action) -> pschema_protocol::body::Outcome {
            pschema_protocol::body::Outcome::Failed
        }
    }
    let runtime = Runtime::new();
    let error = run(Wrong, &options(&runtime.place("none"))).unwrap_err();
    assert!(matches!(error, RunError::Description(Refusal::DuplicateName { .. })), "{error}");
}

#[test]
fn tools_are_answered_in_one_page_or_many() {
    let runtime = Runtime::new();
    let place = runtime.place("ask");
    let daemon = Daemon::start(place.clone(), 0, as_many);
    let mut client = Client::connect(&place, PATIENCE).unwrap();
    for length in [0, 1, PAGE_BYTES - 1, PAGE_BYTES, PAGE_BYTES + 1, 40 * PAGE_BYTES + 7, ANSWER_BYTES_MAX] {
        let question = length.to_string();
        assert!(client.request(question.as_bytes()).unwrap() == as_many(question.as_bytes()), "{length}");
    }
    let error = client.request((ANSWER_BYTES_MAX + 1).to_string().as_bytes()).unwrap_err().to_string();
    assert!(error.contains("16777217 bytes"), "{error}");
    let error = client.request(&vec![0; PAGE_BYTES + 1]).unwrap_err();
    assert!(matches!(error, ClientError::Transport(TransportError::TooLong { .. })), "{error}");
    daemon.stop();
    let error = client.request(b"1").unwrap_err();
    assert!(error.is_no_daemon(), "{error}");
    let error = Client::connect(&place, PATIENCE).unwrap_err();
    assert!(error.is_no_daemon(), "{error}");
}

#[test]
fn values_are_asked_and_answered_by_type() {
    let runtime = Runtime::new();
    let daemon = Daemon::start(runtime.place("typed"), 0, echo);
    let mut client = Client::connect(&runtime.place("typed"), PATIENCE).unwrap();
    let question = (7_u32, "seven".to_owned(), vec![0.5_f64]);
    let answer: (u32, String, Vec<f64>) = client.ask(&question).unwrap();
    assert_eq!(answer, question);
    let error = client.ask::<_, u8>(&question).unwrap_err();
    assert!(matches!(error, ClientError::Codec(_)), "{error}");
    daemon.stop();
}

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

/// A body of its own making: sends what a correct one never would.
fn attach(place: &Place) -> BodyLink {
    BodyLink::attach(place, &counter_description(), &AtomicBool::new(false)).unwrap()
}

fn reply_to(link: &mut BodyLink, frame: &RawFrame) -> WireReply {
    link.exchange(frame, &AtomicBool::new(false)).unwrap()
}

#[test]
fn a_hostile_body_is_refused_each_time_and_disturbs_no_other() {
    let runtime = Runtime::new();
    let place = runtime.place("hostile");
    let daemon = Daemon::start(place.clone(), u64::MAX, echo);
    let options = options(&place);
    let stop = options.stop.clone();
    let good = std::thread::spawn(move || run(Counter::new(), &options));
    let mut link = attach(&place);
    let other = attach(&place);
    let mut body = BodyLoop::new(Counter::new());
    body.attached(link.session());
    let reply = reply_to(&mut link, body.next_frame());
    assert_eq!(body.obey(&reply).unwrap(), Directive::Continue);
    let good_frame = body.next_frame().clone();
    let seed: u64 = 0x5eed;
    println!("seed {seed:#x}");
    let mut state = seed;
    let mut random = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        state >> 16
    };
    for round in 0..500 {
        let mut frame = good_frame.clone();
        let value = random();
        match round % 8 {
            0 => frame.header.magic = value as u32,
            1 => frame.header.version = value as u32 | 2,
            2 => frame.header.session = other.session(),
            3 => frame.header.session = value,
            4 => frame.header.sequence = 1,
            5 => frame.header.sequence = value | 64,
            6 => frame.header = FrameHeader { purpose: purpose::DETACH, session: value, ..frame.header },
            _ => {
                frame.header.session = 0;
                frame.header.observation_count = u32::MAX;
            }
        }
        let reply = reply_to(&mut link, &frame);
        assert_eq!(reply.kind, reply::REFUSED, "round {round}: {frame:?}");
        assert_ne!(reply.code, 0);
    }
    // Its own good frame is still the next, and taken.
    assert_eq!(reply_to(&mut link, &good_frame).kind, reply::ACT);
    let frames = daemon.frames.load(Ordering::Relaxed);
    until("frames of the good body", || daemon.frames.load(Ordering::Relaxed) > frames + 100);
    stop.store(true, Ordering::Relaxed);
    assert_eq!(good.join().unwrap().unwrap().refused, 0);
    drop((link, other));
    assert_eq!(daemon.stop().refused.len(), 500);
}

#[test]
fn a_resting_body_rests_until_its_time_or_until_it_is_roused() {
    let runtime = Runtime::new();
    let place = runtime.place("rest");
    let order = |frames| if frames <= 5 { Reply::Wait { ms: 60 } } else { Reply::Detach };
    let daemon = Daemon::start_with(place.clone(), order, echo);
    let start = Instant::now();
    let summary = run(Counter::new(), &options(&place)).unwrap();
    assert!(start.elapsed() >= Duration::from_millis(5 * 60), "{:?}", start.elapsed());
    assert_eq!((summary.frames, summary.orders), (6, 0));
    daemon.stop();

    // Roused, it takes less than the ten seconds it was laid to rest for.
    let mut transport = ServerTransport::create(OwnedDomain::create(place.clone()).unwrap()).unwrap();
    let waker = transport.waker().unwrap();
    let stop = Arc::new(AtomicBool::new(false));
    let told = stop.clone();
    let body = std::thread::spawn(move || {
        let link = attach(&place);
        let start = Instant::now();
        link.rest(Duration::from_secs(10), &told);
        waker.wake();
        start.elapsed()
    });
    let mut welcomed = false;
    while !body.is_finished() {
        transport.wait(Duration::from_millis(10));
        transport.poll(&mut |incoming| {
            if let Incoming::Hello { reply, .. } = incoming {
                reply.accept(1, "rest").unwrap();
                welcomed = true;
            }
        });
        if welcomed {
            transport.rouse(1);
        }
    }
    assert!(body.join().unwrap() < Duration::from_secs(10));
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
    assert_eq!((summary.sessions, summary.ending), (2, Ending::Stopped));
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
    // Its last frame may still be under way.
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

#[test]
fn a_body_ends_with_its_daemon_when_it_shall() {
    let runtime = Runtime::new();
    let place = runtime.place("ends");
    let daemon = Daemon::start(place.clone(), u64::MAX, echo);
    let options = RunOptions { exit_when_daemon_gone: true, ..options(&place) };
    let body = std::thread::spawn(move || run(Counter::new(), &options));
    until("frames", || daemon.frames.load(Ordering::Relaxed) > 10);
    daemon.stop();
    assert_eq!(body.join().unwrap().unwrap().ending, Ending::DaemonGone);
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
    assert_eq!(body.join().unwrap().unwrap().ending, Ending::Stopped);
    let last = daemon.stop().prefix;
    for prefix in prefixes.iter().chain([&last]) {
        assert_swept(&runtime.path(), prefix);
    }
}
