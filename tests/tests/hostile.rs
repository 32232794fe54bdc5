//! A body and a tool that send wrong messages to a daemon which keeps its memory on disk: each message is refused
//! with its reason, all are counted by reason in `status`, and memory stays as it was.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

use pschema_inspect::codec::{self, Reply};
use pschema_inspect::{StatusQuery, ask};
use pschema_protocol::body::{Body, BodyLoop};
use pschema_protocol::client::Client;

use pschema_protocol::domain::{LearnerName, Place, RuntimeDir};
use pschema_protocol::refusal;
use pschema_protocol::transport::TransportError;
use pschema_protocol::transport::body_link::BodyLink;
use pschema_protocol::wire::message::RawFrame;
use pschema_protocol::wire::{kind, outcome, purpose, reply};
use pschema_tests::{DEADLINE, Row, Sandbox, until};
use serde_json::Value;

const BINARY: &str = env!("CARGO_BIN_EXE_pschema-under-test");
static NEVER: AtomicBool = AtomicBool::new(false);

fn place(sandbox: &Sandbox) -> Place {
    Place::new(RuntimeDir::at(sandbox.runtime()).unwrap(), LearnerName::new("default").unwrap())
}

fn refused(status: &Value) -> BTreeMap<String, u64> {
    let counts = status["refused"].as_array().unwrap();
    counts
        .iter()
        .map(|one| (one["reason"].as_str().unwrap().to_owned(), one["count"].as_u64().unwrap()))
        .collect()
}

/// A change that makes a sound frame of [`Row`] wrong. The records of such a frame are the finger (an integer), the object (a symbol and an
/// integer) and the extent (a real). Whether its number in the session is used up by that.
type Damage = (u32, bool, fn(&mut RawFrame));

const DAMAGES: [Damage; 22] = [
    (1, false, |raw| raw.header.magic = 0),
    (1, false, |raw| raw.header.magic = u32::MAX),
    (2, false, |raw| raw.header.version = u32::MAX),
    (3, false, |raw| raw.header.session = u64::MAX),
    (4, false, |raw| raw.header.sequence -= 1),
    (4, false, |raw| raw.header.sequence += 1),
    (4, false, |raw| raw.header.sequence = 0),
    (4, false, |raw| raw.header.sequence = u64::MAX),
    (5, true, |raw| raw.header.purpose = 77),
    (6, true, |raw| raw.header.outcome = 7),
    (7, true, |raw| raw.header.outcome = outcome::NONE),
    (7, true, |raw| raw.header.answers = u64::MAX),
    (8, true, |raw| raw.header.observation_count = u32::MAX),
    (8, true, |raw| raw.header.observation_count = 4097),
    (9, true, |raw| raw.records[0].index = 4),
    (10, true, |raw| raw.records[0].count = u16::MAX),
    (11, true, |raw| raw.records[0].kinds = kind::SYMBOL),
    (11, true, |raw| raw.records[1].values[0] = u64::MAX),
    (12, true, |raw| raw.records[1].values[0] = 2),
    (12, true, |raw| raw.records[0].values[0] = i64::MIN.cast_unsigned()),
    (12, true, |raw| raw.records[2].values[0] = f64::NAN.to_bits()),
    (12, true, |raw| raw.records[2].values[0] = f64::INFINITY.to_bits()),
];

#[test]
fn what_a_body_should_not_send_is_refused_counted_and_changes_nothing() {
    let sandbox = Sandbox::new(BINARY);
    let data = sandbox.runtime().join("data");
    let daemon = sandbox.daemon("default", &["--data", data.to_str().unwrap()]);
    let mut body = BodyLoop::new(Row::new("hostile"));
    let mut link = BodyLink::attach(&place(&sandbox), body.description(), &NEVER).unwrap();
    body.attached(link.session());
    for _ in 0..20 {
        let reply = link.exchange(body.next_frame(), &NEVER).unwrap();
        body.obey(&reply).unwrap();
    }
    let before = sandbox.status("default");
    let mut sound = body.next_frame().clone();
    let mut expected = BTreeMap::new();
    for (number, (code, uses_its_number, damage)) in DAMAGES.into_iter().enumerate() {
        let mut raw = sound.clone();
        damage(&mut raw);
        let answer = link.exchange(&raw, &NEVER).unwrap();
        let reason =
            String::from_utf8_lossy(&answer.reason.bytes[..answer.reason.length as usize]).into_owned();
        assert_eq!((answer.kind, answer.code), (reply::REFUSED, code), "damage {number}: {reason}");
        assert!(!reason.is_empty());
        *expected.entry(refusal::reason(code).to_owned()).or_insert(0) += 1;
        sound.header.sequence += u64::from(uses_its_number);
    }
    let after = sandbox.status("default");
    assert_eq!(refused(&after), expected);
    assert_eq!(after["bodies"][0]["frames_refused"], DAMAGES.len());
    assert_eq!((&after["step"], &after["memory_digest"]), (&before["step"], &before["memory_digest"]));
    assert_eq!(
        link.exchange(&sound, &NEVER).unwrap().kind,
        reply::ACT,
        "the frame itself is taken after all of that"
    );
    assert_eq!(sandbox.status("default")["step"], before["step"].as_u64().unwrap() + 1);
    link.detach();
    assert_eq!(daemon.ended().code(), Some(0));
    assert_eq!(sandbox.left(), Vec::<String>::new());
}

/// Floods, one after the other: introductions, frames that are refused, requests that are none.
#[test]
fn floods_are_counted_and_neither_fill_the_log_nor_the_disk_nor_memory() {
    const FLOOD: u64 = 2_000;
    let sandbox = Sandbox::new(BINARY);
    let data = sandbox.runtime().join("data");
    let daemon = sandbox.daemon("default", &["--data", data.to_str().unwrap()]);
    let mut good = BodyLoop::new(Row::new("good"));
    let mut link = BodyLink::attach(&place(&sandbox), good.description(), &NEVER).unwrap();
    good.attached(link.session());
    let mut serve = |times: u32| {
        for _ in 0..times {
            let reply = link.exchange(good.next_frame(), &NEVER).unwrap();
            good.obey(&reply).unwrap();
        }
    };
    serve(20);
    let before = sandbox.status("default");
    let journal = |status: &Value| status["storage"]["journal_bytes"].as_u64().unwrap();

    let bodies = Row::new("again").describe();
    for round in 0..60 {
        let again = BodyLink::attach(&place(&sandbox), &bodies, &NEVER);
        match again {
            // The daemon notices the body's end within a moment; until then the body's name is taken.
            Err(TransportError::Refused { code: 21, .. }) | Ok(_) => {}
            Err(error) => panic!("round {round}: {error}"),
        }
    }
    let nameless = Row::new("").describe();
    assert!(BodyLink::attach(&place(&sandbox), &nameless, &NEVER).is_err());

    let mut wrong = BodyLoop::new(Row::new("wrong"));
    let mut flooding = BodyLink::attach(&place(&sandbox), wrong.description(), &NEVER).unwrap();
    wrong.attached(flooding.session());
    let mut raw = wrong.next_frame().clone();
    raw.header.purpose = purpose::OBSERVE;
    for number in 1..=FLOOD {
        raw.header.sequence = number;
        raw.records[2].values[0] = f64::NAN.to_bits();
        assert_eq!(flooding.exchange(&raw, &NEVER).unwrap().code, 12);
    }
    let mut client = Client::connect(&place(&sandbox), DEADLINE).unwrap();
    for number in 0..FLOOD {
        let bytes: Vec<u8> = (0..number % 200).map(|at| (number * 31 + at * 7) as u8 | 0x80).collect();
        // No JSON begins with a byte of 0x80 or above.
        let answer = client.request(&bytes).unwrap();
        assert!(matches!(codec::decode(&answer), Ok(Reply::<()>::Problem(_))), "{number}");
    }
    serve(20);
    let after = sandbox.status("default");
    let counts = refused(&after);
    assert_eq!((counts["value range"], counts["request"]), (FLOOD, FLOOD));
    // The good body's twenty steps and the others' declarations; nothing of thousands of messages.
    let written = journal(&after) - journal(&before);
    assert!(written < 64 * 1024, "{written} bytes of journal");
    let status = ask(StatusQuery {}, |request| client.request(request)).unwrap();
    assert_eq!(status.step, before["step"].as_u64().unwrap() + 20);
    drop((client, flooding));
    link.detach();
    until("all have left", || {
        let status = sandbox.status("default");
        status["bodies"].as_array().unwrap().iter().all(|body| body["state"] != "attached").then_some(())
    });
    let daemon = daemon.ended();
    assert_eq!(daemon.code(), Some(0));
    let lines = daemon.stderr.lines().count();
    assert!(lines < 120, "{lines} lines of log: {}", daemon.stderr);
    assert_eq!(sandbox.left(), Vec::<String>::new());
}
