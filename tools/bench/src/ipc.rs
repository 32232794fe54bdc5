//! How long it takes from a frame to its action when nothing is learnt: through the protocol, with all its checks, between
//! two processes; against requests and responses of iceoryx2 with nothing around them. They take turns within each round,
//! the same bytes going the same way, so that both meet the same machine. Beside them, what one could have taken instead:
//! a Unix socket with bincode; and the least that is possible: two threads and a number that both see.

mod atomic;
mod bare;
mod crowd;
mod peer;
mod socket;

use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::thread;
use std::time::{Duration, Instant};

use clap::{Args, ValueEnum};
use pschema_process::Stop;
use pschema_protocol::body::BodyLoop;
use pschema_protocol::domain::{LearnerName, Place, RuntimeDir};
use pschema_protocol::transport::body_link::BodyLink;
use pschema_protocol::transport::{SPIN_US_MAX, Spin};
use pschema_tools::kit::{Bar, Child, Columns, Failure, ParentArgs, runtime_directory, show, wrapped};
use serde::Serialize;

use crate::times::Times;
use atomic::Atomic;
use bare::{BareClient, BareWake, RECORD_WORDS};
use crowd::CrowdBody;
pub(crate) use peer::serve;
use socket::Socket;

/// The learner's name on the domain that is measured.
const NAME: &str = "bench";
/// The smallest, a usual and a large payload: bytes asked for, and the records of 72 bytes that come next to it.
const PAYLOADS: [(usize, usize); 3] = [(64, 1), (4_096, 57), (262_144, 3_641)];
/// Exchanges of one kind before it is the other's turn.
const TURN: u32 = 50;
/// Exchanges of each turn that are not measured: those that get the other side up again.
const WARM_UP: u32 = 5;
/// How long the other process may take to be ready.
const READY_WITHIN: Duration = Duration::from_secs(20);

/// The round trips to measure.
#[derive(Debug, Args)]
pub(crate) struct IpcArgs {
    /// How many round trips each way, for each payload and way of waiting
    #[arg(long, default_value_t = 2_000, value_name = "N", value_parser = clap::value_parser!(u32).range(100..=1_000_000))]
    rounds: u32,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// How the other process is started.
#[derive(Debug, Args)]
pub(crate) struct PeerArgs {
    /// How it waits
    #[arg(long)]
    mode: Mode,
    #[command(flatten)]
    parent: ParentArgs,
}

/// How those who wait do so.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Mode {
    /// They poll.
    Polling,
    /// They sleep until woken.
    Event,
    /// They poll for a while, and sleep then: what daemons and bodies do.
    Hybrid,
}

impl Mode {
    const ALL: [Self; 3] = [Self::Polling, Self::Event, Self::Hybrid];

    fn name(self) -> &'static str {
        match self {
            Self::Polling => "polling",
            Self::Event => "event",
            Self::Hybrid => "hybrid",
        }
    }

    /// For how long they poll.
    fn spin(self) -> Spin {
        match self {
            Self::Polling => Spin::new(SPIN_US_MAX),
            Self::Event => Spin::new(0),
            Self::Hybrid => Spin::usual(),
        }
    }

    fn bare(self) -> BareWake {
        if self == Self::Polling { BareWake::Polls } else { BareWake::Events(self.spin()) }
    }

    /// How long until a side that polled and got nothing sleeps.
    fn until_asleep(self) -> Duration {
        Duration::from_micros(if self == Self::Polling { SPIN_US_MAX + 500 } else { 500 })
    }
}

/// Times of round trips with one payload and one way of waiting.
#[derive(Debug, Serialize)]
struct ExchangeTimes {
    /// What was asked for.
    payload_bytes: usize,
    /// Of the records sent, which are whole ones.
    record_bytes: usize,
    mode: &'static str,
    exchanges: usize,
    ours_us_p50: f64,
    ours_us_p99: f64,
    bare_us_p50: f64,
    bare_us_p99: f64,
    ratio_p50: f64,
    ratio_p99: f64,
    ratio_wanted: f64,
    socket_us_p50: f64,
    socket_us_p99: f64,
    atomic_us_p50: f64,
    atomic_us_p99: f64,
}

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct IpcMeasurement {
    rounds: u32,
    /// For how long the hybrid polls.
    spin_us: u64,
    /// Whether all medians are within what is wanted, and whether all 99th percentiles are.
    within_p50: bool,
    within_p99: bool,
    rows: Vec<ExchangeTimes>,
}

pub(crate) fn run(args: &IpcArgs, quiet: bool) -> Result<(), Failure> {
    let stop = Stop::on_signals()?;
    let bar = Bar::count(quiet);
    let mut rows = Vec::new();
    for mode in Mode::ALL {
        rows.extend(measured(mode, args.rounds, &stop, &bar)?);
    }
    drop(bar);
    let within = |of: fn(&ExchangeTimes) -> f64| rows.iter().all(|row| of(row) <= row.ratio_wanted);
    let measurement = IpcMeasurement {
        rounds: args.rounds,
        spin_us: Spin::usual().us(),
        within_p50: within(|row| row.ratio_p50),
        within_p99: within(|row| row.ratio_p99),
        rows,
    };
    show(args.json, &measurement, text)
}

/// What is wanted of the ratio. A large frame is copied once and checked, and the floor does neither.
fn wanted(payload_bytes: usize) -> f64 {
    if payload_bytes > 64 * 1024 { 1.8 } else { 1.3 }
}

fn measured(mode: Mode, rounds: u32, stop: &Stop, bar: &Bar) -> Result<Vec<ExchangeTimes>, Failure> {
    let runtime = runtime_directory()?;
    let arguments = ["ipc-peer", "--mode", mode.name()];
    let mut peer = Child::start("other side", runtime.path(), arguments)?;
    let mut rows = Vec::new();
    for (payload_bytes, records) in PAYLOADS {
        let mut four = FourWays::connect(mode, records, runtime.path(), &mut peer, stop)?;
        let mut done = 0;
        while done < rounds {
            stop.check()?;
            peer.check()?;
            four.take_turns(TURN.min(rounds - done))?;
            done += TURN;
            let message = format!("{payload_bytes} bytes, {}", mode.name());
            bar.show(u64::from(done.min(rounds)), u64::from(rounds), message);
        }
        rows.push(four.row(payload_bytes));
    }
    Ok(rows)
}

/// The four ways from a frame to its reply.
struct FourWays {
    mode: Mode,
    body: BodyLoop<CrowdBody>,
    link: BodyLink,
    bare: BareClient,
    sensing: Sensing,
    socket: Socket,
    atomic: Atomic,
    unstopped: AtomicBool,
    ours: Times,
    bared: Times,
    socketed: Times,
    atomics: Times,
}

impl FourWays {
    fn connect(
        mode: Mode,
        records: usize,
        runtime: &Path,
        peer: &mut Child,
        stop: &Stop,
    ) -> Result<Self, Failure> {
        let place = Place::new(RuntimeDir::at(runtime)?, LearnerName::new(NAME)?);
        let mut body = BodyLoop::new(CrowdBody::new(records));
        let unstopped = AtomicBool::new(false);
        // The socket is made last: where it is, everything is.
        let socket = in_time(peer, stop, || Socket::connect(&runtime.join(socket::FILE)))?;
        let bare = in_time(peer, stop, || BareClient::open(&place, mode.bare()))?;
        let mut link = in_time(peer, stop, || BodyLink::attach(&place, body.description(), &unstopped))?;
        link.set_spin(mode.spin());
        body.attached(link.session());
        Ok(Self {
            mode,
            body,
            link,
            bare,
            sensing: Sensing::new(records),
            socket,
            atomic: Atomic::new(records * RECORD_WORDS),
            unstopped,
            ours: Times::default(),
            bared: Times::default(),
            socketed: Times::default(),
            atomics: Times::default(),
        })
    }

    /// Each way its turn, those before it asleep.
    fn take_turns(&mut self, exchanges: u32) -> Result<(), Failure> {
        for _ in 0..WARM_UP {
            self.ours()?;
        }
        for _ in 0..exchanges {
            let took = self.ours()?;
            self.ours.push(took);
        }
        thread::sleep(self.mode.until_asleep());
        for _ in 0..WARM_UP {
            self.bare()?;
        }
        for _ in 0..exchanges {
            let took = self.bare()?;
            self.bared.push(took);
        }
        thread::sleep(self.mode.until_asleep());
        for _ in 0..WARM_UP {
            self.socket()?;
        }
        for _ in 0..exchanges {
            let took = self.socket()?;
            self.socketed.push(took);
        }
        let took = self.atomic.exchanges(&self.sensing.payload, WARM_UP + exchanges);
        took.into_iter().skip(WARM_UP as usize).for_each(|took| self.atomics.push(took));
        Ok(())
    }

    /// From a frame that is sensed to an action that is carried out, by a body that needs no time for either.
    fn ours(&mut self) -> Result<Duration, Failure> {
        let frame = self.body.next_frame();
        let began = Instant::now();
        let reply = self.link.exchange(frame, &self.unstopped).map_err(Failure::of)?;
        self.body.obey(&reply).map_err(Failure::of)?;
        Ok(began.elapsed())
    }

    fn bare(&mut self) -> Result<Duration, Failure> {
        self.sensing.again();
        let payload = &self.sensing.payload;
        let began = Instant::now();
        let reply = self.bare.exchange(payload).map_err(Failure::of)?;
        let took = began.elapsed();
        let sum = payload.iter().fold(0_u64, |sum, word| sum.wrapping_add(*word));
        if reply[0] != sum {
            return Err(Failure::Failed("the bare payload came otherwise than it was sent".to_owned()));
        }
        Ok(took)
    }

    fn socket(&mut self) -> Result<Duration, Failure> {
        self.sensing.again();
        self.socket.exchange(&self.sensing.payload)
    }

    fn row(&self, payload_bytes: usize) -> ExchangeTimes {
        let both = |times: &Times| (times.p50(), times.p99());
        let (ours_us_p50, ours_us_p99) = both(&self.ours);
        let (bare_us_p50, bare_us_p99) = both(&self.bared);
        let (socket_us_p50, socket_us_p99) = both(&self.socketed);
        let (atomic_us_p50, atomic_us_p99) = both(&self.atomics);
        ExchangeTimes {
            payload_bytes,
            record_bytes: size_of_val(&*self.sensing.payload),
            mode: self.mode.name(),
            exchanges: self.ours.len(),
            ours_us_p50,
            ours_us_p99,
            bare_us_p50,
            bare_us_p99,
            ratio_p50: ours_us_p50 / bare_us_p50,
            ratio_p99: ours_us_p99 / bare_us_p99,
            ratio_wanted: wanted(payload_bytes),
            socket_us_p50,
            socket_us_p99,
            atomic_us_p50,
            atomic_us_p99,
        }
    }
}

/// What is sent without the protocol: sensed and written down anew for each exchange, as a frame is, so that nobody has
/// less to do in between, and the other side not longer to wait.
struct Sensing {
    body: BodyLoop<CrowdBody>,
    payload: Vec<u64>,
}

impl Sensing {
    fn new(records: usize) -> Self {
        let mut new = Self { body: BodyLoop::new(CrowdBody::new(records)), payload: Vec::new() };
        new.again();
        new
    }

    fn again(&mut self) {
        self.payload.clear();
        for record in &self.body.next_frame().records {
            let head =
                u64::from(record.index) | u64::from(record.count) << 16 | u64::from(record.kinds) << 32;
            self.payload.push(head);
            self.payload.extend_from_slice(&record.values);
        }
    }
}

/// Tries until the other process is ready for it.
fn in_time<T, E: std::fmt::Display>(
    peer: &mut Child,
    stop: &Stop,
    mut attempt: impl FnMut() -> Result<T, E>,
) -> Result<T, Failure> {
    let began = Instant::now();
    loop {
        stop.check()?;
        peer.check()?;
        match attempt() {
            Ok(done) => return Ok(done),
            Err(_) if began.elapsed() < READY_WITHIN => thread::sleep(Duration::from_millis(5)),
            Err(error) => return Err(Failure::Failed(format!("the other side can't be reached: {error}"))),
        }
    }
}

fn text(f: &IpcMeasurement) -> String {
    let headings = ["payload", "mode", "ours", "bare", "ratio", "wanted", "socket", "atomic"];
    let mut table = Columns::new(&headings).figures(&[0, 2, 3, 4, 5, 6, 7]);
    let pair = |p50: f64, p99: f64| format!("{p50:.1} / {p99:.1}");
    for row in &f.rows {
        table.row([
            row.payload_bytes.to_string(),
            row.mode.to_owned(),
            pair(row.ours_us_p50, row.ours_us_p99),
            pair(row.bare_us_p50, row.bare_us_p99),
            format!("{:.2} / {:.2}", row.ratio_p50, row.ratio_p99),
            format!("{:.1}", row.ratio_wanted),
            pair(row.socket_us_p50, row.socket_us_p99),
            pair(row.atomic_us_p50, row.atomic_us_p99),
        ]);
    }
    let verdict = |within: bool| if within { "within" } else { "not all within" };
    let told = format!(
        "Microseconds from frame to action, median / 99th percentile of {} round trips each way, taking turns by {TURN}. The \
         medians are {} what is wanted, the 99th percentiles {}. Hybrid is what daemons and bodies do: they poll for {} us \
         before they sleep.",
        f.rounds,
        verdict(f.within_p50),
        verdict(f.within_p99),
        f.spin_us
    );
    format!("{}\n{}", table.text(&[0]), wrapped(&told, ""))
}
