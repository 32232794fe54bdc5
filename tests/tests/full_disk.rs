//! A data directory on a disk that becomes full: no action after the failure, a message that helps, and a start that goes on
//! once there is room. The disk is a small file system in a mount namespace, which needs no privilege.

#![allow(clippy::unwrap_used)] // A test panics to fail.

use std::io::Write;
use std::process::{Command, Stdio};

use pschema_tests::{ChildProcess, Sandbox, until};

const BINARY: &str = env!("CARGO_BIN_EXE_pschema-under-test");
const PEER: &str = env!("CARGO_BIN_EXE_pschema-test-peer");

/// Serves on 2 MiB until that is full, then on 64.
const SCRIPT: &str = r#"
set -e
mkdir "$1"
mount -t tmpfs -o size=2m tmpfs "$1"
"$0" server --data "$1" && exit 9
echo "the first ended"
mount -o remount,size=64m "$1"
exec "$0" server --data "$1"
"#;

fn orders(body: &ChildProcess) -> u64 {
    let said = body.stdout();
    let last = said.lines().rev().find_map(|line| line.strip_suffix(" orders")?.parse().ok());
    last.unwrap_or(0)
}

#[test]
fn a_full_disk_ends_the_daemon_with_a_reason_and_loses_nothing_acknowledged() {
    let possible = Command::new("unshare").args(["-rm", "true"]).stderr(Stdio::null()).status();
    if !possible.is_ok_and(|status| status.success()) {
        let mut said = std::io::stderr();
        writeln!(
            said,
            "SKIPPED a_full_disk: this machine gives no user namespaces (`unshare -rm true` fails)"
        )
        .unwrap();
        return;
    }
    let sandbox = Sandbox::new(BINARY);
    let data = sandbox.runtime().join("data");
    let arguments = ["-rm", "sh", "-c", SCRIPT, BINARY, data.to_str().unwrap()];
    let daemons = sandbox.start_program("unshare", &arguments);
    let body = sandbox.start_program(PEER, &["body", "default", "row"]);
    daemons.says("the first ended");
    let said = daemons.stderr();
    let error = said.lines().rev().find(|line| line.contains("No space left")).unwrap_or_default();
    assert!(error.contains("data/journal"), "the reason names the place: {said}");
    let acknowledged = orders(&body);
    assert!(acknowledged > 100, "{acknowledged} orders before 2 MiB were full");
    let found = until("the second answers", || {
        let status = sandbox.run(&["status", "--json"]);
        (status.code() == Some(0)).then(|| status.json()["storage"]["durable_step"].as_u64().unwrap())
    });
    assert!(found >= acknowledged, "{found} of {acknowledged} steps");
    until("the same body goes on", || (orders(&body) > acknowledged + 20).then_some(()));
    drop(body);
    let daemon = sandbox.status("default")["pid"].as_u64().unwrap();
    pschema_tests::signal_process(u32::try_from(daemon).unwrap(), rustix::process::Signal::TERM);
    assert_eq!(daemons.finished().code(), Some(0));
    assert_eq!(sandbox.left(), Vec::<String>::new());
}
