//! Frames that are refused before they come to their session: counted in it all the same, and nothing learnt.

#![allow(clippy::unwrap_used)] // A test panics to fail.

mod common;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use common::{Row, ask, free, setup};
use pschema_inspect::{Status, StatusQuery};
use pschema_protocol::body::BodyLoop;
use pschema_protocol::client::Client;
use pschema_protocol::domain::{LearnerName, Place, RuntimeDir};
use pschema_protocol::transport::body_link::BodyLink;
use pschema_protocol::wire::message::RawFrame;
use pschema_protocol::wire::{WireReply, reply};
use pschema_server::serve;

const PATIENCE: Duration = Duration::from_secs(60);

/// Tries until it works: the daemon may be only starting.
fn patiently<T, E: std::fmt::Display>(mut attempt: impl FnMut() -> Result<T, E>) -> T {
    let start = Instant::now();
    loop {
        match attempt() {
            Ok(made) => return made,
            Err(error) => assert!(start.elapsed() < PATIENCE, "{error}"),
        }
        std::thread::yield_now();
    }
}

fn status(client: &mut Client) -> Status {
    ask(client, StatusQuery {}).unwrap()
}

/// A frame that is damaged, sent.
type Damage = fn(&mut RawFrame);

/// The transport refused frames of another version or session by itself, and `status` showed a body whose every
/// frame was refused as one that had never sent any.
#[test]
fn a_frame_of_another_version_or_session_is_counted_in_the_status_of_its_body() {
    let directory = tempfile::Builder::new().prefix("ps").tempdir_in("/tmp").unwrap();
    let runtime = RuntimeDir::at(&directory.path().join("run")).unwrap();
    let place = Place::new(runtime, LearnerName::new("test").unwrap());
    let stop = Arc::new(AtomicBool::new(false));
    let daemon = {
        let (place, stop) = (place.clone(), stop.clone());
        std::thread::spawn(move || serve(place, setup(1, free()), &stop))
    };
    let mut body = BodyLoop::new(Row::new("row"));
    let going_on = AtomicBool::new(false);
    let mut link = patiently(|| BodyLink::attach(&place, body.description(), &going_on));
    body.attached(link.session());
    let mut client = patiently(|| Client::connect(&place, PATIENCE));
    let before = status(&mut client);
    assert_eq!((before.step, before.bodies[0].frames_refused), (0, 0));
    let damages: [(Damage, &str); 4] = [
        (|raw| raw.header.magic ^= 1, "not a pschema message"),
        (|raw| raw.header.version += 1, "version 2"),
        (|raw| raw.header.session += 1, "is not open"),
        (|raw| raw.header.session = 0, "session 0 is not open"),
    ];
    let sound = body.next_frame().clone();
    for (number, (damage, sentence)) in (1..).zip(damages) {
        let mut wrong = sound.clone();
        damage(&mut wrong);
        let answer: WireReply = link.exchange(&wrong, &going_on).unwrap();
        assert_eq!(answer.kind, reply::REFUSED, "{sentence}");
        let now = status(&mut client);
        let last = now.bodies[0].last_refusal.clone().unwrap_or_default();
        assert_eq!((now.bodies[0].frames_refused, now.bodies[0].frames), (number, 0), "{last}");
        assert!(last.contains(sentence), "{last:?} should say {sentence:?}");
        assert_eq!((now.step, &now.memory_digest), (0, &before.memory_digest), "{sentence}");
    }
    let answer = link.exchange(&sound, &going_on).unwrap();
    assert_eq!(answer.kind, reply::ACT, "the frame itself is taken after all of that");
    assert_eq!((status(&mut client).step, status(&mut client).bodies[0].frames), (1, 1));
    link.detach();
    drop(client);
    stop.store(true, Ordering::Relaxed);
    daemon.join().unwrap().unwrap();
}
