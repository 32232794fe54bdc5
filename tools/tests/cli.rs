//! What can be typed: help, usage and exit codes, on the real binary.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use tempfile::TempDir;

/// A runtime directory of the test's own, short enough for sockets.
fn runtime() -> TempDir {
    let private = std::fs::Permissions::from_mode(0o700);
    tempfile::Builder::new().prefix("pschema-").permissions(private).tempdir_in("/tmp").unwrap()
}

fn pschema(runtime: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pschema"));
    command.args(arguments).env("PSCHEMA_RUNTIME_DIR", runtime).env_remove("RUST_LOG").stdin(Stdio::null());
    command.output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

const COMMANDS: [&str; 12] = [
    "demo",
    "server",
    "sim",
    "status",
    "schemas",
    "show",
    "explain",
    "say",
    "stage",
    "experiment",
    "doctor",
    "completions",
];

#[test]
fn every_command_has_help_with_an_example() {
    let runtime = runtime();
    let all = pschema(runtime.path(), &["--help"]);
    for command in COMMANDS {
        assert!(text(&all.stdout).contains(&format!("  {command} ")), "{command} is not in `pschema --help`");
        let help = pschema(runtime.path(), &[command, "--help"]);
        assert_eq!(help.status.code(), Some(0), "{command}");
        let help = text(&help.stdout);
        assert!(help.contains("Example:\n  pschema "), "{command} has no example:\n{help}");
        let alone = ["demo", "experiment", "doctor", "completions"].contains(&command);
        assert!(alone || help.contains("--name"), "{command} has no --name:\n{help}");
    }
    for order in ["show", "next", "hold", "resume", "set"] {
        let help = text(&pschema(runtime.path(), &["stage", order, "--help"]).stdout);
        assert!(help.contains("Example:\n  pschema stage "), "stage {order}:\n{help}");
    }
}

#[test]
fn a_name_is_taken_before_and_after_the_command() {
    let runtime = runtime();
    for arguments in [["--name", "robot-1", "status"], ["status", "--name", "robot-1"]] {
        let output = pschema(runtime.path(), &arguments);
        assert_eq!(output.status.code(), Some(3), "{arguments:?}");
        assert!(text(&output.stderr).contains("robot-1"), "{}", text(&output.stderr));
    }
}

#[test]
fn without_a_daemon_asking_exits_3_and_says_how_to_start_one() {
    let runtime = runtime();
    let questions: [&[&str]; 7] = [
        &["status"],
        &["status", "--json"],
        &["schemas", "--generalised"],
        &["show", "1"],
        &["explain"],
        &["say", "touch"],
        &["stage", "next"],
    ];
    for question in questions {
        let output = pschema(runtime.path(), question);
        assert_eq!(output.status.code(), Some(3), "{question:?}: {}", text(&output.stderr));
        assert!(output.stdout.is_empty(), "{question:?} has no result");
        let said = text(&output.stderr);
        assert!(said.contains("no daemon") && said.contains("start one"), "{question:?}: {said}");
    }
}

#[test]
fn wrong_usage_exits_2_and_points_at_it() {
    let runtime = runtime();
    let slips: [(&[&str], &str); 9] = [
        (&["demo", "--sead", "1"], "--seed"),
        (&["no-such-command"], "no-such-command"),
        (&["show"], "<ID>"),
        (&["show", "first"], "first"),
        (&["--name", "No Good", "status"], "a-z"),
        (&["experiment", "exp9"], "exp1-s1"),
        (&["experiment", "exp1-s1", "--seeds", "9..1"], "above"),
        (&["schemas", "--limit", "0"], "0"),
        (&["say"], "<WORD>"),
    ];
    for (arguments, says) in slips {
        let output = pschema(runtime.path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(output.stdout.is_empty(), "{arguments:?}");
        assert!(text(&output.stderr).contains(says), "{arguments:?}: {}", text(&output.stderr));
    }
}

#[test]
fn completions_know_the_commands() {
    let runtime = runtime();
    for shell in ["bash", "zsh", "fish"] {
        let output = pschema(runtime.path(), &["completions", shell]);
        assert_eq!(output.status.code(), Some(0), "{shell}");
        let script = text(&output.stdout);
        assert!(COMMANDS.iter().all(|command| script.contains(command)), "{shell}");
    }
}

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let runtime = runtime();
    let mut command = Command::new(env!("CARGO_BIN_EXE_pschema"));
    command.args(["completions", "bash"]).env("PSCHEMA_RUNTIME_DIR", runtime.path());
    let mut process = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(process.stdout.take());
    let output = process.wait_with_output().unwrap();
    assert_eq!(text(&output.stderr), "");
    assert_eq!(output.status.code(), Some(0));
}

#[test]
fn doctor_finds_a_runtime_directory_that_is_open_to_others() {
    let runtime = runtime();
    let well = pschema(runtime.path(), &["doctor", "--json"]);
    let findings: serde_json::Value = serde_json::from_slice(&well.stdout).unwrap();
    let checks = findings["checks"].as_array().unwrap();
    let found = checks.iter().find(|check| check["name"] == "runtime directory").unwrap();
    assert_eq!(found["ok"], true, "{findings}");

    std::fs::set_permissions(runtime.path(), std::fs::Permissions::from_mode(0o755)).unwrap();
    let ill = pschema(runtime.path(), &["doctor"]);
    assert_eq!(ill.status.code(), Some(1));
    assert!(text(&ill.stdout).contains("chmod 700"), "{}", text(&ill.stdout));
}
