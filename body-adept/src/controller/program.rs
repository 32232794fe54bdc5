//! The controller while the server program `vplus/pschema.v2` runs on it: numbered lines with sums, a watchdog.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use super::attention::{Attention, Doing};
use super::{Controller, Ended, Fault, State};
use crate::gate::{Leg, Permitted};
use crate::line::Line;
use crate::switch::StopSwitch;
use crate::taught::Joints;
use crate::v_plus::message::{Cause, Message};
use crate::v_plus::program::{self, Guard, NUMBER_MAX, Reply, Request};
use crate::v_plus::{ANSWER_BYTES_MAX, values};
use crate::watch::Beat;

/// Version of the program that this driver speaks to.
const VERSION: u32 = 1;
/// How often a question that may be repeated is asked before it counts as unanswered.
const TRIES: usize = 4;
/// How often the points of a path are sent before the motion is given up. It has not begun then.
const PATH_TRIES: usize = 4;
/// Longest wait for high power.
const POWER_WAIT: Duration = Duration::from_secs(20);
/// Longest wait for the arm to be calibrated.
const CALIBRATE_WAIT: Duration = Duration::from_secs(120);
/// Longest that one wait for bytes takes.
const SLICE: Duration = Duration::from_millis(20);
/// While power comes up or the arm is calibrated, the program's watchdog is fed so many times within its time.
const FEEDS: u32 = 4;
/// How often a motion is asked about.
const FOLLOW_EVERY: Duration = Duration::from_millis(25);
/// Longest wait for an arm that was told to stop to stand still.
const HALT_WAIT: Duration = Duration::from_secs(5);
/// Ends of motions that were told and not asked for yet.
const ENDS_MAX: usize = 16;
/// The program's refusal of a line whose sum is wrong: it was not understood, and did nothing.
const UNREADABLE: u32 = 0;

/// The program at the other end of a line.
pub struct ProgramController {
    line: Box<dyn Line>,
    attention: Attention,
    joints: usize,
    touch_inverted: bool,
    answer_wait: Duration,
    /// After so long without a line the program stops what it does.
    watchdog: Duration,
    number: u32,
    /// The highest number of a motion that the program may know of: it takes none but above it.
    moved: u32,
    held: Vec<u8>,
    ends: VecDeque<(u32, Ended)>,
    motion: Option<u32>,
    asked_at: Instant,
}

impl ProgramController {
    /// A controller of an arm of so many joints, not greeted yet. `driver` is renewed with each answer.
    #[must_use]
    pub fn new(
        line: Box<dyn Line>,
        switch: StopSwitch,
        driver: Beat,
        joints: usize,
        touch_inverted: bool,
        answer_wait: Duration,
    ) -> Self {
        Self {
            line,
            attention: Attention::new(switch, driver),
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
    fn line(&mut self, deadline: Instant) -> Result<Option<String>, Fault> {
        loop {
            if let Some(end) = self.held.iter().position(|byte| *byte == b'\n') {
                let line: Vec<u8> = self.held.drain(..=end).collect();
                return Ok(Some(String::from_utf8_lossy(&line).into_owned()));
            }
            // A line without end is none.
            if self.held.len() > ANSWER_BYTES_MAX {
                self.held.clear();
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(None);
            }
            self.attention.moment()?;
            let mut buffer = [0; 512];
            let count = self.line.receive(&mut buffer, left.min(SLICE))?;
            self.held.extend_from_slice(buffer.get(..count).unwrap_or_default());
        }
    }

    /// The next line of the program before the deadline; ends of motions are put aside.
    fn reply(&mut self, deadline: Instant) -> Result<Option<Reply>, Fault> {
        while let Some(line) = self.line(deadline)? {
            match Reply::read(&line) {
                Some(Reply::End { number, ended }) => self.put_aside(number, ended),
                Some(reply) => return Ok(Some(reply)),
                None => tracing::debug!(?line, "not a line of the program"),
            }
        }
        Ok(None)
    }

    fn put_aside(&mut self, number: u32, ended: Ended) {
        if self.ends.len() >= ENDS_MAX {
            self.ends.pop_front();
        }
        self.ends.push_back((number, ended));
    }

    fn next_number(&mut self) -> u32 {
        self.number = if self.number >= NUMBER_MAX { 1 } else { self.number + 1 };
        self.number
    }

    /// Sends a request; its number.
    fn send(&mut self, request: &Request<'_>) -> Result<u32, Fault> {
        let number = self.next_number();
        let text = request.line(number);
        if matches!(request, Request::Move { .. }) {
            self.moved = number;
        }
        if request.may_move() {
            let line = &mut self.line;
            self.attention.order(|| line.send(text.as_bytes()))?;
        } else {
            self.line.send(text.as_bytes())?;
        }
        Ok(number)
    }

    /// Asks once and waits for the answer to that number. None when none came, or the program could not read the line.
    fn ask_once(
        &mut self,
        request: &Request<'_>,
        wait: Duration,
    ) -> Result<Option<(u32, Vec<String>)>, Fault> {
        let number = self.send(request)?;
        let words = self.answer_to(number, Instant::now() + wait)?;
        Ok(words.map(|words| (number, words)))
    }

    /// The answer to a number before the deadline. None when none came, or the program could not read the line.
    fn answer_to(&mut self, number: u32, deadline: Instant) -> Result<Option<Vec<String>>, Fault> {
        while let Some(reply) = self.reply(deadline)? {
            match reply {
                Reply::Ok { number: answered, words } if answered == number => {
                    self.attention.answered();
                    return Ok(Some(words));
                }
                Reply::Refused { number: answered, message } if answered == number => {
                    return Err(Fault::Refused(message));
                }
                Reply::Refused { number: UNREADABLE, message } if message.cause() == Cause::Line => {
                    return Ok(None);
                }
                _ => tracing::debug!(?reply, "an answer to another question"),
            }
        }
        Ok(None)
    }

    /// Asks for something that takes its time, and again and again how it goes, which feeds the program's watchdog. Ends
    /// when the switch is pressed. False when it has ended and the answer was lost, or takes too long.
    fn ask_patiently(&mut self, request: &Request<'_>, wait: Duration) -> Result<bool, Fault> {
        let begun = Instant::now();
        let number = self.send(request)?;
        while begun.elapsed() < wait {
            if self.answer_to(number, Instant::now() + self.watchdog / FEEDS)?.is_some() {
                return Ok(true);
            }
            let asked = self.send(&Request::State)?;
            let deadline = Instant::now() + self.answer_wait;
            while let Some(reply) = self.reply(deadline)? {
                match reply {
                    // It was done before the question about it came.
                    Reply::Ok { number: answered, .. } if answered == number => return Ok(true),
                    Reply::Ok { number: answered, words } if answered == asked => {
                        if program::state(&words).is_some_and(|state| !state.moving) {
                            return Ok(false);
                        }
                        break;
                    }
                    Reply::Refused { number: answered, message } if answered == number => {
                        return Err(Fault::Refused(message));
                    }
                    Reply::Refused { number: UNREADABLE, .. } => break,
                    _ => tracing::debug!(?reply, "an answer to another question"),
                }
            }
        }
        Ok(false)
    }

    /// Does something during which a stop ends every wait.
    fn ordering<T>(&mut self, order: impl FnOnce(&mut Self) -> Result<T, Fault>) -> Result<T, Fault> {
        let before = self.attention.turn_to(Doing::Ordering);
        let done = order(self);
        self.attention.turn_to(before);
        done
    }

    /// Asks, again if need be and harmless, and reads the answer with `read`.
    fn ask<T>(
        &mut self,
        request: &Request<'_>,
        wait: Duration,
        read: impl Fn(&[String]) -> Option<T>,
    ) -> Result<T, Fault> {
        let tries = if request.may_be_repeated() { TRIES } else { 1 };
        for _ in 0..tries {
            if let Some((_, words)) = self.ask_once(request, wait)? {
                return read(&words)
                    .ok_or_else(|| Fault::Garbled { what: format!("{request:?}"), answer: words.join(" ") });
            }
        }
        Err(Fault::Silent { what: format!("{request:?}"), waited: wait * tries as u32 })
    }

    fn program_state(&mut self) -> Result<program::State, Fault> {
        self.ask(&Request::State, self.answer_wait, program::state)
    }

    /// Sends the points of a path and begins it. False when the program did not get all of it and nothing has begun.
    fn send_path(&mut self, path: &Permitted) -> Result<bool, Fault> {
        let Some((last, vias)) = path.legs().split_last() else { return Ok(false) };
        for (index, Leg { to, speed_percent }) in vias.iter().enumerate() {
            let via = Request::Via { speed: *speed_percent, joints: to };
            match self.ask_once(&via, self.answer_wait)? {
                Some((_, words)) if words == [(index + 1).to_string()] => {}
                // Lost, or doubled: the points are no longer known.
                _ => return Ok(false),
            }
        }
        let guard = match (path.guarded(), self.touch_inverted) {
            (false, _) => Guard::None,
            (true, false) => Guard::On,
            (true, true) => Guard::Off,
        };
        let order = Request::Move { guard, speed: last.speed_percent, joints: &last.to };
        match self.ask_once(&order, self.answer_wait)? {
            Some((number, _)) => {
                self.motion = Some(number);
                Ok(true)
            }
            // It may have begun without our knowing. That is found out, never tried again.
            None => self.has_begun(self.number),
        }
    }

    /// Whether the motion of a request whose answer was lost has begun.
    fn has_begun(&mut self, number: u32) -> Result<bool, Fault> {
        let state = self.program_state()?;
        let ended = state.last.is_some_and(|(last, _)| last == number);
        let told = self.ends.iter().any(|(end, _)| *end == number);
        if state.moving || ended || told {
            self.motion = Some(number);
            return Ok(true);
        }
        Ok(false)
    }

    fn begin_path(&mut self, path: &Permitted) -> Result<(), Fault> {
        for _ in 0..PATH_TRIES {
            match self.send_path(path) {
                Ok(true) => return Ok(()),
                Ok(false) => self.forget_points()?,
                Err(fault) => return Err(fault),
            }
        }
        let what = format!("a path to ({})", values(path.end(), " "));
        Err(Fault::Silent { what, waited: self.answer_wait * PATH_TRIES as u32 })
    }

    /// Forgets points that were sent.
    fn forget_points(&mut self) -> Result<(), Fault> {
        self.ask(&Request::Stop, self.answer_wait, |_| Some(()))
    }

    fn end_of(&mut self, number: u32) -> Option<Ended> {
        let index = self.ends.iter().position(|(end, _)| *end == number)?;
        self.ends.remove(index).map(|(_, ended)| ended)
    }
}

impl Controller for ProgramController {
    fn greet(&mut self) -> Result<String, Fault> {
        self.held.clear();
        self.ends.clear();
        self.motion = None;
        self.attention.switch.send();
        // Half a line from before is ended, and refused for its sum.
        self.line.send(b"\n")?;
        self.line.discard()?;
        let greeting = self.ask(&Request::Hello, self.answer_wait, program::greeting)?;
        if greeting.version != VERSION || greeting.joints != self.joints {
            return Err(Fault::Other(format!(
                "version {} of pschema.v2 answers, for {} joints: this driver speaks to version {VERSION}, and arm.toml has \
                 {} joints",
                greeting.version, greeting.joints, self.joints
            )));
        }
        self.watchdog = Duration::from_millis(u64::from(greeting.watchdog_ms)).max(FOLLOW_EVERY);
        self.halt()?;
        // Numbers go on above that of the last motion, whoever ordered it, so that its end is not taken for that of one
        // of ours.
        if let Some((last, _)) = self.program_state()?.last {
            self.number = self.number.max(last);
            self.moved = last;
        }
        Ok(format!("pschema.v2 version {VERSION}, watchdog {} ms", greeting.watchdog_ms))
    }

    fn state(&mut self) -> Result<State, Fault> {
        let state = self.program_state()?;
        Ok(State {
            power: state.power,
            calibrated: state.calibrated,
            emergency_stop: state.emergency_stop,
            moving: state.moving,
            latched: state.latched,
            signals: state.signals,
        })
    }

    fn joints(&mut self) -> Result<Joints, Fault> {
        let count = self.joints;
        self.ask(&Request::Where, self.answer_wait, |words| program::joints(words, count))
    }

    fn passing(&mut self) -> Result<Joints, Fault> {
        self.joints()
    }

    fn power(&mut self, on: bool) -> Result<(), Fault> {
        let request = Request::Power(on);
        let wait = if on { POWER_WAIT } else { self.answer_wait };
        let done = if on {
            self.ordering(|this| this.ask_patiently(&request, wait))?
        } else {
            self.ask_once(&request, wait)?.is_some()
        };
        // Asked what came of it rather than asked for again.
        if done || self.program_state()?.power == on {
            return Ok(());
        }
        Err(Fault::Silent { what: format!("{request:?}"), waited: wait })
    }

    fn calibrate(&mut self) -> Result<(), Fault> {
        let request = Request::Calibrate;
        let done = self.ordering(|this| this.ask_patiently(&request, CALIBRATE_WAIT))?;
        if done || self.program_state()?.calibrated {
            return Ok(());
        }
        Err(Fault::Silent { what: format!("{request:?}"), waited: CALIBRATE_WAIT })
    }

    fn reset(&mut self) -> Result<(), Fault> {
        match self.ask(&Request::Reset, self.answer_wait, |_| Some(())) {
            Err(Fault::Silent { what, waited }) => {
                if self.program_state()?.latched {
                    Err(Fault::Silent { what, waited })
                } else {
                    Ok(())
                }
            }
            done => done,
        }
    }

    fn begin(&mut self, path: &Permitted) -> Result<(), Fault> {
        self.motion = None;
        self.ends.clear();
        // The program takes motions in ascending numbers only. Questions since the last may have begun the numbers anew.
        if self.number < self.moved || self.number + LINES_OF_A_MOTION > NUMBER_MAX {
            self.number = 0;
            self.ask(&Request::Hello, self.answer_wait, program::greeting)?;
            self.moved = 0;
        }
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

/// Numbers that one motion may use, all its tries included.
const LINES_OF_A_MOTION: u32 = 1000;

impl ProgramController {
    fn stop_and_look(&mut self) -> Result<(), Fault> {
        self.motion = None;
        let deadline = Instant::now() + HALT_WAIT;
        while Instant::now() < deadline {
            self.attention.switch.send();
            match self.program_state() {
                Ok(state) if !state.moving => return self.forget_points(),
                // It brakes.
                Ok(_) => std::thread::sleep(FOLLOW_EVERY),
                Err(Fault::Silent { .. } | Fault::Garbled { .. } | Fault::Refused(_)) => {}
                Err(fault) => return Err(fault),
            }
        }
        Err(Fault::NotStopping)
    }

    fn follow_for_a_moment(&mut self) -> Result<Option<Ended>, Fault> {
        let Some(number) = self.motion else { return Ok(Some(Ended::Stopped)) };
        // The end may be told before the question is due.
        let due = self.asked_at + FOLLOW_EVERY;
        while self.end_is_awaited(number)
            && let Some(line) = self.line(due)?
        {
            if let Some(Reply::End { number, ended }) = Reply::read(&line) {
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
            && !state.moving
        {
            self.motion = None;
            return Ok(Some(ended));
        }
        if !state.moving {
            // It ended between two answers, or the controller was switched off and on: then this number means nothing to it.
            let again = self.program_state()?;
            self.motion = None;
            let ended = again.last.clone().filter(|(last, _)| *last == number).map(|(_, ended)| ended);
            return ended.map(Some).ok_or_else(|| Fault::Refused(lost_motion(&again)));
        }
        Ok(None)
    }

    fn end_is_awaited(&self, number: u32) -> bool {
        !self.ends.iter().any(|(end, _)| *end == number)
    }
}

/// What to say of a motion that the program knows nothing of.
fn lost_motion(state: &program::State) -> Message {
    let text = if state.emergency_stop {
        "E-stop pressed during a motion"
    } else if !state.power {
        "power off during a motion"
    } else {
        "motion lost"
    };
    let code = state.latched.then_some(11);
    Message { code, text: text.to_owned() }
}
