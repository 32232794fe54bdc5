//! The daemon killed with SIGKILL at any instant: in a step, while a snapshot is written, while it recovers. It comes back
//! with everything that a body acted on, and its memory is that of a run that was never interrupted.
//!
//! `PSCHEMA_KILLS=2000 cargo test -p pschema-server --test kill_nine` kills so often.

#![allow(clippy::unwrap_used)] // A test panics to fail.

mod common;

use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use common::Row;
use common::process::{BLOCK, BodyThread, directory, place, recovered, served, setup};
use pschema_learner::digest::digest;
use pschema_learner::random::Random;
use pschema_server::in_process::InProcess;

/// Lives led at the same time.
const AT_ONCE: usize = 3;

/// The states of the daemon in which the kills met it.
#[derive(Debug, Default)]
struct Met {
    kills: u64,
    in_recovery: u64,
    in_snapshot: u64,
    one_more: u64,
    steps: u64,
}

#[test]
fn killed_at_any_instant_it_remembers_what_an_uninterrupted_run_does() {
    let kills: u64 = std::env::var("PSCHEMA_KILLS").map_or(100, |kills| kills.parse().unwrap());
    let (met, seeds) = (Mutex::new(Met::default()), AtomicU64::new(0));
    let live = || {
        while met.lock().unwrap().kills < kills {
            life(seeds.fetch_add(1, Ordering::SeqCst), &met);
        }
    };
    std::thread::scope(|scope| {
        let lives: Vec<_> = (0..AT_ONCE).map(|_| scope.spawn(live)).collect();
        lives.into_iter().for_each(|life| life.join().unwrap());
    });
    let met = met.into_inner().unwrap();
    println!("{met:?}");
    // Otherwise the kills missed what they were aimed at.
    assert!(met.in_recovery >= kills / 20 && met.in_snapshot >= kills / 50, "{met:?}");
}

/// One memory: killed in its life, then perhaps while it recovers, then compared.
fn life(seed: u64, met: &Mutex<Met>) {
    println!("seed {seed}");
    let mut random = Random::from_seed(seed ^ 2011);
    let directory = directory();
    let data = directory.path().join("data");
    let start = || served(directory.path(), data.to_str().unwrap(), seed, &["--snapshot-every", "2KiB"]);
    let writing = data.join("snapshot/writing.tmp");
    let began = Instant::now();
    let mut daemon = start();
    daemon.ready();
    let start_took = began.elapsed();
    let body = BodyThread::start(&place(directory.path()));
    body.past(1 + random.below(300) as u64);
    if seed.is_multiple_of(4) {
        // Aimed: a snapshot is made every few steps.
        let most = body.acts() + 2_000;
        while !writing.exists() && body.acts() < most {
            std::hint::spin_loop();
        }
    } else {
        wait(Duration::from_micros(random.below(3_000) as u64));
    }
    daemon.kill();
    let acknowledged = body.acts();
    drop(body);
    let in_snapshot = writing.exists();
    let (mut kills, mut in_recovery) = (1, 0);
    while random.below(2) == 0 {
        // Some of a start is the process, some the memory, some the domain in shared memory. Now and then it is over.
        let most = usize::try_from(start_took.as_micros()).unwrap() * 5 / 4;
        let mut daemon = start();
        wait(Duration::from_micros(random.below(most) as u64));
        let ready = daemon.said_ready();
        daemon.kill();
        kills += 1;
        in_recovery += u64::from(!ready);
    }
    let more = check(&data, seed, acknowledged);
    let mut met = met.lock().unwrap();
    met.kills += kills;
    met.in_recovery += in_recovery;
    met.in_snapshot += u64::from(in_snapshot);
    met.one_more += more;
    met.steps += acknowledged;
}

/// Compares the steps on disk with those that a body acted on. Returns how many more steps the disk has.
fn check(data: &Path, seed: u64, acknowledged: u64) -> u64 {
    let memory = recovered(data, seed);
    let step = memory.content().step;
    assert!(step >= acknowledged, "seed {seed}: {step} of {acknowledged} steps");
    assert!(step <= acknowledged + 1, "seed {seed}: {step} steps, {acknowledged} acted on");
    let mut uninterrupted = InProcess::new(Row::with_block("row", BLOCK), setup(seed)).unwrap();
    while uninterrupted.learner().memory().content().step < step {
        uninterrupted.advance().unwrap();
    }
    let expected = digest(uninterrupted.learner().memory().content());
    assert_eq!(digest(memory.content()), expected, "seed {seed}, step {step}");
    step - acknowledged
}

/// Waits for an instant: there is no event to wait for.
fn wait(time: Duration) {
    let began = Instant::now();
    while began.elapsed() < time {
        std::thread::yield_now();
    }
}
