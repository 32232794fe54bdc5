//! Pictures over shared memory: they are sent only while a tool watches, and never delay the body.

#![allow(clippy::unwrap_used)] // A test panics to fail.

mod support;

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use pschema_protocol::body::{Body, Outcome, RunOptions, Senses, run};
use pschema_protocol::description::{Action, Description};
use pschema_protocol::domain::Place;
use pschema_protocol::limits::WATCHERS_MAX;
use pschema_protocol::picture::{FieldMark, Picture, PictureMessage};
use pschema_protocol::transport::TransportError;
use pschema_protocol::transport::pictures::PictureWatch;
use support::{Counter, Daemon, Runtime, as_many, counter_description, options, until};

const WIDTH_PX: u32 = 20;
const HEIGHT_PX: u32 = 10;
const FIELDS: [FieldMark; 2] =
    [FieldMark { x_px: 5.0, y_px: 5.0, radius_px: 4.0 }, FieldMark { x_px: 15.0, y_px: 5.0, radius_px: 4.0 }];

/// A counter whose picture has the count in every byte.
struct Painter {
    counter: Counter,
    rgb: Vec<u8>,
    asked: Arc<AtomicU64>,
}

impl Painter {
    fn new(bytes: usize) -> Self {
        Self { counter: Counter::new(), rgb: vec![0; bytes], asked: Arc::default() }
    }

    fn whole() -> Self {
        Self::new((WIDTH_PX * HEIGHT_PX * 3) as usize)
    }
}

impl Body for Painter {
    fn describe(&self) -> Description {
        counter_description()
    }

    fn sense(&mut self, frame: &mut Senses) {
        self.counter.sense(frame);
        self.rgb.fill((self.counter.acted % 256) as u8);
    }

    fn act(&mut self, action: &Action) -> Outcome {
        self.counter.act(action)
    }

    fn picture(&mut self) -> Option<Picture<'_>> {
        self.asked.fetch_add(1, Ordering::Relaxed);
        Some(Picture { width_px: WIDTH_PX, height_px: HEIGHT_PX, rgb: &self.rgb, fields: &FIELDS })
    }
}

struct BodyThread {
    options: RunOptions,
    thread: std::thread::JoinHandle<()>,
}

impl BodyThread {
    fn start(place: &Place, body: impl Body + Send + 'static) -> Self {
        let options = options(place);
        let given = options.clone();
        let thread = std::thread::spawn(move || run(body, &given).map(|_| ()).unwrap());
        Self { options, thread }
    }

    fn stop(self) {
        self.options.stop.store(true, Ordering::Relaxed);
        self.thread.join().unwrap();
    }
}

fn next(watch: &PictureWatch) -> PictureMessage {
    let mut seen = None;
    until("a picture", || {
        seen = watch.newest().unwrap();
        seen.is_some()
    });
    seen.unwrap()
}

#[test]
fn whoever_watches_sees_what_the_body_sees_now() {
    let runtime = Runtime::new();
    let place = runtime.place("seen");
    let daemon = Daemon::start(place.clone(), u64::MAX, as_many);
    let painter = Painter::whole();
    let asked = painter.asked.clone();
    let body = BodyThread::start(&place, painter);
    until("frames", || daemon.frames.load(Ordering::Relaxed) > 20);
    assert_eq!(asked.load(Ordering::Relaxed), 0, "nobody watches");
    let watch = PictureWatch::open(&place).unwrap();
    let first = next(&watch);
    assert_eq!((first.width_px, first.height_px), (WIDTH_PX, HEIGHT_PX));
    assert_eq!(first.fields, FIELDS);
    let second = next(&watch);
    assert!(second.frame > first.frame && second.session == first.session, "{first:?}, {second:?}");
    for seen in [&first, &second] {
        // The picture is of the frame it is said to be of: as many actions as frames were replied to before.
        assert!(seen.rgb.iter().all(|byte| u64::from(*byte) == seen.frame % 256), "{seen:?}");
    }
    drop(watch);
    body.stop();
    daemon.stop();
}

#[test]
fn a_body_without_an_eye_is_watched_in_vain_and_one_with_a_wrong_picture_lives_on() {
    for (learner, short) in [("blind", false), ("wrong", true)] {
        let runtime = Runtime::new();
        let place = runtime.place(learner);
        let daemon = Daemon::start(place.clone(), u64::MAX, as_many);
        let watch = PictureWatch::open(&place).unwrap();
        let body = if short {
            BodyThread::start(&place, Painter::new(7))
        } else {
            BodyThread::start(&place, Counter::new())
        };
        until("frames", || daemon.frames.load(Ordering::Relaxed) > 20);
        assert_eq!(watch.newest().unwrap(), None, "{learner}");
        body.stop();
        daemon.stop();
    }
}

#[test]
fn as_many_may_watch_as_there_are_places_and_the_next_is_told_so() {
    let runtime = Runtime::new();
    let place = runtime.place("places");
    let daemon = Daemon::start(place.clone(), u64::MAX, as_many);
    let body = BodyThread::start(&place, Painter::whole());
    let mut watches: Vec<_> = (0..WATCHERS_MAX).map(|_| PictureWatch::open(&place).unwrap()).collect();
    let error = PictureWatch::open(&place).unwrap_err();
    assert!(matches!(error, TransportError::Full { limit: WATCHERS_MAX, .. }), "{error}");
    // The others see on, also while one of them looks at nothing.
    next(&watches[0]);
    watches.pop();
    let late = PictureWatch::open(&place).unwrap();
    next(&late);
    next(&watches[1]);
    assert!(late.is_current());
    body.stop();
    daemon.stop();
    assert!(!late.is_current());
}

#[test]
fn no_daemon_is_said_so() {
    let runtime = Runtime::new();
    let error = PictureWatch::open(&runtime.place("none")).unwrap_err();
    assert!(matches!(error, TransportError::Domain(_)), "{error}");
}
