//! Bodies, tools and a daemon over real shared memory, in threads: their messages when all goes well.
#![allow(clippy::unwrap_used)] // A test panics to fail.

mod support;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use pschema_protocol::body::{Body, BodyLoop, Outcome, RunEnding, RunSummary, Senses, run};
use pschema_protocol::client::{Client, ClientError};
use pschema_protocol::description::{Action, Description};
use pschema_protocol::domain::{DomainError, OwnedDomain};
use pschema_protocol::limits::{ANSWER_BYTES_MAX, PAGE_BYTES};
use pschema_protocol::transport::TransportError;
use pschema_protocol::transport::server::{Incoming, ServerTransport};
use pschema_protocol::wire::message::Reply;
use support::{
    Counter, Daemon, PATIENCE, Runtime, as_many, assert_swept, attach, echo, options, shared_files, until,
};

#[test]
fn a_thousand_frames_and_nothing_left() {
    let runtime = Runtime::new();
    let place = runtime.place("one");
    let daemon = Daemon::start(place.clone(), 1000, echo);
    let prefix = daemon.prefix.clone();
    assert!(!shared_files(&prefix).is_empty());
    let summary = run(Counter::new(), &options(&place)).unwrap();
    let seen = daemon.stop();
    let RunSummary { ending, sessions, frames, orders, refused, .. } = summary;
    assert_eq!((ending, sessions, frames, orders, refused), (RunEnding::Detached, 1, 1000, 999, 0));
    assert_eq!((seen.frames, seen.reports, seen.last_count), (1000, 999, 999));
    assert_swept(&runtime.path(), &prefix);
    assert!(matches!(place.served(), Err(DomainError::NotServed { .. })));
}

#[test]
fn a_body_goes_on_with_the_next_daemon() {
    let runtime = Runtime::new();
    let place = runtime.place("again");
    let first = Daemon::start(place.clone(), u64::MAX, echo);
    let options = options(&place);
    let stop = options.stop.clone();
    let body = std::thread::spawn(move || run(Counter::new(), &options));
    let mut daemon = first;
    for _ in 0..3 {
        until("frames", || daemon.frames.load(Ordering::Relaxed) > 100);
        let seen = daemon.stop();
        assert_eq!(seen.sessions.len(), 1, "{seen:?}");
        assert_swept(&runtime.path(), &seen.prefix);
        daemon = Daemon::start(place.clone(), u64::MAX, echo);
        assert_ne!(daemon.prefix, seen.prefix);
    }
    until("frames", || daemon.frames.load(Ordering::Relaxed) > 100);
    stop.store(true, Ordering::Relaxed);
    let summary = body.join().unwrap().unwrap();
    assert_eq!((summary.ending, summary.sessions), (RunEnding::Stopped, 4));
    until("the farewell", || daemon.gone.load(Ordering::Relaxed) == 1);
    let seen = daemon.stop();
    assert_eq!(seen.gone, [(seen.sessions[0], true)]);
    assert_swept(&runtime.path(), &seen.prefix);
}

/// A body that can't sense to the end has reported a part of the world, and the rest would be learnt to be gone.
#[test]
fn a_body_that_is_stopped_while_it_senses_sends_no_frame() {
    struct Unsure {
        counter: Counter,
        sensed: u64,
        stop: Arc<AtomicBool>,
    }
    impl Body for Unsure {
        fn describe(&self) -> Description {
            self.counter.describe()
        }

        fn sense(&mut self, frame: &mut Senses) {
            self.sensed += 1;
            if self.sensed == 4 {
                self.stop.store(true, Ordering::Relaxed);
            } else {
                self.counter.sense(frame);
            }
        }

        fn act(&mut self, action: &Action) -> Outcome {
            self.counter.act(action)
        }
    }
    let runtime = Runtime::new();
    let place = runtime.place("unsure");
    let daemon = Daemon::start(place.clone(), u64::MAX, echo);
    let options = options(&place);
    let body = Unsure { counter: Counter::new(), sensed: 0, stop: options.stop.clone() };
    let summary = run(body, &options).unwrap();
    assert_eq!((summary.ending, summary.frames), (RunEnding::Stopped, 3));
    until("the farewell", || daemon.gone.load(Ordering::Relaxed) == 1);
    let seen = daemon.stop();
    assert_eq!((seen.frames, seen.gone), (3, vec![(seen.sessions[0], true)]));
}

#[test]
fn a_second_daemon_is_refused_and_learns_by_whom() {
    let runtime = Runtime::new();
    let daemon = Daemon::start(runtime.place("only"), 10, echo);
    let error = OwnedDomain::create(runtime.place("only")).unwrap_err();
    let me = std::process::id().to_string();
    assert!(matches!(&error, DomainError::AlreadyServed { pid, .. } if *pid == me), "{error}");
    // Another learner beside it is no matter.
    let other = Daemon::start(runtime.place("other"), 10, echo);
    assert_ne!(other.prefix, daemon.prefix);
    run(Counter::new(), &options(&runtime.place("only"))).unwrap();
    assert_eq!(daemon.stop().frames, 10);
    assert_eq!(other.stop().frames, 0);
}

#[test]
fn tools_are_answered_in_one_page_or_many() {
    let runtime = Runtime::new();
    let place = runtime.place("ask");
    let daemon = Daemon::start(place.clone(), 0, as_many);
    let mut client = Client::connect(&place, PATIENCE).unwrap();
    for length in [0, 1, PAGE_BYTES - 1, PAGE_BYTES, PAGE_BYTES + 1, 40 * PAGE_BYTES + 7, ANSWER_BYTES_MAX] {
        let question = length.to_string();
        assert!(client.request(question.as_bytes()).unwrap() == as_many(question.as_bytes()), "{length}");
    }
    let error = client.request((ANSWER_BYTES_MAX + 1).to_string().as_bytes()).unwrap_err().to_string();
    assert!(error.contains("16777217 bytes"), "{error}");
    let error = client.request(&vec![0; PAGE_BYTES + 1]).unwrap_err();
    assert!(matches!(error, ClientError::Transport(TransportError::TooLong { .. })), "{error}");
    daemon.stop();
    let error = client.request(b"1").unwrap_err();
    assert!(error.is_no_daemon(), "{error}");
    let error = Client::connect(&place, PATIENCE).unwrap_err();
    assert!(error.is_no_daemon(), "{error}");
}

#[test]
fn a_resting_body_rests_until_its_time_or_until_it_is_roused() {
    let runtime = Runtime::new();
    let place = runtime.place("rest");
    let order = |frames| if frames <= 5 { Reply::Wait { ms: 60 } } else { Reply::Detach };
    let daemon = Daemon::start_with(place.clone(), order, echo);
    let start = Instant::now();
    let summary = run(Counter::new(), &options(&place)).unwrap();
    assert!(start.elapsed() >= Duration::from_millis(5 * 60), "{:?}", start.elapsed());
    assert_eq!((summary.frames, summary.orders), (6, 0));
    daemon.stop();

    // Roused, it takes less than the ten seconds it was laid to rest for.
    let mut transport = ServerTransport::create(OwnedDomain::create(place.clone()).unwrap()).unwrap();
    let waker = transport.waker().unwrap();
    let stop = Arc::new(AtomicBool::new(false));
    let told = stop.clone();
    let body = std::thread::spawn(move || {
        let link = attach(&place);
        let start = Instant::now();
        link.rest(Duration::from_secs(10), &told);
        waker.wake();
        start.elapsed()
    });
    let mut welcomed = false;
    while !body.is_finished() {
        transport.wait(Duration::from_millis(10));
        transport.poll(&mut |incoming| {
            if let Incoming::Hello { reply, .. } = incoming {
                reply.accept(1, "rest").unwrap();
                welcomed = true;
            }
        });
        if welcomed {
            transport.rouse(1);
        }
    }
    assert!(body.join().unwrap() < Duration::from_secs(10));
}

/// The body heard that it was roused while it waited for its reply, forgot it, and rested to the end.
#[test]
fn a_body_that_is_roused_before_its_reply_comes_does_not_rest() {
    let runtime = Runtime::new();
    let place = runtime.place("roused");
    let mut transport = ServerTransport::create(OwnedDomain::create(place.clone()).unwrap()).unwrap();
    let body = std::thread::spawn(move || {
        let stop = AtomicBool::new(false);
        let mut body = BodyLoop::new(Counter::new());
        let mut link = attach(&place);
        body.attached(link.session());
        link.exchange(body.next_frame(), &stop).unwrap();
        let start = Instant::now();
        link.rest(Duration::from_secs(10), &stop);
        start.elapsed()
    });
    let mut held = None;
    let mut looks = 0;
    while !body.is_finished() {
        transport.wait(Duration::from_millis(10));
        transport.poll(&mut |incoming| match incoming {
            Incoming::Hello { reply, .. } => reply.accept(1, "roused").unwrap(),
            Incoming::Frame { reply, .. } => held = Some(reply),
            _ => {}
        });
        if let Some(reply) = held.take() {
            // Looked at some times more, so that the body hears it while it waits.
            if looks == 0 {
                transport.rouse(1);
            }
            looks += 1;
            if looks < 20 {
                held = Some(reply);
            } else {
                reply.send(&Reply::Wait { ms: 10_000 }).unwrap();
            }
        }
    }
    assert!(body.join().unwrap() < Duration::from_secs(5));
}

#[test]
fn a_body_ends_with_its_daemon_when_it_shall() {
    let runtime = Runtime::new();
    let place = runtime.place("ends");
    let daemon = Daemon::start(place.clone(), u64::MAX, echo);
    let options = options(&place).exit_when_daemon_gone(true);
    let body = std::thread::spawn(move || run(Counter::new(), &options));
    until("frames", || daemon.frames.load(Ordering::Relaxed) > 10);
    daemon.stop();
    assert_eq!(body.join().unwrap().unwrap().ending, RunEnding::DaemonGone);
}
