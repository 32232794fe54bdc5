//! The controller while the server program `vplus/pschema.v2` runs on it, which has numbered lines with sums and a
//! watchdog.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use super::guarded_line::{Activity, GuardedLine, OnLine};
use super::{
    CALIBRATE_WAIT, Controller, ControllerError, ControllerState, MotionEnd, POWER_WAIT, Result, SLICE, TRIES,
};
use crate::gate::{Leg, PermittedPath};
use crate::taught::Joints;
use crate::v_plus::message::{Cause, VPlusMessage};
use crate::v_plus::program::{self, NUMBER_MAX, ProgramReply, ProgramRequest, TouchGuard};
use crate::v_plus::{ANSWER_BYTES_MAX, values};

/// Version of the program that this driver can talk to.
const VERSION: u32 = 1;
/// How often the points of a path are sent before the motion is given up, which has not begun then.
const PATH_TRIES: usize = 4;
/// How often the program's watchdog is fed within its time while power comes up or the arm is calibrated.
const FEEDS: u32 = 4;
/// Time between two questions about a motion.
const FOLLOW_EVERY: Duration = Duration::from_millis(25);
/// Longest wait for an arm that was told to stop to stand still.
const HALT_WAIT: Duration = Duration::from_secs(5);
/// Most ends of motions that are kept until they are asked for.
const ENDS_MAX: usize = 16;
/// The number in the program's refusal of a line whose sum is wrong. The program did nothing then.
const UNREADABLE: u32 = 0;

/// The program at the other end of a line.
pub struct ProgramController {
    line: GuardedLine,
    joints: usize,
    touch_inverted: bool,
    answer_wait: Duration,
    /// Time without a line after which the program stops the arm.
    watchdog: Duration,
    number: u32,
    /// The highest number of a motion that the program may know of. It takes only motions with higher numbers.
    moved: u32,
    held: Vec<u8>,
    ends: VecDeque<(u32, MotionEnd)>,
    motion: Option<u32>,
    asked_at: Instant,
}

impl ProgramController {
    /// A controller of an arm of so many joints, not greeted yet.
    #[must_use]
    pub fn new(line: GuardedLine, joints: usize, touch_inverted: bool, answer_wait: Duration) -> Self {
        Self {
            line,
            joints,
            touch_inverted,
            answer_wait,
            watchdog: FOLLOW_EVERY,
            number: 0,
            moved: 0,
            held: Vec::new(),
            ends: VecDeque::new(),
            motion: None,
            asked_at: Instant::now(),
        }
    }

    /// The next whole line, if one comes before the deadline.
    fn next_line(&mut self, deadline: Instant) -> Result<Option<String>> {
        loop {
            if let Some(end) = self.held.iter().position(|byte| *byte == b'\n') {
                let line: Vec<u8> = self.held.drain(..=end).collect();
                return Ok(Some(String::from_utf8_lossy(&line).into_owned()));
            }
            // Bytes without a line end are no line.
            if self.held.len() > ANSWER_BYTES_MAX {
                self.held.clear();
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(None);
            }
            self.line.receive(&mut self.held, left.min(SLICE))?;
        }
    }

    /// The next line of the program before the deadline; ends of motions are put aside.
    fn reply(&mut self, deadline: Instant) -> Result<Option<ProgramReply>> {
        while let Some(line) = self.next_line(deadline)? {
            match ProgramReply::read(&line) {
                Some(ProgramReply::End { number, ended }) => self.put_aside(number, ended),
                Some(reply) => return Ok(Some(reply)),
                None => tracing::debug!(?line, "not a line of the program"),
            }
        }
        Ok(None)
    }

    fn put_aside(&mut self, number: u32, ended: MotionEnd) {
        if self.ends.len() >= ENDS_MAX {
            self.ends.pop_front();
        }
        self.ends.push_back((number, ended));
    }

    fn next_number(&mut self) -> u32 {
        self.number = if self.number >= NUMBER_MAX { 1 } else { self.number + 1 };
        self.number
    }

    /// Sends a request. Returns its number.
    fn send(&mut self, request: &ProgramRequest<'_>) -> Result<u32> {
        let number = self.next_number();
        let text = request.line(number);
        if matches!(request, ProgramRequest::Move { .. }) {
            self.moved = number;
        }
        self.line.send(text.as_bytes(), request.may_move())?;
        Ok(number)
    }

    /// Asks once and waits for the answer to that number. None when none came, or the program could not read the line.
    fn ask_once(
        &mut self,
        request: &ProgramRequest<'_>,
        wait: Duration,
    ) -> Result<Option<(u32, Vec<String>)>> {
        let number = self.send(request)?;
        let words = self.answer_to(number, Instant::now() + wait)?;
        Ok(words.map(|words| (number, words)))
    }

    /// The answer to a number before the deadline. None when none came, or the program could not read the line.
    fn answer_to(&mut self, number: u32, deadline: Instant) -> Result<Option<Vec<String>>> {
        while let Some(reply) = self.reply(deadline)? {
            match reply {
                ProgramReply::Ok { number: answered, words } if answered == number => {
                    self.line.answered();
                    return Ok(Some(words));
                }
                ProgramReply::Refused { number: answered, message } if answered == number => {
                    return Err(ControllerError::Refused(message));
                }
                ProgramReply::Refused { number: UNREADABLE, message } if message.cause() == Cause::Line => {
                    return Ok(None);
                }
                _ => tracing::debug!(?reply, "an answer to another question"),
            }
        }
        Ok(None)
    }

    /// Asks for something that takes seconds, and meanwhile asks again and again for the state, which feeds the
    /// program's watchdog. Ends when the switch is pressed. False when the answer was lost, or the wait was too long.
    fn ask_patiently(&mut self, request: &ProgramRequest<'_>, wait: Duration) -> Result<bool> {
        let begun = Instant::now();
        let number = self.send(request)?;
        while begun.elapsed() < wait {
            if self.answer_to(number, Instant::now() + self.watchdog / FEEDS)?.is_some() {
                return Ok(true);
            }
            let asked = self.send(&ProgramRequest::State)?;
            let deadline = Instant::now() + self.answer_wait;
            while let Some(reply) = self.reply(deadline)? {
                match reply {
                    // It was done before the question about the state came.
                    ProgramReply::Ok { number: answered, .. } if answered == number => return Ok(true),
                    ProgramReply::Ok { number: answered, words } if answered == asked => {
                        if program::state(&words).is_some_and(|state| !state.controller.moving) {
                            return Ok(false);
                        }
                        break;
                    }
                    ProgramReply::Refused { number: answered, message } if answered == number => {
                        return Err(ControllerError::Refused(message));
                    }
                    ProgramReply::Refused { number: UNREADABLE, .. } => break,
                    _ => tracing::debug!(?reply, "an answer to another question"),
                }
            }
        }
        Ok(false)
    }

    /// Asks, repeats a lost question where that is harmless, and reads the answer with `read`.
    fn ask<T>(
        &mut self,
        request: &ProgramRequest<'_>,
        wait: Duration,
        read: impl Fn(&[String]) -> Option<T>,
    ) -> Result<T> {
        let tries = if request.may_be_repeated() { TRIES } else { 1 };
        for _ in 0..tries {
            if let Some((_, words)) = self.ask_once(request, wait)? {
                return read(&words).ok_or_else(|| ControllerError::Garbled {
                    what: format!("{request:?}"),
                    answer: words.join(" "),
                });
            }
        }
        Err(ControllerError::Silent { what: format!("{request:?}"), waited: wait * tries as u32 })
    }

    fn program_state(&mut self) -> Result<program::ProgramState> {
        self.ask(&ProgramRequest::State, self.answer_wait, program::state)
    }

    /// Sends the points of a path and begins the motion. False when the program did not get all points and nothing has
    /// begun.
    fn send_path(&mut self, path: &PermittedPath) -> Result<bool> {
        let Some((last, vias)) = path.legs().split_last() else { return Ok(false) };
        for (index, Leg { to, speed_percent }) in vias.iter().enumerate() {
            let via = ProgramRequest::Via { speed: *speed_percent, joints: to };
            match self.ask_once(&via, self.answer_wait)? {
                Some((_, words)) if words == [(index + 1).to_string()] => {}
                // A point was lost or doubled: it is no longer known which ones the program has.
                _ => return Ok(false),
            }
        }
        let guard = match (path.guarded(), self.touch_inverted) {
            (false, _) => TouchGuard::None,
            (true, false) => TouchGuard::On,
            (true, true) => TouchGuard::Off,
        };
        let order = ProgramRequest::Move { guard, speed: last.speed_percent, joints: &last.to };
        match self.ask_once(&order, self.answer_wait)? {
            Some((number, _)) => {
                self.motion = Some(number);
                Ok(true)
            }
            // The motion may have begun although the answer was lost. That is found out; the order is never sent again.
            None => self.has_begun(self.number),
        }
    }

    /// Whether the motion of a request whose answer was lost has begun.
    fn has_begun(&mut self, number: u32) -> Result<bool> {
        let state = self.program_state()?;
        let ended = state.last.is_some_and(|(last, _)| last == number);
        let told = self.ends.iter().any(|(end, _)| *end == number);
        if state.controller.moving || ended || told {
            self.motion = Some(number);
            return Ok(true);
        }
        Ok(false)
    }

    fn begin_path(&mut self, path: &PermittedPath) -> Result<()> {
        for _ in 0..PATH_TRIES {
            match self.send_path(path) {
                Ok(true) => return Ok(()),
                Ok(false) => self.forget_points()?,
                Err(fault) => return Err(fault),
            }
        }
        let what = format!("a path to ({})", values(path.end(), " "));
        Err(ControllerError::Silent { what, waited: self.answer_wait * PATH_TRIES as u32 })
    }

    /// Forgets points that were sent.
    fn forget_points(&mut self) -> Result<()> {
        self.ask(&ProgramRequest::Stop, self.answer_wait, |_| Some(()))
    }

    fn end_of(&mut self, number: u32) -> Option<MotionEnd> {
        let index = self.ends.iter().position(|(end, _)| *end == number)?;
        self.ends.remove(index).map(|(_, ended)| ended)
    }
}

impl OnLine for ProgramController {
    fn line(&mut self) -> &mut GuardedLine {
        &mut self.line
    }
}

impl Controller for ProgramController {
    fn greet(&mut self) -> Result<String> {
        self.held.clear();
        self.ends.clear();
        self.motion = None;
        self.line.send_stop();
        // Ends half a line that may stand there, which the program then refuses for its sum.
        self.line.send(b"\n", false)?;
        self.line.discard()?;
        let greeting = self.ask(&ProgramRequest::Hello, self.answer_wait, program::greeting)?;
        if greeting.version != VERSION || greeting.joints != self.joints {
            return Err(ControllerError::Other(format!(
                "version {} of pschema.v2 answers, for {} joints: this driver speaks to version {VERSION}, and arm.toml has \
                 {} joints",
                greeting.version, greeting.joints, self.joints
            )));
        }
        self.watchdog = Duration::from_millis(u64::from(greeting.watchdog_ms)).max(FOLLOW_EVERY);
        self.halt()?;
        // Numbers go on above that of the last motion, whoever ordered it, so that its end is not taken for the end of
        // a motion of this driver.
        if let Some((last, _)) = self.program_state()?.last {
            self.number = self.number.max(last);
            self.moved = last;
        }
        Ok(format!("pschema.v2 version {VERSION}, watchdog {} ms", greeting.watchdog_ms))
    }

    fn state(&mut self) -> Result<ControllerState> {
        Ok(self.program_state()?.controller)
    }

    fn joints(&mut self) -> Result<Joints> {
        let count = self.joints;
        self.ask(&ProgramRequest::Where, self.answer_wait, |words| program::joints(words, count))
    }

    fn passing(&mut self) -> Result<Joints> {
        self.joints()
    }

    fn power(&mut self, on: bool) -> Result<()> {
        let request = ProgramRequest::Power(on);
        let wait = if on { POWER_WAIT } else { self.answer_wait };
        let done = if on {
            self.during(Activity::Ordering, |this| this.ask_patiently(&request, wait))?
        } else {
            self.ask_once(&request, wait)?.is_some()
        };
        // The order is not repeated: the state shows its result.
        if done || self.program_state()?.controller.power == on {
            return Ok(());
        }
        Err(ControllerError::Silent { what: format!("{request:?}"), waited: wait })
    }

    fn calibrate(&mut self) -> Result<()> {
        let request = ProgramRequest::Calibrate;
        let done = self.during(Activity::Ordering, |this| this.ask_patiently(&request, CALIBRATE_WAIT))?;
        if done || self.program_state()?.controller.calibrated {
            return Ok(());
        }
        Err(ControllerError::Silent { what: format!("{request:?}"), waited: CALIBRATE_WAIT })
    }

    fn reset(&mut self) -> Result<()> {
        match self.ask(&ProgramRequest::Reset, self.answer_wait, |_| Some(())) {
            Err(ControllerError::Silent { what, waited }) => {
                if self.program_state()?.controller.latched {
                    Err(ControllerError::Silent { what, waited })
                } else {
                    Ok(())
                }
            }
            done => done,
        }
    }

    fn begin(&mut self, path: &PermittedPath) -> Result<()> {
        self.motion = None;
        self.ends.clear();
        // The program takes motions in ascending numbers only, and questions since the last motion may have begun the
        // numbers anew.
        if self.number < self.moved || self.number + LINES_OF_A_MOTION > NUMBER_MAX {
            self.number = 0;
            self.ask(&ProgramRequest::Hello, self.answer_wait, program::greeting)?;
            self.moved = 0;
        }
        self.during(Activity::Ordering, |this| this.begin_path(path))
    }

    fn follow(&mut self) -> Result<Option<MotionEnd>> {
        self.during(Activity::Ordering, Self::follow_for_a_moment)
    }

    fn halt(&mut self) -> Result<()> {
        self.during(Activity::Halting, Self::stop_and_look)
    }
}

/// Numbers that one motion may use, all its tries included.
const LINES_OF_A_MOTION: u32 = 1000;

impl ProgramController {
    fn stop_and_look(&mut self) -> Result<()> {
        self.motion = None;
        let deadline = Instant::now() + HALT_WAIT;
        while Instant::now() < deadline {
            self.line.send_stop();
            match self.program_state() {
                Ok(state) if !state.controller.moving => return self.forget_points(),
                // The arm brakes.
                Ok(_) => std::thread::sleep(FOLLOW_EVERY),
                Err(fault) if fault.may_pass() => {}
                Err(fault) => return Err(fault),
            }
        }
        Err(ControllerError::NotStopping)
    }

    fn follow_for_a_moment(&mut self) -> Result<Option<MotionEnd>> {
        let Some(number) = self.motion else { return Ok(Some(MotionEnd::Stopped)) };
        // The program may tell the end before the next question is due.
        let due = self.asked_at + FOLLOW_EVERY;
        while self.end_is_awaited(number)
            && let Some(line) = self.next_line(due)?
        {
            if let Some(ProgramReply::End { number, ended }) = ProgramReply::read(&line) {
                self.put_aside(number, ended);
            }
        }
        if let Some(ended) = self.end_of(number) {
            self.motion = None;
            return Ok(Some(ended));
        }
        let state = self.program_state()?;
        self.asked_at = Instant::now();
        if let Some((last, ended)) = state.last
            && last == number
            && !state.controller.moving
        {
            self.motion = None;
            return Ok(Some(ended));
        }
        if !state.controller.moving {
            // The motion ended between two answers, or the controller was switched off and on and does not know its
            // number.
            let again = self.program_state()?;
            self.motion = None;
            let ended = again.last.clone().filter(|(last, _)| *last == number).map(|(_, ended)| ended);
            return ended.map(Some).ok_or_else(|| ControllerError::Refused(lost_motion(&again.controller)));
        }
        Ok(None)
    }

    fn end_is_awaited(&self, number: u32) -> bool {
        !self.ends.iter().any(|(end, _)| *end == number)
    }
}

/// The message about a motion that the program does not know.
fn lost_motion(state: &ControllerState) -> VPlusMessage {
    let text = if state.emergency_stop {
        "E-stop pressed during a motion"
    } else if !state.power {
        "power off during a motion"
    } else {
        "motion lost"
    };
    let code = state.latched.then_some(11);
    VPlusMessage { code, text: text.to_owned() }
}
