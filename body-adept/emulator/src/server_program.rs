//! The program `pschema.v2` as it runs on the controller, on a user serial line: lines that end in LF, no echo, no line
//! editing, every line with a sum. Its words are explained in `vplus/pschema.v2`, which this
//! module follows.

use std::time::{Duration, Instant};

use crate::console::Console;
use crate::decimal::decimal;
use crate::machine::{Machine, MachineEvent, MotionEnd, TouchGuard};
use crate::messages::{self, VPlusMessage};
use crate::path::{JOINTS, Joints, Leg};
use crate::sum;

/// Longest line taken, in bytes.
const LINE_BYTES_MAX: usize = 128;
/// Points that may come before the end of a motion.
const VIAS_MAX: usize = 64;
/// Highest number of a request.
const NUMBER_MAX: u32 = 999_999;
/// The byte that stops the arm without being part of a line: Ctrl-C.
const STOP_BYTE: u8 = 3;

/// Refusals of the program itself, with its own numbers, which are positive.
mod refusal {
    use crate::messages::VPlusMessage;

    const fn refusal(code: i32, text: &'static str) -> VPlusMessage {
        VPlusMessage { code, text }
    }

    pub(super) const BUSY: VPlusMessage = refusal(10, "busy");
    pub(super) const LATCHED: VPlusMessage = refusal(11, "latched");
    pub(super) const VALUES: VPlusMessage = refusal(12, "values");
    pub(super) const TOO_MANY: VPlusMessage = refusal(14, "too many points");
    pub(super) const UNKNOWN: VPlusMessage = refusal(15, "unknown");
    pub(super) const CHECKSUM: VPlusMessage = refusal(16, "checksum");
    pub(super) const REPEATED: VPlusMessage = refusal(17, "repeated");
    pub(super) const STOPPED: VPlusMessage = refusal(18, "stopped");
}

/// The answer to a request, None when it comes later, or the refusal.
type Answer = Result<Option<String>, VPlusMessage>;

/// The ways in which a motion ended, in the numbers of the program.
mod end {
    pub(super) const ARRIVED: i32 = 0;
    pub(super) const TOUCHED: i32 = 1;
    pub(super) const STOPPED: i32 = 2;
    pub(super) const WATCHDOG: i32 = 3;
}

/// The program, between lines.
pub(crate) struct ServerProgram {
    watchdog: Duration,
    line: Vec<u8>,
    /// Whether the line under way is too long to be taken.
    overlong: bool,
    /// When the last line with a right sum came.
    fed_at: Instant,
    vias: Vec<Leg>,
    /// The number of the motion under way, or the last one.
    moving: u32,
    last_ended: (u32, i32),
    /// Set when a person should know why the arm stopped. Moves are refused until `RESET`.
    latched: bool,
    /// Whether the program itself stopped the motion, which END tells.
    fell: bool,
    /// Requests that are answered when power or calibration are done.
    awaiting_power: Option<u32>,
    awaiting_calibration: Option<u32>,
    /// Lines without their sums that have not gone out yet.
    said: Vec<String>,
}

impl ServerProgram {
    pub(crate) fn new(watchdog: Duration, now: Instant) -> Self {
        Self {
            watchdog,
            line: Vec::new(),
            overlong: false,
            fed_at: now,
            vias: Vec::new(),
            moving: 0,
            last_ended: (0, end::ARRIVED),
            latched: false,
            fell: false,
            awaiting_power: None,
            awaiting_calibration: None,
            said: Vec::new(),
        }
    }

    /// Stops a motion, or power coming up, or a calibration, for which no line comes any more.
    fn watch(&mut self, machine: &mut Machine, now: Instant) {
        if self.is_busy(machine)
            && now.saturating_duration_since(self.fed_at) > self.watchdog
            && !self.latched
        {
            machine.record().watchdog_stops += 1;
            self.fall(machine);
        }
    }

    fn fall(&mut self, machine: &mut Machine) {
        self.fell = machine.is_moving();
        self.stop(machine);
        self.latched = true;
    }

    fn is_busy(&self, machine: &Machine) -> bool {
        machine.is_moving() || machine.is_preparing()
    }

    fn stop(&mut self, machine: &mut Machine) {
        self.vias.clear();
        let asked = [self.awaiting_power.take(), self.awaiting_calibration.take()];
        if machine.is_preparing() || asked.iter().any(Option::is_some) {
            // Braking ends one of a calibration's own motions, not the calibration. Only without power is that over.
            machine.disable_power();
        }
        machine.stop();
        self.said.extend(asked.into_iter().flatten().map(|number| error(number, refusal::STOPPED)));
    }

    /// The answer to a line; none when it comes later.
    fn line(&mut self, line: &[u8], machine: &mut Machine, now: Instant) -> Option<String> {
        let line = String::from_utf8_lossy(line);
        if line.trim() == "STOP" {
            // Stopping needs no proof.
            self.stop(machine);
            return Some(ok(0));
        }
        let Some(text) = sum::checked(&line) else { return Some(error(0, refusal::CHECKSUM)) };
        // Noise feeds no watchdog: it says nothing of the host.
        self.fed_at = now;
        let mut words = text.split(' ');
        let verb = words.next().unwrap_or_default();
        let Some(number) = words.next().and_then(number).filter(|number| *number <= NUMBER_MAX) else {
            return Some(error(0, refusal::VALUES));
        };
        let values: Vec<&str> = words.collect();
        match self.obey(verb, number, &values, machine) {
            Ok(answer) => answer,
            Err(message) => Some(error(number, message)),
        }
    }

    fn obey(&mut self, verb: &str, number: u32, values: &[&str], machine: &mut Machine) -> Answer {
        let none = |answer: String| if values.is_empty() { Ok(Some(answer)) } else { Err(refusal::VALUES) };
        match verb {
            "HELLO" => {
                self.moving = 0;
                none(format!("OK {number} PSCHEMA 1 {JOINTS} {}", self.watchdog.as_millis()))
            }
            "PING" => none(ok(number)),
            "STAT" => none(self.state(number, machine)),
            "WHERE" => {
                let joints = machine.joints().map(|value| format!("{value:.3}"));
                none(format!("OK {number} {}", joints.join(" ")))
            }
            "STOP" => {
                self.stop(machine);
                Ok(Some(ok(number)))
            }
            "RESET" if self.is_busy(machine) => Err(refusal::BUSY),
            "RESET" => {
                self.latched = machine.is_stopped();
                if self.latched { Err(messages::E_STOP) } else { none(ok(number)) }
            }
            "POWER" | "CAL" if self.is_busy(machine) && values != ["0"] => Err(refusal::BUSY),
            "POWER" | "CAL" if self.latched && values != ["0"] => Err(refusal::LATCHED),
            "POWER" => self.power(number, values, machine),
            "CAL" => {
                machine.calibrate()?;
                self.awaiting_calibration = Some(number);
                Ok(None)
            }
            "VIA" => {
                let leg = leg(values)?;
                if self.vias.len() >= VIAS_MAX {
                    return Err(refusal::TOO_MANY);
                }
                self.vias.push(leg);
                Ok(Some(format!("OK {number} {}", self.vias.len())))
            }
            "MOVE" => {
                let begun = self.begin(number, values, machine);
                self.vias.clear();
                begun
            }
            _ => Err(refusal::UNKNOWN),
        }
    }

    fn begin(&mut self, number: u32, values: &[&str], machine: &mut Machine) -> Answer {
        let (guard, values) = match values.split_first() {
            Some((&"0", rest)) => (TouchGuard::None, rest),
            Some((&"1", rest)) => (TouchGuard::On, rest),
            Some((&"2", rest)) => (TouchGuard::Off, rest),
            _ => return Err(refusal::VALUES),
        };
        let last = leg(values)?;
        if self.is_busy(machine) {
            return Err(refusal::BUSY);
        }
        if self.latched {
            return Err(refusal::LATCHED);
        }
        if number <= self.moving {
            return Err(refusal::REPEATED);
        }
        self.vias.push(last);
        machine.start(&self.vias, guard)?;
        self.moving = number;
        Ok(Some(ok(number)))
    }

    fn power(&mut self, number: u32, values: &[&str], machine: &mut Machine) -> Answer {
        match values {
            ["0"] => {
                self.stop(machine);
                machine.disable_power();
                Ok(Some(ok(number)))
            }
            ["1"] if machine.has_power() => Ok(Some(ok(number))),
            ["1"] => {
                machine.enable_power()?;
                self.awaiting_power = Some(number);
                Ok(None)
            }
            _ => Err(refusal::VALUES),
        }
    }

    fn state(&self, number: u32, machine: &Machine) -> String {
        let bit = u8::from;
        let (last, code) = self.last_ended;
        format!(
            "OK {number} {} {} {} {} {} {} {last} {code}",
            bit(machine.has_power()),
            // As STATE(1) tells it, which it cannot without power.
            bit(machine.overall_state() == 7),
            bit(machine.is_stopped()),
            bit(self.is_busy(machine)),
            bit(self.latched),
            machine.signals()
        )
    }
}

impl Console for ServerProgram {
    fn take(&mut self, bytes: &[u8], machine: &mut Machine, now: Instant) {
        for byte in bytes {
            match *byte {
                STOP_BYTE => {
                    self.stop(machine);
                    // The line that it cut short may lack nothing but its end: no line end may make an order of it.
                    self.line = vec![b'?'];
                }
                b'\n' => {
                    let line = std::mem::take(&mut self.line);
                    let overlong = std::mem::take(&mut self.overlong);
                    machine.record().lines += 1;
                    if overlong {
                        self.said.push(error(0, refusal::CHECKSUM));
                    } else {
                        let answer = self.line(&line, machine, now);
                        self.said.extend(answer);
                    }
                }
                b'\r' => {}
                _ if self.line.len() >= LINE_BYTES_MAX => self.overlong = true,
                byte => self.line.push(byte),
            }
        }
        self.watch(machine, now);
    }

    fn tell(&mut self, event: MachineEvent, _: &mut Machine) {
        match event {
            MachineEvent::PowerUp => self.said.extend(self.awaiting_power.take().map(ok)),
            MachineEvent::Calibrated => self.said.extend(self.awaiting_calibration.take().map(ok)),
            MachineEvent::Interrupted(message) => {
                self.latched = true;
                let asked = [self.awaiting_power.take(), self.awaiting_calibration.take()];
                self.said.extend(asked.into_iter().flatten().map(|number| error(number, message)));
            }
            MachineEvent::Ended(end) => {
                let code = match end {
                    MotionEnd::Stopped if std::mem::take(&mut self.fell) => end::WATCHDOG,
                    MotionEnd::Arrived => end::ARRIVED,
                    MotionEnd::Touched => end::TOUCHED,
                    MotionEnd::Stopped => end::STOPPED,
                    MotionEnd::Error(message) => {
                        self.latched = true;
                        message.code
                    }
                };
                self.last_ended = (self.moving, code);
                self.said.push(format!("END {} {code}", self.moving));
            }
        }
    }

    /// Each line with its sum and the end that `WRITE` gives it.
    fn said(&mut self) -> Vec<String> {
        self.said.drain(..).map(|line| format!("{}\r\n", sum::summed(&line))).collect()
    }

    /// An error of V+ in the task that serves the line. The program stops the arm, latches, tells the host, and goes
    /// on.
    fn trip(&mut self, machine: &mut Machine) -> Result<(), String> {
        self.fall(machine);
        self.said.push(error(0, messages::OVERRUN));
        Ok(())
    }
}

fn ok(number: u32) -> String {
    format!("OK {number}")
}

fn error(number: u32, VPlusMessage { code, text }: VPlusMessage) -> String {
    format!("ERR {number} {code} {text}")
}

/// A whole number that is written in digits alone.
fn number(text: &str) -> Option<u32> {
    let plain = !text.is_empty() && text.len() <= 9 && text.bytes().all(|byte| byte.is_ascii_digit());
    if plain { text.parse().ok() } else { None }
}

/// Speed and one value a joint, all decimal numbers as V+ reads them: no `nan`, no `inf`, no exponents.
fn leg(values: &[&str]) -> Result<Leg, VPlusMessage> {
    let [speed, joints @ ..] = values else { return Err(refusal::VALUES) };
    if joints.len() != JOINTS {
        return Err(refusal::VALUES);
    }
    let speed = number(speed).filter(|speed| (1..=100).contains(speed)).ok_or(refusal::VALUES)?;
    let mut to: Joints = [0.0; JOINTS];
    for (value, text) in to.iter_mut().zip(joints) {
        *value = decimal(text).ok_or(refusal::VALUES)?;
    }
    Ok(Leg { to, speed: f64::from(speed) / 100.0 })
}

#[cfg(test)]
mod tests;
