//! A daemon that keeps its memory on disk and a body at 50 Hz, for as long as `PSCHEMA_SOAK_SECONDS` says: neither its
//! memory nor its reply times grow. Not run without that variable; `.ci/run` gives it what its time allows, and before a
//! release it has 86400, with `PSCHEMA_SOAK_IDLE=1` on a machine that does nothing else: then reply times are judged, too.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

use std::io::Write;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use pschema_protocol::body::{BodyLoop, Directive};
use pschema_protocol::domain::{LearnerName, Place, RuntimeDir};
use pschema_protocol::transport::body_link::BodyLink;
use pschema_tests::{Row, Sandbox, count, own_memory};

const BINARY: &str = env!("CARGO_BIN_EXE_pschema-under-test");

/// One frame in this time: 50 Hz.
const PERIOD: Duration = Duration::from_millis(20);
/// Steps after which the daemon has kept as many records of steps as it ever does.
const RECORDS_FULL: u32 = 70_000;
/// What may be added to memory in an hour, and what a page or two more or less are.
const GROWTH_PER_HOUR: f64 = 1024.0 * 1024.0;
const NOISE: f64 = 256.0 * 1024.0;
/// The time that one interruption by other work of the machine takes, in milliseconds.
const INTERRUPTION_MS: f64 = 2.0;

struct Paced {
    link: BodyLink,
    body: BodyLoop<Row>,
}

impl Paced {
    /// One frame and its reply; how long the reply took, in milliseconds.
    fn step(&mut self) -> f64 {
        let frame = self.body.next_frame();
        let begin = Instant::now();
        let reply = self.link.exchange(frame, &AtomicBool::new(false)).unwrap();
        let took = begin.elapsed().as_secs_f64() * 1e3;
        assert_eq!(self.body.obey(&reply).unwrap(), Directive::Continue);
        took
    }
}

/// The value below which the share `of` of `values` is.
fn quantile(values: &[f64], of: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = ((sorted.len() as f64 * of) as usize).min(sorted.len() - 1);
    sorted[at]
}

#[test]
fn neither_memory_nor_reply_times_grow() {
    let seconds = count("PSCHEMA_SOAK_SECONDS", 0);
    if seconds == 0 {
        let mut said = std::io::stderr();
        writeln!(said, "SKIPPED neither_memory_nor_reply_times_grow: PSCHEMA_SOAK_SECONDS is not set")
            .unwrap();
        return;
    }
    let sandbox = Sandbox::new(BINARY);
    let data = sandbox.runtime().join("data");
    let daemon = sandbox.daemon("default", &["--data", data.to_str().unwrap(), "--durability", "relaxed"]);
    let place = Place::new(RuntimeDir::at(sandbox.runtime()).unwrap(), LearnerName::new("default").unwrap());
    let mut body = BodyLoop::new(Row::new("soaked"));
    let link = BodyLink::attach(&place, body.description(), &AtomicBool::new(false)).unwrap();
    body.attached(link.session());
    let mut paced = Paced { link, body };
    // At full speed until everything of bounded size has the size it keeps.
    for _ in 0..RECORDS_FULL {
        paced.step();
    }
    let (mut replies, mut memory) = (Vec::new(), Vec::new());
    let begin = Instant::now();
    let mut next = begin;
    let total = Duration::from_secs(seconds);
    while begin.elapsed() < total {
        replies.push(paced.step());
        if replies.len().is_multiple_of(25) {
            memory.push(own_memory(daemon.pid()) as f64);
        }
        next += PERIOD;
        std::thread::sleep(next.saturating_duration_since(Instant::now()));
    }
    let hours = begin.elapsed().as_secs_f64() / 3600.0;
    let third = memory.len() / 3;
    let (early, late) = (quantile(&memory[..third], 0.5), quantile(&memory[memory.len() - third..], 0.5));
    // From the middle of the first third to that of the last.
    let allowed = GROWTH_PER_HOUR * hours * 2.0 / 3.0 + NOISE;
    let third = replies.len() / 3;
    let (first, last) = (&replies[..third], &replies[replies.len() - third..]);
    let p99 = (quantile(first, 0.99), quantile(last, 0.99));
    println!(
        "{} frames in {:.1} s; memory {:.0} then {:.0} KiB; replies p50 {:.3} then {:.3} ms, p99 {:.3} then {:.3} ms",
        replies.len(),
        hours * 3600.0,
        early / 1024.0,
        late / 1024.0,
        quantile(first, 0.5),
        quantile(last, 0.5),
        p99.0,
        p99.1
    );
    assert!(late - early < allowed, "memory grew by {} bytes in {hours} h", late - early);
    // Other work of the machine decides the slowest replies, so they are judged only where there is none.
    let judged = count("PSCHEMA_SOAK_IDLE", 0) > 0;
    assert!(
        !judged || p99.1 <= 1.2 * p99.0 + INTERRUPTION_MS,
        "p99 was {} ms and became {} ms",
        p99.0,
        p99.1
    );
    paced.link.detach();
    assert_eq!(daemon.ended().code(), Some(0));
    assert_eq!(sandbox.left(), Vec::<String>::new());
}
