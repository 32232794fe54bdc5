//! The controller's own monitor: nothing needs to be installed, and nothing on the controller stops the arm when this
//! process dies.
//!
//! The monitor has no sums. Where it echoes, the echo of every command is compared before the next one is sent. Where the
//! arm is to go, and how fast, is told, read back and compared first, with or without echo, and only then comes the order
//! that moves it. A position counts once it was read twice alike. Any doubt during a motion stops the arm.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use super::attention::{Attention, Doing};
use super::{Controller, Ended, Fault, State};
use crate::gate::{Leg, Permitted};
use crate::line::Line;
use crate::switch::StopSwitch;
use crate::taught::Joints;
use crate::v_plus::ANSWER_BYTES_MAX;
use crate::v_plus::monitor::{self, Answer, Command};
use crate::watch::Beat;

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
    attention: Attention,
    joints: usize,
    /// How far each joint of an arm that arrived may be from where it was to be.
    tolerances: Vec<f64>,
    signals: [u16; 4],
    touch_inverted: bool,
    answer_wait: Duration,
    /// Whether it echoes; None before it was greeted.
    echoes: Option<bool>,
    speed: Option<u8>,
    motion: Option<Motion>,
}

/// A motion that is carried out point by point.
struct Motion {
    guarded: bool,
    /// The sides that have been touched ever since it began.
    held: u8,
    under_way: Joints,
    left: VecDeque<Leg>,
}

impl MonitorController {
    /// A controller of an arm with a joint for each tolerance, with its touch inputs, not greeted yet. `driver` is renewed
    /// with each answer.
    #[must_use]
    pub fn new(
        line: Box<dyn Line>,
        switch: StopSwitch,
        driver: Beat,
        tolerances: Vec<f64>,
        signals: [u16; 4],
        touch_inverted: bool,
        answer_wait: Duration,
    ) -> Self {
        let joints = tolerances.len();
        Self {
            line,
            attention: Attention::new(switch, driver),
            joints,
            tolerances,
            signals,
            touch_inverted,
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
            self.attention.moment()?;
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
            self.attention.moment()?;
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
        if command.may_move() {
            let line = &mut self.line;
            self.attention.order(|| line.send(bytes.as_bytes()))?;
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
        self.attention.answered();
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

    /// The sides that are touched, as bits.
    fn touched(&self, signals: u8) -> u8 {
        if self.touch_inverted { !signals & 0b1111 } else { signals }
    }

    fn joints_once(&mut self) -> Result<Joints, Fault> {
        let count = self.joints;
        self.ask(&Command::Where, self.answer_wait, |answer| answer.numbers(count))
    }

    /// Does something during which a stop ends every wait.
    fn ordering<T>(&mut self, order: impl FnOnce(&mut Self) -> Result<T, Fault>) -> Result<T, Fault> {
        let before = self.attention.turn_to(Doing::Ordering);
        let done = order(self);
        self.attention.turn_to(before);
        done
    }

    /// Sets the speed, and makes sure that it arrived as it was told, and that no program has set one above it.
    fn set_speed(&mut self, percent: u8) -> Result<(), Fault> {
        if self.speed == Some(percent) {
            return Ok(());
        }
        self.speed = None;
        self.set(&Command::Speed(percent))?;
        let speeds = self.ask(&Command::ListSpeeds, self.answer_wait, |answer| answer.all_numbers(2))?;
        let [of_monitor, of_programs] = speeds.as_slice() else { return Ok(()) };
        // The two are multiplied.
        if (of_monitor - f64::from(percent)).abs() > SAME || !(0.0..=100.0 + SAME).contains(of_programs) {
            let answer = format!("{of_monitor} % of {of_programs} % instead of {percent} % of at most 100 %");
            return Err(Fault::Garbled { what: Command::ListSpeeds.text(), answer });
        }
        self.speed = Some(percent);
        Ok(())
    }

    /// Begins the motion to one point: tells it, makes sure that it arrived as it was told, and only then moves.
    fn begin_leg(&mut self, leg: &Leg) -> Result<(), Fault> {
        self.set_speed(leg.speed_percent)?;
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

    /// Turns power on, and waits until the controller knows whether the arm is calibrated.
    fn power_up(&mut self) -> Result<(), Fault> {
        let begun = Instant::now();
        // Asked what came of it rather than believed or asked for again.
        match self.type_once(&Command::Power(true), POWER_WAIT) {
            Ok(_) => {}
            Err(Fault::Refused(message)) if !message.cause().needs_a_person() => {}
            Err(fault) => return Err(fault),
        }
        self.quiet()?;
        while begun.elapsed() < POWER_WAIT {
            let state = self.monitor_state()?;
            if state.power && !state.settling {
                return Ok(());
            }
            if !state.power && !state.settling && begun.elapsed() > self.answer_wait {
                break;
            }
        }
        Err(Fault::Silent { what: Command::Power(true).text(), waited: begun.elapsed() })
    }

    /// Asks to calibrate, makes sure that it is this which is asked back, and agrees.
    fn calibrate_now(&mut self) -> Result<(), Fault> {
        let text = Command::Calibrate.text();
        let bytes = format!("{text}\r\n");
        let line = &mut self.line;
        self.attention.order(|| line.send(bytes.as_bytes()))?;
        let deadline = Instant::now() + self.answer_wait;
        let mut printed = Vec::new();
        let mut buffer = [0; 512];
        while !monitor::ends_with_question(&printed)
            && printed.len() < ANSWER_BYTES_MAX
            && Instant::now() < deadline
        {
            self.attention.moment()?;
            let count = self.line.receive(&mut buffer, SLICE)?;
            printed.extend_from_slice(buffer.get(..count).unwrap_or_default());
        }
        let answer = monitor::answer(&text, &printed);
        if let Some(message) = answer.message() {
            return Err(Fault::Refused(message));
        }
        if !monitor::ends_with_question(&printed) || (self.echoes == Some(true) && !answer.echoed) {
            // Whatever else it asks, it is not agreed to.
            return Err(Fault::Garbled { what: text, answer: answer.lines.join(" / ") });
        }
        self.type_once(&Command::Yes, CALIBRATE_WAIT)?;
        self.quiet()
    }

    fn begin_path(&mut self, path: &Permitted) -> Result<(), Fault> {
        // Set anew with each motion: a controller that was switched off and on begins at its own speed.
        self.speed = None;
        let mut left: VecDeque<Leg> = path.legs().iter().cloned().collect();
        let signals = if path.guarded() { self.state()?.signals } else { 0 };
        let held = self.touched(signals);
        let Some(first) = left.pop_front() else { return Ok(()) };
        self.begin_leg(&first)?;
        self.motion = Some(Motion { guarded: path.guarded(), held, under_way: first.to, left });
        Ok(())
    }

    fn follow_for_a_moment(&mut self) -> Result<Option<Ended>, Fault> {
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
        motion.held &= self.touched(state.signals);
        if motion.guarded && self.touched(state.signals) & !motion.held != 0 {
            // Read twice: one slip of the line is no touch.
            let again = self.monitor_state()?.signals;
            if self.touched(again) & !motion.held != 0 {
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
    fn stop_and_look(&mut self) -> Result<(), Fault> {
        self.motion = None;
        let deadline = Instant::now() + HALT_WAIT;
        while Instant::now() < deadline {
            self.attention.switch.send();
            // Without a switch's line, as in the first greeting of a test.
            self.line.send(monitor::STOP)?;
            self.quiet()?;
            let stands = match self.state() {
                Ok(state) if !state.moving => self.joints().map(|_| ()),
                Ok(_) => continue,
                Err(fault) => Err(fault),
            };
            match stands {
                Ok(()) => return Ok(()),
                // It may still come to rest, or what was asked was cut short by the order to stop.
                Err(Fault::Silent { .. } | Fault::Garbled { .. } | Fault::Refused(_)) => {}
                Err(fault) => return Err(fault),
            }
        }
        Err(Fault::NotStopping)
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
        self.attention.switch.send();
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
                let monitor::State { power, calibrated, emergency_stop, moving, signals, .. } = state;
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

    fn passing(&mut self) -> Result<Joints, Fault> {
        self.joints_once()
    }

    fn power(&mut self, on: bool) -> Result<(), Fault> {
        if on {
            return self.ordering(Self::power_up);
        }
        match self.type_once(&Command::Power(false), self.answer_wait) {
            // Asked what came of it rather than believed.
            Ok(_) | Err(Fault::Refused(_)) => {}
            Err(fault) => return Err(fault),
        }
        self.quiet()?;
        if self.state()?.power {
            return Err(Fault::Silent { what: Command::Power(false).text(), waited: self.answer_wait });
        }
        Ok(())
    }

    fn calibrate(&mut self) -> Result<(), Fault> {
        self.ordering(Self::calibrate_now)?;
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
        self.ordering(|this| this.begin_path(path))
    }

    fn follow(&mut self) -> Result<Option<Ended>, Fault> {
        self.ordering(Self::follow_for_a_moment)
    }

    fn halt(&mut self) -> Result<(), Fault> {
        let before = self.attention.turn_to(Doing::Halting);
        let halted = self.stop_and_look();
        self.attention.turn_to(before);
        halted
    }
}
