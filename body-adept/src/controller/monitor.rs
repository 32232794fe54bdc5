//! The controller's own monitor: nothing needs to be installed, and nothing on the controller stops the arm when this
//! process dies.
//!
//! The monitor has no sums. If it echoes, the echo of every command is compared before the next one is sent. With or
//! without echo, the goal and the speed of a motion are sent, read back and compared first, and only then comes the
//! order that moves the arm. A position counts once it was read twice alike. Any doubt during a motion stops the arm.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use super::guarded_line::{Activity, GuardedLine, OnLine};
use super::{
    CALIBRATE_WAIT, Controller, ControllerError, ControllerState, MotionEnd, POWER_WAIT, Result, SLICE, TRIES,
};
use crate::gate::{Leg, PermittedPath};
use crate::taught::Joints;
use crate::v_plus::ANSWER_BYTES_MAX;
use crate::v_plus::message::VPlusMessage;
use crate::v_plus::monitor::{self, MonitorAnswer, MonitorCommand, MonitorState};

/// A line this long without a byte is quiet.
const QUIET: Duration = Duration::from_millis(60);
/// Longest wait for a line to become quiet.
const QUIET_WAIT: Duration = Duration::from_secs(2);
/// Longest wait for an arm that was told to stop to stand still.
const HALT_WAIT: Duration = Duration::from_secs(10);
/// Two values printed with three decimals are the same when they differ by at most this.
const SAME: f64 = 0.0011;

/// The monitor at the other end of a line.
pub struct MonitorController {
    line: GuardedLine,
    /// Largest distance of each joint from its goal when the arm has arrived.
    tolerances: Vec<f64>,
    signals: [u16; 4],
    touch_inverted: bool,
    answer_wait: Duration,
    /// Whether the monitor echoes. None before it was greeted.
    echoes: Option<bool>,
    speed: Option<u8>,
    motion: Option<Motion>,
}

/// A motion that is carried out point by point.
struct Motion {
    guarded: bool,
    /// The sides that have been touched ever since the motion began.
    held: u8,
    under_way: Joints,
    left: VecDeque<Leg>,
}

impl MonitorController {
    /// A controller of an arm with a joint for each tolerance, with its touch inputs, not greeted yet.
    #[must_use]
    pub fn new(
        line: GuardedLine,
        tolerances: Vec<f64>,
        signals: [u16; 4],
        touch_inverted: bool,
        answer_wait: Duration,
    ) -> Self {
        Self {
            line,
            tolerances,
            signals,
            touch_inverted,
            answer_wait,
            echoes: None,
            speed: None,
            motion: None,
        }
    }

    /// Throws away all bytes until none come any more.
    fn quiet(&mut self) -> Result<()> {
        let (mut heard, begun) = (Instant::now(), Instant::now());
        while heard.elapsed() < QUIET && begun.elapsed() < QUIET_WAIT {
            if self.line.receive(&mut Vec::new(), SLICE)? > 0 {
                heard = Instant::now();
            }
        }
        Ok(())
    }

    /// The text printed until a prompt, the deadline, or a length that no answer has; and whether there was a prompt.
    fn printed(&mut self, command: &str, wait: Duration) -> Result<(MonitorAnswer, bool)> {
        let deadline = Instant::now() + wait;
        let mut printed = Vec::new();
        while printed.len() < ANSWER_BYTES_MAX {
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                break;
            }
            let count = self.line.receive(&mut printed, left.min(SLICE))?;
            if count == 0 && monitor::ends_with_prompt(&printed) {
                let answer = monitor::answer(command, &printed);
                // A prompt before the echo of the command is an earlier one.
                if self.echoes != Some(true) || answer.echoed || answer.lines.len() > 1 {
                    return Ok((answer, true));
                }
            }
        }
        Ok((monitor::answer(command, &printed), false))
    }

    /// Types a command and takes the answer. None when no answer came, or another text than the command arrived.
    fn type_once(&mut self, command: &MonitorCommand<'_>, wait: Duration) -> Result<Option<MonitorAnswer>> {
        let text = command.text();
        self.line.send(format!("{text}\r\n").as_bytes(), command.may_move())?;
        let (answer, prompted) = self.printed(&text, wait)?;
        if !prompted || (self.echoes == Some(true) && !answer.echoed) {
            return Ok(None);
        }
        if let Some(message) = answer.message() {
            return Err(ControllerError::Refused(message));
        }
        self.line.answered();
        Ok(Some(answer))
    }

    /// Asks a question that moves nothing, until the answer is one that `read` can read.
    fn ask<T>(
        &mut self,
        command: &MonitorCommand<'_>,
        wait: Duration,
        read: impl Fn(&MonitorAnswer) -> Option<T>,
    ) -> Result<T> {
        let mut heard = None;
        for _ in 0..TRIES {
            match self.type_once(command, wait) {
                Ok(Some(answer)) => match read(&answer) {
                    Some(value) => return Ok(value),
                    None => heard = Some(answer.lines.join(" / ")),
                },
                Ok(None) => {}
                // The command may have arrived as another one, which the monitor then refused.
                Err(ControllerError::Refused(message)) if !message.cause().needs_a_person() => {
                    heard = Some(message.to_string())
                }
                Err(fault) => return Err(fault),
            }
            self.quiet()?;
        }
        Err(match heard {
            Some(answer) => ControllerError::Garbled { what: command.text(), answer },
            None => silent(command, wait * TRIES as u32),
        })
    }

    fn monitor_state(&mut self) -> Result<MonitorState> {
        self.ask(&MonitorCommand::State { signals: self.signals }, self.answer_wait, monitor::state)
    }

    /// The sides that are touched, as bits.
    fn touched(&self, signals: u8) -> u8 {
        if self.touch_inverted { !signals & 0b1111 } else { signals }
    }

    fn joints_once(&mut self) -> Result<Joints> {
        let count = self.tolerances.len();
        self.ask(&MonitorCommand::Where, self.answer_wait, |answer| answer.numbers(count))
    }

    /// Sets the speed, and makes sure that it arrived unchanged and that no program has set a higher one.
    fn set_speed(&mut self, percent: u8) -> Result<()> {
        if self.speed == Some(percent) {
            return Ok(());
        }
        self.speed = None;
        self.set(&MonitorCommand::Speed(percent))?;
        let speeds =
            self.ask(&MonitorCommand::ListSpeeds, self.answer_wait, |answer| answer.all_numbers(2))?;
        let [of_monitor, of_programs] = speeds.as_slice() else { return Ok(()) };
        // V+ multiplies the two speeds.
        if (of_monitor - f64::from(percent)).abs() > SAME || !(0.0..=100.0 + SAME).contains(of_programs) {
            let answer = format!("{of_monitor} % of {of_programs} % instead of {percent} % of at most 100 %");
            return Err(ControllerError::Garbled { what: MonitorCommand::ListSpeeds.text(), answer });
        }
        self.speed = Some(percent);
        Ok(())
    }

    /// Begins the motion to one point: sends the point, makes sure that it arrived unchanged, and only then moves.
    fn begin_leg(&mut self, leg: &Leg) -> Result<()> {
        self.set_speed(leg.speed_percent)?;
        self.set(&MonitorCommand::SetGoal(&leg.to))?;
        let count = self.tolerances.len();
        let listed = self.ask(&MonitorCommand::ListGoal, self.answer_wait, |answer| answer.numbers(count))?;
        if !same(&listed, &leg.to) {
            let answer = format!("{listed:?}");
            return Err(ControllerError::Garbled { what: "LISTL of the goal just set".to_owned(), answer });
        }
        match self.type_once(&MonitorCommand::MoveToGoal, self.answer_wait)? {
            Some(_) => Ok(()),
            // Whether the motion has begun is in doubt, and the caller halts.
            None => Err(silent(&MonitorCommand::MoveToGoal, self.answer_wait)),
        }
    }

    /// Turns power on, and waits until the controller knows whether the arm is calibrated.
    fn power_up(&mut self) -> Result<()> {
        let begun = Instant::now();
        // The answer is neither believed nor asked for again: the state shows whether power came.
        match self.type_once(&MonitorCommand::Power(true), POWER_WAIT) {
            Ok(_) => {}
            Err(ControllerError::Refused(message)) if !message.cause().needs_a_person() => {}
            Err(fault) => return Err(fault),
        }
        self.quiet()?;
        while begun.elapsed() < POWER_WAIT {
            let MonitorState { controller, settling } = self.monitor_state()?;
            if controller.power && !settling {
                return Ok(());
            }
            if !controller.power && !settling && begun.elapsed() > self.answer_wait {
                break;
            }
        }
        Err(silent(&MonitorCommand::Power(true), begun.elapsed()))
    }

    /// Asks to calibrate, makes sure that the monitor asks back about calibrating, and agrees.
    fn calibrate_now(&mut self) -> Result<()> {
        let text = MonitorCommand::Calibrate.text();
        self.line.send(format!("{text}\r\n").as_bytes(), true)?;
        let deadline = Instant::now() + self.answer_wait;
        let mut printed = Vec::new();
        while !monitor::ends_with_question(&printed)
            && printed.len() < ANSWER_BYTES_MAX
            && Instant::now() < deadline
        {
            self.line.receive(&mut printed, SLICE)?;
        }
        let answer = monitor::answer(&text, &printed);
        if let Some(message) = answer.message() {
            return Err(ControllerError::Refused(message));
        }
        if !monitor::ends_with_question(&printed) || (self.echoes == Some(true) && !answer.echoed) {
            // No other question is agreed to.
            return Err(ControllerError::Garbled { what: text, answer: answer.lines.join(" / ") });
        }
        self.type_once(&MonitorCommand::Yes, CALIBRATE_WAIT)?;
        self.quiet()
    }

    fn begin_path(&mut self, path: &PermittedPath) -> Result<()> {
        // The speed is set anew with each motion: a controller that was switched off and on begins at its own speed.
        self.speed = None;
        let mut left: VecDeque<Leg> = path.legs().iter().cloned().collect();
        let signals = if path.guarded() { self.state()?.signals } else { 0 };
        let held = self.touched(signals);
        let Some(first) = left.pop_front() else { return Ok(()) };
        self.begin_leg(&first)?;
        self.motion = Some(Motion { guarded: path.guarded(), held, under_way: first.to, left });
        Ok(())
    }

    fn follow_for_a_moment(&mut self) -> Result<Option<MotionEnd>> {
        let Some(mut motion) = self.motion.take() else { return Ok(Some(MotionEnd::Stopped)) };
        let state = self.monitor_state()?.controller;
        if state.emergency_stop || !state.power {
            let text = if state.emergency_stop {
                "E-stop pressed during a motion"
            } else {
                "power off during a motion"
            };
            return Err(ControllerError::Refused(VPlusMessage::of_text(text)));
        }
        motion.held &= self.touched(state.signals);
        if motion.guarded && self.touched(state.signals) & !motion.held != 0 {
            // Signals are read twice: one slip of the line is no touch.
            let again = self.monitor_state()?.controller.signals;
            if self.touched(again) & !motion.held != 0 {
                self.halt()?;
                return Ok(Some(MotionEnd::Touched));
            }
        }
        if state.moving {
            self.motion = Some(motion);
            return Ok(None);
        }
        let at = self.joints()?;
        if !self.is_at(&motion.under_way, &at) {
            // The motion may have begun between two looks.
            if self.state()?.moving {
                self.motion = Some(motion);
                return Ok(None);
            }
            let at = self.joints()?;
            if !self.is_at(&motion.under_way, &at) {
                // Somebody stopped the arm. The next part would resume the motion, on a way that nobody checked.
                return Err(ControllerError::Short { at, wanted: motion.under_way });
            }
        }
        let Some(next) = motion.left.pop_front() else { return Ok(Some(MotionEnd::Arrived)) };
        self.begin_leg(&next)?;
        motion.under_way = next.to;
        self.motion = Some(motion);
        Ok(None)
    }

    fn stop_and_look(&mut self) -> Result<()> {
        self.motion = None;
        let deadline = Instant::now() + HALT_WAIT;
        while Instant::now() < deadline {
            self.line.send_stop();
            // Sent here as well, for a switch that is not connected to the line.
            self.line.send(monitor::STOP, false)?;
            self.quiet()?;
            let stands = match self.state() {
                Ok(state) if !state.moving => self.joints().map(|_| ()),
                Ok(_) => continue,
                Err(fault) => Err(fault),
            };
            match stands {
                Ok(()) => return Ok(()),
                // The arm may still come to rest, or the order to stop cut the question short.
                Err(fault) if fault.may_pass() => {}
                Err(fault) => return Err(fault),
            }
        }
        Err(ControllerError::NotStopping)
    }

    fn is_at(&self, wanted: &[f64], at: &[f64]) -> bool {
        let near = |((a, b), most): ((&f64, &f64), &f64)| (a - b).abs() <= *most;
        wanted.len() == at.len() && wanted.iter().zip(at).zip(&self.tolerances).all(near)
    }

    /// Types a command that moves nothing, and repeats it until it arrived.
    fn set(&mut self, command: &MonitorCommand<'_>) -> Result<()> {
        self.ask(command, self.answer_wait, |answer| answer.lines.is_empty().then_some(()))
    }
}

fn silent(command: &MonitorCommand<'_>, waited: Duration) -> ControllerError {
    ControllerError::Silent { what: command.text(), waited }
}

fn same(one: &[f64], other: &[f64]) -> bool {
    one.len() == other.len() && one.iter().zip(other).all(|(a, b)| (a - b).abs() <= SAME)
}

impl OnLine for MonitorController {
    fn line(&mut self) -> &mut GuardedLine {
        &mut self.line
    }
}

impl Controller for MonitorController {
    fn greet(&mut self) -> Result<String> {
        self.motion = None;
        self.speed = None;
        // Stops the arm, and spoils a command that may stand on the line half typed, so that no line end can complete
        // it.
        self.line.send_stop();
        self.line.send(monitor::STOP, false)?;
        self.quiet()?;
        self.echoes = None;
        let mut echoes = Vec::new();
        let mut name = None;
        for _ in 0..2 * TRIES {
            let answer = self.type_once(&MonitorCommand::Identify, self.answer_wait);
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
            return Err(silent(&MonitorCommand::Identify, self.answer_wait * 2 * TRIES as u32));
        }
        self.halt()?;
        Ok(name.unwrap_or_else(|| "a V+ monitor".to_owned()))
    }

    fn state(&mut self) -> Result<ControllerState> {
        // There are no sums: the state counts once it was read twice alike.
        let mut before = self.monitor_state()?;
        for _ in 0..TRIES {
            let state = self.monitor_state()?;
            if state == before {
                return Ok(state.controller);
            }
            before = state;
        }
        Err(ControllerError::Garbled { what: "its state".to_owned(), answer: format!("{before:?}") })
    }

    fn joints(&mut self) -> Result<Joints> {
        let mut before = self.joints_once()?;
        for _ in 0..TRIES {
            let joints = self.joints_once()?;
            if same(&joints, &before) {
                return Ok(joints);
            }
            before = joints;
        }
        Err(ControllerError::Garbled {
            what: "WHERE, again and again,".to_owned(),
            answer: format!("{before:?}"),
        })
    }

    fn passing(&mut self) -> Result<Joints> {
        self.joints_once()
    }

    fn power(&mut self, on: bool) -> Result<()> {
        if on {
            return self.during(Activity::Ordering, Self::power_up);
        }
        match self.type_once(&MonitorCommand::Power(false), self.answer_wait) {
            // The answer is not believed: the state shows whether power went.
            Ok(_) | Err(ControllerError::Refused(_)) => {}
            Err(fault) => return Err(fault),
        }
        self.quiet()?;
        if self.state()?.power {
            return Err(silent(&MonitorCommand::Power(false), self.answer_wait));
        }
        Ok(())
    }

    fn calibrate(&mut self) -> Result<()> {
        self.during(Activity::Ordering, Self::calibrate_now)?;
        if self.state()?.calibrated {
            return Ok(());
        }
        Err(silent(&MonitorCommand::Calibrate, CALIBRATE_WAIT))
    }

    fn reset(&mut self) -> Result<()> {
        // The monitor latches nothing; the driver does.
        Ok(())
    }

    fn begin(&mut self, path: &PermittedPath) -> Result<()> {
        self.motion = None;
        self.during(Activity::Ordering, |this| this.begin_path(path))
    }

    fn follow(&mut self) -> Result<Option<MotionEnd>> {
        self.during(Activity::Ordering, Self::follow_for_a_moment)
    }

    fn halt(&mut self) -> Result<()> {
        self.during(Activity::Halting, Self::stop_and_look)
    }
}
