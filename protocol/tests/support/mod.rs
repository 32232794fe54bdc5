//! A body, a daemon that orders by rote, and a private runtime directory, for tests over shared memory.
#![allow(dead_code, clippy::unwrap_used)] // Each test file uses its part; a test panics to fail.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use pschema_protocol::body::RunOptions;
use pschema_protocol::description::ActionId;
use pschema_protocol::domain::{LearnerName, OwnedDomain, Place, RuntimeDir};
use pschema_protocol::prelude::*;
use pschema_protocol::refusal::Refusal;
use pschema_protocol::transport::DaemonWaker;
use pschema_protocol::transport::body_link::BodyLink;
use pschema_protocol::transport::server::{Incoming, ServerTransport};
use pschema_protocol::wire::decode::{self, SessionChecks};
use pschema_protocol::wire::message::Reply;

/// Longest that anything in a test may take before the test fails.
pub(crate) const PATIENCE: Duration = Duration::from_secs(20);

/// A runtime directory of the test's own, removed at its end.
pub(crate) struct Runtime {
    directory: tempfile::TempDir,
}

impl Runtime {
    pub(crate) fn new() -> Self {
        // Below /tmp: sockets allow only short paths.
        Self { directory: tempfile::Builder::new().prefix("ps").tempdir_in("/tmp").unwrap() }
    }

    pub(crate) fn path(&self) -> PathBuf {
        self.directory.path().join("run")
    }

    pub(crate) fn place(&self, learner: &str) -> Place {
        Place::new(RuntimeDir::at(&self.path()).unwrap(), LearnerName::new(learner).unwrap())
    }
}

/// Files in shared memory of one epoch.
pub(crate) fn shared_files(prefix: &str) -> Vec<String> {
    let entries = std::fs::read_dir("/dev/shm").unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned());
    names.filter(|name| name.starts_with(prefix)).collect()
}

/// Waits until `done`, which something running beside makes come true.
pub(crate) fn until(what: &str, mut done: impl FnMut() -> bool) {
    let start = std::time::Instant::now();
    while !done() {
        assert!(start.elapsed() < PATIENCE, "waited {PATIENCE:?} for {what}");
        std::thread::yield_now();
    }
}

/// A body of one sense and one action. It senses how often it acted, and carries out every order.
pub(crate) struct Counter {
    pub(crate) acted: i64,
    /// Reports a value outside its limits in every frame divisible by this.
    pub(crate) wrong_every: Option<i64>,
    pub(crate) frames: i64,
    /// Orders carried out, for a test to watch from another thread.
    pub(crate) orders: Arc<AtomicU64>,
}

impl Counter {
    pub(crate) fn new() -> Self {
        Self { acted: 0, wrong_every: None, frames: 0, orders: Arc::default() }
    }
}

pub(crate) fn counter_description() -> Description {
    let mut description = Description::new("counter", "test");
    let count = ObservationType::state("count")
        .own()
        .property(Property::integer("number", 0..=1_000_000))
        .property(Property::real("half", 0.0..=500_000.0, 0.5));
    assert_eq!(description.observation(count), COUNT);
    let add = description.action(ActionType::new("add").parameter(Property::integer("amount", 1..=3)));
    assert_eq!(add, ADD);
    description.primitive(add, [1]);
    description.scene_command(ActionType::new("reset"));
    description
}

/// The sense and the action of a [`Counter`].
pub(crate) const COUNT: SenseId = SenseId::from_index(0);
pub(crate) const ADD: ActionId = ActionId::from_index(0);

impl Body for Counter {
    fn describe(&self) -> Description {
        counter_description()
    }

    fn sense(&mut self, frame: &mut Senses) {
        self.frames += 1;
        let wrong = self.wrong_every.is_some_and(|every| self.frames % every == 0);
        let number = if wrong { -1 } else { self.acted };
        frame.observe(COUNT, (number, self.acted as f64 / 2.0));
    }

    fn act(&mut self, action: &Action) -> Outcome {
        let [Value::Integer(amount)] = action.parameters[..] else { panic!("{action:?}") };
        self.acted += amount;
        self.orders.fetch_add(1, Ordering::Relaxed);
        Outcome::Done
    }

    fn arrange(&mut self, _: &Action) -> Outcome {
        self.acted = 0;
        Outcome::Done
    }
}

/// Counts of the messages that came to a test's daemon.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    pub(crate) prefix: String,
    pub(crate) sessions: Vec<u64>,
    pub(crate) frames: u64,
    pub(crate) reports: u64,
    pub(crate) last_count: i64,
    pub(crate) refused: Vec<Refusal>,
    /// Sessions closed, and whether by a farewell.
    pub(crate) gone: Vec<(u64, bool)>,
}

/// A daemon on a thread of its own, that orders the one action after every frame, detaches bodies after
/// `frames_max` frames, and answers requests with what `answer` makes of them.
pub(crate) struct Daemon {
    stop: Arc<AtomicBool>,
    waker: DaemonWaker,
    thread: Option<JoinHandle<Tally>>,
    pub(crate) prefix: String,
    pub(crate) frames: Arc<AtomicU64>,
    pub(crate) gone: Arc<AtomicU64>,
}

pub(crate) type Answer = fn(&[u8]) -> Vec<u8>;

impl Daemon {
    pub(crate) fn start(place: Place, frames_max: u64, answer: Answer) -> Self {
        let order = move |frames| {
            if frames >= frames_max {
                return Reply::Detach;
            }
            Reply::Act(Action::new(ADD, [1]))
        };
        Self::start_with(place, order, answer)
    }

    /// As [`Daemon::start`], with `order` choosing the reply to the frame of that number.
    pub(crate) fn start_with(
        place: Place,
        order: impl Fn(u64) -> Reply + Send + 'static,
        answer: Answer,
    ) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let frames = Arc::<AtomicU64>::default();
        let gone = Arc::<AtomicU64>::default();
        let (told, counted, left) = (stop.clone(), frames.clone(), gone.clone());
        let (ready, is_ready) = std::sync::mpsc::channel();
        let thread = std::thread::spawn(move || {
            let domain = OwnedDomain::create(place).unwrap();
            let mut transport = ServerTransport::create(domain).unwrap();
            let prefix = transport.domain().record().prefix.clone();
            ready.send((transport.waker().unwrap(), prefix.clone())).unwrap();
            let mut sessions = BTreeMap::new();
            let mut tally = Tally { prefix, ..Tally::default() };
            while !told.load(Ordering::Relaxed) {
                if transport.wait(Duration::from_millis(100)) {
                    transport
                        .poll(&mut |incoming| handle(incoming, &order, answer, &mut sessions, &mut tally));
                    counted.store(tally.frames, Ordering::Relaxed);
                    left.store(tally.gone.len() as u64, Ordering::Relaxed);
                }
            }
            tally
        });
        let (waker, prefix) = is_ready.recv_timeout(PATIENCE).unwrap();
        Self { stop, waker, thread: Some(thread), prefix, frames, gone }
    }

    /// Ends it cleanly.
    pub(crate) fn stop(mut self) -> Tally {
        self.end().unwrap().unwrap()
    }

    fn end(&mut self) -> Option<std::thread::Result<Tally>> {
        self.stop.store(true, Ordering::Relaxed);
        self.waker.wake();
        self.thread.take().map(JoinHandle::join)
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        // Also when the test fails, so that nothing of it stays in shared memory.
        self.end();
    }
}

fn handle(
    incoming: Incoming<'_>,
    order: &dyn Fn(u64) -> Reply,
    answer: Answer,
    sessions: &mut BTreeMap<u64, SessionChecks>,
    tally: &mut Tally,
) {
    match incoming {
        Incoming::Hello { hello, reply } => match decode::hello(&hello) {
            Ok(hello) => {
                // Numbers of other epochs must not be taken for this one's.
                let session = u64::from(std::process::id()) * 1000 + tally.sessions.len() as u64 + 1;
                reply.accept(session, "test").unwrap();
                sessions.insert(session, SessionChecks::new(session, hello.description));
                tally.sessions.push(session);
            }
            Err(refusal) => {
                reply.refuse(&refusal, "test").unwrap();
                tally.refused.push(refusal);
            }
        },
        Incoming::Frame { frame, reply } => {
            let session = sessions.get_mut(&reply.session()).unwrap();
            match session.check(frame) {
                Ok(frame) => {
                    tally.frames += 1;
                    tally.reports += u64::from(frame.report.is_some());
                    let values: Vec<_> = frame.observations.iter().flat_map(|one| one.values()).collect();
                    let [Value::Integer(count), Value::Real(half)] = values[..] else { panic!("{frame:?}") };
                    assert_eq!(count as f64 / 2.0, half);
                    tally.last_count = count;
                    let order = order(tally.frames);
                    session.replied(&order);
                    // The body may just have been killed by its test.
                    reply.send(&order).ok();
                }
                Err(refusal) => {
                    reply.refuse(&refusal).unwrap();
                    tally.refused.push(refusal);
                }
            }
        }
        Incoming::Refused { refusal, .. } => tally.refused.push(refusal),
        Incoming::Request { bytes, reply } => reply.answer(answer(&bytes)),
        Incoming::BodyGone { session, farewell } => {
            sessions.remove(&session);
            tally.gone.push((session, farewell));
        }
    }
}

pub(crate) fn echo(bytes: &[u8]) -> Vec<u8> {
    bytes.to_vec()
}

/// Answers a number, as text, with so many bytes.
pub(crate) fn as_many(bytes: &[u8]) -> Vec<u8> {
    let length: usize = std::str::from_utf8(bytes).unwrap().parse().unwrap();
    (0..length).map(|place| (place % 251) as u8).collect()
}

pub(crate) fn options(place: &Place) -> RunOptions {
    RunOptions::new(place.clone())
}

/// Nothing of an epoch is left, in shared memory or in the runtime directory.
pub(crate) fn assert_swept(runtime: &Path, prefix: &str) {
    assert_eq!(shared_files(prefix), Vec::<String>::new());
    let left: Vec<_> = std::fs::read_dir(runtime).unwrap().map(|one| one.unwrap().file_name()).collect();
    assert!(!left.iter().any(|name| name.to_string_lossy().contains(prefix)), "{left:?}");
}

/// A body that sends messages which a correct body never sends.
pub(crate) fn attach(place: &Place) -> BodyLink {
    BodyLink::attach(place, &counter_description(), &AtomicBool::new(false)).unwrap()
}
