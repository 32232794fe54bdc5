//! A learner written down while it lives.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

use std::fs;
use std::process::Command;

use pschema_tests::{ChildProcess, Sandbox, until};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::Signal;
use serde_json::Value;

const BINARY: &str = env!("CARGO_BIN_EXE_pschema-under-test");

fn lines(path: &str) -> Vec<Value> {
    let text = fs::read_to_string(path).unwrap();
    // The last line may be on its way.
    let whole = text.rsplit_once('\n').map_or("", |(whole, _)| whole);
    whole.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn every_step_is_written_down_in_order_until_the_daemon_ends() {
    let sandbox = Sandbox::new(BINARY);
    let nobody = sandbox.run(&["record", "--jsonl", "/tmp/never-made.jsonl"]);
    assert_eq!(nobody.code(), Some(3), "{nobody:?}");
    let daemon = sandbox.daemon("default", &["--curriculum", "exp1-s1", "--seed", "1"]);
    let body = sandbox.body("default", &["--seed", "1"]);
    let path = |name: &str| sandbox.runtime().join(name).display().to_string();
    let (all, some) = (path("all.jsonl"), path("some.jsonl"));
    let all_the_while = sandbox.start(&["record", "--jsonl", &all, "--json"]);
    let of_some = sandbox.run(&["record", "--jsonl", &some, "--steps", "20", "--json"]).json();
    assert_eq!((&of_some["steps"], &of_some["first_step"]), (&Value::from(20), &Value::from(1)), "{of_some}");
    assert_eq!(lines(&some).iter().filter(|line| line.get("step").is_some()).count(), 20);
    sandbox.curriculum_over("default");
    let status = sandbox.status("default");
    // The recording can be read while it goes on.
    let last = || Some(lines(&all).iter().rev().find_map(|line| line.get("step"))?["step"] == status["step"]);
    until("the last step is recorded", || last().filter(|last| *last));
    daemon.signal(Signal::TERM);
    drop(daemon.finished());
    let recorded = all_the_while.finished().json();
    assert_eq!(recorded["steps_missed"], 0, "{recorded}");
    let lines = lines(&all);
    let next = sandbox.daemon("next", &[]);
    let steps: Vec<u64> = lines.iter().filter_map(|line| line.get("step")?.get("step")?.as_u64()).collect();
    assert!(steps.is_sorted() && steps.first() == Some(&1), "{steps:?}");
    assert_eq!(steps.last(), status["step"].as_u64().as_ref());
    let schemas: Vec<u64> = lines.iter().filter_map(|line| line.get("schema")?.get("id")?.as_u64()).collect();
    assert!(!schemas.is_empty() && schemas.is_sorted(), "{schemas:?}");
    assert!(
        lines.iter().any(|line| line["step"]["stage_name"] == "first touches"),
        "stages have their names"
    );
    let again = sandbox.run(&["record", "--jsonl", &all, "--name", "next"]);
    assert_eq!(again.code(), Some(1), "a file that is there is not written over: {again:?}");
    assert!(again.stderr.contains("it is there already"), "{again:?}");
    drop(next);
    drop(body);
}

/// Steps as they are taken, for another program: `-` made a file of that name, and pipes were refused.
#[test]
fn steps_stream_into_stdout_and_into_pipes() {
    let sandbox = Sandbox::new(BINARY);
    let _daemon = sandbox.daemon("default", &[]);
    let _body = sandbox.body("default", &[]);
    let steps = |text: &str| text.lines().filter(|line| line.starts_with("{\"step\"")).count();
    for stdout in ["-", "/dev/stdout"] {
        let streamed = sandbox.run(&["record", "--jsonl", stdout, "--steps", "20"]);
        assert_eq!((streamed.code(), steps(&streamed.stdout)), (Some(0), 20), "{streamed:?}");
        let all_json = streamed.stdout.lines().all(|line| serde_json::from_str::<Value>(line).is_ok());
        assert!(all_json && streamed.stderr.contains("Recorded 20 steps"), "{streamed:?}");
    }
    assert!(!fs::exists("-").unwrap());
    // A line is there when its step is taken, not when a buffer is full.
    let live = sandbox.start(&["record", "--jsonl", "-"]);
    let first = until("a step is streamed", || Some(steps(&live.stdout())).filter(|steps| *steps > 0));
    until("more are streamed", || (steps(&live.stdout()) > first).then_some(()));
    assert_eq!(live.ended().code(), Some(0));

    let pipe = sandbox.runtime().join("pipe").display().to_string();
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let writer = sandbox.start(&["record", "--jsonl", &pipe, "--steps", "20"]);
    assert_eq!(steps(&fs::read_to_string(&pipe).unwrap()), 20);
    let recorded = writer.finished();
    assert!(recorded.code() == Some(0) && recorded.stdout.contains("Recorded 20 steps"), "{recorded:?}");
    // A reader that goes away is no failure.
    let writer = sandbox.start(&["record", "--jsonl", &pipe]);
    drop(fs::File::open(&pipe).unwrap());
    let ended = writer.finished();
    let waited = |line: &str| line.contains("waiting until somebody does");
    assert!(ended.code() == Some(0) && ended.stderr.lines().all(waited), "{ended:?}");
    // A pipe without a reader was waited for in silence, at the first signal too.
    let writer = sandbox.start(&["record", "--jsonl", &pipe]);
    writer.says(&format!("nobody reads {pipe} yet: waiting until somebody does"));
    writer.signal(Signal::TERM);
    let ended = writer.finished();
    assert_eq!(ended.code(), Some(1), "{ended:?}");
    assert_eq!(ended.stderr.matches("waiting until somebody does").count(), 1, "{ended:?}");
}

/// A recording or an export into a pipe whose reader was halted hung in its write, and the first signal ended neither; no
/// SIGHUP ever did.
#[test]
fn a_reader_that_takes_nothing_does_not_keep_a_writer_that_is_to_end() {
    let sandbox = Sandbox::new(BINARY);
    let path = |name: &str| sandbox.runtime().join(name).display().to_string();
    let (data, pipe) = (path("data"), path("pipe"));
    let _daemon = sandbox.daemon("default", &["--data", &data]);
    let _body = sandbox.body("default", &[]);
    assert!(sandbox.past("default", 1_000) > 1_000);
    let into_stdout = format!("exec {BINARY} record --jsonl - >{pipe}");
    let record = || sandbox.start(&["record", "--jsonl", &pipe]);
    let export = || sandbox.start(&["export", "--data", &data, "-o", &pipe]);
    let writers: [(&dyn Fn() -> ChildProcess, Signal); 5] = [
        (&record, Signal::TERM),
        (&record, Signal::HUP),
        (&|| sandbox.start_program("sh", &["-c", &into_stdout]), Signal::INT),
        (&export, Signal::TERM),
        (&export, Signal::HUP),
    ];
    for (start, signal) in writers {
        assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let halted = fs::File::options().read(true).write(true).open(&pipe).unwrap();
        let writer = start();
        let has_room =
            || poll(&mut [PollFd::new(&halted, PollFlags::OUT)], Some(&Timespec::default())).unwrap();
        until("the pipe is full", || (has_room() == 0).then_some(()));
        writer.signal(signal);
        let ended = writer.finished();
        assert_eq!(ended.code(), Some(1), "{ended:?}");
        assert!(ended.stderr.contains("stopped before the end"), "{ended:?}");
        fs::remove_file(&pipe).unwrap();
    }
    // An export into a pipe that nobody reads yet waited for a reader whatever came.
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let writer = export();
    writer.says(&format!("nobody reads {pipe} yet: waiting until somebody does"));
    let ended = writer.ended();
    assert_eq!(ended.code(), Some(1), "{ended:?}");
}

#[test]
fn where_to_is_to_be_said() {
    let sandbox = Sandbox::new(BINARY);
    let nothing = sandbox.run(&["record"]);
    assert_eq!(nothing.code(), Some(2), "{nothing:?}");
    assert!(nothing.stderr.contains("--jsonl"), "{nothing:?}");
}
