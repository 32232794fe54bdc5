//! The controller's own monitor: nothing needs to be installed, and nothing on the controller stops the arm when this
//! process dies.
//!
//! The monitor has no sums. Where it echoes, the echo of every command is compared before the next one is sent: where
//! the arm is to go is told and compared first, and only then the order that moves it. Where it does not echo, the goal
//! is listed and compared. A position counts once it was read twice alike. Any doubt during a motion stops the arm.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use super::{Controller, Ended, Fault, State};
use crate::gate::{Leg, Permitted};
use crate::line::Line;
use crate::switch::{Pressed, StopSwitch};
use crate::taught::Joints;
use crate::v_plus::ANSWER_BYTES_MAX;
use crate::v_plus::monitor::{self, Answer, Command};

/// How often a question is asked before it counts as unanswered.
const TRIES: usize = 4;
/// Longest wait for high power.
const POWER_WAIT: Duration = Duration::from_secs(20);
/// Longest wait for the arm to be calibrated.
const CALIBRATE_WAIT: Duration = Duration::from_secs(120);
/// Longest that one wait for bytes takes.
const SLICE: Duration = Duration::from_millis(20);
/// A line this long without a byte is quiet.
const QUIET: Duration = Duration::from_millis(60);
/// Longest wait for a line to become quiet.
const QUIET_WAIT: Duration = Duration::from_secs(2);
/// Longest wait for an arm that was told to stop to stand still.
const HALT_WAIT: Duration = Duration::from_secs(10);
/// Two values that were printed with three decimals are the same.
const SAME: f64 = 0.0011;

/// The monitor at the other end of a line.
pub struct MonitorController {
    line: Box<dyn Line>,
    switch: StopSwitch,
    joints: usize,
    /// How far each joint of an arm that arrived may be from where it was to be.
    tolerances: Vec<f64>,
    signals: [u16; 4],
    answer_wait: Duration,
    /// Whether it echoes; None before it was greeted.
    echoes: Option<bool>,
    speed: Option<u8>,
    motion: Option<Motion>,
}

/// A motion that is carried out point by point.
struct Motion {
    guarded: bool,
    /// The touch inputs that have been on since it began.
    held: u8,
    under_way: Joints,
    left: VecDeque<Leg>,
}

impl MonitorController {
    /// A controller of an arm with a joint for each tolerance, with its touch inputs, not greeted yet.
    #[must_use]
    pub fn new(
        line: Box<dyn Line>,
        switch: StopSwitch,
        tolerances: Vec<f64>,
        signals: [u16; 4],
        answer_wait: Duration,
    ) -> Self {
        let joints = tolerances.len();
        Self {
            line,
            switch,
            joints,
            tolerances,
            signals,
            answer_wait,
            echoes: None,
            speed: None,
            motion: None,
        }
    }

    /// Throws away everything until nothing comes any more.
    fn quiet(&mut self) -> Result<(), Fault> {
        let (mut heard, begun) = (Instant::now(), Instant::now());
        let mut buffer = [0; 512];
        while heard.elapsed() < QUIET && begun.elapsed() < QUIET_WAIT {
            if self.line.receive(&mut buffer, SLICE)? > 0 {
                heard = Instant::now();
            }
        }
        Ok(())
    }

    /// What is printed until a prompt, or the deadline, or too much. The second: whether there was a prompt.
    fn printed(&mut self, command: &str, wait: Duration) -> Result<(Answer, bool), Fault> {
        let deadline = Instant::now() + wait;
        let mut printed = Vec::new();
        let mut buffer = [0; 512];
        while printed.len() < ANSWER_BYTES_MAX {
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                break;
            }
            let count = self.line.receive(&mut buffer, left.min(SLICE))?;
            printed.extend_from_slice(buffer.get(..count).unwrap_or_default());
            if count == 0 && monitor::ends_with_prompt(&printed) {
                let answer = monitor::answer(command, &printed);
                // A prompt that came before the command was echoed was there before.
                if self.echoes != Some(true) || answer.echoed || answer.lines.len() > 1 {
                    return Ok((answer, true));
                }
            }
        }
        Ok((monitor::answer(command, &printed), false))
    }

    /// Types a command and takes the answer. None when there was none, or the command was not what arrived.
    fn type_once(&mut self, command: &Command<'_>, wait: Duration) -> Result<Option<Answer>, Fault> {
        let text = command.text();
        let bytes = format!("{text}\r\n");
        let switch = self.switch.clone();
        if matches!(command, Command::SetGoal(_) | Command::MoveToGoal | Command::Speed(_)) {
            let line = &mut self.line;
            switch.order(|| line.send(bytes.as_bytes())).map_err(|error| {
                error.map_or_else(
                    || Fault::Stopped(switch.pressed_by().unwrap_or(Pressed::Trouble)),
                    Fault::Line,
                )
            })?;
        } else {
            self.line.send(bytes.as_bytes())?;
        }
        let (answer, prompted) = self.printed(&text, wait)?;
        if !prompted || (self.echoes == Some(true) && !answer.echoed) {
            return Ok(None);
        }
        if let Some(message) = answer.message() {
            return Err(Fault::Refused(message));
        }
        Ok(Some(answer))
    }

    /// Asks something that moves nothing until it is answered so that `read` can read it.
    fn ask<T>(
        &mut self,
        command: &Command<'_>,
        wait: Duration,
        read: impl Fn(&Answer) -> Option<T>,
    ) -> Result<T, Fault> {
        let mut heard = None;
        for _ in 0..TRIES {
            match self.type_once(command, wait) {
                Ok(Some(answer)) => match read(&answer) {
                    Some(value) => return Ok(value),
                    None => heard = Some(answer.lines.join(" / ")),
                },
                Ok(None) => {}
                // What was typed may have arrived as something else, which the monitor then refused.
                Err(Fault::Refused(message)) if !message.cause().needs_a_person() => {
                    heard = Some(message.to_string())
                }
                Err(fault) => return Err(fault),
            }
            self.quiet()?;
        }
        let what = command.text();
        Err(match heard {
            Some(answer) => Fault::Garbled { what, answer },
            None => Fault::Silent { what, waited: wait * TRIES as u32 },
        })
    }

    fn monitor_state(&mut self) -> Result<monitor::State, Fault> {
        self.ask(&Command::State { signals: self.signals }, self.answer_wait, monitor::state)
    }

    fn joints_once(&mut self) -> Result<Joints, Fault> {
        let count = self.joints;
        self.ask(&Command::Where, self.answer_wait, |answer| answer.numbers(count))
    }

    /// Begins the motion to one point: tells it, makes sure that it arrived as it was told, and only then moves.
    fn begin_leg(&mut self, leg: &Leg) -> Result<(), Fault> {
        if self.speed != Some(leg.speed_percent) {
            self.speed = None;
            self.set(&Command::Speed(leg.speed_percent))?;
            self.speed = Some(leg.speed_percent);
        }
        self.set(&Command::SetGoal(&leg.to))?;
        let count = self.joints;
        let listed = self.ask(&Command::ListGoal, self.answer_wait, |answer| answer.numbers(count))?;
        if !same(&listed, &leg.to) {
            let answer = format!("{listed:?}");
            return Err(Fault::Garbled { what: "LISTL of the goal just set".to_owned(), answer });
        }
        match self.type_once(&Command::MoveToGoal, self.answer_wait)? {
            Some(_) => Ok(()),
            // Whether it has begun is in doubt, and the caller halts.
            None => Err(Fault::Silent { what: Command::MoveToGoal.text(), waited: self.answer_wait }),
        }
    }

    fn is_at(&self, wanted: &[f64], at: &[f64]) -> bool {
        let near = |((a, b), most): ((&f64, &f64), &f64)| (a - b).abs() <= *most;
        wanted.len() == at.len() && wanted.iter().zip(at).zip(&self.tolerances).all(near)
    }

    /// Types a command that moves nothing and may be repeated until it arrived.
    fn set(&mut self, command: &Command<'_>) -> Result<(), Fault> {
        self.ask(command, self.answer_wait, |answer| answer.lines.is_empty().then_some(()))
    }
}

fn same(one: &[f64], other: &[f64]) -> bool {
    one.len() == other.len() && one.iter().zip(other).all(|(a, b)| (a - b).abs() <= SAME)
}

impl Controller for MonitorController {
    fn greet(&mut self) -> Result<String, Fault> {
        self.motion = None;
        self.speed = None;
        // Stops, and spoils what stood on the line before, so that no line end can complete it.
        self.switch.send();
        self.line.send(monitor::STOP)?;
        self.quiet()?;
        self.echoes = None;
        let mut echoes = Vec::new();
        let mut name = None;
        for _ in 0..2 * TRIES {
            let answer = self.type_once(&Command::Identify, self.answer_wait);
            if let Ok(Some(answer)) = answer {
                echoes.push(answer.echoed);
                name = answer.lines.last().cloned();
            }
            if let [.., one, other] = echoes.as_slice()
                && one == other
            {
                self.echoes = Some(*one);
                break;
            }
            self.quiet()?;
        }
        if self.echoes.is_none() {
            return Err(Fault::Silent {
                what: Command::Identify.text(),
                waited: self.answer_wait * 2 * TRIES as u32,
            });
        }
        self.halt()?;
        Ok(name.unwrap_or_else(|| "a V+ monitor".to_owned()))
    }

    fn state(&mut self) -> Result<State, Fault> {
        // Without sums, twice alike.
        let mut before = self.monitor_state()?;
        for _ in 0..TRIES {
            let state = self.monitor_state()?;
            if state == before {
                let monitor::State { power, calibrated, emergency_stop, moving, signals } = state;
                return Ok(State { power, calibrated, emergency_stop, moving, latched: false, signals });
            }
            before = state;
        }
        Err(Fault::Garbled { what: "its state".to_owned(), answer: format!("{before:?}") })
    }

    fn joints(&mut self) -> Result<Joints, Fault> {
        let mut before = self.joints_once()?;
        for _ in 0..TRIES {
            let joints = self.joints_once()?;
            if same(&joints, &before) {
                return Ok(joints);
            }
            before = joints;
        }
        Err(Fault::Garbled { what: "WHERE, again and again,".to_owned(), answer: format!("{before:?}") })
    }

    fn power(&mut self, on: bool) -> Result<(), Fault> {
        match self.type_once(&Command::Power(on), if on { POWER_WAIT } else { self.answer_wait }) {
            Ok(_) => {}
            Err(Fault::Refused(message)) if message.cause().needs_a_person() => {
                return Err(Fault::Refused(message));
            }
            Err(Fault::Refused(_)) => {}
            Err(fault) => return Err(fault),
        }
        self.quiet()?;
        if self.state()?.power == on {
            return Ok(());
        }
        Err(Fault::Silent { what: Command::Power(on).text(), waited: POWER_WAIT })
    }

    fn calibrate(&mut self) -> Result<(), Fault> {
        self.line.send(format!("{}\r\n", Command::Calibrate.text()).as_bytes())?;
        let deadline = Instant::now() + self.answer_wait;
        let mut printed = Vec::new();
        let mut buffer = [0; 512];
        while !monitor::ends_with_question(&printed) && Instant::now() < deadline {
            let count = self.line.receive(&mut buffer, SLICE)?;
            printed.extend_from_slice(buffer.get(..count).unwrap_or_default());
            if printed.len() > ANSWER_BYTES_MAX {
                break;
            }
        }
        if let Some(message) = monitor::answer(&Command::Calibrate.text(), &printed).message() {
            return Err(Fault::Refused(message));
        }
        self.type_once(&Command::Yes, CALIBRATE_WAIT)?;
        self.quiet()?;
        if self.state()?.calibrated {
            return Ok(());
        }
        Err(Fault::Silent { what: Command::Calibrate.text(), waited: CALIBRATE_WAIT })
    }

    fn reset(&mut self) -> Result<(), Fault> {
        // The monitor latches nothing; what is latched is latched in the driver.
        Ok(())
    }

    fn begin(&mut self, path: &Permitted) -> Result<(), Fault> {
        self.motion = None;
        let mut left: VecDeque<Leg> = path.legs().iter().cloned().collect();
        let held = if path.guarded() { self.state()?.signals } else { 0 };
        let Some(first) = left.pop_front() else { return Ok(()) };
        self.begin_leg(&first)?;
        self.motion = Some(Motion { guarded: path.guarded(), held, under_way: first.to, left });
        Ok(())
    }

    fn follow(&mut self) -> Result<Option<Ended>, Fault> {
        let Some(mut motion) = self.motion.take() else { return Ok(Some(Ended::Stopped)) };
        let state = self.monitor_state()?;
        if state.emergency_stop || !state.power {
            let text = if state.emergency_stop {
                "E-stop pressed during a motion"
            } else {
                "power off during a motion"
            };
            return Err(Fault::Refused(crate::v_plus::message::Message::of_text(text)));
        }
        motion.held &= state.signals;
        if motion.guarded && state.signals & !motion.held != 0 {
            // Read twice: one slip of the line is no touch.
            if self.monitor_state()?.signals & !motion.held != 0 {
                self.halt()?;
                return Ok(Some(Ended::Touched));
            }
        }
        if state.moving {
            self.motion = Some(motion);
            return Ok(None);
        }
        let at = self.joints()?;
        if !self.is_at(&motion.under_way, &at) {
            // Between two looks it may have begun.
            if self.state()?.moving {
                self.motion = Some(motion);
                return Ok(None);
            }
            let at = self.joints()?;
            if !self.is_at(&motion.under_way, &at) {
                // Somebody stopped it. The next part would resume the motion, on a way that nobody checked.
                return Err(Fault::Short { at, wanted: motion.under_way });
            }
        }
        let Some(next) = motion.left.pop_front() else { return Ok(Some(Ended::Arrived)) };
        self.begin_leg(&next)?;
        motion.under_way = next.to;
        self.motion = Some(motion);
        Ok(None)
    }

    fn halt(&mut self) -> Result<(), Fault> {
        self.motion = None;
        let deadline = Instant::now() + HALT_WAIT;
        while Instant::now() < deadline {
            self.switch.send();
            // Without a switch's line, as in the first greeting of a test.
            self.line.send(monitor::STOP)?;
            self.quiet()?;
            match self.state() {
                Ok(state) if !state.moving => return self.joints().map(|_| ()),
                Ok(_) | Err(Fault::Silent { .. } | Fault::Garbled { .. } | Fault::Refused(_)) => {}
                Err(fault) => return Err(fault),
            }
        }
        Err(Fault::NotStopping)
    }
}
