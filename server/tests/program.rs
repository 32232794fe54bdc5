//! The program `pschema-server` as it is run: signals end it cleanly, mistakes end it before it begins.

#![allow(clippy::unwrap_used)] // A test panics to fail.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use rustix::process::{Pid, Signal, kill_process};

fn program(directory: &Path, arguments: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_pschema-server"))
        .args(arguments)
        .env("PSCHEMA_RUNTIME_DIR", directory.join("run"))
        .env_remove("RUST_LOG")
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

fn directory() -> tempfile::TempDir {
    tempfile::Builder::new().prefix("ps").tempdir_in("/tmp").unwrap()
}

#[test]
fn signals_end_it_cleanly() {
    for (signal, json) in [(Signal::TERM, "--log-json"), (Signal::INT, "--seed=3")] {
        let directory = directory();
        let mut daemon = program(directory.path(), &["--name", "one", json]);
        let mut log = BufReader::new(daemon.stderr.take().unwrap());
        let mut line = String::new();
        while !line.contains("ready") {
            line.clear();
            assert!(log.read_line(&mut line).unwrap() > 0, "the daemon ended before it was ready");
        }
        assert_eq!(line.starts_with('{'), json == "--log-json", "{line}");
        let record = std::fs::read_to_string(directory.path().join("run/one/domain")).unwrap();
        let prefix = record.lines().find_map(|line| line.strip_prefix("prefix = ")).unwrap().to_owned();
        kill_process(Pid::from_child(&daemon), signal).unwrap();
        let mut rest = String::new();
        log.read_to_string(&mut rest).unwrap();
        assert!(daemon.wait().unwrap().success(), "{rest}");
        assert!(rest.contains("ended"), "{rest}");
        assert!(!directory.path().join("run/one/domain").exists());
        let left = std::fs::read_dir("/dev/shm").unwrap().filter_map(Result::ok);
        let left: Vec<_> =
            left.filter(|file| file.file_name().to_string_lossy().starts_with(&prefix)).collect();
        assert!(left.is_empty(), "{left:?}");
    }
}

#[test]
fn a_mistake_in_a_file_is_told_with_its_place_and_leaves_nothing() {
    let directory = directory();
    let config = directory.path().join("learner.toml");
    std::fs::write(&config, "attention = true\nassociation_weight = 2.0\n").unwrap();
    let config = config.to_str().unwrap();
    let cases = [
        (vec!["--config", config], "learner.toml:2:22: association_weight = 2 is outside 0..=1"),
        (vec!["--config", "/nowhere/learner.toml"], "cannot read /nowhere/learner.toml"),
        (vec!["--curriculum", "exp9"], "no curriculum \"exp9\""),
    ];
    for (arguments, complaint) in cases {
        let output = program(directory.path(), &arguments).wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(said.contains(complaint), "{arguments:?}: {said}");
        assert_eq!(output.status.code(), Some(1));
        assert!(!directory.path().join("run").exists(), "{arguments:?} left a runtime directory");
    }
}

#[test]
fn wrong_usage_is_its_own_exit_code() {
    let directory = directory();
    for arguments in [["--name", "No Such Name"], ["--seed", "soon"]] {
        let output = program(directory.path(), &arguments).wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    }
}
