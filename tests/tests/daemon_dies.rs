//! The daemon is stopped, killed, started again and written over, while bodies are attached to it.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

use std::fs::OpenOptions;
use std::os::unix::fs::FileExt;
use std::path::Path;
use std::time::{Duration, Instant};

use pschema_tests::{ChildProcess, DEADLINE, Sandbox, count, prefix_of, shared_files, until};
use rustix::process::Signal;

const BINARY: &str = env!("CARGO_BIN_EXE_pschema-under-test");
const PEER: &str = env!("CARGO_BIN_EXE_pschema-test-peer");

/// Orders that a body said it carried out.
fn orders(body: &ChildProcess) -> u64 {
    let said = body.stdout();
    let last = said.lines().rev().find_map(|line| line.strip_suffix(" orders")?.parse().ok());
    last.unwrap_or(0)
}

#[test]
fn stopped_it_is_waited_for_and_the_body_says_so() {
    let sandbox = Sandbox::new(BINARY);
    let daemon = sandbox.daemon("default", &[]);
    let body = sandbox.start_program(PEER, &["body", "default", "waiting"]);
    until("it moves", || (orders(&body) > 20).then_some(()));
    daemon.signal(Signal::STOP);
    body.says("the daemon does not reply: it is stopped, very busy, or waiting for a slow disk; holding");
    let at = orders(&body);
    let tool = sandbox.start(&["status"]);
    daemon.signal(Signal::CONT);
    body.says("the daemon replies again; going on");
    until("it goes on", || (orders(&body) > at + 20).then_some(()));
    assert_eq!(tool.finished().code(), Some(0), "a tool waits as well");
    let status = sandbox.status("default");
    assert_eq!(status["bodies"][0]["id"], 1, "still its first session: {status}");
    drop(body);
    assert_eq!(daemon.ended().code(), Some(0));
    assert_eq!(sandbox.left(), Vec::<String>::new());
}

#[test]
fn killed_again_and_again_its_life_goes_on_with_the_same_simulated_body() {
    let sandbox = Sandbox::new(BINARY);
    let data = sandbox.runtime().join("data");
    let arguments = ["--data", data.to_str().unwrap(), "--seed", "5"];
    let mut daemon = sandbox.daemon("default", &arguments);
    let body = sandbox.body("default", &[]);
    let mut at = 0;
    for life in 0..4 {
        at = sandbox.past("default", at + 5);
        daemon.signal(Signal::KILL);
        assert_eq!(daemon.finished().code(), None);
        daemon = sandbox.daemon("default", &arguments);
        let now = sandbox.status("default");
        assert!(now["durable_step"].as_u64().unwrap() >= at, "life {life}: {now}");
        let found = now["step"].as_u64().unwrap();
        assert!(found >= at, "life {life}: {now}");
        at = found;
    }
    let _on = sandbox.past("default", at);
    let bodies = sandbox.status("default");
    assert_eq!(bodies["bodies"][0]["pid"], body.pid(), "{bodies}");
    assert_eq!(body.ended().code(), Some(0));
    assert_eq!(daemon.ended().code(), Some(0));
    assert_eq!(sandbox.left(), Vec::<String>::new());
}

/// Numbers from a seed.
struct Draws(u64);

impl Draws {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.0 >> 20
    }
}

/// Writes nonsense over some bytes of one of the daemon's files in shared memory.
fn scribble(prefix: &str, draws: &mut Draws) {
    let files = shared_files(prefix);
    let Some(name) = files.get(draws.next() as usize % files.len().max(1)) else { return };
    let Ok(file) = OpenOptions::new().write(true).open(Path::new("/dev/shm").join(name)) else { return };
    let length = file.metadata().map_or(0, |found| found.len()).max(1);
    let bytes: Vec<u8> = (0..draws.next() % 256).map(|_| draws.next() as u8).collect();
    // Mostly near the beginning, where headers and counters are.
    let at =
        if draws.next().is_multiple_of(4) { draws.next() % length } else { draws.next() % length.min(4096) };
    let bytes = &bytes[..bytes.len().min((length - at) as usize)];
    file.write_all_at(bytes, at).unwrap();
}

/// A hostile process of the same user can write into shared memory. The daemon may crash or hang by that;
/// whoever supervises it starts it again, and nothing that a body acted on is lost.
#[test]
fn written_over_by_a_process_of_the_same_user_it_loses_nothing_acknowledged() {
    let rounds = count("PSCHEMA_SCRIBBLES", 8);
    let seed = 2011;
    println!("seed {seed}");
    let mut draws = Draws(seed);
    let sandbox = Sandbox::new(BINARY);
    let data = sandbox.runtime().join("data");
    let arguments = ["--data", data.to_str().unwrap()];
    let (mut acknowledged, mut crashed, mut hung, mut survived) = (0, 0, 0, 0);
    for round in 0..rounds {
        let daemon = sandbox.daemon("default", &arguments);
        let found = sandbox.status("default")["step"].as_u64().unwrap();
        assert!(found >= acknowledged, "round {round}: {found} of {acknowledged} steps");
        let body = sandbox.start_program(PEER, &["body", "default", "victim"]);
        until("it moves", || (orders(&body) > 20).then_some(()));
        let prefix = prefix_of(sandbox.runtime(), "default");
        let begin = Instant::now();
        let mut answers = true;
        for _ in 0..400 {
            scribble(&prefix, &mut draws);
            answers = house_lives(&daemon);
            if !answers {
                break;
            }
        }
        acknowledged = found.max(orders_since(found, &body));
        drop(body);
        if !answers {
            crashed += 1;
        } else if answered_in_time(&sandbox) {
            survived += 1;
        } else {
            hung += 1;
        }
        drop(daemon);
        assert!(begin.elapsed() < DEADLINE);
    }
    println!("{rounds} rounds: {crashed} crashed, {hung} hung, {survived} survived");
    let daemon = sandbox.daemon("default", &arguments);
    let status = sandbox.status("default");
    assert!(status["step"].as_u64().unwrap() >= acknowledged, "{status} after {acknowledged}");
    let body = sandbox.start_program(PEER, &["body", "default", "victim"]);
    until("learning goes on", || (orders(&body) > 20).then_some(()));
    drop(body);
    assert_eq!(daemon.ended().code(), Some(0));
    assert_eq!(sandbox.left(), Vec::<String>::new());
}

/// Whether the process is there and not a zombie.
fn house_lives(daemon: &ChildProcess) -> bool {
    let stat = std::fs::read_to_string(format!("/proc/{}/stat", daemon.pid())).unwrap_or_default();
    stat.rsplit(')').next().is_some_and(|rest| !rest.trim_start().starts_with(['Z', 'X']) && !rest.is_empty())
}

/// A tool's patience with a daemon whose shared memory was written over. In service a watchdog ends such a daemon.
fn answered_in_time(sandbox: &Sandbox) -> bool {
    let tool = sandbox.start(&["status"]);
    let begin = Instant::now();
    let pid = tool.pid();
    while begin.elapsed() < Duration::from_secs(5) {
        if !std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default().contains(") Z") {
            std::thread::sleep(Duration::from_millis(10));
            continue;
        }
        return tool.finished().code() == Some(0);
    }
    false
}

/// The step of the last order that a body of this round carried out: each was acknowledged after `found`.
fn orders_since(found: u64, body: &ChildProcess) -> u64 {
    found + orders(body)
}
