//! The requests to the server program `vplus/pschema.v2` and its replies: one line each, with a sum.

use super::message::VPlusMessage;
use super::{ControllerState, decimal, sum, values};

/// Highest number of a request.
pub const NUMBER_MAX: u32 = 999_999;
/// Points that may come before the end of a motion.
pub const VIAS_MAX: usize = 64;
/// Longest line in either direction, in bytes.
pub const LINE_BYTES_MAX: usize = 128;
/// Stops the arm: the byte that stops without a line and spoils the line that it cuts short, then a line end, then the
/// order. It needs no number, no sum and no answer.
pub const STOP: &[u8] = b"\x03\nSTOP\n";

/// The touch inputs that end a motion before its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum TouchGuard {
    /// None.
    None = 0,
    /// A touch input that comes on.
    On = 1,
    /// A touch input that goes off, for inputs that are on when nothing is touched.
    Off = 2,
}

/// A request. Joint values in it have passed the [gate](crate::gate); nothing else builds a motion.
#[derive(Clone, Debug, PartialEq)]
pub enum ProgramRequest<'a> {
    /// Asks which program answers, and begins the numbering of motions anew.
    Hello,
    /// Asks for the controller's state.
    State,
    /// Asks for the joints of the arm.
    Where,
    /// Adds a point to the coming motion.
    Via {
        /// Percent of full speed on the way to the point.
        speed: u8,
        /// The joints at the point.
        joints: &'a [f64],
    },
    /// Begins the motion through the added points to this last one.
    Move {
        /// The touch inputs that end the motion.
        guard: TouchGuard,
        /// Percent of full speed.
        speed: u8,
        /// The joints at the end.
        joints: &'a [f64],
    },
    /// Brakes, and forgets the added points.
    Stop,
    /// Turns high power on or off.
    Power(bool),
    /// Calibrates the arm, which moves it.
    Calibrate,
    /// Clears a latched fault.
    Reset,
}

impl ProgramRequest<'_> {
    /// The line, its end included.
    #[must_use]
    pub fn line(&self, number: u32) -> String {
        let flag = |on: bool| u8::from(on);
        let text = match self {
            Self::Hello => format!("HELLO {number}"),
            Self::State => format!("STAT {number}"),
            Self::Where => format!("WHERE {number}"),
            Self::Via { speed, joints } => format!("VIA {number} {speed} {}", values(joints, " ")),
            Self::Move { guard, speed, joints } => {
                format!("MOVE {number} {} {speed} {}", *guard as u8, values(joints, " "))
            }
            Self::Stop => format!("STOP {number}"),
            Self::Power(on) => format!("POWER {number} {}", flag(*on)),
            Self::Calibrate => format!("CAL {number}"),
            Self::Reset => format!("RESET {number}"),
        };
        sum::seal(&text) + "\n"
    }

    /// Whether the request moves the arm, or may. Such an order passes no switch that is pressed.
    #[must_use]
    pub fn may_move(&self) -> bool {
        matches!(self, Self::Via { .. } | Self::Move { .. } | Self::Power(true) | Self::Calibrate)
    }

    /// Whether asking again after a lost answer can do no harm.
    #[must_use]
    pub fn may_be_repeated(&self) -> bool {
        matches!(self, Self::Hello | Self::State | Self::Where | Self::Stop)
    }
}

/// A line from the program whose sum is right.
#[derive(Clone, Debug, PartialEq)]
pub enum ProgramReply {
    /// The request is done, or begun.
    Ok {
        /// The number of the request.
        number: u32,
        /// Values, as words.
        words: Vec<String>,
    },
    /// The request is refused.
    Refused {
        /// The number of the request, 0 when the program could not read it.
        number: u32,
        /// The reason.
        message: VPlusMessage,
    },
    /// A motion has ended.
    End {
        /// The number of its request.
        number: u32,
        /// How the motion ended.
        ended: MotionEnd,
    },
}

/// How a motion ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MotionEnd {
    /// At its end.
    Arrived,
    /// By a touch.
    Touched,
    /// By an order to stop.
    Stopped,
    /// By the program's watchdog.
    Watchdog,
    /// By an error of V+.
    Fault(i32),
}

impl MotionEnd {
    fn of_code(code: i32) -> Option<Self> {
        match code {
            0 => Some(Self::Arrived),
            1 => Some(Self::Touched),
            2 => Some(Self::Stopped),
            3 => Some(Self::Watchdog),
            code if code < 0 => Some(Self::Fault(code)),
            _ => None,
        }
    }
}

/// The program's answer to [`ProgramRequest::Hello`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Greeting {
    /// Version of the program.
    pub version: u32,
    /// Joints of the arm.
    pub joints: usize,
    /// Time after which the watchdog stops a motion for which no line comes, in milliseconds.
    pub watchdog_ms: u32,
}

/// The program's answer to [`ProgramRequest::State`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProgramState {
    /// The controller's state.
    pub controller: ControllerState,
    /// The number of the motion that ended last, and how it ended; None when none did.
    pub last: Option<(u32, MotionEnd)>,
}

impl ProgramReply {
    /// Reads a line. None when it is not a line of the program: noise, a message of the controller, half a line.
    #[must_use]
    pub fn read(line: &str) -> Option<Self> {
        let mut words = sum::unseal(line)?.split(' ');
        let (verb, number) = (words.next()?, whole(words.next()?)?);
        match verb {
            "OK" => Some(Self::Ok { number, words: words.map(str::to_owned).collect() }),
            "ERR" => {
                let code = Some(signed(words.next()?)?);
                let text = words.collect::<Vec<_>>().join(" ");
                Some(Self::Refused { number, message: VPlusMessage { code, text } })
            }
            "END" => {
                let ended = MotionEnd::of_code(signed(words.next()?)?)?;
                if words.next().is_some() { None } else { Some(Self::End { number, ended }) }
            }
            _ => None,
        }
    }
}

/// Reads the values of an answer to [`ProgramRequest::Hello`].
#[must_use]
pub fn greeting(words: &[String]) -> Option<Greeting> {
    match words {
        [name, version, joints, watchdog_ms] if name == "PSCHEMA" => Some(Greeting {
            version: whole(version)?,
            joints: usize::try_from(whole(joints)?).ok()?,
            watchdog_ms: whole(watchdog_ms)?,
        }),
        _ => None,
    }
}

/// Reads the values of an answer to [`ProgramRequest::State`].
#[must_use]
pub fn state(words: &[String]) -> Option<ProgramState> {
    let [power, calibrated, emergency_stop, moving, latched, signals, last, code] = words else {
        return None;
    };
    let last = whole(last)?;
    let ended = MotionEnd::of_code(signed(code)?)?;
    let controller = ControllerState {
        power: flag(power)?,
        calibrated: flag(calibrated)?,
        emergency_stop: flag(emergency_stop)?,
        moving: flag(moving)?,
        latched: flag(latched)?,
        signals: whole(signals)?.try_into().ok().filter(|bits| *bits < 16)?,
    };
    Some(ProgramState { controller, last: (last > 0).then_some((last, ended)) })
}

/// Reads the values of an answer to [`ProgramRequest::Where`]: exactly so many joints.
#[must_use]
pub fn joints(words: &[String], count: usize) -> Option<Vec<f64>> {
    let joints: Option<Vec<f64>> = words.iter().map(|word| decimal(word)).collect();
    joints.filter(|joints| joints.len() == count)
}

fn whole(text: &str) -> Option<u32> {
    let plain = (1..=6).contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_digit());
    if plain { text.parse().ok() } else { None }
}

fn signed(text: &str) -> Option<i32> {
    match text.strip_prefix('-') {
        Some(digits) => Some(-i32::try_from(whole(digits)?).ok()?),
        None => i32::try_from(whole(text)?).ok(),
    }
}

fn flag(text: &str) -> Option<bool> {
    match text {
        "0" => Some(false),
        "1" => Some(true),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn read(text: &str) -> Option<ProgramReply> {
        ProgramReply::read(&sum::seal(text))
    }

    fn words(text: &str) -> Vec<String> {
        text.split(' ').map(str::to_owned).collect()
    }

    #[test]
    fn requests_are_the_lines_of_the_program() {
        let joints = [12.3456, -80.0];
        for (request, text) in [
            (ProgramRequest::Hello, "HELLO 7"),
            (ProgramRequest::Via { speed: 10, joints: &joints }, "VIA 7 10 12.346 -80.000"),
            (
                ProgramRequest::Move { guard: TouchGuard::On, speed: 5, joints: &joints },
                "MOVE 7 1 5 12.346 -80.000",
            ),
            (ProgramRequest::Power(true), "POWER 7 1"),
            (ProgramRequest::Reset, "RESET 7"),
        ] {
            assert_eq!(request.line(7), sum::seal(text) + "\n");
        }
        let longest = [-359.999; crate::v_plus::JOINTS_MAX];
        let line =
            ProgramRequest::Move { guard: TouchGuard::On, speed: 100, joints: &longest }.line(NUMBER_MAX);
        assert!(line.len() <= LINE_BYTES_MAX, "{} bytes", line.len());
        assert!(
            !ProgramRequest::Move { guard: TouchGuard::None, speed: 5, joints: &joints }.may_be_repeated()
        );
    }

    #[test]
    fn replies_are_read() {
        assert_eq!(read("OK 3 1 2"), Some(ProgramReply::Ok { number: 3, words: words("1 2") }));
        assert_eq!(read("END 9 1"), Some(ProgramReply::End { number: 9, ended: MotionEnd::Touched }));
        assert_eq!(read("END 9 -645"), Some(ProgramReply::End { number: 9, ended: MotionEnd::Fault(-645) }));
        let refused = read("ERR 4 -604 Robot power off");
        let message = VPlusMessage { code: Some(-604), text: "Robot power off".into() };
        assert_eq!(refused, Some(ProgramReply::Refused { number: 4, message }));
        for wrong in ["", "OK", "OK x", "END 1", "END 1 7", "END 1 0 0", "ERR 1 x", "OK 1234567", "YES 1"] {
            assert_eq!(read(wrong), None, "{wrong}");
        }
        assert_eq!(ProgramReply::read("OK 3 1 2"), None, "without a sum");
    }

    #[test]
    fn values_are_read_whole_or_not_at_all() {
        let good = state(&words("1 1 0 0 0 5 12 1")).unwrap();
        assert_eq!((good.controller.signals, good.last), (5, Some((12, MotionEnd::Touched))));
        for wrong in
            ["1 1 0 0 0 5 12", "1 1 0 0 0 16 0 0", "2 1 0 0 0 0 0 0", "1 1 0 0 0 5 12 1 1", "1 1 0 0 0 5 x 1"]
        {
            assert_eq!(state(&words(wrong)), None, "{wrong}");
        }
        assert_eq!(joints(&words("1.5 -2"), 2), Some(vec![1.5, -2.0]));
        assert_eq!(joints(&words("1.5 -2 3"), 2), None);
        assert_eq!(joints(&words("1.5 nan"), 2), None);
        let greeted = greeting(&words("PSCHEMA 1 4 1000")).unwrap();
        assert_eq!((greeted.joints, greeted.watchdog_ms), (4, 1000));
        assert_eq!(greeting(&words("PSCHEMO 1 4 1000")), None);
    }

    proptest! {
        #[test]
        fn hostile_lines_are_read_as_nothing(line in "\\PC{0,200}") {
            prop_assert_eq!(ProgramReply::read(&line), None);
        }

        #[test]
        fn hostile_text_under_a_right_sum_never_panics(text in "(OK|ERR|END|[A-Z]{1,4})( [-0-9.a-z*]{0,12}){0,12}") {
            if let Some(ProgramReply::Ok { words, .. }) = read(&text) {
                let (_, _) = (state(&words), greeting(&words));
                if let Some(found) = joints(&words, 4) {
                    prop_assert!(found.len() == 4 && found.iter().all(|joint| joint.is_finite()));
                }
            }
        }
    }
}
