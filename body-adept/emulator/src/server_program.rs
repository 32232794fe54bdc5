//! The program `pschema.v2` as it runs on the controller, on a user serial line: lines that end in LF, no echo, no line
//! editing, every line with a sum. Its words are explained in `vplus/pschema.v2`, whose behaviour this follows.

use std::time::{Duration, Instant};

use crate::machine::{End, Guard, Happened, Machine};
use crate::messages;
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

/// What the program itself refuses.
mod refusal {
    pub(super) const BUSY: (i32, &str) = (10, "busy");
    pub(super) const LATCHED: (i32, &str) = (11, "latched");
    pub(super) const VALUES: (i32, &str) = (12, "values");
    pub(super) const TOO_MANY: (i32, &str) = (14, "too many points");
    pub(super) const UNKNOWN: (i32, &str) = (15, "unknown");
    pub(super) const CHECKSUM: (i32, &str) = (16, "checksum");
    pub(super) const REPEATED: (i32, &str) = (17, "repeated");
    pub(super) const STOPPED: (i32, &str) = (18, "stopped");
}

/// What a request leads to: an answer, none yet, or a refusal.
type Answer = Result<Option<String>, (i32, &'static str)>;

/// How a motion ended, in the program's numbers.
mod ended {
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
    /// When the last line came whose sum was right.
    fed_at: Instant,
    vias: Vec<Leg>,
    /// The number of the motion under way, or the last one.
    moving: u32,
    last_ended: (u32, i32),
    /// Set by whatever stopped the arm that a person should know about; moves are refused until `RESET`.
    latched: bool,
    /// Whether it was stopped by the program itself, which END tells.
    fell: bool,
    /// Requests that are answered when power or calibration are done.
    awaiting_power: Option<u32>,
    awaiting_calibration: Option<u32>,
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
            last_ended: (0, ended::ARRIVED),
            latched: false,
            fell: false,
            awaiting_power: None,
            awaiting_calibration: None,
        }
    }

    /// Takes bytes from the line; answers go to `out`, one after the other.
    pub(crate) fn take(&mut self, bytes: &[u8], machine: &mut Machine, now: Instant, out: &mut Vec<String>) {
        for byte in bytes {
            match *byte {
                STOP_BYTE => {
                    self.stop(machine, out);
                    // What it cut short may lack its end alone: no line end may make an order of it.
                    self.line = vec![b'?'];
                }
                b'\n' => {
                    let line = std::mem::take(&mut self.line);
                    let overlong = std::mem::take(&mut self.overlong);
                    machine.record().lines += 1;
                    if overlong {
                        out.push(refused(0, refusal::CHECKSUM));
                    } else {
                        let answer = self.line(&line, machine, now, out);
                        out.extend(answer);
                    }
                }
                b'\r' => {}
                _ if self.line.len() >= LINE_BYTES_MAX => self.overlong = true,
                byte => self.line.push(byte),
            }
        }
    }

    /// Stops a motion, or power coming up, or a calibration, for which no line comes any more.
    pub(crate) fn watch(&mut self, machine: &mut Machine, now: Instant, out: &mut Vec<String>) {
        if self.is_busy(machine)
            && now.saturating_duration_since(self.fed_at) > self.watchdog
            && !self.latched
        {
            machine.record().watchdog_stops += 1;
            self.fall(machine, out);
        }
    }

    /// An error of V+ in the task that serves the line: it stops the arm, latches, tells, and goes on.
    pub(crate) fn trip(&mut self, machine: &mut Machine, out: &mut Vec<String>) {
        self.fall(machine, out);
        out.push(error(0, messages::OVERRUN.code, messages::OVERRUN.text));
    }

    fn fall(&mut self, machine: &mut Machine, out: &mut Vec<String>) {
        self.fell = machine.is_moving();
        self.stop(machine, out);
        self.latched = true;
    }

    fn is_busy(&self, machine: &Machine) -> bool {
        machine.is_moving() || machine.is_preparing()
    }

    /// Tells what happened by itself.
    pub(crate) fn happened(&mut self, happened: Happened, out: &mut Vec<String>) {
        match happened {
            Happened::PowerUp => out.extend(self.awaiting_power.take().map(ok)),
            Happened::Calibrated => out.extend(self.awaiting_calibration.take().map(ok)),
            Happened::Interrupted(message) => {
                self.latched = true;
                let asked = [self.awaiting_power.take(), self.awaiting_calibration.take()];
                out.extend(
                    asked.into_iter().flatten().map(|number| error(number, message.code, message.text)),
                );
            }
            Happened::Ended(end) => {
                let code = match end {
                    End::Stopped if std::mem::take(&mut self.fell) => ended::WATCHDOG,
                    End::Arrived => ended::ARRIVED,
                    End::Touched => ended::TOUCHED,
                    End::Stopped => ended::STOPPED,
                    End::Error(message) => {
                        self.latched = true;
                        message.code
                    }
                };
                self.last_ended = (self.moving, code);
                out.push(format!("END {} {code}", self.moving));
            }
        }
    }

    fn stop(&mut self, machine: &mut Machine, out: &mut Vec<String>) {
        self.vias.clear();
        let asked = [self.awaiting_power.take(), self.awaiting_calibration.take()];
        if machine.is_preparing() || asked.iter().any(Option::is_some) {
            // Braking ends one of a calibration's own motions, not the calibration: without power it is over.
            machine.disable_power();
        }
        machine.stop();
        out.extend(asked.into_iter().flatten().map(|number| refused(number, refusal::STOPPED)));
    }

    /// The answer to a line; none when it comes later.
    fn line(
        &mut self,
        line: &[u8],
        machine: &mut Machine,
        now: Instant,
        out: &mut Vec<String>,
    ) -> Option<String> {
        let line = String::from_utf8_lossy(line);
        if line.trim() == "STOP" {
            // Stopping needs no proof.
            self.stop(machine, out);
            return Some(ok(0));
        }
        let Some(text) = sum::checked(&line) else { return Some(refused(0, refusal::CHECKSUM)) };
        // Noise feeds no watchdog: it says nothing of the host.
        self.fed_at = now;
        let mut words = text.split(' ');
        let verb = words.next().unwrap_or_default();
        let Some(number) = words.next().and_then(number).filter(|number| *number <= NUMBER_MAX) else {
            return Some(refused(0, refusal::VALUES));
        };
        let values: Vec<&str> = words.collect();
        match self.obey(verb, number, &values, machine, out) {
            Ok(answer) => answer,
            Err((code, text)) => Some(error(number, code, text)),
        }
    }

    fn obey(
        &mut self,
        verb: &str,
        number: u32,
        values: &[&str],
        machine: &mut Machine,
        out: &mut Vec<String>,
    ) -> Answer {
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
                self.stop(machine, out);
                Ok(Some(ok(number)))
            }
            "RESET" if self.is_busy(machine) => Err(refusal::BUSY),
            "RESET" => {
                self.latched = machine.is_stopped();
                if self.latched {
                    Err((messages::E_STOP.code, messages::E_STOP.text))
                } else {
                    none(ok(number))
                }
            }
            "POWER" | "CAL" if self.is_busy(machine) && values != ["0"] => Err(refusal::BUSY),
            "POWER" | "CAL" if self.latched && values != ["0"] => Err(refusal::LATCHED),
            "POWER" => self.power(number, values, machine, out),
            "CAL" => {
                machine.calibrate().map_err(|message| (message.code, message.text))?;
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
            Some((&"0", rest)) => (Guard::None, rest),
            Some((&"1", rest)) => (Guard::On, rest),
            Some((&"2", rest)) => (Guard::Off, rest),
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
        machine.start(&self.vias, guard).map_err(|message| (message.code, message.text))?;
        self.moving = number;
        Ok(Some(ok(number)))
    }

    fn power(
        &mut self,
        number: u32,
        values: &[&str],
        machine: &mut Machine,
        out: &mut Vec<String>,
    ) -> Answer {
        match values {
            ["0"] => {
                self.stop(machine, out);
                machine.disable_power();
                Ok(Some(ok(number)))
            }
            ["1"] if machine.has_power() => Ok(Some(ok(number))),
            ["1"] => {
                machine.enable_power().map_err(|message| (message.code, message.text))?;
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
            // As STATE(1) tells it, which without power cannot.
            bit(machine.overall_state() == 7),
            bit(machine.is_stopped()),
            bit(self.is_busy(machine)),
            bit(self.latched),
            machine.signals()
        )
    }
}

fn ok(number: u32) -> String {
    format!("OK {number}")
}

fn error(number: u32, code: i32, text: &str) -> String {
    format!("ERR {number} {code} {text}")
}

fn refused(number: u32, (code, text): (i32, &str)) -> String {
    error(number, code, text)
}

/// A whole number of digits alone.
fn number(text: &str) -> Option<u32> {
    let plain = !text.is_empty() && text.len() <= 9 && text.bytes().all(|byte| byte.is_ascii_digit());
    if plain { text.parse().ok() } else { None }
}

/// Speed and one value a joint, all decimal numbers as V+ reads them: no `nan`, no `inf`, no exponents.
fn leg(values: &[&str]) -> Result<Leg, (i32, &'static str)> {
    let [speed, joints @ ..] = values else { return Err(refusal::VALUES) };
    if joints.len() != JOINTS {
        return Err(refusal::VALUES);
    }
    let speed = number(speed).filter(|speed| (1..=100).contains(speed)).ok_or(refusal::VALUES)?;
    let mut to: Joints = [0.0; JOINTS];
    for (value, text) in to.iter_mut().zip(joints) {
        *value = crate::decimal(text).ok_or(refusal::VALUES)?;
    }
    Ok(Leg { to, speed: f64::from(speed) / 100.0 })
}

#[cfg(test)]
mod tests;
