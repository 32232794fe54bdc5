//! Orders that a body does not carry out: its reason is logged, shown by `status` and kept in the trace, and steers no
//! terminal.

#![allow(clippy::unwrap_used)] // A test panics to fail.

mod common;

use std::time::Instant;

use common::process::{Daemon, PATIENCE, directory, place};
use common::{Row, ask, free, setup};
use pschema_inspect::{
    DeclarationWarning, FailedOutcome, OrderFailure, ShutdownOrder, Status, StatusQuery, TraceQuery,
};
use pschema_protocol::body::{Body, Outcome, RunOptions, Senses, run};
use pschema_protocol::client::Client;
use pschema_protocol::description::{Action, ActionType, Description, ObservationType, Property, SenseId};
use pschema_server::in_process::InProcess;

/// A body that carries nothing out. Its orders have these outcomes, by how many it had before.
struct Faulty<F>(Row, F, u64);

impl<F: Fn(u64) -> Outcome> Faulty<F> {
    fn new(outcome: F) -> Self {
        Self(Row::new("row"), outcome, 0)
    }
}

impl<F: Fn(u64) -> Outcome> Body for Faulty<F> {
    fn describe(&self) -> Description {
        self.0.describe()
    }
    fn sense(&mut self, frame: &mut Senses) {
        self.0.sense(frame);
    }
    fn act(&mut self, _: &Action) -> Outcome {
        self.2 += 1;
        (self.1)(self.2 - 1)
    }
}

#[test]
fn each_kind_of_failure_is_told_with_its_reason_and_its_step() {
    let cases = [
        (Outcome::refused("the lid is shut"), FailedOutcome::Refused, Some("the lid is shut")),
        (
            Outcome::failed("a\\b\x1b[2J\r\n\u{9b}é"),
            FailedOutcome::Failed,
            Some("a\\b\\u{1b}[2J\\r\\n\\u{9b}é"),
        ),
        (Outcome::failed(""), FailedOutcome::Failed, None),
        (Outcome::TimedOut, FailedOutcome::TimedOut, None),
    ];
    for (told, outcome, reason) in cases {
        let mut run = InProcess::new(Faulty::new(|_| told.clone()), setup(1, free())).unwrap();
        run.advance().unwrap();
        let status = run.ask(&StatusQuery {}).unwrap();
        assert_eq!(status.bodies[0].last_failure, None, "no order was answered yet");
        run.advance().unwrap();
        let failure = OrderFailure { outcome, reason: reason.map(str::to_owned), step: 2 };
        let status = run.ask(&StatusQuery {}).unwrap();
        assert_eq!(status.bodies[0].last_failure.as_ref(), Some(&failure));
        let trace = run.ask(&TraceQuery { from: 0 }).unwrap();
        let failures: Vec<_> = trace.records.into_iter().map(|record| record.failure).collect();
        assert_eq!(failures, [None, Some(failure)]);
    }
}

#[test]
fn a_carried_out_order_leaves_no_failure_in_its_record() {
    let mut run = InProcess::new(Row::new("row"), setup(1, free())).unwrap();
    for _ in 0..5 {
        run.advance().unwrap();
    }
    let trace = run.ask(&TraceQuery { from: 0 }).unwrap();
    assert!(trace.records.len() == 5 && trace.records.iter().all(|record| record.failure.is_none()));
}

/// The last status and the log of a daemon whose body fails in these ways for more than 200 steps.
fn daemon_with(outcome: impl Fn(u64) -> Outcome + Send + 'static) -> (Status, String) {
    daemon_of(Faulty::new(outcome), 200)
}

/// The last status and the log of a daemon that took more than so many steps with a body.
fn daemon_of(body: impl Body + Send + 'static, steps: u64) -> (Status, String) {
    let home = directory();
    let (begun, place) = (Instant::now(), place(home.path()));
    let mut daemon = Daemon::start(home.path(), &["--name", "one"]);
    daemon.ready();
    let options = RunOptions::new(place.clone());
    let body = std::thread::spawn(move || run(body, &options));
    let mut client = Client::connect(&place, PATIENCE).unwrap();
    let status = loop {
        let status: Status = ask(&mut client, StatusQuery {}).unwrap();
        if status.step > steps {
            break status;
        }
        assert!(begun.elapsed() < PATIENCE, "only {} steps were taken", status.step);
    };
    ask(&mut client, ShutdownOrder {}).unwrap();
    body.join().unwrap().unwrap();
    let (code, log) = daemon.ended();
    assert_eq!(code, Some(0), "{log}");
    (status, log)
}

/// The reason was checked when it came to the daemon, and then dropped.
#[test]
fn a_daemon_logs_the_reason_of_a_failing_body_and_steers_no_terminal_with_it() {
    let (status, log) = daemon_with(|_| Outcome::failed("\x1b[2J\nERROR all is lost"));
    let failure = status.bodies[0].last_failure.as_ref().unwrap();
    assert_eq!(failure.reason.as_deref(), Some("\\u{1b}[2J\\nERROR all is lost"));
    assert!(log.chars().all(|c| c == '\n' || !c.is_control()), "{log:?}");
    let lines: Vec<_> = log.lines().filter(|line| line.contains("all is lost")).collect();
    let words = ["WARN", "not carried out", "failed"];
    assert!(words.iter().all(|word| lines[0].contains(word)), "{}", lines[0]);
    assert!(lines.len() < 32, "{} lines of the same failure", lines.len());
}

/// A body that senses how often it sensed, and can do nothing about it.
struct Clock {
    description: Description,
    time: SenseId,
    ticks: i64,
}

impl Clock {
    fn new() -> Self {
        let mut description = Description::new("clock", "clock");
        let ticks = Property::integer("ticks", 0..=1_000_000);
        let time = description.observation(ObservationType::state("time").property(ticks));
        description.action_with_primitives(ActionType::new("wait"));
        Self { description, time, ticks: 0 }
    }
}

impl Body for Clock {
    fn describe(&self) -> Description {
        self.description.clone()
    }
    fn sense(&mut self, frame: &mut Senses) {
        self.ticks += 1;
        frame.observe(self.time, [self.ticks]);
    }
    fn act(&mut self, _: &Action) -> Outcome {
        Outcome::Done
    }
}

#[test]
fn a_sense_that_never_repeats_is_told_by_status_and_logged_once() {
    let (status, log) = daemon_of(Clock::new(), 700);
    let warning =
        DeclarationWarning::ValuesNeverRepeat { sense: "time".to_owned(), observations: 500, repeated: 0 };
    assert_eq!(status.bodies[0].warnings, [warning]);
    let lines: Vec<_> = log.lines().filter(|line| line.contains("can't be learnt as it is")).collect();
    assert!(lines.len() == 1 && lines[0].contains("time hardly ever has the same values"), "{log}");
}

#[test]
fn that_an_episode_is_over_is_no_failure() {
    let outcomes = [Outcome::Done, Outcome::EpisodeEnded, Outcome::EpisodeCut];
    let (status, log) = daemon_with(move |number| outcomes[number as usize % 3].clone());
    let body = &status.bodies[0];
    assert_eq!((&body.last_failure, body.frames_refused), (&None, 0));
    assert!(body.episodes_ended > 60 && body.episodes_cut > 60, "{body:?}");
    assert!(!log.contains("not carried out") && !log.contains("WARN"), "{log}");
}

#[test]
fn a_body_with_a_new_reason_each_time_does_not_flood_the_log() {
    let begun = Instant::now();
    let (_, log) = daemon_with(|number| Outcome::refused(format_args!("reason {number}")));
    let lines = log.lines().filter(|line| line.contains("not carried out")).count();
    let minutes = usize::try_from(begun.elapsed().as_secs() / 60).unwrap();
    assert!((20..=60 * (minutes + 1)).contains(&lines), "{lines} lines");
}
