//! `pschema demo`: the first thing anyone types. However it ends, it leaves nothing behind.

use std::path::{Path, PathBuf};

use pschema_tests::{
    ChildProcess, Leftovers, Sandbox, demo_directory, processes_with, signal_process, until,
};
use rustix::process::Signal;

const BINARY: &str = env!("CARGO_BIN_EXE_pschema-under-test");

/// A demo in the middle of things, and where it does them.
struct Demo {
    process: ChildProcess,
    pid: u32,
    directory: PathBuf,
    leftovers: Leftovers,
}

fn started(sandbox: &Sandbox) -> Demo {
    let process = sandbox.start(&["demo", "--seed", "5"]);
    let pid = process.pid();
    let directory = until("the demo has its directory", || demo_directory(pid));
    let mut leftovers = Leftovers::of(&directory);
    until("the demo's daemon has its epoch", || (leftovers.note() > 0).then_some(()));
    Demo { process, pid, directory, leftovers }
}

/// Waits for everything to be gone that must go by itself.
fn nothing_is_left(pid: u32, directory: &Path, leftovers: &Leftovers) {
    let name = format!("demo-{pid}");
    until(&format!("the processes of {name} end"), || processes_with(&name).is_empty().then_some(()));
    assert!(!directory.exists(), "{} is left", directory.display());
    assert_eq!(leftovers.left(), Vec::<String>::new());
}

#[test]
fn it_tells_what_the_robot_learns_and_leaves_nothing() {
    let sandbox = Sandbox::new(BINARY);
    let Demo { process, pid, directory, leftovers } = started(&sandbox);
    let demo = process.finished();
    assert_eq!(demo.code(), Some(0), "{demo:?}");
    for told in [
        "babbling",
        "blue block",
        "generalised after placement 2",
        "remembers the exception",
        "places never seen",
    ] {
        assert!(demo.stderr.contains(told), "{told:?} is not in the story:\n{}", demo.stderr);
    }
    let learnt = demo.stdout.replace("\n  ", " ");
    assert!(learnt.contains("of any colour $") && learnt.contains("and it touches"), "{learnt}");
    assert!(learnt.contains("but it does not touch"), "the exception is shown: {learnt}");
    assert!(learnt.contains("227") && learnt.contains("memory digest"), "{learnt}");
    assert!(
        !learnt.contains('\x1b') && !demo.stderr.contains('\x1b'),
        "no colour where there is no terminal"
    );
    nothing_is_left(pid, &directory, &leftovers);
}

#[test]
fn ctrl_c_and_sigterm_end_it_early_and_cleanly() {
    let sandbox = Sandbox::new(BINARY);
    for signal in [Signal::INT, Signal::TERM] {
        let Demo { process, pid, directory, leftovers } = started(&sandbox);
        process.signal(signal);
        let demo = process.finished();
        assert_eq!(demo.code(), Some(1), "{signal:?}: {demo:?}");
        assert!(demo.stderr.contains("stopped before the end"), "{demo:?}");
        nothing_is_left(pid, &directory, &leftovers);
    }
}

#[test]
fn a_body_that_dies_is_reported_and_nothing_is_left() {
    let sandbox = Sandbox::new(BINARY);
    let Demo { process, pid, directory, leftovers } = started(&sandbox);
    let own = format!("demo-{pid}");
    let body = until("the demo's body runs", || {
        let bodies = processes_with("sim");
        processes_with(&own).into_iter().find(|pid| bodies.contains(pid))
    });
    signal_process(body, Signal::KILL);
    let demo = process.finished();
    assert_eq!(demo.code(), Some(1), "{demo:?}");
    assert!(demo.stderr.contains("the body ended too early"), "{demo:?}");
    nothing_is_left(pid, &directory, &leftovers);
}

#[test]
fn a_demo_that_is_killed_takes_its_processes_with_it() {
    let sandbox = Sandbox::new(BINARY);
    let Demo { process, pid, directory, leftovers } = started(&sandbox);
    process.signal(Signal::KILL);
    assert_eq!(process.finished().code(), None);
    nothing_is_left(pid, &directory, &leftovers);
}
