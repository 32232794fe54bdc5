//! How long an action waits until the step that chose it is on disk, against a bare write and fdatasync of as many bytes
//! on the same disk. The two take turns, so that both meet the same disk.
//!
//! Twice: in this process, where a frame goes through session, learner and journal (what the daemon does); and between
//! processes, where a body sends a frame to a daemon and gets its action (what a body sees).

use std::fs::File;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::thread;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use clap::Args;
use pschema_process::Stop;
use pschema_protocol::body::BodyLoop;
use pschema_protocol::domain::{LearnerName, Place, RuntimeDir};
use pschema_protocol::transport::TransportError;
use pschema_protocol::transport::body_link::BodyLink;
use pschema_protocol::wire::{decode, encode};
use pschema_server::session::Session;
use pschema_server::{Setup, config};
use pschema_store::past::Past;
use pschema_store::{Cause, Change, Opened, Options};
use pschema_tools::kit::{Bar, Child, Columns, Failure, runtime_directory, show, wrapped};
use serde::Serialize;

use crate::body::RowBody;
use crate::times::{Times, directory_on_disk};

/// What the product promises: the median durable decision within this many times the bare write.
const RATIO_WANTED: f64 = 1.3;
/// Exchanges before anything is measured.
const WARM_UP: u32 = 100;
/// Bytes zeroed ahead at a time, as the journal does it.
const AHEAD: usize = 1024 * 1024;
/// How long a daemon may take to be ready.
const READY_WITHIN: Duration = Duration::from_secs(20);

/// The disk to measure.
#[derive(Debug, Args)]
pub(crate) struct DurabilityArgs {
    /// Measure the disk that this directory is on; a directory made in it is removed again [default: here]
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// How many times each way
    #[arg(long, default_value_t = 1000, value_name = "N", value_parser = clap::value_parser!(u32).range(100..=1_000_000))]
    rounds: u32,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Times of durable steps in one way of taking them.
#[derive(Debug, Serialize)]
struct DurableTimes {
    /// `in one process`: frame to action in the daemon's own code; `between processes`: as a body sees it.
    mode: &'static str,
    /// Bytes of a step in the journal, on the average.
    bytes: u64,
    ours_us_p50: f64,
    ours_us_p99: f64,
    /// Of ours, what the disk has no part in: the same without one.
    without_disk_us_p50: f64,
    bare_us_p50: f64,
    bare_us_p99: f64,
    ratio_p50: f64,
    ratio_p99: f64,
}

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct DurabilityMeasurement {
    rounds: u32,
    ratio_wanted: f64,
    /// Whether the medians of all modes are within it.
    within: bool,
    rows: Vec<DurableTimes>,
}

pub(crate) fn run(args: &DurabilityArgs, quiet: bool) -> Result<(), Failure> {
    let stop = Stop::on_signals()?;
    let directory = directory_on_disk(args.data.as_deref())?;
    let bar = Bar::count(quiet);
    let rounds = args.rounds;
    let one = in_process(directory.path(), rounds, &stop, &bar)?;
    let two = between_processes(directory.path(), rounds, &stop, &bar)?;
    drop(bar);
    let rows = vec![one, two];
    let within = rows.iter().all(|row| row.ratio_p50 <= RATIO_WANTED);
    show(args.json, &DurabilityMeasurement { rounds, ratio_wanted: RATIO_WANTED, within, rows }, text)
}

fn text(f: &DurabilityMeasurement) -> String {
    let headings = ["frame to action", "durable", "bare write", "ratio", "not durable", "bytes"];
    let mut table = Columns::new(&headings).figures(&[1, 2, 3, 4, 5]);
    let pair = |p50: f64, p99: f64| format!("{p50:.0} / {p99:.0}");
    for row in &f.rows {
        table.row([
            row.mode.to_owned(),
            pair(row.ours_us_p50, row.ours_us_p99),
            pair(row.bare_us_p50, row.bare_us_p99),
            format!("{:.2} / {:.2}", row.ratio_p50, row.ratio_p99),
            format!("{:.0}", row.without_disk_us_p50),
            row.bytes.to_string(),
        ]);
    }
    let verdict = if f.within { "within" } else { "above" };
    let told = format!(
        "Microseconds, median / 99th percentile of {} rounds. The medians are {verdict} {} times a bare write and fdatasync \
         of as many bytes, the two taking turns.",
        f.rounds, f.ratio_wanted
    );
    format!("{}\n{}", table.text(&[0]), wrapped(&told, ""))
}

impl DurableTimes {
    fn new(mode: &'static str, bytes: u64, ours: &Times, without: &Times, bare: &Times) -> Self {
        Self {
            mode,
            bytes,
            ours_us_p50: ours.p50(),
            ours_us_p99: ours.p99(),
            without_disk_us_p50: without.p50(),
            bare_us_p50: bare.p50(),
            bare_us_p99: bare.p99(),
            ratio_p50: ours.p50() / bare.p50(),
            ratio_p99: ours.p99() / bare.p99(),
        }
    }
}

/// A file that is written and made durable, and nothing else.
struct BareFile {
    file: File,
    end: u64,
    zeroed: u64,
}

impl BareFile {
    fn new(directory: &Path, name: &str) -> std::io::Result<Self> {
        let file = File::create(directory.join(name))?;
        Ok(Self { file, end: 0, zeroed: 0 })
    }

    fn write(&mut self, bytes: &[u8]) -> std::io::Result<Duration> {
        if self.end + bytes.len() as u64 > self.zeroed {
            self.file.write_all_at(&vec![0; AHEAD], self.zeroed)?;
            self.zeroed += AHEAD as u64;
            self.file.sync_data()?;
        }
        let began = Instant::now();
        self.file.write_all_at(bytes, self.end)?;
        self.file.sync_data()?;
        let took = began.elapsed();
        self.end += bytes.len() as u64;
        Ok(took)
    }
}

fn disk(error: impl std::fmt::Display) -> Failure {
    Failure::Failed(format!("the disk can't be measured: {error}"))
}

/// The bytes that stand for a step in the baseline: as many as one of ours took, and none of them zero.
fn filled(length: u64) -> Vec<u8> {
    vec![0x5a; usize::try_from(length).unwrap_or(0)]
}

fn setup() -> Result<Setup, Failure> {
    let (curriculum, learner) = config::lesson("free", Default::default(), &[]).map_err(Failure::of)?;
    Ok(Setup { seed: 1, learner, curriculum })
}

/// A frame, and the action that is durable: what a daemon does between the two, without the shared memory.
fn in_process(directory: &Path, rounds: u32, stop: &Stop, bar: &Bar) -> Result<DurableTimes, Failure> {
    let Setup { seed, learner, curriculum } = setup()?;
    let options = Options::new("bench", seed, &learner.parameters, &curriculum);
    let me = thread::current();
    let opened =
        pschema_store::open(&directory.join("in-process"), options, move || me.unpark()).map_err(disk)?;
    let Opened { mut learner, mut store, .. } = opened;
    let mut body = BodyLoop::new(RowBody::new());
    let hello = decode::hello(&body.hello().map_err(Failure::of)?).map_err(Failure::of)?;
    let (mut session, effects) = Session::attach(1, &hello, &mut learner).map_err(Failure::of)?;
    body.attached(session.number());
    let mut bare = BareFile::new(directory, "bare-1").map_err(disk)?;
    let (mut ours, mut without, mut bared) = (Times::default(), Times::default(), Times::default());
    let mut write = |change: &Change<'_>, content: &_| {
        let batch = store.append(change, content).map_err(disk)?;
        while !store.is_durable(batch) {
            if let Some(failure) = store.failure() {
                return Err(disk(failure));
            }
            thread::park_timeout(Duration::from_secs(1));
        }
        Ok(store.journal_bytes())
    };
    let declared = Change { cause: Cause::Declared("bench"), at_unix_ms: 0, effects: &effects };
    let mut before = write(&declared, learner.memory().content())?;
    let first = before;
    for round in 0..WARM_UP + rounds {
        stop.check()?;
        let frame = body.next_frame();
        let began = Instant::now();
        let served = session.frame(&mut learner, frame, &mut Vec::new(), false);
        let decided = began.elapsed();
        let mut after = before;
        if let Some(step) = &served.step {
            let cause = Cause::Step(session.input());
            let change = Change { cause, at_unix_ms: now(), effects: &step.effects };
            after = write(&change, learner.memory().content())?;
        }
        let took = began.elapsed();
        let wire = encode::reply(session.number(), frame.header.sequence, &served.reply);
        body.obey(&wire).map_err(Failure::of)?;
        let bare = bare.write(&filled(after.saturating_sub(before))).map_err(disk)?;
        if round >= WARM_UP && after > before {
            ours.push(took);
            without.push(decided);
            bared.push(bare);
        }
        before = after;
        bar.show(u64::from(round), u64::from(rounds), "frames in this process".to_owned());
    }
    let bytes = (before - first) / u64::from(WARM_UP + rounds);
    Ok(DurableTimes::new("in one process", bytes, &ours, &without, &bared))
}

fn now() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since.as_millis()).unwrap_or(u64::MAX)
}

/// A body attached to a daemon.
struct AttachedBody {
    body: BodyLoop<RowBody>,
    link: BodyLink,
    stop: AtomicBool,
    // Last, so that the body leaves first.
    _daemon: Child,
}

impl AttachedBody {
    fn start(runtime: &Path, name: &str, data: Option<&Path>, stop: &Stop) -> Result<Self, Failure> {
        let place = Place::new(RuntimeDir::at(runtime)?, LearnerName::new(name)?);
        let mut arguments = vec!["server".to_owned(), "--name".to_owned(), name.to_owned()];
        if let Some(data) = data {
            arguments.extend(["--data".to_owned(), data.display().to_string()]);
        }
        let mut daemon = Child::start("daemon", runtime, arguments)?;
        let mut body = BodyLoop::new(RowBody::new());
        let (began, unstopped) = (Instant::now(), AtomicBool::new(false));
        let link = loop {
            stop.check()?;
            daemon.check()?;
            match BodyLink::attach(&place, body.description(), &unstopped) {
                Ok(link) => break link,
                Err(
                    TransportError::Domain(_) | TransportError::Setup { .. } | TransportError::DaemonGone,
                ) if began.elapsed() < READY_WITHIN => {
                    thread::sleep(Duration::from_millis(5));
                }
                Err(error) => return Err(Failure::of(error)),
            }
        };
        body.attached(link.session());
        Ok(Self { body, link, stop: unstopped, _daemon: daemon })
    }

    /// One frame, and how long its action took to come.
    fn exchange(&mut self) -> Result<Duration, Failure> {
        let frame = self.body.next_frame();
        let began = Instant::now();
        let reply = self.link.exchange(frame, &self.stop).map_err(Failure::of)?;
        let took = began.elapsed();
        self.body.obey(&reply).map_err(Failure::of)?;
        Ok(took)
    }
}

/// As a body sees it: with a daemon that keeps memory on disk, with one that does not, and bare.
fn between_processes(directory: &Path, rounds: u32, stop: &Stop, bar: &Bar) -> Result<DurableTimes, Failure> {
    let runtime = runtime_directory()?;
    let data = directory.join("daemon");
    let mut kept = AttachedBody::start(runtime.path(), "kept", Some(&data), stop)?;
    let mut in_ram = AttachedBody::start(runtime.path(), "in-ram", None, stop)?;
    for _ in 0..WARM_UP {
        kept.exchange()?;
        in_ram.exchange()?;
    }
    let bytes = bytes_of_a_step(&data)?;
    let mut bare = BareFile::new(directory, "bare-2").map_err(disk)?;
    let (mut ours, mut without, mut bared) = (Times::default(), Times::default(), Times::default());
    for round in 0..rounds {
        stop.check()?;
        ours.push(kept.exchange()?);
        bared.push(bare.write(&filled(bytes)).map_err(disk)?);
        without.push(in_ram.exchange()?);
        bar.show(u64::from(round), u64::from(rounds), "frames between processes".to_owned());
    }
    Ok(DurableTimes::new("between processes", bytes, &ours, &without, &bared))
}

/// What steps take in the journal, on the average.
fn bytes_of_a_step(data: &Path) -> Result<u64, Failure> {
    let (batches, _) = Past::open(data)?.batches(Some(1), None, 1_000, false)?;
    let bytes: u64 = batches.iter().map(|batch| batch.bytes).sum();
    Ok(bytes / (batches.len() as u64).max(1))
}
