//! The places that a daemon holds go away under it: its data directory, its runtime directory, its shared memory.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

use std::fs;
use std::path::Path;
use std::process::Command;

use pschema_tests::{Sandbox, prefix_of, shared_files, until};
use serde_json::Value;

const BINARY: &str = env!("CARGO_BIN_EXE_pschema-under-test");

fn step_at(sandbox: &Sandbox) -> Option<u64> {
    let status = sandbox.run(&["status", "--json"]);
    (status.code() == Some(0)).then(|| status.json()["step"].as_u64().unwrap())
}

/// What `pschema status` acknowledged is found again, whatever became of the directory meanwhile.
#[test]
fn a_data_directory_that_is_copied_under_its_daemon_ends_it_and_loses_nothing() {
    let sandbox = Sandbox::new(BINARY);
    let (life, away) = (sandbox.runtime().join("life"), sandbox.runtime().join("away"));
    let data = ["--data", life.to_str().unwrap()];
    let daemon = sandbox.daemon("default", &data);
    let body = sandbox.body("default", &[]);
    let mut acknowledged = sandbox.past("default", 20);
    fs::rename(&life, &away).unwrap();
    assert!(Command::new("cp").arg("-a").args([&away, &life]).status().unwrap().success());
    while let Some(step) = step_at(&sandbox) {
        acknowledged = acknowledged.max(step);
    }
    let daemon = daemon.finished();
    assert_eq!(daemon.code(), Some(1), "{daemon:?}");
    assert!(daemon.stderr.contains("life was moved or removed"), "{daemon:?}");
    // What was acknowledged is in the directory that was moved.
    fs::remove_dir_all(&life).unwrap();
    fs::rename(&away, &life).unwrap();
    let daemon = sandbox.daemon("default", &data);
    assert!(step_at(&sandbox).unwrap() >= acknowledged);
    assert_eq!(body.ended().code(), Some(0));
    assert_eq!(daemon.ended().code(), Some(0));
}

/// Removes all that `under` has, as those do who clean up by age or by user.
fn cleaned(directory: &Path, under: impl Fn(&str) -> bool) {
    for entry in fs::read_dir(directory).unwrap().flatten() {
        if under(&entry.file_name().to_string_lossy()) {
            let path = entry.path();
            // Whoever uses it may remove it at the same time.
            drop(if path.is_dir() { fs::remove_dir_all(&path) } else { fs::remove_file(&path) });
        }
    }
}

#[test]
fn a_daemon_whose_runtime_directory_or_shared_memory_was_cleaned_up_is_found_again() {
    let sandbox = Sandbox::new(BINARY);
    let runtime = sandbox.runtime().join("run");
    let sandbox_runtime = runtime.to_str().unwrap().to_owned();
    let run = |arguments: &[&str]| {
        let with = format!("PSCHEMA_RUNTIME_DIR={sandbox_runtime}");
        let arguments = [&[with.as_str(), BINARY], arguments].concat();
        sandbox.start_program("env", &arguments)
    };
    let daemon = run(&["server"]);
    let body = run(&["sim"]);
    let status = || -> Option<Value> {
        let status = run(&["status", "--json"]).finished();
        (status.code() == Some(0)).then(|| status.json())
    };
    let past = |at: u64| {
        until("steps are taken", || {
            let status = status()?;
            let step = status["step"].as_u64()?;
            (step > at && status["bodies"][0]["state"] == "attached").then_some(step)
        })
    };
    let mut at = past(10);
    let mut prefix = prefix_of(&runtime, "default");
    for mishap in ["shared memory", "the runtime directory", "the learner's directory", "the domain file"] {
        match mishap {
            "shared memory" => cleaned(Path::new("/dev/shm"), |name| name.starts_with(&prefix)),
            "the runtime directory" => fs::remove_dir_all(&runtime).unwrap_or_default(),
            "the domain file" => fs::remove_file(runtime.join("default/domain")).unwrap(),
            _ => fs::remove_dir_all(runtime.join("default")).unwrap(),
        }
        until(&format!("a new epoch after {mishap} was removed"), || {
            let domain = fs::read_to_string(runtime.join("default/domain")).ok()?;
            (!domain.contains(&prefix) && domain.contains("state = ready")).then_some(())
        });
        prefix = prefix_of(&runtime, "default");
        // Memory is the same, and its body has come back.
        at = past(at);
    }
    assert_eq!(body.ended().code(), Some(0));
    let daemon = daemon.ended();
    assert_eq!(daemon.code(), Some(0), "{daemon:?}");
    assert!(daemon.stderr.contains("it begins a new epoch"), "{daemon:?}");
    assert_eq!(shared_files(&prefix), Vec::<String>::new());
}

/// Where another daemon serves the learner by now, the first leaves it in peace.
#[test]
fn a_daemon_that_another_replaced_ends_and_says_so() {
    let sandbox = Sandbox::new(BINARY);
    let first = sandbox.daemon("default", &[]);
    let pid = first.pid();
    rustix::process::kill_process(
        rustix::process::Pid::from_raw(i32::try_from(pid).unwrap()).unwrap(),
        rustix::process::Signal::STOP,
    )
    .unwrap();
    fs::remove_dir_all(sandbox.runtime().join("default")).unwrap();
    let second = sandbox.daemon("default", &[]);
    first.signal(rustix::process::Signal::CONT);
    let first = first.finished();
    assert_eq!(first.code(), Some(1), "{first:?}");
    let named = format!("process {}", second.pid());
    assert!(first.stderr.contains("was moved or removed") && first.stderr.contains(&named), "{first:?}");
    assert_eq!(sandbox.status("default")["pid"], second.pid(), "it was not cut off");
    assert_eq!(second.ended().code(), Some(0));
    assert_eq!(sandbox.left(), Vec::<String>::new());
}

#[test]
fn memory_that_has_come_to_its_limit_learns_nothing_new_and_goes_on() {
    let sandbox = Sandbox::new(BINARY);
    let life = sandbox.runtime().join("life");
    let data = ["--data", life.to_str().unwrap()];
    let body = sandbox.body("default", &[]);
    // A limit below what the daemon takes by itself is refused with what that is, before anything is made.
    let server = [&["server", "--name", "default"], &data[..]].concat();
    let refused = sandbox.run(&[&server[..], &["--memory-max", "5"]].concat());
    assert_eq!(refused.code(), Some(1), "{refused:?}");
    let taken =
        refused.stderr.split_once("the daemon takes ").and_then(|(_, rest)| rest.split_once(" bytes"));
    let taken: u64 = taken.unwrap().0.parse().unwrap();
    assert!(!life.exists() && refused.stderr.contains("--memory-max 5"), "{refused:?}");
    // A little more is what the daemon has taken by the time at which it is ready.
    let max = taken + (1 << 20);
    let daemon = sandbox.daemon("default", &[&data[..], &["--memory-max", &max.to_string()]].concat());
    daemon.says("nothing new is learnt from here");
    let _acting = sandbox.past("default", 50);
    let status = sandbox.status("default");
    assert_eq!((&status["memory_full"], &status["memory_max_bytes"]), (&true.into(), &max.into()));
    let learnt = status["schemas_total"].as_u64().unwrap();
    let at = sandbox.past("default", status["step"].as_u64().unwrap() + 100);
    assert_eq!(
        sandbox.status("default")["schemas_total"],
        learnt,
        "the curriculum leads on, and no schema is made"
    );
    let text = sandbox.run(&["status"]);
    assert!(text.stdout.contains("of at most ") && text.stdout.contains("; it is full"), "{text:?}");
    assert_eq!(daemon.ended().code(), Some(0));
    assert_eq!(body.finished().code(), Some(0), "it was sent away");

    let verified = sandbox.run(&["verify", "--data", data[1], "--relearn"]);
    assert_eq!(verified.code(), Some(0), "{verified:?}");
    let daemon = sandbox.daemon("default", &[&data[..], &["--memory-max", &max.to_string()]].concat());
    daemon.says("memory is as full as it was: nothing new is learnt");
    assert_eq!(daemon.ended().code(), Some(0));
    let daemon = sandbox.daemon("default", &[&data[..], &["--memory-max", "none"]].concat());
    daemon.says("memory has room again");
    let body = sandbox.body("default", &[]);
    let _on = sandbox.past("default", at);
    until("it learns again", || {
        let now = sandbox.status("default");
        (now["memory_full"] == false && now["schemas_total"].as_u64().unwrap() > learnt).then_some(())
    });
    assert_eq!(body.ended().code(), Some(0));
    assert_eq!(daemon.ended().code(), Some(0));
}

#[test]
fn too_few_files_are_said_at_the_start_and_a_soft_limit_is_raised() {
    let sandbox = Sandbox::new(BINARY);
    let limited = |limit: &str| format!("ulimit {limit} 64; exec '{BINARY}' server");
    // Shared memory only says that it failed.
    for (peer, who) in [("sim", "a body"), ("status", "a tool")] {
        let few = format!("ulimit -n 16; exec '{BINARY}' {peer}");
        let refused = sandbox.start_program("/bin/sh", &["-c", &few]).finished();
        assert_eq!(refused.code(), Some(1), "{refused:?}");
        let told = format!("this process may open 16 files, and {who} needs 128: run `ulimit -n 128` first");
        assert!(refused.stderr.contains(&told), "{refused:?}");
    }
    let refused = sandbox.start_program("/bin/sh", &["-c", &limited("-n")]).finished();
    assert_eq!(refused.code(), Some(1), "{refused:?}");
    assert!(
        refused.stderr.contains("may open 64 files") && refused.stderr.contains("ulimit -n"),
        "{refused:?}"
    );
    let raised = sandbox.start_program("/bin/sh", &["-c", &limited("-S -n")]);
    until("the daemon serves", || step_at(&sandbox));
    let limits = fs::read_to_string(format!("/proc/{}/limits", raised.pid())).unwrap();
    let files = limits.lines().find(|line| line.starts_with("Max open files")).unwrap();
    assert_eq!(files.split_whitespace().nth(3), Some("1024"), "{files}");
    assert_eq!(raised.ended().code(), Some(0));
    assert_eq!(sandbox.left(), Vec::<String>::new());
}
