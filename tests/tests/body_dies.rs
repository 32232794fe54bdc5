//! Bodies and tools that are killed or stopped wherever they are: nothing of them stays, and nobody else notices.
//!
//! `PSCHEMA_DEATHS=200 cargo test -p pschema-tests --test body_dies` goes 200 rounds of deaths instead of 20.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

use pschema_tests::{ChildProcess, Sandbox, count, descriptors, own_memory, prefix_of, shared_files, until};
use rustix::process::Signal;
use serde_json::Value;

const BINARY: &str = env!("CARGO_BIN_EXE_pschema-under-test");
const PEER: &str = env!("CARGO_BIN_EXE_pschema-test-peer");

/// Where a body is killed: in its handshake, with a loan in its hands, with a frame under way, and after the reply.
const POINTS: [&str; 8] = [
    "node open",
    "frame port open",
    "hello loaned",
    "hello sent",
    "welcome received",
    "frame loaned",
    "frame sent",
    "reply received",
];

fn body(sandbox: &Sandbox, name: &str, point: Option<&str>) -> ChildProcess {
    sandbox.start_program(PEER, &[&["body", "default", name], point.as_slice()].concat())
}

fn killed(process: ChildProcess) {
    process.signal(Signal::KILL);
    assert_eq!(process.finished().code(), None);
}

fn named<'a>(status: &'a Value, name: &str) -> Option<&'a Value> {
    let bodies = status["bodies"].as_array().unwrap();
    bodies.iter().find(|body| body["name"] == name && body["state"] == "attached")
}

fn frames(sandbox: &Sandbox, name: &str) -> u64 {
    named(&sandbox.status("default"), name).map_or(0, |body| body["frames"].as_u64().unwrap())
}

fn attached(sandbox: &Sandbox) -> usize {
    let status = sandbox.status("default");
    let bodies = status["bodies"].as_array().unwrap();
    bodies.iter().filter(|body| body["state"] == "attached").count()
}

/// Whether no file is in shared memory but those that were there `before`. Names are drawn anew for each peer, so that one that came
/// later is not among them.
fn nothing_beside(prefix: &str, before: &[String]) -> Option<()> {
    shared_files(prefix).iter().all(|file| before.contains(file)).then_some(())
}

#[test]
fn killed_at_any_point_it_leaves_nothing_and_another_goes_on() {
    let rounds = count("PSCHEMA_DEATHS", 20);
    let sandbox = Sandbox::new(BINARY);
    let daemon = sandbox.daemon("default", &[]);
    let prefix = prefix_of(sandbox.runtime(), "default");
    let survivor = body(&sandbox, "survivor", None);
    until("the survivor moves", || (frames(&sandbox, "survivor") > 50).then_some(()));
    // With those of a tool that asked just now and that are being removed; the survivor's are all there when it moves.
    let files = shared_files(&prefix);
    let session = named(&sandbox.status("default"), "survivor").unwrap()["id"].clone();
    let (mut open, mut own, mut taught) = (0, 0, 0);
    for round in 0..rounds {
        for group in POINTS.chunks(4) {
            let before = frames(&sandbox, "survivor");
            let start =
                |(number, point): (usize, &&str)| body(&sandbox, &format!("victim-{number}"), Some(point));
            let victims: Vec<_> = group.iter().enumerate().map(start).collect();
            for (victim, point) in victims.iter().zip(group) {
                victim.says(&format!("at {point}"));
            }
            victims.into_iter().for_each(killed);
            until(&format!("round {round}: what {group:?} left is removed"), || {
                nothing_beside(&prefix, &files)
            });
            until(&format!("round {round}: {group:?} are missed"), || {
                (attached(&sandbox) == 1).then_some(())
            });
            until("the survivor goes on", || (frames(&sandbox, "survivor") > before + 20).then_some(()));
        }
        if round == 2 {
            // The steps are counted before the memory that they take, and at the end behind it, so that none is left out.
            taught = frames(&sandbox, "survivor");
            (open, own) = (descriptors(daemon.pid()), own_memory(daemon.pid()));
        }
    }
    let status = sandbox.status("default");
    assert_eq!(named(&status, "survivor").unwrap()["id"], session, "it was never disturbed");
    assert_eq!(named(&status, "survivor").unwrap()["frames_refused"], 0);
    // Those of the last body that was killed are closed when its death is noticed.
    until("no more descriptors are open than after two rounds", || {
        (descriptors(daemon.pid()) <= open).then_some(())
    });
    // A record is kept of each of the last 65,536 steps, which takes some 600 bytes. The place of one body is 300 KiB.
    let grown = own_memory(daemon.pid()).saturating_sub(own);
    let steps = (frames(&sandbox, "survivor") - taught).min(65_536);
    let limit = steps * 700 + 4 * 1024 * 1024;
    assert!(grown < limit, "{rounds} rounds, {steps} steps: {grown} bytes");
    println!("{} deaths; memory grew by {grown} bytes in {steps} steps", rounds * POINTS.len() as u64);
    drop(survivor);
    assert_eq!(daemon.ended().code(), Some(0));
    assert_eq!(sandbox.left(), Vec::<String>::new());
}

#[test]
fn stopped_it_keeps_its_session_and_delays_nobody() {
    let sandbox = Sandbox::new(BINARY);
    let daemon = sandbox.daemon("default", &[]);
    let (stopped, other) = (body(&sandbox, "stopped", None), body(&sandbox, "other", None));
    for name in ["stopped", "other"] {
        until("both move", || (frames(&sandbox, name) > 10).then_some(()));
    }
    let session = named(&sandbox.status("default"), "stopped").unwrap()["id"].clone();
    for _ in 0..5 {
        stopped.halt();
        // One more may have been under way.
        let (still, moving) = (frames(&sandbox, "stopped") + 1, frames(&sandbox, "other"));
        until("the other goes on", || (frames(&sandbox, "other") > moving + 100).then_some(()));
        let status = sandbox.status("default");
        assert!(named(&status, "stopped").unwrap()["frames"].as_u64().unwrap() <= still, "{status}");
        stopped.signal(Signal::CONT);
        until("it goes on", || (frames(&sandbox, "stopped") > still).then_some(()));
    }
    assert_eq!(named(&sandbox.status("default"), "stopped").unwrap()["id"], session);
    stopped.halt();
    killed(stopped);
    until("a body killed while it was stopped is missed", || (attached(&sandbox) == 1).then_some(()));
    drop(other);
    assert_eq!(daemon.ended().code(), Some(0));
    assert_eq!(sandbox.left(), Vec::<String>::new());
}

/// Tools that ask and never read take places of tools and no time; a tool that comes when all places are taken is told so.
#[test]
fn stopped_tools_delay_nobody_and_give_their_places_back() {
    let sandbox = Sandbox::new(BINARY);
    let daemon = sandbox.daemon("default", &[]);
    let moving = body(&sandbox, "moving", None);
    until("it moves", || (frames(&sandbox, "moving") > 10).then_some(()));
    let prefix = prefix_of(sandbox.runtime(), "default");
    let files = shared_files(&prefix);
    let point = |number: u32| if number.is_multiple_of(2) { "request sent" } else { "page received" };
    let mut tools = Vec::new();
    for number in 0..15 {
        let tool = sandbox.start_program(PEER, &["tool", "default", "tool", point(number)]);
        tool.says(&format!("at {}", point(number)));
        tools.push(tool);
    }
    let before = frames(&sandbox, "moving");
    until("the body goes on", || (frames(&sandbox, "moving") > before + 100).then_some(()));
    let last = sandbox.start_program(PEER, &["tool", "default", "tool", "request sent"]);
    last.says("at request sent");
    let refused = sandbox.run(&["schemas"]);
    assert_eq!(refused.code(), Some(1), "{refused:?}");
    assert!(refused.stderr.contains("already has 16 tools"), "{refused:?}");
    // However many watch, whoever wants to look at the learner, to hold it or to send it somewhere can.
    let orders: [&[&str]; 6] = [
        &["status"],
        &["stage", "show"],
        &["say", "up"],
        &["achieve", "word{}", "--wait", "10"],
        &["stage", "hold"],
        &["stage", "resume"],
    ];
    for order in orders {
        let obeyed = sandbox.run(order);
        assert!(!obeyed.stderr.contains("already has 16 tools"), "{obeyed:?}");
        // Whether it is achieved is another matter.
        assert!(order[0] == "achieve" || obeyed.code() == Some(0), "{obeyed:?}");
    }
    // The daemon makes sure at its start that it may open 1,024.
    let open = descriptors(daemon.pid());
    assert!(open < 512, "{open} files are open, with all tools and one body");
    tools.push(last);
    tools.into_iter().for_each(killed);
    until("their places are free", || nothing_beside(&prefix, &files));
    let after = frames(&sandbox, "moving");
    until("the body goes on", || (frames(&sandbox, "moving") > after).then_some(()));
    drop(moving);
    assert_eq!(daemon.ended().code(), Some(0));
    assert_eq!(sandbox.left(), Vec::<String>::new());
}
