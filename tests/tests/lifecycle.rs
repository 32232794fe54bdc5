//! Processes come, go, die and come back; nothing is left behind and nobody else notices.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

use std::io::{PipeReader, PipeWriter, Read, Write};
use std::process::{Child, Command, Stdio};

use pschema_tests::{ChildProcess, Sandbox, prefix_of, shared_files, signal_process, until};
use rustix::process::Signal;
use serde_json::Value;

const BINARY: &str = env!("CARGO_BIN_EXE_pschema-under-test");

fn attached(status: &Value) -> Vec<u64> {
    let bodies = status["bodies"].as_array().unwrap();
    let here = bodies.iter().filter(|body| body["state"] == "attached");
    here.map(|body| body["pid"].as_u64().unwrap()).collect()
}

fn killed(process: ChildProcess) {
    process.signal(Signal::KILL);
    assert_eq!(process.finished().code(), None);
}

#[test]
fn sigterm_ends_daemon_and_body_cleanly_and_nothing_is_left() {
    let sandbox = Sandbox::new(BINARY);
    let daemon = sandbox.daemon("default", &[]);
    let body = sandbox.body("default", &[]);
    let _moving = sandbox.past("default", 3);
    assert!(!sandbox.left().is_empty(), "there is something to leave behind");
    let body = body.ended();
    assert_eq!(body.code(), Some(0), "{body:?}");
    let daemon = daemon.ended();
    assert_eq!(daemon.code(), Some(0), "{daemon:?}");
    assert_eq!(sandbox.left(), Vec::<String>::new());
    let gone = sandbox.run(&["status"]);
    assert_eq!(gone.code(), Some(3), "{gone:?}");
}

/// A daemon whose log nobody reads. It ends with the test, however that ends.
struct Unread(Child);

impl Drop for Unread {
    fn drop(&mut self) {
        // It has usually ended by now.
        self.0.kill().ok();
        self.0.wait().unwrap();
    }
}

/// The log was written in the loop: a terminal that was held (Ctrl-S), or a full pipe, froze the learner.
#[test]
fn a_log_that_nobody_reads_stops_neither_the_learner_nor_its_end() {
    let sandbox = Sandbox::new(BINARY);
    let (unread, stderr) = std::io::pipe().unwrap();
    // Fills the pipe, and then waits until it is closed.
    let mut filling = stderr.try_clone().unwrap();
    let filling = std::thread::spawn(move || filling.write_all(&[b'.'; 1 << 20]));
    let mut daemon = Command::new(BINARY);
    daemon.arg("server").env("RUST_LOG", "trace").env("PSCHEMA_RUNTIME_DIR", sandbox.runtime());
    let mut daemon = Unread(daemon.stdout(Stdio::null()).stderr(stderr).spawn().unwrap());
    until("the daemon serves", || (sandbox.run(&["status"]).code() == Some(0)).then_some(()));
    let body = sandbox.body("default", &[]);
    let _moving = sandbox.past("default", 100);
    assert_eq!(sandbox.status("default")["log_lines_lost"], 0, "there is room for a few");
    assert_eq!(body.ended().code(), Some(0));
    signal_process(daemon.0.id(), Signal::TERM);
    assert_eq!(daemon.0.wait().unwrap().code(), Some(0));
    drop(unread);
    filling.join().unwrap().unwrap_err();
    assert_eq!(sandbox.left(), Vec::<String>::new());
}

/// A pipe that takes nothing more: its reader, and the end to be written to.
fn full_pipe() -> (PipeReader, PipeWriter) {
    let (unread, mut full) = std::io::pipe().unwrap();
    let flags = rustix::fs::fcntl_getfl(&full).unwrap();
    rustix::fs::fcntl_setfl(&full, flags | rustix::fs::OFlags::NONBLOCK).unwrap();
    while full.write(b".").is_ok() {}
    rustix::fs::fcntl_setfl(&full, flags).unwrap();
    (unread, full)
}

/// The last words of a tool waited for who reads them, and the first SIGTERM had no effect.
#[test]
fn a_tool_whose_stderr_nobody_reads_ends_at_the_first_signal() {
    let sandbox = Sandbox::new(BINARY);
    let _daemon = sandbox.daemon("default", &[]);
    let _body = sandbox.body("default", &[]);
    for arguments in
        [&["view", "--no-open"][..], &["record", "--jsonl", "-"], &["view", "--no-open", "--name", "typo"]]
    {
        let (unread, full) = full_pipe();
        let mut tool = Command::new(BINARY);
        tool.args(arguments).env("PSCHEMA_RUNTIME_DIR", sandbox.runtime());
        let mut tool = Unread(tool.stdout(Stdio::piped()).stderr(full).spawn().unwrap());
        let mut stdout = tool.0.stdout.take().unwrap();
        // It is at work when it has written something; all of it is read, for only stderr is full.
        stdout.read_exact(&mut [0; 8]).unwrap();
        let rest = std::thread::spawn(move || std::io::copy(&mut stdout, &mut std::io::sink()));
        signal_process(tool.0.id(), Signal::TERM);
        let ended = until("it ends", || tool.0.try_wait().unwrap());
        assert_eq!(ended.code(), Some(0), "{arguments:?}");
        rest.join().unwrap().unwrap();
        drop(unread);
    }
}

/// `timeout` sends its signal to the process and then to the whole group: two at once, which are one wish.
#[test]
fn two_signals_at_once_end_a_daemon_as_cleanly_as_one() {
    let sandbox = Sandbox::new(BINARY);
    for _ in 0..5 {
        let daemon = sandbox.daemon("default", &[]);
        for _ in 0..3 {
            daemon.signal(Signal::TERM);
        }
        let daemon = daemon.finished();
        assert_eq!(daemon.code(), Some(0), "{daemon:?}");
        assert_eq!(sandbox.left(), Vec::<String>::new());
    }
}

/// `nohup` starts a process with SIGHUP ignored, so that it outlives its terminal.
#[test]
fn a_signal_that_a_daemon_was_started_to_ignore_stays_ignored() {
    let sandbox = Sandbox::new(BINARY);
    let command = format!("trap '' HUP; exec '{BINARY}' server");
    let daemon = sandbox.start_program("/bin/sh", &["-c", &command]);
    until("the daemon serves", || (sandbox.run(&["status"]).code() == Some(0)).then_some(()));
    daemon.signal(Signal::HUP);
    let body = sandbox.body("default", &[]);
    let _on = sandbox.past("default", 100);
    assert_eq!(body.ended().code(), Some(0));
    assert_eq!(daemon.ended().code(), Some(0));
    // Otherwise it ends cleanly, as by any other signal.
    let daemon = sandbox.start_program("env", &["--default-signal", BINARY, "server"]);
    until("the daemon serves", || (sandbox.run(&["status"]).code() == Some(0)).then_some(()));
    daemon.signal(Signal::HUP);
    assert_eq!(daemon.finished().code(), Some(0));
    assert_eq!(sandbox.left(), Vec::<String>::new());
}

#[test]
fn a_body_that_is_killed_is_noticed_and_can_come_back() {
    let sandbox = Sandbox::new(BINARY);
    let daemon = sandbox.daemon("default", &[]);
    let body = sandbox.body("default", &[]);
    let _moving = sandbox.past("default", 3);
    killed(body);
    until("the body is lost", || attached(&sandbox.status("default")).is_empty().then_some(()));
    let at = sandbox.status("default")["step"].as_u64().unwrap();
    let body = sandbox.body("default", &[]);
    let _on = sandbox.past("default", at);
    assert_eq!(attached(&sandbox.status("default")), [u64::from(body.pid())]);
    drop(body);
    assert_eq!(daemon.ended().code(), Some(0));
    assert_eq!(sandbox.left(), Vec::<String>::new());
}

#[test]
fn two_learners_live_side_by_side() {
    let sandbox = Sandbox::new(BINARY);
    let daemons = [sandbox.daemon("one", &["--seed", "1"]), sandbox.daemon("two", &["--seed", "2"])];
    let bodies = [sandbox.body("one", &["--seed", "1"]), sandbox.body("two", &["--seed", "2"])];
    for name in ["one", "two"] {
        let _moving = sandbox.past(name, 10);
        assert_eq!(sandbox.status(name)["name"], name);
    }
    let [one, two] = bodies;
    assert_eq!(attached(&sandbox.status("one")), [u64::from(one.pid())]);
    assert_eq!(attached(&sandbox.status("two")), [u64::from(two.pid())]);
    drop((one, two));
    for daemon in daemons {
        assert_eq!(daemon.ended().code(), Some(0));
    }
    assert_eq!(sandbox.left(), Vec::<String>::new());
}

#[test]
fn a_second_daemon_of_one_name_explains_itself_and_harms_nobody() {
    let sandbox = Sandbox::new(BINARY);
    let first = sandbox.daemon("default", &[]);
    let _body = sandbox.body("default", &[]);
    let at = sandbox.past("default", 3);
    let second = sandbox.run(&["server"]);
    assert_eq!(second.code(), Some(1), "{second:?}");
    assert!(second.stderr.contains(&first.pid().to_string()), "it names the first: {second:?}");
    let _on = sandbox.past("default", at);
}

/// A body without a daemon was silent for ever, and so was a page.
#[test]
fn whoever_waits_for_a_daemon_says_so_once() {
    let sandbox = Sandbox::new(BINARY);
    let view = sandbox.start(&["view", "--name", "typo", "--no-open"]);
    let body = sandbox.body("default", &[]);
    view.says("no daemon serves learner typo");
    body.says("waiting to attach: no daemon serves learner default");
    body.says("start one with `pschema server --name default`");
    // As many tries as it makes in some seconds.
    std::thread::sleep(std::time::Duration::from_secs(3));
    assert_eq!(body.stderr().matches("waiting to attach").count(), 1, "{}", body.stderr());
    let _daemon = sandbox.daemon("default", &[]);
    let _attached = sandbox.past("default", 3);
    // Another body of its name is told so once, and gives up.
    let second = sandbox.body("default", &[]).finished();
    assert_eq!(second.code(), Some(1), "{second:?}");
    assert!(second.stderr.matches("is attached already").count() <= 2, "{second:?}");
    assert_eq!(view.ended().code(), Some(0));
    assert_eq!(body.ended().code(), Some(0));
}

/// A process substitution of the shell, `--curriculum <(…)`, is a pipe.
#[test]
fn a_curriculum_may_come_through_a_pipe() {
    let sandbox = Sandbox::new(BINARY);
    let pipe = sandbox.runtime().join("curriculum").display().to_string();
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let daemon = sandbox.start(&["server", "--curriculum", &pipe]);
    std::fs::write(&pipe, include_str!("../../server/curricula/exp1-s1.toml")).unwrap();
    let named = until("the daemon answers", || {
        let answer = sandbox.run(&["status", "--json"]);
        (answer.code() == Some(0)).then(|| answer.json()["curriculum"].clone())
    });
    assert_eq!(named, "exp1-s1");
    assert_eq!(daemon.ended().code(), Some(0));
    let experiment = sandbox.run(&["experiment", &pipe]);
    assert!(experiment.stderr.contains("write it to a file"), "{experiment:?}");
}

#[test]
fn a_body_outlives_a_daemon_that_is_killed_and_started_again() {
    let sandbox = Sandbox::new(BINARY);
    let first = sandbox.daemon("default", &[]);
    let body = sandbox.body("default", &[]);
    let _moving = sandbox.past("default", 3);
    killed(first);
    assert_eq!(sandbox.run(&["status"]).code(), Some(3), "nobody serves");
    assert!(!sandbox.left().is_empty(), "a killed daemon cannot clean up");
    let doctor = sandbox.run(&["doctor"]);
    assert_eq!(doctor.code(), Some(1), "{doctor:?}");
    assert!(doctor.stdout.contains("doctor --clean"), "{doctor:?}");

    let second = sandbox.daemon("default", &[]);
    let _on = sandbox.past("default", 3);
    assert_eq!(attached(&sandbox.status("default")), [u64::from(body.pid())]);
    assert_eq!(body.ended().code(), Some(0));
    assert_eq!(second.ended().code(), Some(0));
    assert_eq!(sandbox.left(), Vec::<String>::new(), "the second swept what the first left");
}

/// In a container that shares the machine's shared memory, with a runtime directory of its own, the doctor saw no process that
/// used the files of a living daemon; it called the daemon dead, and cleaning cut it off.
#[test]
fn the_doctor_in_a_container_leaves_a_living_daemon_alone() {
    let container = ["--pid", "--fork", "--mount-proc"];
    let permitted = std::process::Command::new("unshare").args(container).arg("true").output();
    if !permitted.is_ok_and(|output| output.status.success()) {
        println!("this user may not make a container: not tried");
        return;
    }
    let (sandbox, other) = (Sandbox::new(BINARY), Sandbox::new(BINARY));
    let _daemon = sandbox.daemon("default", &[]);
    let _body = sandbox.body("default", &[]);
    let at = sandbox.past("default", 3);
    let prefix = prefix_of(sandbox.runtime(), "default");
    let files = || shared_files(&prefix).len();
    let before = files();
    let doctor = [&container[..], &[BINARY, "doctor", "--clean", "--json"]].concat();
    let doctor = other.start_program("unshare", &doctor).finished();
    let findings: Value = serde_json::from_str(&doctor.stdout).unwrap();
    assert_eq!(findings["cleaned"], serde_json::json!([]), "{findings}");
    let told =
        findings["checks"].as_array().unwrap().iter().find(|check| {
            check["name"] == "left behind" && check["found"].as_str().unwrap().contains(&prefix)
        });
    let told = told.unwrap_or_else(|| panic!("it is not told: {findings}"));
    assert!(told["ok"] == true && told["mend"].is_null(), "{told}");
    assert!(files() >= before, "nothing is removed");
    let _on = sandbox.past("default", at + 3);
}

#[test]
fn the_doctor_cleans_up_after_a_killed_daemon() {
    let sandbox = Sandbox::new(BINARY);
    killed(sandbox.daemon("default", &[]));
    assert!(!sandbox.left().is_empty());
    let cleaned = sandbox.run(&["doctor", "--clean", "--json"]);
    let findings: Value = serde_json::from_str(&cleaned.stdout).unwrap();
    assert!(!findings["cleaned"].as_array().unwrap().is_empty(), "{findings}");
    assert_eq!(sandbox.left(), Vec::<String>::new());
}
