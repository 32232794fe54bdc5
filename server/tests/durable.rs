//! The daemon with a data directory: killed at any instant, it comes back with everything that a body acted on.

#![allow(clippy::unwrap_used)] // A test panics to fail.

mod common;

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use common::Row;
use pschema_learner::digest::digest;
use pschema_learner::memory::Memory;
use pschema_learner::parameters::Parameters;
use pschema_learner::random::Random;
use pschema_protocol::body::{Body, Outcome, RunOptions, Senses};
use pschema_protocol::client::Client;
use pschema_protocol::description::{Action, Description};
use pschema_protocol::domain::{LearnerName, Place, RuntimeDir};
use pschema_protocol::inspect::{Answer, Request, Status};
use pschema_server::in_process::InProcess;
use pschema_server::{Setup, config};
use pschema_store::{Durability, Origin};

/// What any wait of these tests may take; a machine under load takes its time.
const PATIENCE: Duration = Duration::from_secs(60);
const BLOCK: i64 = 5;

/// A [`Row`] that counts what it was told to do: each order is a step that was acknowledged.
struct Counted(Row, Arc<AtomicU64>);

impl Body for Counted {
    fn describe(&self) -> Description {
        self.0.describe()
    }
    fn sense(&mut self, frame: &mut Senses) {
        self.0.sense(frame);
    }
    fn act(&mut self, action: &Action) -> Outcome {
        self.1.fetch_add(1, Ordering::SeqCst);
        self.0.act(action)
    }
    fn arrange(&mut self, command: &Action) -> Outcome {
        self.0.arrange(command)
    }
}

struct Running {
    acts: Arc<AtomicU64>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Running {
    fn start(place: &Place) -> Self {
        let (acts, stop) = (Arc::new(AtomicU64::new(0)), Arc::new(AtomicBool::new(false)));
        let options = RunOptions { place: place.clone(), exit_when_daemon_gone: false, stop: stop.clone() };
        let body = Counted(Row::with_block("row", BLOCK), acts.clone());
        let run = move || pschema_protocol::body::run(body, &options).map(|_| ()).unwrap();
        let thread = std::thread::spawn(run);
        Self { acts, stop, thread: Some(thread) }
    }

    fn acts(&self) -> u64 {
        self.acts.load(Ordering::SeqCst)
    }

    /// Waits until it was told to do so much.
    fn past(&self, acts: u64) {
        let start = Instant::now();
        while self.acts() < acts {
            assert!(start.elapsed() < PATIENCE, "only {} orders came", self.acts());
            std::thread::yield_now();
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::SeqCst);
        if let Some(thread) = self.thread.take() {
            thread.join().unwrap();
        }
    }
}

/// A daemon's process; dropped, it is killed.
struct Daemon(Child);

impl Daemon {
    fn start(directory: &Path, arguments: &[&str]) -> Self {
        let child = Command::new(env!("CARGO_BIN_EXE_pschema-server"))
            .args(arguments)
            .env("PSCHEMA_RUNTIME_DIR", directory.join("run"))
            .env_remove("RUST_LOG")
            .stderr(Stdio::piped())
            .spawn();
        Self(child.unwrap())
    }

    /// Waits until it is ready, and goes on reading what it says.
    fn ready(&mut self) {
        let mut log = BufReader::new(self.0.stderr.take().unwrap());
        let mut said = String::new();
        while !said.lines().last().unwrap_or_default().contains("ready") {
            assert!(log.read_line(&mut said).unwrap() > 0, "the daemon ended before it was ready: {said}");
        }
        std::thread::spawn(move || log.read_to_string(&mut said).map(drop));
    }

    fn kill(mut self) {
        self.0.kill().unwrap();
        self.0.wait().unwrap();
    }

    /// What it says when it ends by itself.
    fn failed(mut self) -> String {
        let mut said = String::new();
        self.0.stderr.take().unwrap().read_to_string(&mut said).unwrap();
        assert_eq!(self.0.wait().unwrap().code(), Some(1), "{said}");
        said
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        // Fails only for a process that has ended.
        drop(self.0.kill());
        drop(self.0.wait());
    }
}

fn place(directory: &Path) -> Place {
    Place::new(RuntimeDir::at(&directory.join("run")).unwrap(), LearnerName::new("one").unwrap())
}

fn directory() -> tempfile::TempDir {
    tempfile::Builder::new().prefix("ps").tempdir_in("/tmp").unwrap()
}

fn setup(seed: u64) -> Setup {
    let (curriculum, parameters) = config::lesson("free", Parameters::default(), &[]).unwrap();
    Setup { seed, parameters, curriculum }
}

/// Memory as the disk has it.
fn recovered(data: &Path, seed: u64) -> Memory {
    let Setup { seed, parameters, curriculum } = setup(seed);
    let origin = Origin { learner: "one", seed, parameters: &parameters, curriculum: &curriculum };
    pschema_store::open(data, origin, Durability::Strict, || ()).unwrap().0
}

fn status(place: &Place) -> Status {
    let mut client = Client::connect(place, PATIENCE).unwrap();
    match client.ask(&Request::Status).unwrap() {
        Answer::Status(status) => *status,
        other => panic!("{other:?}"),
    }
}

fn served(directory: &Path, data: &str, seed: u64, more: &[&str]) -> Daemon {
    let seed = seed.to_string();
    let arguments = [&["--name", "one", "--seed", &seed, "--data", data], more].concat();
    Daemon::start(directory, &arguments)
}

#[test]
fn killed_at_any_instant_it_remembers_what_an_uninterrupted_run_does() {
    let mut random = Random::from_seed(2011);
    for seed in 0..20 {
        let directory = directory();
        let data = directory.path().join("data");
        let mut daemon = served(directory.path(), data.to_str().unwrap(), seed, &[]);
        daemon.ready();
        let body = Running::start(&place(directory.path()));
        body.past(1 + random.below(300) as u64);
        daemon.kill();
        let acknowledged = body.acts();
        drop(body);
        let memory = recovered(&data, seed);
        let step = memory.content().step;
        assert!(step >= acknowledged, "seed {seed}: {step} of {acknowledged} steps");
        assert!(step <= acknowledged + 1, "seed {seed}: {step} steps, {acknowledged} acted on");
        let mut uninterrupted = InProcess::new(Row::with_block("row", BLOCK), setup(seed)).unwrap();
        while uninterrupted.learner().memory().content().step < step {
            uninterrupted.advance().unwrap();
        }
        assert_eq!(
            digest(memory.content()),
            digest(uninterrupted.learner().memory().content()),
            "seed {seed}, step {step}"
        );
    }
}

#[test]
fn one_memory_outlives_many_daemons_and_says_so() {
    let directory = directory();
    let place = place(directory.path());
    let data = directory.path().join("data");
    let data = data.to_str().unwrap();
    let body = Running::start(&place);
    let mut random = Random::from_seed(3);
    for life in 0..6 {
        let acknowledged = body.acts();
        let mut daemon = served(directory.path(), data, 7, &[]);
        daemon.ready();
        let now = status(&place);
        let storage = now.storage.clone().unwrap();
        assert!(now.step >= acknowledged && now.durable_step >= Some(acknowledged), "life {life}: {now:?}");
        assert_eq!((storage.durability.as_str(), storage.directory.ends_with("data")), ("strict", true));
        body.past(acknowledged + 1 + random.below(200) as u64);
        let later = status(&place).storage.unwrap();
        assert!(later.journal_bytes > storage.journal_bytes);
        daemon.kill();
    }
}

#[test]
fn what_stands_in_the_way_of_keeping_memory_is_told() {
    let directory = directory();
    let data = directory.path().join("data");
    let data = data.to_str().unwrap();
    let mut first = served(directory.path(), data, 1, &["--durability", "relaxed"]);
    first.ready();
    assert_eq!(status(&place(directory.path())).storage.unwrap().durability, "relaxed");
    let second = Daemon::start(directory.path(), &["--name", "two", "--data", data]).failed();
    let holder = format!("in use by learner one, process {}", first.0.id());
    assert!(second.contains(&holder), "{second}");
    first.kill();

    let other_seed = served(directory.path(), data, 2, &[]).failed();
    assert!(other_seed.contains("begun with seed = 1, and 2 was given"), "{other_seed}");
    let file = directory.path().join("file");
    std::fs::write(&file, "").unwrap();
    let nowhere = served(directory.path(), file.join("data").to_str().unwrap(), 1, &[]).failed();
    assert!(nowhere.contains("cannot create") && nowhere.contains("file/data"), "{nowhere}");
    let journal = Path::new(data).join("journal");
    std::fs::remove_dir_all(&journal).unwrap();
    std::fs::write(&journal, "").unwrap();
    let unreadable = served(directory.path(), data, 1, &[]).failed();
    assert!(unreadable.contains("cannot read") && unreadable.contains("data/journal"), "{unreadable}");
}
