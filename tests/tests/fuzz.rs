//! The fuzz targets as tests: each reads the committed corpus and a few thousand seeded mutations of it, within a bound on
//! memory. With `PSCHEMA_FUZZ_SECONDS=60` each target goes on for so long; `fuzz/README.md` has the real fuzzer.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Mutex;
use std::time::Instant;

use pschema_tests::count;
use pschema_tests::fuzz::{Target, corpus, is_answer, is_request, target};

use counted::{COUNTED, CountingAllocator};

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

/// Memory is counted for all threads together.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

/// An allocator that counts the bytes that are allocated.
mod counted {
    #![allow(unsafe_code)]

    use std::alloc::{GlobalAlloc, Layout, System};
    use std::sync::atomic::{AtomicUsize, Ordering};

    pub(super) struct CountingAllocator;

    /// The bytes that are allocated now, and the most since this was last reset.
    pub(super) static COUNTED: (AtomicUsize, AtomicUsize) = (AtomicUsize::new(0), AtomicUsize::new(0));

    fn taken(bytes: usize) {
        let now = COUNTED.0.fetch_add(bytes, Ordering::Relaxed) + bytes;
        COUNTED.1.fetch_max(now, Ordering::Relaxed);
    }

    fn given_back(bytes: usize) {
        COUNTED.0.fetch_sub(bytes, Ordering::Relaxed);
    }

    // SAFETY: the system's allocator does all the work, and counting changes nothing of it.
    unsafe impl GlobalAlloc for CountingAllocator {
        unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
            taken(layout.size());
            // SAFETY: the caller's promise is the system's.
            unsafe { System.alloc(layout) }
        }

        unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
            given_back(layout.size());
            // SAFETY: the caller's promise is the system's.
            unsafe { System.dealloc(pointer, layout) }
        }

        unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
            taken(size);
            given_back(layout.size());
            // SAFETY: the caller's promise is the system's.
            unsafe { System.realloc(pointer, layout, size) }
        }
    }
}

/// The seed of every run, so that a run can be repeated.
const SEED: u64 = 0x9e37_79b9_7f4a_7c15;

/// Numbers from a seed.
struct Draws(u64);

impl Draws {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, end: usize) -> usize {
        usize::try_from(self.next() % (end.max(1) as u64)).unwrap()
    }
}

/// Bytes with some random changes, as a fuzzer makes them.
fn mutated(from: &[u8], other: &[u8], draws: &mut Draws) -> Vec<u8> {
    let mut bytes = from.to_vec();
    for _ in 0..=draws.below(4) {
        let at = draws.below(bytes.len() + 1);
        match draws.below(7) {
            0 if at < bytes.len() => bytes[at] ^= 1 << draws.below(8),
            1 if at < bytes.len() => bytes[at] = draws.next() as u8,
            2 if at < bytes.len() => bytes[at] = [0, 1, 0x7f, 0x80, 0xfb, 0xfc, 0xfd, 0xff][draws.below(8)],
            3 => bytes.truncate(at),
            4 => {
                let end = (at + 1 + draws.below(16)).min(bytes.len());
                bytes.drain(at.min(end)..end);
            }
            5 => {
                let new: Vec<_> = (0..draws.below(16)).map(|_| draws.next() as u8).collect();
                bytes.splice(at..at, new);
            }
            _ => {
                let from = draws.below(other.len() + 1);
                let to = (from + draws.below(64)).min(other.len());
                bytes.splice(at..at, other[from..to].iter().copied());
            }
        }
    }
    bytes
}

/// Reads one input. If that panics or takes too much memory, the test fails and the input is kept in a file.
fn read(target: &Target, bytes: &[u8], what: &str) {
    let before = COUNTED.0.load(std::sync::atomic::Ordering::Relaxed);
    COUNTED.1.store(before, std::sync::atomic::Ordering::Relaxed);
    let done = catch_unwind(AssertUnwindSafe(|| (target.read)(bytes)));
    let most = COUNTED.1.load(std::sync::atomic::Ordering::Relaxed).saturating_sub(before);
    let name = target.name;
    let saved = || {
        let path = std::env::temp_dir().join(format!("pschema-fuzz-{name}"));
        std::fs::write(&path, bytes).unwrap();
        path
    };
    assert!(done.is_ok(), "{name}: {what} panics; the input is kept as {:?}", saved());
    assert!(
        most < target.memory_max,
        "{name}: {what} takes {most} bytes; the input is kept as {:?}",
        saved()
    );
}

fn run(name: &str, rounds: u64) {
    let _alone = ONE_AT_A_TIME.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let target = target(name);
    let mut inputs = (target.seeds)();
    for (path, bytes) in corpus(name) {
        read(&target, &bytes, &format!("{path:?}"));
        inputs.push(bytes);
    }
    for (number, bytes) in inputs.iter().enumerate() {
        read(&target, bytes, &format!("seed {number}"));
    }
    read(&target, &[], "nothing");
    println!("{name}: seed {SEED:#x}, {rounds} rounds, {} inputs", inputs.len());
    let mut draws = Draws(SEED);
    let (begin, seconds) = (Instant::now(), count("PSCHEMA_FUZZ_SECONDS", 0));
    for round in (0..).take_while(|round| *round < rounds || begin.elapsed().as_secs() < seconds) {
        let (from, other) = (draws.below(inputs.len()), draws.below(inputs.len()));
        let bytes = mutated(&inputs[from], &inputs[other], &mut draws);
        read(&target, &bytes, &format!("round {round}"));
    }
}

/// The committed requests and answers were in a binary form that nothing read any more, so that the targets began from
/// nothing. `UPDATE_GOLDEN=1` writes both corpora anew.
#[test]
fn the_sound_requests_and_answers_of_the_corpus_are_of_todays_types() {
    let is_request: fn(&[u8]) -> bool = is_request;
    for (name, is_sound) in [("request", is_request), ("answer", is_answer)] {
        let seeds = (target(name).seeds)();
        if std::env::var_os("UPDATE_GOLDEN").is_some() {
            write_corpus(name, &seeds);
        }
        let sound =
            |path: &Path| path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"sound"));
        let files: Vec<_> = corpus(name).into_iter().filter(|(path, _)| sound(path)).collect();
        assert_eq!(files.len(), seeds.len(), "{name}: one file for each kind of message");
        assert!(seeds.iter().all(|seed| is_sound(seed)), "{name}");
        for (path, bytes) in files {
            assert!(is_sound(&bytes), "{path:?} can't be read");
        }
    }
}

/// Writes the corpus of a target: its sound messages, and some that a fuzzer made of them.
fn write_corpus(name: &str, seeds: &[Vec<u8>]) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/corpus").join(name);
    std::fs::remove_dir_all(&folder).unwrap();
    std::fs::create_dir(&folder).unwrap();
    for (number, seed) in seeds.iter().enumerate() {
        std::fs::write(folder.join(format!("sound-{number:02}")), seed).unwrap();
    }
    let mut draws = Draws(SEED);
    for number in 0..16 {
        let (from, other) = (draws.below(seeds.len()), draws.below(seeds.len()));
        let bytes = mutated(&seeds[from], &seeds[other], &mut draws);
        std::fs::write(folder.join(format!("mutated-{number:02}")), bytes).unwrap();
    }
}

macro_rules! targets {
    ($($name:ident: $rounds:literal),+ $(,)?) => {
        $(#[test]
        fn $name() {
            run(stringify!($name), $rounds);
        })+

        #[test]
        fn every_target_is_tested() {
            let tested = [$(stringify!($name)),+];
            assert!(pschema_tests::fuzz::TARGETS.iter().all(|target| tested.contains(&target.name)));
        }
    };
}

targets! {
    hello: 1_000,
    frames: 3_000,
    reply: 3_000,
    request: 1_000,
    answer: 2_000,
    domain: 1_000,
    world: 300,
    curriculum: 300,
    learner: 500,
    store: 500,
    export: 1_000,
}
