//! A body as a process, with a real daemon: it comes, stays, comes back and goes.

use pschema_tests::{ChildProcess, Sandbox, until};
use rustix::process::Signal;
use serde_json::Value;

use super::{BINARY, Subject};

const NAME: &str = "conformance";

fn attached(sandbox: &Sandbox) -> Vec<u64> {
    let status: Value = sandbox.status(NAME);
    let bodies = status["bodies"].as_array().expect("bodies");
    let here = bodies.iter().filter(|body| body["state"] == "attached");
    here.filter_map(|body| body["pid"].as_u64()).collect()
}

/// A daemon and the body, past a few steps.
fn living(subject: &dyn Subject, sandbox: &Sandbox) -> (ChildProcess, super::StartedBody) {
    let daemon = sandbox.daemon(NAME, &[]);
    let body = subject.start(sandbox, NAME);
    let _moving = sandbox.past(NAME, 3);
    (daemon, body)
}

/// The body attaches and acts, and none of its frames is refused.
pub(crate) fn it_lives_with_a_daemon(subject: &dyn Subject) {
    let sandbox = Sandbox::new(BINARY);
    let (daemon, body) = living(subject, &sandbox);
    assert_eq!(attached(&sandbox), [u64::from(body.process.pid())]);
    let status = sandbox.status(NAME);
    let own = status["bodies"].as_array().and_then(|bodies| bodies.first()).expect("a body");
    assert_eq!(own["frames_refused"], 0, "{status}");
    drop(body);
    assert_eq!(daemon.ended().code(), Some(0));
    assert_eq!(sandbox.left(), Vec::<String>::new());
}

/// A daemon that was killed and started again finds it there, without anybody's help.
pub(crate) fn it_goes_on_after_the_daemon_is_restarted(subject: &dyn Subject) {
    let sandbox = Sandbox::new(BINARY);
    let (first, body) = living(subject, &sandbox);
    first.signal(Signal::KILL);
    assert_eq!(first.finished().code(), None);
    let second = sandbox.daemon(NAME, &[]);
    let _on = sandbox.past(NAME, 3);
    assert_eq!(attached(&sandbox), [u64::from(body.process.pid())]);
    let body = body.process.ended();
    assert_eq!(body.code(), Some(0), "{body:?}");
    assert_eq!(second.ended().code(), Some(0));
    assert_eq!(sandbox.left(), Vec::<String>::new());
}

/// Sent away by a daemon that ends, it ends.
pub(crate) fn it_ends_when_it_is_sent_away(subject: &dyn Subject) {
    let sandbox = Sandbox::new(BINARY);
    let (daemon, body) = living(subject, &sandbox);
    assert_eq!(daemon.ended().code(), Some(0));
    let body = body.process.finished();
    assert_eq!(body.code(), Some(0), "{body:?}");
    assert_eq!(sandbox.left(), Vec::<String>::new());
}

/// Ctrl-C ends it with a farewell: the daemon knows that it left.
pub(crate) fn it_ends_on_ctrl_c(subject: &dyn Subject) {
    let sandbox = Sandbox::new(BINARY);
    let (daemon, body) = living(subject, &sandbox);
    body.process.signal(Signal::INT);
    let ended = body.process.finished();
    assert_eq!(ended.code(), Some(0), "{ended:?}");
    until("the daemon knows that it left", || {
        let status = sandbox.status(NAME);
        (status["bodies"][0]["state"] == "left").then_some(())
    });
    assert_eq!(daemon.ended().code(), Some(0));
    assert_eq!(sandbox.left(), Vec::<String>::new());
}

/// Ctrl-C ends it also while there is no daemon to attach to.
pub(crate) fn it_ends_on_ctrl_c_without_a_daemon(subject: &dyn Subject) {
    let sandbox = Sandbox::new(BINARY);
    let (daemon, body) = living(subject, &sandbox);
    daemon.signal(Signal::KILL);
    assert_eq!(daemon.finished().code(), None);
    body.process.signal(Signal::INT);
    let ended = body.process.finished();
    assert_eq!(ended.code(), Some(0), "{ended:?}");
}
