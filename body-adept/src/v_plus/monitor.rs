//! The commands that are typed at the controller's monitor, and the answers that it prints.
//!
//! The prompt is a period at the beginning of a line, which a decimal never is; messages stand between asterisks. The
//! columns of listings, the echo and the line ends are not documented, so all of them are taken as they come: an
//! answer is the text between the command and the next prompt, and its numbers are all the decimals there.

use super::message::VPlusMessage;
use super::{ControllerState, decimal, values};

/// The location that motions go to.
const GOAL: &str = "#PSGOAL";
/// Stops the arm: the byte that abandons a line, then the order twice, the first of which may be spoilt by half a line
/// before it. Never a bare line end: it could complete an order that was given up.
pub const STOP: &[u8] = b"\x03PANIC\r\nPANIC\r\n";

/// A command. Joint values in it have passed the [gate](crate::gate); nothing else builds a motion.
#[derive(Clone, Debug, PartialEq)]
pub enum MonitorCommand<'a> {
    /// Asks which controller it is.
    Identify,
    /// Asks for the joints of the arm.
    Where,
    /// Asks for the values of switches, state words and digital inputs; see [`state`].
    State {
        /// The touch inputs.
        signals: [u16; 4],
    },
    /// Sets the speed, in percent of full speed.
    Speed(u8),
    /// Asks for that speed, and for the percentage that programs have set, which multiplies it.
    ListSpeeds,
    /// Sets the goal of the next motion.
    SetGoal(&'a [f64]),
    /// Asks for that goal.
    ListGoal,
    /// Begins the motion to the goal.
    MoveToGoal,
    /// Turns high power on or off.
    Power(bool),
    /// Asks to calibrate the arm, which moves it; the monitor asks back.
    Calibrate,
    /// Agrees to calibrate.
    Yes,
}

impl MonitorCommand<'_> {
    /// Whether the command moves the arm, or may. Such an order passes no switch that is pressed.
    #[must_use]
    pub fn may_move(&self) -> bool {
        matches!(
            self,
            Self::Speed(_)
                | Self::SetGoal(_)
                | Self::MoveToGoal
                | Self::Power(true)
                | Self::Calibrate
                | Self::Yes
        )
    }

    /// The text, without a line end.
    #[must_use]
    pub fn text(&self) -> String {
        match self {
            Self::Identify => "ID".to_owned(),
            Self::Where => "WHERE".to_owned(),
            Self::State { signals: [left, right, near, far] } => format!(
                "LISTR SWITCH(POWER),STATE(4),STATE(2),STATE(1),SIG({left}),SIG({right}),SIG({near}),SIG({far})"
            ),
            Self::Speed(percent) => format!("SPEED {percent}"),
            Self::ListSpeeds => "LISTR SPEED(1),SPEED(2)".to_owned(),
            Self::SetGoal(joints) => format!("DO SET {GOAL}=#PPOINT({})", values(joints, ",")),
            Self::ListGoal => format!("LISTL {GOAL}"),
            Self::MoveToGoal => format!("DO MOVE {GOAL}"),
            Self::Power(true) => "ENABLE POWER".to_owned(),
            Self::Power(false) => "DISABLE POWER".to_owned(),
            Self::Calibrate => "CALIBRATE".to_owned(),
            Self::Yes => "Y".to_owned(),
        }
    }
}

/// Whether printed text ends with the prompt: a period alone at the beginning of the last line.
#[must_use]
pub fn ends_with_prompt(printed: &[u8]) -> bool {
    matches!(printed, [.., b'\n' | b'\r', b'.'] | [.., b'\n' | b'\r', b'.', b' '])
}

/// Whether printed text ends with a question.
#[must_use]
pub fn ends_with_question(printed: &[u8]) -> bool {
    printed.trim_ascii_end().ends_with(b"?")
}

/// An answer: the text that was printed after a command and before the prompt.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MonitorAnswer {
    /// Whether the command itself was printed first, character by character.
    pub echoed: bool,
    /// The lines of the answer, without the echo, empty lines and the prompt.
    pub lines: Vec<String>,
}

/// Takes an answer apart.
#[must_use]
pub fn answer(command: &str, printed: &[u8]) -> MonitorAnswer {
    let text = String::from_utf8_lossy(printed);
    let text = text.trim_end().strip_suffix('.').unwrap_or(&text);
    let mut lines: Vec<String> =
        text.split(['\r', '\n']).map(str::trim).filter(|line| !line.is_empty()).map(str::to_owned).collect();
    let echoed = lines.first().is_some_and(|line| line.trim_start_matches('.') == command);
    if echoed {
        lines.remove(0);
    }
    MonitorAnswer { echoed, lines }
}

impl MonitorAnswer {
    /// The message in the answer, if there is one.
    #[must_use]
    pub fn message(&self) -> Option<VPlusMessage> {
        self.lines.iter().find_map(|line| {
            let (_, rest) = line.split_once('*')?;
            let (text, _) = rest.split_once('*')?;
            (!text.trim().is_empty()).then(|| VPlusMessage::of_text(text))
        })
    }

    /// The decimals of the last line that has `count` decimals and nothing else.
    #[must_use]
    pub fn numbers(&self, count: usize) -> Option<Vec<f64>> {
        let of_line = |line: &String| -> Option<Vec<f64>> {
            let all: Option<Vec<f64>> =
                line.split([' ', '\t', ',']).filter(|word| !word.is_empty()).map(decimal).collect();
            all.filter(|numbers| numbers.len() == count)
        };
        self.lines.iter().rev().find_map(of_line)
    }

    /// The decimals of all lines, if there are `count` of them and nothing else.
    #[must_use]
    pub fn all_numbers(&self, count: usize) -> Option<Vec<f64>> {
        let words =
            self.lines.iter().flat_map(|line| line.split([' ', '\t', ','])).filter(|word| !word.is_empty());
        let all: Option<Vec<f64>> = words.map(decimal).collect();
        all.filter(|numbers| numbers.len() == count)
    }
}

/// The answer to [`MonitorCommand::State`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MonitorState {
    /// The controller's state. The monitor latches nothing.
    pub controller: ControllerState,
    /// Power is coming up or going, or the arm is being calibrated: the driver has to wait.
    pub settling: bool,
}

/// `STATE(1)`: the robot is under program control. The vendor's list: 0 resetting, 1 fatal error, 2 waiting for power,
/// 3 initializing after power-up, 4 manual control, 5 calibrating, 7 under program control, 8 not calibrated.
const UNDER_CONTROL: u32 = 7;
const RESETTING: u32 = 0;
const INITIALIZING: u32 = 3;
const CALIBRATING: u32 = 5;

/// Reads an answer to [`MonitorCommand::State`]. V+ calls -1 true and 0 false; bit 3 of `STATE(4)` is the emergency
/// stop; `STATE(2)` is odd while the arm moves, brakes or settles, and even while it stands.
#[must_use]
pub fn state(answer: &MonitorAnswer) -> Option<MonitorState> {
    let numbers = answer.all_numbers(8)?;
    let [power, stops, motion, overall, touch @ ..] = numbers.as_slice() else { return None };
    let mut signals = 0;
    for (bit, signal) in touch.iter().enumerate() {
        signals |= u8::from(truth(*signal)?) << bit;
    }
    let overall = word(*overall)?;
    let controller = ControllerState {
        power: truth(*power)?,
        calibrated: overall == UNDER_CONTROL,
        emergency_stop: word(*stops)? & 4 != 0,
        moving: word(*motion)? % 2 == 1 || overall == CALIBRATING,
        latched: false,
        signals,
    };
    Some(MonitorState { controller, settling: [RESETTING, INITIALIZING, CALIBRATING].contains(&overall) })
}

/// A word of the state: a whole number that is not negative.
fn word(value: f64) -> Option<u32> {
    ((0.0..65_536.0).contains(&value) && value.fract() == 0.0).then_some(value as u32)
}

fn truth(value: f64) -> Option<bool> {
    if value == -1.0 {
        Some(true)
    } else if value == 0.0 {
        Some(false)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_prompt_is_a_period_at_the_beginning_of_a_line() {
        for prompt in ["\r\n.", "WHERE\r\n 1.5 2.5\r\n.", "x\n.", "\r\n. "] {
            assert!(ends_with_prompt(prompt.as_bytes()), "{prompt:?}");
        }
        for other in ["", ".", "12.", "\r\n12.", "\r\n.5", "\r\n*Robot power off.*"] {
            assert!(!ends_with_prompt(other.as_bytes()), "{other:?}");
        }
    }

    #[test]
    fn positions_are_read_with_and_without_echo_and_headers() {
        for printed in [
            "WHERE\r\n  X  Y  Z\r\n 1.0 2.0 3.0 4.0 5.0 6.0\r\n  12.500  -80.250\r\n.",
            " 12.500\t-80.250\n\n.",
            "WHERE\r    J1   J2\r12.5,-80.25\r.",
        ] {
            assert_eq!(
                answer("WHERE", printed.as_bytes()).numbers(2),
                Some(vec![12.5, -80.25]),
                "{printed:?}"
            );
        }
        for printed in ["WHERE\r\n 12.500\r\n.", "12.500 -80.250 x\r\n.", "12.5.0 -80\r\n."] {
            assert_eq!(answer("WHERE", printed.as_bytes()).numbers(2), None, "{printed:?}");
        }
    }

    #[test]
    fn messages_and_echo_are_found() {
        let refused = answer("DO MOVE #PSGOAL", b"DO MOVE #PSGOAL\r\n*Robot power off*\r\n.");
        assert!(refused.echoed);
        assert_eq!(refused.message(), Some(VPlusMessage::of_text("Robot power off")));
        let garbled = answer("DO MOVE #PSGOAL", b"DO MOVE #PSGOBL\r\n.");
        assert!(!garbled.echoed && garbled.message().is_none());
        assert_eq!(garbled.lines, ["DO MOVE #PSGOBL"]);
    }

    #[test]
    fn the_state_is_read() {
        let read = |values: &str| state(&answer("LISTR", format!("LISTR\r\n{values}\r\n.").as_bytes()));
        let found = read("-1\r\n4\r\n1\r\n7\r\n-1\r\n0\r\n0\r\n-1").unwrap();
        let (moving, calibrated, settling) = (true, true, false);
        let (power, emergency_stop, latched, signals) = (true, true, false, 0b1001);
        let controller = ControllerState { power, calibrated, emergency_stop, moving, latched, signals };
        assert_eq!(found, MonitorState { controller, settling });
        assert_eq!(read("-1 0 0 7 0 0 0 0").map(|state| state.controller.signals), Some(0));
        for (words, moving, calibrated, settling) in [
            ("2 7", false, true, false),
            ("5 7", true, true, false),
            ("6 7", false, true, false),
            ("0 8", false, false, false),
            ("0 5", true, false, true),
            ("0 3", false, false, true),
            ("0 4", false, false, false),
        ] {
            let found = read(&format!("-1 0 {words} 0 0 0 0")).unwrap();
            assert_eq!(
                (found.controller.moving, found.controller.calibrated, found.settling),
                (moving, calibrated, settling),
                "{words}"
            );
        }
        for wrong in [
            "-1 0 0 7 0 0 0",
            "2 0 0 7 0 0 0 0",
            "-1 0 0 7 0 0 0 0 0",
            "-1 0 0 7 0 0 0 -2",
            "-1 0 0 -1 0 0 0 0",
            "-1 0 0.5 7 0 0 0 0",
        ] {
            assert_eq!(read(wrong), None, "{wrong}");
        }
    }

    proptest! {
        #[test]
        fn hostile_bytes_never_panic(printed in proptest::collection::vec(any::<u8>(), 0..400), count in 0_usize..9) {
            let answer = answer("WHERE", &printed);
            let (_, _, _) = (answer.message(), state(&answer), ends_with_prompt(&printed));
            if let Some(numbers) = answer.numbers(count) {
                prop_assert_eq!(numbers.len(), count);
                prop_assert!(numbers.iter().all(|number| number.is_finite()));
            }
        }
    }
}
