//! The daemon over shared memory: bodies attach, learn and die, tools ask and order, and nothing is left
//! behind. Each test has a runtime directory and a learner of its own.

#![allow(clippy::unwrap_used)] // A test panics to fail.

mod common;

use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use common::{Row, ask, curriculum, free, problem, setup};
use pschema_inspect::codec::{self, Reply};
use pschema_inspect::{
    Ask, AskError, BodyState, DetailQuery, Live, LiveQuery, Report, ReportQuery, SayOrder, SchemaQuery,
    ShutdownOrder, StageOrder, StageState, Status, StatusQuery,
};
use pschema_protocol::body::{RunEnding, RunError, RunOptions, RunSummary};
use pschema_protocol::client::Client;
use pschema_protocol::domain::{LearnerName, Place, RuntimeDir};
use pschema_server::in_process::run_in_process;
use pschema_server::{ServerError, Setup, serve};

/// The longest that any wait of these tests may take; a machine under load takes its time.
const PATIENCE: Duration = Duration::from_secs(60);

struct Daemon {
    place: Place,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<Result<(), ServerError>>>,
    directory: tempfile::TempDir,
}

impl Daemon {
    fn start(setup: Setup) -> Self {
        let directory = tempfile::Builder::new().prefix("ps").tempdir_in("/tmp").unwrap();
        let place = Place::new(
            RuntimeDir::at(&directory.path().join("run")).unwrap(),
            LearnerName::new("test").unwrap(),
        );
        let stop = Arc::new(AtomicBool::new(false));
        let thread = {
            let (place, stop) = (place.clone(), stop.clone());
            std::thread::spawn(move || serve(place, setup, &stop))
        };
        Self { place, stop, thread: Some(thread), directory }
    }

    /// A tool, once the daemon answers.
    fn client(&mut self) -> Client {
        let start = Instant::now();
        loop {
            let tried = Client::connect(&self.place, PATIENCE).map_err(AskError::Send);
            match tried.and_then(|mut client| ask(&mut client, ReportQuery {}).map(|_| client)) {
                Ok(client) => return client,
                Err(AskError::Send(error)) if error.is_no_daemon() && start.elapsed() < PATIENCE => {
                    std::thread::yield_now();
                }
                Err(error) => panic!("{error}"),
            }
            if self.thread.as_ref().is_some_and(JoinHandle::is_finished) {
                panic!("the daemon ended: {:?}", self.thread.take().unwrap().join());
            }
        }
    }

    /// Ends the daemon by its flag, as a signal would, and checks that it leaves nothing.
    fn end(mut self) {
        let prefix = self.place.served().map(|record| record.prefix);
        self.stop.store(true, Ordering::Relaxed);
        self.thread.take().unwrap().join().unwrap().unwrap();
        assert!(!self.place.is_served());
        if let Ok(prefix) = prefix {
            let left = std::fs::read_dir("/dev/shm").unwrap().filter_map(Result::ok);
            let left: Vec<_> =
                left.filter(|file| file.file_name().to_string_lossy().starts_with(&prefix)).collect();
            assert!(left.is_empty(), "{left:?}");
        }
        let domain = self.directory.path().join("run/test/domain");
        assert!(!domain.exists(), "{domain:?} is left");
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            drop(thread.join());
        }
    }
}

/// A body in a thread.
struct BodyThread {
    stop: Arc<AtomicBool>,
    thread: JoinHandle<Result<RunSummary, RunError>>,
}

impl BodyThread {
    fn start(place: &Place, body: Row) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let options = RunOptions::new(place.clone()).exit_when_daemon_gone(true).stop(stop.clone());
        Self { stop, thread: std::thread::spawn(move || pschema_protocol::body::run(body, &options)) }
    }

    fn join(self) -> RunSummary {
        self.thread.join().unwrap().unwrap()
    }
}

fn status(client: &mut Client) -> Status {
    ask(client, StatusQuery {}).unwrap()
}

fn report(client: &mut Client, asked: impl Ask<Answer = Report>) -> Report {
    ask(client, asked).unwrap()
}

fn live(client: &mut Client, trace_from: u64) -> Live {
    ask(client, LiveQuery { trace_from, candidates_max: 2, terms_max: 3, newest_max: 4 }).unwrap()
}

/// Asks for the status until it is as wanted.
fn until(client: &mut Client, wanted: impl Fn(&Status) -> bool) -> Status {
    let start = Instant::now();
    loop {
        let status = status(client);
        if wanted(&status) {
            return status;
        }
        assert!(start.elapsed() < PATIENCE, "still {status:?}");
        std::thread::yield_now();
    }
}

#[test]
fn over_shared_memory_the_same_is_learnt_as_in_one_process() {
    let mut daemon = Daemon::start(setup(5, curriculum()));
    let mut client = daemon.client();
    let body = BodyThread::start(&daemon.place, Row::new("row"));
    let status = until(&mut client, |status| status.stage_state == StageState::Finished);
    let alone = run_in_process(Row::new("row"), setup(5, curriculum()), &AtomicBool::new(false)).unwrap();
    assert_eq!((status.step, &status.memory_digest), (alone.step, &alone.memory_digest));
    let over = report(&mut client, ReportQuery {});
    assert_eq!((over.finished, over.stages), (true, alone.stages));
    assert!(over.step_latency_us_p50 > 0.0 && over.step_latency_us_p99 >= over.step_latency_us_p50);
    assert_eq!((status.bodies.len(), status.bodies[0].frames_refused), (1, 0));
    assert!(status.world.iter().any(|one| one.starts_with("object{")), "{:?}", status.world);
    drop(client);
    daemon.end();
    assert_eq!(body.join().ending, RunEnding::Detached);
}

#[test]
fn a_tool_ends_the_daemon_and_gets_an_answer() {
    let mut daemon = Daemon::start(setup(1, free()));
    let mut client = daemon.client();
    let body = BodyThread::start(&daemon.place, Row::new("row"));
    until(&mut client, |status| status.step > 10);
    ask(&mut client, ShutdownOrder {}).unwrap();
    daemon.thread.take().unwrap().join().unwrap().unwrap();
    assert_eq!(body.join().ending, RunEnding::Detached);
    assert!(!daemon.place.is_served());
}

#[test]
fn orders_of_tools_are_obeyed_and_mistakes_explained() {
    let mut daemon = Daemon::start(setup(1, free()));
    let mut client = daemon.client();
    assert_eq!(status(&mut client).stage_state, StageState::WaitingForBody);
    // A step that nobody can take now must not be taken by whoever attaches later.
    let step = problem(&mut client, StageOrder::Step);
    assert!(step.contains("body"), "{step}");
    assert_eq!(status(&mut client).stage_state, StageState::WaitingForBody);
    let body = BodyThread::start(&daemon.place, Row::new("row"));
    until(&mut client, |status| status.step > 10);
    assert_eq!(report(&mut client, StageOrder::Hold).stage_state, StageState::Held);
    let held = status(&mut client);
    let from = live(&mut client, u64::MAX).trace.total;
    report(&mut client, SayOrder { words: vec!["touch".to_owned()] });
    report(&mut client, StageOrder::Resume);
    until(&mut client, |status| status.step > held.step + 10);
    let heard =
        live(&mut client, from).trace.records.into_iter().find(|record| !record.heard.is_empty()).unwrap();
    assert_eq!(heard.heard, ["touch"], "said while held, heard once");
    assert!(!problem(&mut client, StageOrder::Set("dancing".to_owned())).is_empty());
    assert!(!problem(&mut client, SayOrder { words: Vec::new() }).is_empty());
    assert!(!problem(&mut client, DetailQuery { id: 1_000_000 }).is_empty());
    let pre = Some("cat{".to_owned());
    assert!(!problem(&mut client, SchemaQuery { pre, ..SchemaQuery::default() }).is_empty());
    let action = Some("fly".to_owned());
    assert!(!problem(&mut client, SchemaQuery { action, ..SchemaQuery::default() }).is_empty());
    let answer = client.request(b"\xff\xff\xff not a question").unwrap();
    let answer: Reply<()> = codec::decode(&answer).unwrap();
    assert!(matches!(&answer, Reply::Problem(problem) if problem.0.contains("release")), "{answer:?}");
    let step = status(&mut client).step;
    until(&mut client, |status| status.step > step);
    body.stop.store(true, Ordering::Relaxed);
    assert_eq!(body.join().ending, RunEnding::Stopped);
    let status =
        until(&mut client, |status| status.bodies.iter().all(|body| body.state != BodyState::Attached));
    assert_eq!(status.bodies[0].state, BodyState::Left);
    drop(client);
    daemon.end();
}

/// This very test binary again, running [`body_process`] as a process of its own.

#[test]
fn one_step_is_taken_while_held_and_no_more() {
    let mut daemon = Daemon::start(setup(1, free()));
    let mut client = daemon.client();
    let body = BodyThread::start(&daemon.place, Row::new("row"));
    until(&mut client, |status| status.step > 10);
    report(&mut client, StageOrder::Hold);
    // The learner learns from the action under way, and chooses no other.
    let resting = |client: &mut Client| {
        let mut last = live(client, u64::MAX);
        let start = Instant::now();
        loop {
            let now = live(client, u64::MAX);
            let outcome_in = now.status.step == last.status.step && now.trace.total == last.trace.total;
            if outcome_in && now.status.bodies[0].frames > last.status.bodies[0].frames {
                return now;
            }
            assert!(start.elapsed() < PATIENCE, "never rests: {now:?}");
            last = now;
        }
    };
    let mut before = resting(&mut client);
    assert_eq!(before.status.stage_state, StageState::Held);
    for _ in 0..3 {
        assert_eq!(report(&mut client, StageOrder::Step).stage_state, StageState::Held);
        until(&mut client, |status| status.step > before.status.step);
        resting(&mut client);
        let after = live(&mut client, before.trace.total);
        assert_eq!(after.status.stage_state, StageState::Held);
        let decided = |live: &Live| live.explanation.as_ref().unwrap().step;
        let actions = after.trace.records.iter().filter(|record| record.decision.is_some()).count();
        assert_eq!(actions, 1, "{:?}", after.trace.records);
        assert!(decided(&after) > before.status.step);
        before = after;
    }
    report(&mut client, StageOrder::Resume);
    until(&mut client, |status| status.step > before.status.step + 10);
    // An action that is asked for while the learner is free is one action more.
    report(&mut client, StageOrder::Step);
    assert_eq!(resting(&mut client).status.stage_state, StageState::Held);
    drop(client);
    daemon.end();
    body.join();
}

#[test]
fn those_who_watch_are_shown_what_adds_up() {
    let mut daemon = Daemon::start(setup(1, free()));
    let mut client = daemon.client();
    let none = live(&mut client, 0);
    assert!(none.explanation.is_none() && none.status.world.is_empty() && none.newest.is_empty(), "{none:?}");
    let body = BodyThread::start(&daemon.place, Row::with_block("row", 3));
    until(&mut client, |status| status.step > 50);
    report(&mut client, StageOrder::Hold);
    let status = until(&mut client, |status| status.stage_state == StageState::Held);
    let shown = live(&mut client, 0);
    assert_eq!((&shown.status.world, shown.observations.len()), (&status.world, status.world.len()));
    assert_eq!(
        (shown.status.memory_digest, shown.newest.len()),
        (None, 4),
        "the digest takes a look at all of memory"
    );
    let schemas_total = shown.status.schemas_total;
    assert_eq!(schemas_total, status.schemas_total);
    let newest: Vec<_> = shown.newest.iter().map(|schema| schema.id).collect();
    assert_eq!(newest, (schemas_total - 4..schemas_total).rev().collect::<Vec<_>>());
    let explanation = shown.explanation.unwrap();
    assert!(explanation.candidates.len() <= 2, "{explanation:?}");
    for candidate in &explanation.candidates {
        assert!(candidate.terms.len() <= 4, "{candidate:?}");
        let sum: f64 = candidate.terms.iter().map(|term| term.value).sum();
        let excitation = sum / f64::from(candidate.distance);
        assert!((excitation - candidate.excitation).abs() < 1e-9, "{candidate:?}");
    }
    let finger = shown.observations.iter().find(|one| one.observation.kind == "finger").unwrap();
    assert!(finger.attention > 0, "{:?}", shown.observations);
    drop(client);
    daemon.end();
    body.join();
}

fn body_process_at(place: &Place, name: &str) -> Child {
    Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "body_process", "--ignored", "--nocapture"])
        .env("PSCHEMA_TEST_RUNTIME", place.runtime().path())
        .env("PSCHEMA_TEST_BODY", name)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

#[test]
#[ignore = "not a test: the body of other tests, in a process that they kill"]
fn body_process() {
    let (Some(runtime), Ok(name)) =
        (std::env::var_os("PSCHEMA_TEST_RUNTIME"), std::env::var("PSCHEMA_TEST_BODY"))
    else {
        return;
    };
    let runtime = RuntimeDir::at(std::path::Path::new(&runtime)).unwrap();
    let place = Place::new(runtime, LearnerName::new("test").unwrap());
    let options = RunOptions::new(place).exit_when_daemon_gone(true);
    pschema_protocol::body::run(Row::new(&name), &options).unwrap();
}

#[test]
fn a_body_that_is_killed_leaves_the_other_as_it_was_and_may_come_back() {
    let mut daemon = Daemon::start(setup(1, free()));
    let mut client = daemon.client();
    let survivor = BodyThread::start(&daemon.place, Row::new("survivor"));
    let frames = |status: &Status, name: &str| {
        let body = status.bodies.iter().find(|body| body.name == name && body.state == BodyState::Attached);
        body.map_or(0, |body| body.frames)
    };
    until(&mut client, |status| frames(status, "survivor") > 0);
    for round in 0..3 {
        let mut victim = body_process_at(&daemon.place, "victim");
        until(&mut client, |status| frames(status, "victim") > 20);
        victim.kill().unwrap();
        victim.wait().unwrap();
        let lost = until(&mut client, |status| {
            status.bodies.iter().any(|body| body.name == "victim" && body.state == BodyState::Lost)
        });
        let before = frames(&lost, "survivor");
        until(&mut client, |status| frames(status, "survivor") > before + 20);
        assert_eq!(lost.bodies.len(), 2, "round {round}: {:?}", lost.bodies);
    }
    survivor.stop.store(true, Ordering::Relaxed);
    let summary = survivor.join();
    assert_eq!((summary.sessions, summary.refused), (1, 0));
    drop(client);
    daemon.end();
}

#[test]
fn a_second_daemon_of_the_same_name_is_refused_with_the_first_ones_process() {
    let mut daemon = Daemon::start(setup(1, free()));
    drop(daemon.client());
    let error =
        serve(daemon.place.clone(), setup(1, free()), &AtomicBool::new(false)).unwrap_err().to_string();
    assert!(error.contains(&std::process::id().to_string()), "{error}");
    drop(daemon.client());
    daemon.end();
}

#[test]
fn a_body_whose_name_is_taken_is_told_so() {
    let mut daemon = Daemon::start(setup(1, free()));
    let mut client = daemon.client();
    let first = BodyThread::start(&daemon.place, Row::new("twin"));
    until(&mut client, |status| status.step > 0);
    let second = BodyThread::start(&daemon.place, Row::new("twin"));
    let error = second.thread.join().unwrap().unwrap_err().to_string();
    assert!(error.contains("twin is attached already"), "{error}");
    first.stop.store(true, Ordering::Relaxed);
    first.join();
    drop(client);
    daemon.end();
}
