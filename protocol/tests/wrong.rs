//! Bodies that break the protocol.
#![allow(clippy::unwrap_used)] // A test panics to fail.

mod support;

use std::sync::atomic::{AtomicBool, Ordering};

use pschema_protocol::body::{BodyLoop, Directive, RunError, run};
use pschema_protocol::refusal::Refusal;
use pschema_protocol::transport::body_link::BodyLink;
use pschema_protocol::wire::message::RawFrame;
use pschema_protocol::wire::{FrameHeader, WireReply, purpose, reply};
use support::{Counter, Daemon, Runtime, attach, counter_description, echo, options, until};

#[test]
fn a_refused_frame_says_why_and_the_session_goes_on() {
    let runtime = Runtime::new();
    let place = runtime.place("wrong");
    let daemon = Daemon::start(place.clone(), 40, echo);
    let body = Counter { wrong_every: Some(5), ..Counter::new() };
    let summary = run(body, &options(&place)).unwrap();
    let seen = daemon.stop();
    assert_eq!((summary.sessions, summary.frames, summary.refused), (1, 49, 9));
    // Every order is reported although the frames that first reported some were refused.
    assert_eq!((seen.frames, seen.reports, seen.last_count), (40, 39, 39));
    let sentence = "observation 0 (count): property number = -1 is outside 0..=1000000";
    assert!(seen.refused.iter().all(|refusal| refusal.to_string() == sentence), "{:?}", seen.refused);
}

#[test]
fn a_body_that_is_always_wrong_gives_up() {
    let runtime = Runtime::new();
    let daemon = Daemon::start(runtime.place("wrong"), 40, echo);
    let body = Counter { wrong_every: Some(1), ..Counter::new() };
    let error = run(body, &options(&runtime.place("wrong"))).unwrap_err();
    assert!(matches!(error, RunError::FramesRefused { count: 50, .. }), "{error}");
    assert_eq!(daemon.stop().frames, 0);
}

#[test]
fn a_description_that_is_not_allowed_is_refused_before_anything_is_sent() {
    struct DeclaringTwice;
    impl pschema_protocol::body::Body for DeclaringTwice {
        fn describe(&self) -> pschema_protocol::description::Description {
            let mut description = counter_description();
            description.actions.push(description.actions[0].clone());
            description
        }
        fn sense(&mut self, _: &mut pschema_protocol::body::Senses) {}
        fn act(&mut self, _: &pschema_protocol::description::Action) -> pschema_protocol::body::Outcome {
            pschema_protocol::body::Outcome::TimedOut
        }
    }
    let runtime = Runtime::new();
    let error = run(DeclaringTwice, &options(&runtime.place("none"))).unwrap_err();
    assert!(matches!(error, RunError::Description(Refusal::DuplicateName { .. })), "{error}");
}

fn reply_to(link: &mut BodyLink, frame: &RawFrame) -> WireReply {
    link.exchange(frame, &AtomicBool::new(false)).unwrap()
}

#[test]
fn a_hostile_body_is_refused_each_time_and_disturbs_no_other() {
    let runtime = Runtime::new();
    let place = runtime.place("hostile");
    let daemon = Daemon::start(place.clone(), u64::MAX, echo);
    let options = options(&place);
    let stop = options.stop.clone();
    let good = std::thread::spawn(move || run(Counter::new(), &options));
    let mut link = attach(&place);
    let other = attach(&place);
    let mut body = BodyLoop::new(Counter::new());
    body.attached(link.session());
    let reply = reply_to(&mut link, body.next_frame());
    assert_eq!(body.obey(&reply).unwrap(), Directive::Continue);
    let good_frame = body.next_frame().clone();
    let seed: u64 = 0x5eed;
    println!("seed {seed:#x}");
    let mut state = seed;
    let mut random = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        state >> 16
    };
    for round in 0..500 {
        let mut frame = good_frame.clone();
        let value = random();
        match round % 8 {
            0 => frame.header.magic = value as u32,
            1 => frame.header.version = value as u32 | 2,
            2 => frame.header.session = other.session(),
            3 => frame.header.session = value,
            4 => frame.header.sequence = 1,
            5 => frame.header.sequence = value | 64,
            6 => frame.header = FrameHeader { purpose: purpose::DETACH, session: value, ..frame.header },
            _ => {
                frame.header.session = 0;
                frame.header.observation_count = u32::MAX;
            }
        }
        let reply = reply_to(&mut link, &frame);
        assert_eq!(reply.kind, reply::REFUSED, "round {round}: {frame:?}");
        assert_ne!(reply.code, 0);
    }
    // The body's own sound frame is still the next, and is taken.
    assert_eq!(reply_to(&mut link, &good_frame).kind, reply::ACT);
    let frames = daemon.frames.load(Ordering::Relaxed);
    until("frames of the good body", || daemon.frames.load(Ordering::Relaxed) > frames + 100);
    stop.store(true, Ordering::Relaxed);
    assert_eq!(good.join().unwrap().unwrap().refused, 0);
    drop((link, other));
    assert_eq!(daemon.stop().refused.len(), 500);
}
