//! Line, controller, sockets and time together: one loop, one wait.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};

use crate::args::{Dialect, EmulatorArgs, EmulatorError};
use crate::console::Console;
use crate::faults::{FaultRates, LineFaults};
use crate::line::Line;
use crate::machine::Machine;
use crate::monitor::Monitor;
use crate::pty::Pty;
use crate::record::EmulatorRecord;
use crate::server_program::ServerProgram;
use crate::sockets::{Socket, ppm};

/// Most simulated time between two looks at the line, in seconds. An arm that is emulated faster than a real one then
/// stops as soon, in its own time, as a real one.
const SLICE_S: f64 = 0.02;
/// Time lost beyond this, because the machine was busy, is not caught up with.
const LAG_MAX: Duration = Duration::from_millis(100);

/// Longest wait for something to do, after which the flag that ends the emulator is looked at.
const IDLE: Duration = Duration::from_millis(20);

/// The whole emulator.
pub(crate) struct Rig {
    machine: Machine,
    console: Box<dyn Console>,
    args: EmulatorArgs,
    line: Line,
    camera: Option<Socket>,
    operator: Option<Socket>,
    fast: f64,
    looked: Instant,
}

impl Rig {
    pub(crate) fn new(args: &EmulatorArgs) -> Result<Self, EmulatorError> {
        let now = Instant::now();
        let mut machine = Machine::new(&args.world, args.seed)?;
        machine.invert(args.touch_inverted);
        let faults = LineFaults::new(FaultRates::new(&args.fault), args.fault_seed, args.faults_max);
        let place = |what, path: &Path| {
            let path = path.to_owned();
            move |source| EmulatorError::Place { what, path, source }
        };
        let socket = |what, path: &Option<PathBuf>| {
            path.as_ref().map(|path| Socket::bind(path).map_err(place(what, path))).transpose()
        };
        let camera = socket("the camera's socket", &args.camera)?;
        let operator = socket("the operator's socket", &args.operator)?;
        let pty = Pty::new(&args.link).map_err(place("the line", &args.link))?;
        let mut rig = Self {
            console: console(args, now),
            machine,
            args: args.clone(),
            line: Line::new(pty, faults, args.baud, now),
            camera,
            operator,
            fast: args.fast,
            looked: now,
        };
        rig.say(now);
        Ok(rig)
    }

    /// The record of the arm, for another thread.
    pub(crate) fn watched(&self) -> Arc<Mutex<EmulatorRecord>> {
        self.machine.watched()
    }

    /// Waits for something to do, and does it.
    pub(crate) fn turn(&mut self) -> Result<(), EmulatorError> {
        self.wait()?;
        let now = Instant::now();
        let passed = now.saturating_duration_since(self.looked).min(LAG_MAX);
        self.looked = now;
        let heard = self.line.hear(now).map_err(EmulatorError::Failed)?;
        self.console.take(&heard, &mut self.machine, now);
        self.say(now);
        if self.machine.is_busy() {
            let time_s = (passed.as_secs_f64() * self.fast).min(SLICE_S.max(passed.as_secs_f64()));
            self.machine.advance(time_s);
        }
        for event in self.machine.events() {
            self.console.tell(event, &mut self.machine);
            self.say(now);
        }
        self.serve(now);
        self.line.flush(now).map_err(EmulatorError::Failed)?;
        self.machine.record().faults = self.line.faults.injected();
        Ok(())
    }

    /// Waits for bytes or clients, at most until the next thing is due.
    fn wait(&self) -> Result<(), EmulatorError> {
        let until_due = self.line.due().map(|due| due.saturating_duration_since(Instant::now()));
        let mut time = until_due.unwrap_or(IDLE).min(IDLE);
        if self.machine.is_busy() {
            // At a slow pace the steps of the arm are far enough apart to wait for them.
            time = time.min(if self.fast > 4.0 { Duration::ZERO } else { Duration::from_millis(2) });
        }
        if self.args.baud.is_some() {
            time = time.min(Duration::from_millis(2));
        }
        let sockets = self.camera.iter().chain(&self.operator).flat_map(Socket::fds);
        let mut fds: Vec<_> = self
            .line
            .pty()
            .fd()
            .into_iter()
            .chain(sockets)
            .map(|fd| PollFd::from_borrowed_fd(fd, PollFlags::IN))
            .collect();
        let timeout = Timespec { tv_sec: 0, tv_nsec: i64::from(time.subsec_nanos()) };
        match poll(&mut fds, Some(&timeout)) {
            Ok(_) | Err(rustix::io::Errno::INTR) => Ok(()),
            Err(error) => Err(EmulatorError::Failed(error.into())),
        }
    }

    /// Sends the texts that the console has to say.
    fn say(&mut self, now: Instant) {
        for text in self.console.said() {
            self.line.say(&text, now);
        }
    }

    fn serve(&mut self, now: Instant) {
        if let Some(mut camera) = self.camera.take() {
            camera.serve(|_| {
                self.machine.record().pictures += 1;
                ppm(self.machine.picture())
            });
            self.camera = Some(camera);
        }
        if let Some(mut operator) = self.operator.take() {
            operator.serve(|line| {
                let answer = match self.asked(line, now) {
                    Ok(answer) => format!("{answer}\n"),
                    Err(why) => format!("refused {why}\n"),
                };
                answer.into_bytes()
            });
            self.operator = Some(operator);
        }
    }

    /// Carries out a deed of the person in the room.
    fn asked(&mut self, line: &str, now: Instant) -> Result<String, String> {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.as_slice() {
            ["place", object, position] => {
                let number =
                    position.parse().map_err(|_| format!("{position} is no number of a position"))?;
                self.machine.put(object, number)?;
            }
            ["remove", object] => self.machine.take_away(object)?,
            // As with a pendant: the arm stands, and keeps its power.
            ["halt"] => self.machine.stop(),
            ["trip"] => {
                self.console.trip(&mut self.machine)?;
                self.say(now);
            }
            ["estop", "press"] => self.machine.press(true),
            ["estop", "release"] => self.machine.press(false),
            ["power", "cycle"] => {
                self.machine.cycle();
                self.console = console(&self.args, now);
                self.say(now);
            }
            ["unplug", ms] => {
                let ms: u64 = ms.parse().map_err(|_| format!("{ms} is no number of milliseconds"))?;
                self.line.unplug(Duration::from_millis(ms.min(60_000)), now);
            }
            ["say", words @ ..] => self.line.say(&format!("\r\n{}\r\n", words.join(" ")), now),
            ["faults", "on"] => self.line.faulty = true,
            ["faults", "off"] => self.line.faulty = false,
            ["enable" | "reset", ..] if self.args.consent => {}
            ["enable" | "reset", ..] => return Err("the person in the room does not agree".to_owned()),
            ["record"] => return Ok(self.machine.record().summary()),
            _ => return Err(format!("nobody here understands {line:?}")),
        }
        Ok("done".to_owned())
    }
}

/// The console of a controller that was just switched on.
fn console(args: &EmulatorArgs, now: Instant) -> Box<dyn Console> {
    match args.speaks {
        Dialect::Monitor => Box::new(Monitor::switched_on(!args.no_echo)),
        Dialect::Program => Box::new(ServerProgram::new(Duration::from_millis(args.watchdog_ms), now)),
    }
}
