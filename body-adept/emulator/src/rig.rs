//! Line, controller, sockets and time together: one loop, one wait.

use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};

use crate::faults::{FaultRates, Faults};
use crate::line::Line;
use crate::machine::{Happened, Machine};
use crate::monitor::{Monitor, START_UP};
use crate::pty::Pty;
use crate::server_program::ServerProgram;
use crate::sockets::{Socket, ppm};
use crate::{EmulatorArgs, EmulatorError, IDLE, Record, Speaks};

/// Most simulated time between two looks at the line, in seconds: so that the stop of an arm that is emulated faster than
/// in truth comes as soon, in its own time, as an arm's.
const SLICE_S: f64 = 0.02;
/// Time lost beyond this, because the machine was busy, is not caught up with.
const LAG_MAX: Duration = Duration::from_millis(100);

enum Console {
    Monitor(Monitor),
    Program(ServerProgram),
}

/// Everything there is.
pub(crate) struct Rig {
    machine: Machine,
    console: Console,
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
        let mut rates = FaultRates::default();
        args.fault.iter().for_each(|setting| rates.set(setting));
        let faults = Faults::new(rates, args.fault_seed, args.faults_max);
        let place = |what, path: &Path| {
            let path = path.to_owned();
            move |source| EmulatorError::Place { what, path, source }
        };
        let socket = |what, path: &Option<_>| {
            let path: &std::path::PathBuf = match path {
                Some(path) => path,
                None => return Ok(None),
            };
            Socket::bind(path).map(Some).map_err(place(what, path))
        };
        let camera = socket("the camera's socket", &args.camera)?;
        let operator = socket("the operator's socket", &args.operator)?;
        let pty = Pty::new(&args.link).map_err(place("the line", &args.link))?;
        let mut rig = Self {
            console: Self::console(args, now),
            machine,
            args: args.clone(),
            line: Line::new(pty, faults, args.baud, now),
            camera,
            operator,
            fast: args.fast,
            looked: now,
        };
        rig.switched_on(now);
        Ok(rig)
    }

    /// What the arm is made to do, to be looked at from elsewhere.
    pub(crate) fn watched(&self) -> Arc<Mutex<Record>> {
        self.machine.watched()
    }

    fn console(args: &EmulatorArgs, now: Instant) -> Console {
        match args.speaks {
            Speaks::Monitor => Console::Monitor(Monitor::new(!args.no_echo)),
            Speaks::Program => {
                Console::Program(ServerProgram::new(Duration::from_millis(args.watchdog_ms), now))
            }
        }
    }

    fn switched_on(&mut self, now: Instant) {
        if let Console::Monitor(_) = self.console {
            let mut text = START_UP.to_owned();
            Monitor::prompt(&mut text);
            self.line.say(&text, now);
        }
    }

    /// Waits for something to do, and does it.
    pub(crate) fn turn(&mut self) -> Result<(), EmulatorError> {
        self.wait()?;
        let now = Instant::now();
        let passed = now.saturating_duration_since(self.looked).min(LAG_MAX);
        self.looked = now;
        let heard = self.line.hear(now).map_err(EmulatorError::Failed)?;
        self.take(&heard, now);
        if self.machine.is_busy() {
            let time_s = (passed.as_secs_f64() * self.fast).min(SLICE_S.max(passed.as_secs_f64()));
            self.machine.advance(time_s);
        }
        self.tell(now);
        self.serve(now);
        self.line.flush(now).map_err(EmulatorError::Failed)?;
        self.machine.record().faults = self.line.faults.injected();
        Ok(())
    }

    /// At most until the next thing is due.
    fn wait(&self) -> Result<(), EmulatorError> {
        let until_due = self.line.due().map(|due| due.saturating_duration_since(Instant::now()));
        let mut time = until_due.unwrap_or(IDLE).min(IDLE);
        if self.machine.is_busy() {
            // In slow time, steps are worth waiting for.
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

    fn take(&mut self, heard: &[u8], now: Instant) {
        match &mut self.console {
            Console::Monitor(monitor) => {
                let mut text = String::new();
                monitor.take(heard, &mut self.machine, &mut text);
                if !text.is_empty() {
                    self.line.say(&text, now);
                }
            }
            Console::Program(program) => {
                let mut answers = Vec::new();
                program.take(heard, &mut self.machine, now, &mut answers);
                program.watch(&mut self.machine, now, &mut answers);
                answers.iter().for_each(|answer| self.line.say(&line_of(answer), now));
            }
        }
    }

    /// An error of V+ in the program that serves the line.
    fn trip(&mut self, now: Instant) -> Result<(), String> {
        let Console::Program(program) = &mut self.console else {
            return Err("no program runs there".to_owned());
        };
        let mut answers = Vec::new();
        program.trip(&mut self.machine, &mut answers);
        answers.iter().for_each(|answer| self.line.say(&line_of(answer), now));
        Ok(())
    }

    /// Tells on the line what happened by itself.
    fn tell(&mut self, now: Instant) {
        for happened in self.machine.happened() {
            self.tell_one(happened, now);
        }
    }

    fn tell_one(&mut self, happened: Happened, now: Instant) {
        match &mut self.console {
            Console::Monitor(monitor) => {
                let mut text = String::new();
                monitor.happened(happened, &mut self.machine, &mut text);
                if !text.is_empty() {
                    self.line.say(&text, now);
                }
            }
            Console::Program(program) => {
                let mut answers = Vec::new();
                program.happened(happened, &mut answers);
                answers.iter().for_each(|answer| self.line.say(&line_of(answer), now));
            }
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

    /// What a person in the room does.
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
            ["trip"] => self.trip(now)?,
            ["estop", "press"] => self.machine.press(true),
            ["estop", "release"] => self.machine.press(false),
            ["power", "cycle"] => {
                self.machine.cycle();
                self.console = Self::console(&self.args, now);
                self.switched_on(now);
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

/// A line of the program: with its sum, and as `WRITE` ends it.
fn line_of(answer: &str) -> String {
    format!("{}\r\n", crate::sum::summed(answer))
}
