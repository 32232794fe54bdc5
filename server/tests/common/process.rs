//! A daemon as a process of its own, and a body beside it that counts its orders.
#![allow(dead_code, reason = "each test file uses a part of it")]

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use pschema_inspect::{Status, StatusQuery};
use pschema_learner::memory::Memory;
use pschema_protocol::body::{Body, Outcome, RunOptions, Senses};
use pschema_protocol::client::Client;
use pschema_protocol::description::{Action, Description};
use pschema_protocol::domain::{LearnerName, OwnedDomain, Place, RuntimeDir};
use pschema_server::{Setup, config};
use pschema_store::Options;

use super::Row;

/// The longest that any wait of these tests may take; a machine under load takes its time.
pub(crate) const PATIENCE: Duration = Duration::from_secs(60);
pub(crate) const BLOCK: i64 = 5;

/// A [`Row`] that counts its orders: each order is a step that was acknowledged.
pub(crate) struct CountingBody(Row, Arc<AtomicU64>);

impl Body for CountingBody {
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

pub(crate) struct BodyThread {
    acts: Arc<AtomicU64>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl BodyThread {
    pub(crate) fn start(place: &Place) -> Self {
        let (acts, stop) = (Arc::new(AtomicU64::new(0)), Arc::new(AtomicBool::new(false)));
        let options = RunOptions::new(place.clone()).stop(stop.clone());
        let body = CountingBody(Row::with_block("row", BLOCK), acts.clone());
        let run = move || pschema_protocol::body::run(body, &options).map(|_| ()).unwrap();
        let thread = std::thread::spawn(run);
        Self { acts, stop, thread: Some(thread) }
    }

    pub(crate) fn acts(&self) -> u64 {
        self.acts.load(Ordering::SeqCst)
    }

    /// Waits until the body has had so many orders.
    pub(crate) fn past(&self, acts: u64) {
        let start = Instant::now();
        while self.acts() < acts {
            assert!(start.elapsed() < PATIENCE, "only {} orders came", self.acts());
            std::thread::yield_now();
        }
    }
}

impl Drop for BodyThread {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::SeqCst);
        if let Some(thread) = self.thread.take() {
            thread.join().unwrap();
        }
    }
}

/// A daemon's process; dropped, it is killed.
pub(crate) struct Daemon(pub(crate) Child, Option<JoinHandle<String>>);

impl Daemon {
    pub(crate) fn start(directory: &Path, arguments: &[&str]) -> Self {
        let child = Command::new(env!("CARGO_BIN_EXE_pschema-server"))
            .args(arguments)
            .env("PSCHEMA_RUNTIME_DIR", directory.join("run"))
            .env_remove("RUST_LOG")
            .stderr(Stdio::piped())
            .spawn();
        Self(child.unwrap(), None)
    }

    /// Waits until the daemon is ready, and goes on reading its log.
    pub(crate) fn ready(&mut self) {
        let mut log = BufReader::new(self.0.stderr.take().unwrap());
        let mut said = String::new();
        while !said.lines().last().unwrap_or_default().contains("ready") {
            assert!(log.read_line(&mut said).unwrap() > 0, "the daemon ended before it was ready: {said}");
        }
        let rest = move || log.read_to_string(&mut said).map(|_| said).unwrap();
        self.1 = Some(std::thread::spawn(rest));
    }

    /// Whether the daemon has said by now that it is ready.
    pub(crate) fn said_ready(&mut self) -> bool {
        let mut log = self.0.stderr.take().unwrap();
        let flags = rustix::fs::fcntl_getfl(&log).unwrap();
        rustix::fs::fcntl_setfl(&log, flags | rustix::fs::OFlags::NONBLOCK).unwrap();
        let mut said = Vec::new();
        // Ends with "would block" when all that was said is read.
        drop(log.read_to_end(&mut said));
        String::from_utf8_lossy(&said).contains("ready")
    }

    pub(crate) fn kill(mut self) {
        self.0.kill().unwrap();
        self.0.wait().unwrap();
    }

    /// The exit code of the daemon, which ends by itself, and its whole log.
    pub(crate) fn ended(mut self) -> (Option<i32>, String) {
        let said = match self.1.take() {
            Some(rest) => rest.join().unwrap(),
            None => {
                let mut said = String::new();
                self.0.stderr.take().unwrap().read_to_string(&mut said).unwrap();
                said
            }
        };
        (self.0.wait().unwrap().code(), said)
    }

    /// The log of a daemon that ends by itself because it can't go on.
    pub(crate) fn failed(self) -> String {
        let (code, said) = self.ended();
        assert_eq!(code, Some(1), "{said}");
        said
    }

    /// The daemon's process id.
    pub(crate) fn pid(&self) -> rustix::process::Pid {
        rustix::process::Pid::from_child(&self.0)
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        // Fails only for a process that has ended.
        drop(self.0.kill());
        drop(self.0.wait());
    }
}

pub(crate) fn place(directory: &Path) -> Place {
    Place::new(RuntimeDir::at(&directory.join("run")).unwrap(), LearnerName::new("one").unwrap())
}

/// A directory for a daemon, its data and its domain. What killed daemons left in shared memory goes with it.
pub(crate) struct Home(tempfile::TempDir);

impl Home {
    pub(crate) fn path(&self) -> &Path {
        self.0.path()
    }
}

impl Drop for Home {
    fn drop(&mut self) {
        // Taking the domain sweeps the files of the epochs before. While a test fails the domain may still be in use.
        if self.path().join("run").is_dir() {
            drop(OwnedDomain::create(place(self.path())));
        }
    }
}

pub(crate) fn directory() -> Home {
    Home(tempfile::Builder::new().prefix("ps").tempdir_in("/tmp").unwrap())
}

pub(crate) fn setup(seed: u64) -> Setup {
    let (curriculum, learner) = config::lesson("free", Default::default(), &[]).unwrap();
    Setup { seed, learner, curriculum }
}

/// Memory as the disk has it.
pub(crate) fn recovered(data: &Path, seed: u64) -> Memory {
    let Setup { seed, learner, curriculum } = setup(seed);
    let options = Options::new("one", seed, &learner.parameters, &curriculum);
    let options = Options { mechanisms: learner.mechanisms, ..options };
    pschema_store::open(data, options, || ()).unwrap().learner.into_memory()
}

pub(crate) fn status(place: &Place) -> Status {
    let mut client = Client::connect(place, PATIENCE).unwrap();
    super::ask(&mut client, StatusQuery {}).unwrap()
}

pub(crate) fn served(directory: &Path, data: &str, seed: u64, more: &[&str]) -> Daemon {
    let seed = seed.to_string();
    let arguments = [&["--name", "one", "--seed", &seed, "--data", data], more].concat();
    Daemon::start(directory, &arguments)
}
