//! The daemon under a service manager: the messages to the manager, the log, and the unit that starts the daemon.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

use std::ffi::OsStr;
use std::io::{ErrorKind, Write};
use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixDatagram};
use std::process::Command;
use std::time::Duration;

use pschema_tests::{ChildProcess, DEADLINE, Sandbox, until};
use rustix::process::Signal;
use serde_json::Value;

const BINARY: &str = env!("CARGO_BIN_EXE_pschema-under-test");
const PEER: &str = env!("CARGO_BIN_EXE_pschema-test-peer");

/// How long the manager of these tests waits for a sign of life.
const PATIENCE: Duration = Duration::from_millis(400);

fn server(sandbox: &Sandbox, variables: &[(&str, &OsStr)], arguments: &[&str]) -> ChildProcess {
    let mut command = Command::new(BINARY);
    command
        .args(["server"])
        .args(arguments)
        .env("PSCHEMA_RUNTIME_DIR", sandbox.runtime())
        .env_remove("RUST_LOG");
    command.envs(variables.iter().copied());
    ChildProcess::start(&mut command)
}

/// The next message to the manager, or none within `wait`.
fn told(socket: &UnixDatagram, wait: Duration) -> Option<String> {
    socket.set_read_timeout(Some(wait)).unwrap();
    let mut bytes = [0; 4096];
    match socket.recv(&mut bytes) {
        Ok(length) => Some(String::from_utf8(bytes[..length].to_vec()).unwrap()),
        Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => None,
        Err(error) => panic!("{error}"),
    }
}

fn has(message: &str, line: &str) -> bool {
    message.lines().any(|one| one == line)
}

/// Reads on until a message has `line`.
fn until_told(socket: &UnixDatagram, line: &str) -> String {
    until(&format!("the manager is told {line}"), || {
        told(socket, DEADLINE).filter(|message| has(message, line))
    })
}

#[test]
fn the_manager_hears_that_it_answers_that_it_lives_and_that_it_ends() {
    let sandbox = Sandbox::new(BINARY);
    let path = sandbox.runtime().join("notify");
    let socket = UnixDatagram::bind(&path).unwrap();
    let patience = PATIENCE.as_micros().to_string();
    let variables = [("NOTIFY_SOCKET", path.as_os_str()), ("WATCHDOG_USEC", OsStr::new(&patience))];
    let daemon = server(&sandbox, &variables, &[]);
    let first = told(&socket, DEADLINE).unwrap();
    assert!(has(&first, "READY=1") && first.contains("STATUS=learner default: step 0"), "{first}");
    // No second try: that it is ready means that it answers.
    assert_eq!(sandbox.run(&["status"]).code(), Some(0));
    let body = sandbox.start_program(PEER, &["body", "default", "row"]);
    until("a message tells of the body's steps", || {
        let message = told(&socket, DEADLINE).unwrap();
        (message.contains("bodies attached: 1") && !message.contains("step 0,")).then_some(())
    });
    for _ in 0..5 {
        until_told(&socket, "WATCHDOG=1");
    }

    // A loop that does not turn is silent, however much its process has other threads.
    daemon.signal(Signal::STOP);
    while told(&socket, PATIENCE).is_some() {}
    assert_eq!(told(&socket, 3 * PATIENCE), None);
    daemon.signal(Signal::CONT);
    until_told(&socket, "WATCHDOG=1");

    daemon.signal(Signal::TERM);
    until_told(&socket, "STOPPING=1");
    assert_eq!(daemon.finished().code(), Some(0));
    drop(body);
}

#[test]
fn a_manager_on_an_abstract_socket_hears_it_and_one_that_does_not_watch_hears_no_pings() {
    let sandbox = Sandbox::new(BINARY);
    let name = format!("pschema-test-{}", std::process::id());
    let socket = UnixDatagram::bind_addr(&SocketAddr::from_abstract_name(&name).unwrap()).unwrap();
    let address = format!("@{name}");
    let variables = [
        ("NOTIFY_SOCKET", OsStr::new(&address)),
        // The watchdog is another process's.
        ("WATCHDOG_USEC", OsStr::new("100000")),
        ("WATCHDOG_PID", OsStr::new("1")),
    ];
    let daemon = server(&sandbox, &variables, &[]);
    until_told(&socket, "READY=1");
    daemon.signal(Signal::TERM);
    let mut pings = 0;
    until("it ends", || {
        let message = told(&socket, DEADLINE).unwrap();
        pings += u32::from(has(&message, "WATCHDOG=1"));
        has(&message, "STOPPING=1").then_some(())
    });
    assert_eq!(pings, 0);
    assert_eq!(daemon.finished().code(), Some(0));
}

#[test]
fn a_manager_that_is_not_there_harms_nothing() {
    let sandbox = Sandbox::new(BINARY);
    let nowhere = sandbox.runtime().join("nobody");
    let daemon = server(&sandbox, &[("NOTIFY_SOCKET", nowhere.as_os_str())], &[]);
    until("it answers", || (sandbox.run(&["status"]).code() == Some(0)).then_some(()));
    assert_eq!(daemon.ended().code(), Some(0));
}

#[test]
fn json_logs_are_an_object_a_line_whatever_bodies_are_called() {
    let sandbox = Sandbox::new(BINARY);
    let daemon = server(&sandbox, &[], &["--log-json"]);
    until("it answers", || (sandbox.run(&["status"]).code() == Some(0)).then_some(()));
    let hostile = r#"a"},{"level":"x\n"#;
    let body = sandbox.start_program(PEER, &["body", "default", hostile]);
    until("it moves", || (sandbox.status("default")["step"].as_u64() > Some(3)).then_some(()));
    drop(body);
    daemon.says("body gone");
    let daemon = daemon.ended();
    let mut names = Vec::new();
    for line in daemon.stderr.lines() {
        let one: Value = serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}"));
        assert!(one["timestamp"].is_string() && one["level"].is_string(), "{line}");
        names.extend(one["fields"]["body"].as_str().map(str::to_owned));
    }
    assert_eq!(names, [hostile, hostile], "{}", daemon.stderr);
}

#[test]
fn levels_of_the_log_are_chosen_and_a_refused_choice_is_told() {
    let sandbox = Sandbox::new(BINARY);
    let quiet = server(&sandbox, &[("RUST_LOG", OsStr::new("error"))], &["--name", "quiet"]);
    let talking = server(&sandbox, &[("RUST_LOG", OsStr::new("debug"))], &["--name", "talking"]);
    for name in ["quiet", "talking"] {
        until("it answers", || (sandbox.run(&["status", "--name", name]).code() == Some(0)).then_some(()));
    }
    let (quiet, talking) = (quiet.ended(), talking.ended());
    assert_eq!(quiet.stderr, "");
    assert!(talking.stderr.contains("DEBUG") && talking.stderr.contains("INFO"), "{}", talking.stderr);
}

/// The unit as the machine's own systemd reads it.
#[test]
fn the_unit_is_one_that_systemd_accepts() {
    let unit = include_str!("../../packaging/systemd/pschema@.service");
    let directory = tempfile::tempdir().unwrap();
    // The program and the user of the unit are made when it is installed.
    let unit = unit.replace("/usr/local/bin/pschema", BINARY).replace("User=pschema", "User=root");
    let path = directory.path().join("pschema@robot.service");
    std::fs::write(&path, unit.replace("Group=pschema", "Group=root")).unwrap();
    let verified = match Command::new("systemd-analyze").args(["verify", "--man=no"]).arg(&path).output() {
        Ok(output) => output,
        Err(error) if error.kind() == ErrorKind::NotFound => {
            let mut said = std::io::stderr();
            writeln!(said, "SKIPPED the_unit_is_one_that_systemd_accepts: there is no systemd-analyze")
                .unwrap();
            return;
        }
        Err(error) => panic!("{error}"),
    };
    let said = String::from_utf8_lossy(&verified.stderr).into_owned();
    let ours: Vec<_> = said.lines().filter(|line| line.contains("pschema@")).collect();
    assert!(verified.status.success() && ours.is_empty(), "{}: {said}", verified.status);
}
