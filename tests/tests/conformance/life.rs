//! A body as a process, with a real daemon: it comes, stays, comes back and goes.

use pschema_tests::{House, Running, until};
use rustix::process::Signal;
use serde_json::Value;

use super::{BINARY, Subject};

const NAME: &str = "conformance";

fn attached(house: &House) -> Vec<u64> {
    let status: Value = house.status(NAME);
    let bodies = status["bodies"].as_array().expect("bodies");
    let here = bodies.iter().filter(|body| body["state"] == "attached");
    here.filter_map(|body| body["pid"].as_u64()).collect()
}

/// A daemon and the body, past a few steps.
fn living(subject: &dyn Subject, house: &House) -> (Running, super::Started) {
    let daemon = house.daemon(NAME, &[]);
    let body = subject.start(house, NAME);
    let _moving = house.past(NAME, 3);
    (daemon, body)
}

/// It attaches, acts, and none of its frames is refused.
pub(crate) fn it_lives_with_a_daemon(subject: &dyn Subject) {
    let house = House::new(BINARY);
    let (daemon, body) = living(subject, &house);
    assert_eq!(attached(&house), [u64::from(body.process.pid())]);
    let status = house.status(NAME);
    let own = status["bodies"].as_array().and_then(|bodies| bodies.first()).expect("a body");
    assert_eq!(own["frames_refused"], 0, "{status}");
    drop(body);
    assert_eq!(daemon.ended().code(), Some(0));
    assert_eq!(house.left(), Vec::<String>::new());
}

/// A daemon that was killed and started again finds it there, without anybody's help.
pub(crate) fn it_goes_on_after_the_daemon_is_restarted(subject: &dyn Subject) {
    let house = House::new(BINARY);
    let (first, body) = living(subject, &house);
    first.signal(Signal::KILL);
    assert_eq!(first.finished().code(), None);
    let second = house.daemon(NAME, &[]);
    let _on = house.past(NAME, 3);
    assert_eq!(attached(&house), [u64::from(body.process.pid())]);
    let body = body.process.ended();
    assert_eq!(body.code(), Some(0), "{body:?}");
    assert_eq!(second.ended().code(), Some(0));
    assert_eq!(house.left(), Vec::<String>::new());
}

/// Sent away by a daemon that ends, it ends.
pub(crate) fn it_ends_when_it_is_sent_away(subject: &dyn Subject) {
    let house = House::new(BINARY);
    let (daemon, body) = living(subject, &house);
    assert_eq!(daemon.ended().code(), Some(0));
    let body = body.process.finished();
    assert_eq!(body.code(), Some(0), "{body:?}");
    assert_eq!(house.left(), Vec::<String>::new());
}

/// Ctrl-C ends it with a farewell: the daemon knows that it left.
pub(crate) fn it_ends_on_ctrl_c(subject: &dyn Subject) {
    let house = House::new(BINARY);
    let (daemon, body) = living(subject, &house);
    body.process.signal(Signal::INT);
    let ended = body.process.finished();
    assert_eq!(ended.code(), Some(0), "{ended:?}");
    until("the daemon knows that it left", || {
        let status = house.status(NAME);
        (status["bodies"][0]["state"] == "left").then_some(())
    });
    assert_eq!(daemon.ended().code(), Some(0));
    assert_eq!(house.left(), Vec::<String>::new());
}

/// Ctrl-C ends it also while there is no daemon to attach to.
pub(crate) fn it_ends_on_ctrl_c_without_a_daemon(subject: &dyn Subject) {
    let house = House::new(BINARY);
    let (daemon, body) = living(subject, &house);
    daemon.signal(Signal::KILL);
    assert_eq!(daemon.finished().code(), None);
    body.process.signal(Signal::INT);
    let ended = body.process.finished();
    assert_eq!(ended.code(), Some(0), "{ended:?}");
}
