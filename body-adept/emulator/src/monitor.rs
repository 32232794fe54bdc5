//! The monitor: what a person at the controller's terminal types, and what the controller answers.
//!
//! From the vendor's documents: the prompt is a period at the beginning of a line; commands may be abbreviated;
//! messages stand between asterisks; `SPEED` is a percentage of at most 100; precision points are `#name`, one value a
//! joint; calibrating asks first. From a driver that works: commands end in CR LF, `DO SET #P=#PPOINT(…)`, `DO MOVE
//! #P`, `HERE #P` prints values and asks a question that an empty line answers, `PANIC` stops.
//!
//! **From memory, not verified**: that the monitor echoes the bytes that are typed (`--no-echo` for one that does not);
//! the columns of `WHERE`, `HERE` and `LISTL`; that `SPEED(1)` and `SPEED(2)` tell the speeds that the monitor and a
//! program have set; that `PANIC` ends a calibration; that `DO MOVE` returns the prompt before the motion ends and `DO
//! BREAK` waits for its end; that `PANIC` keeps power and `ESTOP` takes it away; that a motion asked for during another
//! waits for it; that `LISTR` prints each value on a line of its own; the text of a controller that was just switched
//! on.

use std::collections::{BTreeMap, VecDeque};
use std::time::Instant;

use crate::console::Console;
use crate::decimal::decimal;
use crate::machine::{Machine, MachineEvent, MotionEnd, TouchGuard};
use crate::messages::{self, VPlusMessage};
use crate::path::{JOINTS, Joints, Leg};

/// Longest line taken, in bytes; a longer one is an overrun.
const LINE_BYTES_MAX: usize = 256;
/// Points that are remembered.
const POINTS_MAX: usize = 256;
/// Bytes typed ahead while a command takes its time.
const TYPED_AHEAD_MAX: usize = 1024;
/// The byte that ends the waiting of a command: Ctrl-C.
const BREAK_BYTE: u8 = 3;
/// The number that V+ calls true.
const TRUE: f64 = -1.0;

/// The text of a controller that was just switched on.
const START_UP: &str =
    "\r\n\r\nAdept V+ (emulated by pschema)\r\nNo robot attached to this line but a simulated one\r\n";

/// The event or answer that the monitor waits for before it prompts again.
#[derive(Clone, Debug, PartialEq)]
enum PendingCommand {
    /// Power to come up.
    Power,
    /// Calibration to end.
    Calibration,
    /// The motion to end.
    Motion,
    /// The motion to end, before another one begins.
    Next(Leg),
    /// A yes to the question whether to calibrate.
    Sure,
    /// Other values for a point, or none.
    Change(String),
}

/// The monitor, between characters.
pub(crate) struct Monitor {
    echo: bool,
    line: Vec<u8>,
    overrun: bool,
    after_return: bool,
    waiting: Option<PendingCommand>,
    ahead: VecDeque<u8>,
    speed_percent: f64,
    points: BTreeMap<String, Joints>,
    /// Text that has not gone out on the line yet.
    said: String,
}

impl Monitor {
    pub(crate) fn new(echo: bool) -> Self {
        Self {
            echo,
            line: Vec::new(),
            overrun: false,
            after_return: false,
            waiting: None,
            ahead: VecDeque::new(),
            speed_percent: 100.0,
            points: BTreeMap::new(),
            said: String::new(),
        }
    }

    /// The monitor of a controller that was just switched on, with its first text and prompt.
    pub(crate) fn switched_on(echo: bool) -> Self {
        let mut monitor = Self::new(echo);
        monitor.said.push_str(START_UP);
        monitor.prompt();
        monitor
    }

    fn prompt(&mut self) {
        self.said.push_str("\r\n.");
    }

    fn typed(&mut self, byte: u8, machine: &mut Machine) {
        if byte == BREAK_BYTE {
            self.line.clear();
            self.ahead.clear();
            if self.waiting.take().is_some() {
                self.prompt();
            }
            return;
        }
        let asked = matches!(self.waiting, Some(PendingCommand::Sure | PendingCommand::Change(_)));
        if self.waiting.is_some() && !asked {
            if self.ahead.len() < TYPED_AHEAD_MAX {
                self.ahead.push_back(byte);
            }
            return;
        }
        let line_feed_of_return = byte == b'\n' && std::mem::take(&mut self.after_return);
        self.after_return = byte == b'\r';
        match byte {
            b'\n' if line_feed_of_return => {}
            b'\r' | b'\n' => {
                if self.echo {
                    self.said.push_str("\r\n");
                }
                let line = std::mem::take(&mut self.line);
                machine.record().lines += 1;
                if std::mem::take(&mut self.overrun) {
                    return self.answered(Err(messages::OVERRUN));
                }
                let line = String::from_utf8_lossy(&line).trim().to_owned();
                self.entered(&line, machine);
            }
            8 | 127 => drop(self.line.pop()),
            byte => {
                if self.line.len() >= LINE_BYTES_MAX {
                    self.overrun = true;
                } else {
                    self.line.push(byte);
                    if self.echo {
                        self.said.push(char::from(byte));
                    }
                }
            }
        }
    }

    fn answered(&mut self, done: Result<(), VPlusMessage>) {
        if let Err(message) = done {
            self.said.push_str(&message.starred());
        }
        if self.waiting.is_none() {
            self.prompt();
        }
    }

    fn entered(&mut self, line: &str, machine: &mut Machine) {
        let done = match self.waiting.take() {
            Some(PendingCommand::Sure) => {
                if !line.eq_ignore_ascii_case("y") {
                    Ok(())
                } else {
                    let begun = machine.calibrate();
                    self.waiting = begun.is_ok().then_some(PendingCommand::Calibration);
                    begun
                }
            }
            Some(PendingCommand::Change(point)) => match (line.is_empty(), joints(line)) {
                (true, _) => Ok(()),
                (_, Some(values)) => self.remember(&point, values),
                _ => Err(messages::ILLEGAL_VALUE),
            },
            _ => self.command(line, machine),
        };
        self.answered(done);
    }

    fn command(&mut self, line: &str, machine: &mut Machine) -> Result<(), VPlusMessage> {
        if line.is_empty() {
            return Ok(());
        }
        let (verb, rest) = line.split_once(' ').unwrap_or((line, ""));
        let (verb, rest) = (verb.to_ascii_uppercase(), rest.trim());
        let is = |name: &str| verb.len() >= 2 && name.starts_with(&verb);
        match () {
            () if is("DO") => self.instruction(rest, machine)?,
            () if is("ENABLE") => self.switch(rest, true, machine)?,
            () if is("DISABLE") => self.switch(rest, false, machine)?,
            () if is("CALIBRATE") => {
                if !machine.has_power() {
                    return Err(messages::POWER_OFF);
                }
                self.said.push_str("Are you sure (Y/N)? ");
                self.waiting = Some(PendingCommand::Sure);
            }
            () if is("SPEED") => self.speed(rest)?,
            () if is("WHERE") => self.said.push_str(&whereabouts(machine)),
            () if is("HERE") => self.here(rest, machine)?,
            () if is("LISTL") => self.list_point(rest)?,
            () if is("LISTR") => self.list_values(rest, machine)?,
            () if is("STATUS") => {
                let moving = if machine.is_moving() { "moving" } else { "in position" };
                let status = format!("Task 0: idle; robot 1 {moving}; speed {}\r\n", self.speed_percent);
                self.said.push_str(&status);
            }
            () if is("ID") => {
                self.said.push_str("Software: 12.1 (emulated)  Controller: 0  Robot 1: 4 joints\r\n");
            }
            () if is("PANIC") || is("ABORT") => machine.stop(),
            () if is("ESTOP") => machine.disable_power(),
            () => return Err(messages::ILLEGAL_COMMAND),
        }
        Ok(())
    }

    fn switch(&mut self, name: &str, on: bool, machine: &mut Machine) -> Result<(), VPlusMessage> {
        let name = name.to_ascii_uppercase();
        if name == "CP" || name == "ECHO" {
            return Ok(());
        }
        if name.len() < 2 || !"POWER".starts_with(&name) {
            return Err(messages::ILLEGAL_VALUE);
        }
        if on {
            machine.enable_power()?;
            self.waiting = (!machine.has_power()).then_some(PendingCommand::Power);
        } else {
            machine.disable_power();
        }
        Ok(())
    }

    fn speed(&mut self, text: &str) -> Result<(), VPlusMessage> {
        let percent = decimal(text).filter(|percent| *percent > 0.0).ok_or(messages::ILLEGAL_VALUE)?;
        // Documented: more than 100 is taken for 100.
        self.speed_percent = percent.min(100.0);
        Ok(())
    }

    fn instruction(&mut self, text: &str, machine: &mut Machine) -> Result<(), VPlusMessage> {
        let (verb, rest) = text.split_once(' ').unwrap_or((text, ""));
        let rest = rest.trim();
        match verb.to_ascii_uppercase().as_str() {
            "SET" => {
                let (point, value) = rest.split_once('=').ok_or(messages::BAD_SYNTAX)?;
                let value = value.trim().to_ascii_uppercase();
                let inner = value.strip_prefix("#PPOINT(").and_then(|value| value.strip_suffix(')'));
                let values = joints(inner.ok_or(messages::BAD_SYNTAX)?).ok_or(messages::ILLEGAL_VALUE)?;
                self.remember(&point_name(point)?, values)?;
            }
            "MOVE" => {
                let name = point_name(rest)?;
                let to = *self.points.get(&name).ok_or(messages::UNDEFINED)?;
                let leg = Leg { to, speed: self.speed_percent / 100.0 };
                if machine.is_moving() {
                    self.waiting = Some(PendingCommand::Next(leg));
                } else {
                    machine.start(&[leg], TouchGuard::None)?;
                }
            }
            "BREAK" => self.waiting = machine.is_moving().then_some(PendingCommand::Motion),
            "BRAKE" => machine.stop(),
            "SPEED" => self.speed(rest)?,
            "HERE" => self.remember(&point_name(rest)?, machine.joints())?,
            "ENABLE" => self.switch(rest, true, machine)?,
            "DISABLE" => self.switch(rest, false, machine)?,
            "TYPE" => {
                self.said.push_str(rest.trim_matches('"'));
                self.said.push_str("\r\n");
            }
            _ => return Err(messages::ILLEGAL_INSTRUCTION),
        }
        Ok(())
    }

    fn remember(&mut self, point: &str, values: Joints) -> Result<(), VPlusMessage> {
        if self.points.len() >= POINTS_MAX && !self.points.contains_key(point) {
            return Err(messages::OVERRUN);
        }
        self.points.insert(point.to_owned(), values);
        Ok(())
    }

    fn here(&mut self, text: &str, machine: &Machine) -> Result<(), VPlusMessage> {
        let name = point_name(text)?;
        self.remember(&name, machine.joints())?;
        self.said.push_str(&listing(&machine.joints()));
        self.said.push_str("Change? ");
        self.waiting = Some(PendingCommand::Change(name));
        Ok(())
    }

    fn list_point(&mut self, text: &str) -> Result<(), VPlusMessage> {
        let name = point_name(text)?;
        let values = self.points.get(&name).ok_or(messages::UNDEFINED)?;
        self.said.push_str(&listing(values));
        Ok(())
    }

    fn list_values(&mut self, text: &str, machine: &Machine) -> Result<(), VPlusMessage> {
        for expression in text.split(',') {
            let value = self.value(expression.trim(), machine)?;
            self.said.push_str(&format!("{value}\r\n"));
        }
        Ok(())
    }

    /// The real-valued functions that a driver asks for.
    fn value(&self, expression: &str, machine: &Machine) -> Result<f64, VPlusMessage> {
        let upper = expression.to_ascii_uppercase();
        let truth = |holds: bool| if holds { TRUE } else { 0.0 };
        let argument =
            |name: &str| Some(upper.strip_prefix(name)?.trim().strip_prefix('(')?.strip_suffix(')')?.trim());
        if let Some(signal) = argument("SIG") {
            let number = signal.parse().map_err(|_| messages::ILLEGAL_VALUE)?;
            return Ok(truth(machine.signal(number)));
        }
        if let Some(name) = argument("SWITCH") {
            return match name {
                "POWER" => Ok(truth(machine.has_power())),
                "CP" => Ok(TRUE),
                _ => Err(messages::ILLEGAL_VALUE),
            };
        }
        if let Some(number) = argument("SPEED") {
            return match number {
                // From memory: 1 is the speed of the monitor, 2 the speed that a program has set for all its motions.
                "1" => Ok(self.speed_percent),
                "2" => Ok(100.0),
                _ => Err(messages::ILLEGAL_VALUE),
            };
        }
        if let Some(number) = argument("STATE") {
            return match number {
                // Bit 3: an emergency stop is pressed; used so by working programs.
                "4" => Ok(if machine.is_stopped() { 4.0 } else { 0.0 }),
                // 1: a trajectory is evaluated, 2: stopped at a planned place (documented). Its value
                // after a motion that was braked is not emulated.
                "2" => Ok(if machine.is_moving() { 1.0 } else { 2.0 }),
                // Documented: 2 waits for power, 3 has just got it, 5 calibrates, 7 under program control, 8 not
                // calibrated.
                "1" => Ok(f64::from(machine.overall_state())),
                _ => Err(messages::ILLEGAL_VALUE),
            };
        }
        Err(messages::BAD_SYNTAX)
    }
}

impl Console for Monitor {
    fn take(&mut self, bytes: &[u8], machine: &mut Machine, _: Instant) {
        for byte in bytes {
            self.typed(*byte, machine);
        }
    }

    fn tell(&mut self, event: MachineEvent, machine: &mut Machine) {
        let done = match (event, self.waiting.take()) {
            (MachineEvent::PowerUp, Some(PendingCommand::Power))
            | (MachineEvent::Calibrated, Some(PendingCommand::Calibration)) => Some(Ok(())),
            (MachineEvent::Ended(MotionEnd::Error(message)), waiting) => {
                self.said.push_str(&format!("\r\n{}", message.starred()));
                match waiting {
                    Some(asked @ (PendingCommand::Sure | PendingCommand::Change(_))) => {
                        self.waiting = Some(asked);
                        None
                    }
                    _ => Some(Ok(())),
                }
            }
            (
                MachineEvent::Interrupted(message),
                Some(PendingCommand::Power | PendingCommand::Calibration),
            ) => Some(Err(message)),
            (MachineEvent::Ended(_), Some(PendingCommand::Motion)) => Some(Ok(())),
            (MachineEvent::Ended(_), Some(PendingCommand::Next(leg))) => {
                Some(machine.start(&[leg], TouchGuard::None))
            }
            (_, waiting) => {
                self.waiting = waiting;
                None
            }
        };
        if let Some(done) = done {
            self.answered(done);
        }
        while self.waiting.is_none()
            && let Some(byte) = self.ahead.pop_front()
        {
            self.typed(byte, machine);
        }
    }

    fn said(&mut self) -> Vec<String> {
        Some(std::mem::take(&mut self.said)).filter(|said| !said.is_empty()).into_iter().collect()
    }
}

fn point_name(text: &str) -> Result<String, VPlusMessage> {
    let name = text.trim().strip_prefix('#').ok_or(messages::BAD_SYNTAX)?;
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '.' || c == '_';
    if name.is_empty() || name.len() > 15 || !name.chars().all(plain) {
        return Err(messages::BAD_SYNTAX);
    }
    Ok(name.to_ascii_uppercase())
}

/// One value a joint, with commas between.
fn joints(text: &str) -> Option<Joints> {
    let values: Vec<f64> = text.split(',').map(|value| decimal(value.trim())).collect::<Option<_>>()?;
    values.try_into().ok()
}

/// The listing of `WHERE`: the position of the tool in the world, then the joints.
fn whereabouts(machine: &Machine) -> String {
    let tip = machine.body().posture().tip_m * 1000.0;
    let joints = machine.joints();
    let world = [tip.x, tip.y, tip.z, 0.0, 180.0, joints.first().copied().unwrap_or_default()];
    format!(
        "      X          Y          Z          y          p          r\r\n{}\r\n{}",
        columns(&world),
        listing(&joints)
    )
}

fn listing(joints: &Joints) -> String {
    let heads: Vec<_> = (1..=JOINTS).map(|joint| format!("{:>10}", format!("J{joint}"))).collect();
    format!("{}\r\n{}\r\n", heads.join(" "), columns(joints))
}

fn columns(values: &[f64]) -> String {
    values.iter().map(|value| format!("{value:>10.3}")).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Bench {
        monitor: Monitor,
        machine: Machine,
    }

    impl Bench {
        fn new(echo: bool) -> Self {
            Self { monitor: Monitor::new(echo), machine: Machine::new("narrow", 1).unwrap() }
        }

        fn ready() -> Self {
            let mut bench = Self::new(false);
            assert_eq!(bench.typed("EN PO\r\n"), "");
            assert_eq!(bench.wait(3.0), "\r\n.");
            assert_eq!(bench.typed("CA\r\n"), "Are you sure (Y/N)? ");
            assert_eq!(bench.typed("Y\r\n"), "");
            assert_eq!(bench.wait(4.0), "\r\n.");
            bench
        }

        fn typed(&mut self, text: &str) -> String {
            self.monitor.take(text.as_bytes(), &mut self.machine, Instant::now());
            self.monitor.said().concat()
        }

        fn wait(&mut self, time_s: f64) -> String {
            for _ in 0..(time_s / 0.01) as usize {
                self.machine.advance(0.01);
                for event in self.machine.events() {
                    self.monitor.tell(event, &mut self.machine);
                }
            }
            self.monitor.said().concat()
        }
    }

    #[test]
    fn what_is_typed_is_echoed_and_a_prompt_is_a_period_at_the_beginning_of_a_line() {
        let mut bench = Bench::new(true);
        assert_eq!(bench.typed("SPEED 30\r\n"), "SPEED 30\r\n\r\n.");
        assert_eq!(bench.typed("FLY\r"), "FLY\r\n*Illegal monitor command*\r\n.");
        assert_eq!(bench.typed("SPEED -1\r\n"), "SPEED -1\r\n*Invalid argument*\r\n.");
    }

    #[test]
    fn a_motion_returns_the_prompt_at_once_and_break_waits_for_its_end() {
        let mut bench = Bench::ready();
        assert_eq!(bench.typed("DO SET #P=#PPOINT(20,-114.4,117.2,-57.8)\r\n"), "\r\n.");
        let listed = bench.typed("LISTL #P\r\n");
        assert!(listed.contains("20.000   -114.400    117.200    -57.800"), "{listed:?}");
        assert_eq!(bench.typed("SPEED 50\r\nDO MOVE #P\r\n"), "\r\n.\r\n.");
        assert_eq!(bench.typed("LISTR STATE(2), SIG(1001)\r\n"), "1\r\n0\r\n\r\n.");
        assert_eq!(bench.typed("DO BREAK\r\nWHERE\r\n"), "", "typed ahead, it waits");
        let after = bench.wait(5.0);
        assert!(
            after.starts_with("\r\n.") && after.contains("20.000   -114.400    117.200    -57.800"),
            "{after:?}"
        );
    }

    #[test]
    fn speeds_and_states_are_listed() {
        let mut bench = Bench::new(false);
        assert_eq!(bench.typed("LISTR STATE(1)\r\n"), "2\r\n\r\n.");
        let mut bench = Bench::ready();
        bench.typed("SPEED 30\r\n");
        assert_eq!(bench.typed("LISTR SPEED(1),SPEED(2)\r\n"), "30\r\n100\r\n\r\n.");
        assert_eq!(bench.typed("LISTR STATE(2),STATE(1)\r\n"), "2\r\n7\r\n\r\n.");
    }

    #[test]
    fn panic_ends_a_calibration() {
        let mut bench = Bench::new(false);
        bench.typed("EN PO\r\n");
        bench.wait(3.0);
        bench.typed("CA\r\nY\r\n");
        bench.wait(1.0);
        assert_eq!(bench.machine.overall_state(), 5);
        bench.typed("\x03PANIC\r\n");
        bench.wait(10.0);
        assert_eq!(bench.machine.overall_state(), 8);
    }

    #[test]
    fn here_asks_for_a_change_that_an_empty_line_declines() {
        let mut bench = Bench::new(false);
        let said = bench.typed("HERE #Q\r\n");
        assert!(said.ends_with("Change? "), "{said:?}");
        assert_eq!(bench.typed("\r\n"), "\r\n.");
        assert_eq!(bench.typed("DO MOVE #Q\r\n"), "*Robot power off*\r\n.");
        assert_eq!(bench.typed("DO MOVE #R\r\n"), "*Undefined value*\r\n.");
    }

    #[test]
    fn panic_stops_and_keeps_power_estop_takes_it_away() {
        for (stop, powered) in [("PANIC", true), ("ESTOP", false)] {
            let mut bench = Bench::ready();
            bench.typed("DO SET #P=#PPOINT(60,-114.4,117.2,-57.8)\r\nSPEED 20\r\nDO MOVE #P\r\n");
            bench.wait(0.5);
            bench.typed(&format!("{stop}\r\n"));
            bench.wait(0.2);
            assert!(!bench.machine.is_moving() && bench.machine.joints()[0] < 59.0);
            assert_eq!(bench.machine.has_power(), powered, "{stop}");
        }
    }

    #[test]
    fn an_emergency_stop_is_said_unasked_and_ends_whatever_waits() {
        let mut bench = Bench::ready();
        bench.typed("DO SET #P=#PPOINT(60,-114.4,117.2,-57.8)\r\nSPEED 20\r\nDO MOVE #P\r\nDO BREAK\r\n");
        bench.wait(0.5);
        bench.machine.press(true);
        assert_eq!(bench.wait(0.5), "\r\n*E-STOP from user E-STOP button*\r\n.");
        assert_eq!(bench.typed("LISTR SWITCH(POWER),STATE(4)\r\n"), "0\r\n4\r\n\r\n.");
    }

    #[test]
    fn lines_that_are_too_long_and_bytes_of_noise_do_nothing() {
        let mut bench = Bench::ready();
        let said = bench.typed(&format!("{}\r\n", "DO MOVE #P ".repeat(100)));
        assert_eq!(said, "*Communications overrun*\r\n.");
        bench.monitor.take(&[0, 255, 128, b'\r'], &mut bench.machine, Instant::now());
        assert_eq!(bench.monitor.said(), ["*Illegal monitor command*\r\n."]);
        assert_eq!(bench.machine.record().motions, 0);
    }
}
