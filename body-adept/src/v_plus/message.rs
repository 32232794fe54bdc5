//! Messages of the controller when it refuses or gives up, and their causes where number or text are known.

use std::fmt;

/// The cause of a refusal or failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Cause {
    /// The line to the controller lost or garbled bytes.
    Line,
    /// The command was not understood.
    NotUnderstood,
    /// The controller does not take the value or location.
    Value,
    /// High power is off.
    PowerOff,
    /// The arm was never calibrated since the controller was switched on.
    NotCalibrated,
    /// A joint would pass its limit.
    OutOfRange,
    /// An emergency stop is pressed.
    EmergencyStop,
    /// The arm did not follow its path: it met an obstacle.
    Envelope,
    /// A motion is under way.
    Busy,
    /// The server program waits for a reset after its watchdog or a fault.
    Latched,
    /// The server program had this order before.
    Repeated,
    /// A stop came while the order was carried out, or the host fell silent.
    Stopped,
    /// None of these.
    Other,
}

impl Cause {
    /// The advice to a person.
    #[must_use]
    pub fn advice(self) -> &'static str {
        match self {
            Self::Line => "check cable, speed and grounding of the serial line",
            Self::NotUnderstood => {
                "check the mode in arm.toml: monitor, or server with vplus/pschema.v2 running"
            }
            Self::Value => "check joints and limits in arm.toml",
            Self::PowerOff => "enable power at the controller, or let --enable do it",
            Self::NotCalibrated => {
                "calibrate at the controller (CALIBRATE); the arm moves while it does, so stand clear"
            }
            Self::OutOfRange => "narrow the joints' limits in arm.toml to the controller's softstops",
            Self::EmergencyStop => {
                "make sure the work space is clear, release the emergency stop, reset, and enable again"
            }
            Self::Envelope => "find what the arm met, take it away, reset, and enable again",
            Self::Busy => "wait for the motion to end; nothing else may drive the arm",
            Self::Latched => "find out what stopped the arm, then reset and enable again",
            Self::Repeated => "none: the doubled order moved nothing",
            Self::Stopped => "find out what stopped it, then enable again",
            Self::Other => "look the number up in the V+ reference guide",
        }
    }

    /// Whether a person must look before the arm moves again: somebody or something stopped it for a reason.
    #[must_use]
    pub fn needs_a_person(self) -> bool {
        matches!(
            self,
            Self::PowerOff | Self::NotCalibrated | Self::EmergencyStop | Self::Envelope | Self::Latched
        )
    }
}

/// A refusal or failure, as the controller said it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VPlusMessage {
    /// The number, if there was one: negative from V+ itself, positive from the server program.
    pub code: Option<i32>,
    /// The text, without its asterisks.
    pub text: String,
}

/// Numbers that stand for a cause. Those of the line are documented; all other negative ones are as remembered, so
/// the text is looked at first. Positive numbers are those of `vplus/pschema.v2`.
const NUMBERS: [(i32, Cause); 17] = [
    (-504, Cause::Line),
    (-522, Cause::Line),
    (-524, Cause::Line),
    (-526, Cause::Line),
    (-604, Cause::PowerOff),
    (-605, Cause::NotCalibrated),
    (-610, Cause::OutOfRange),
    (-645, Cause::EmergencyStop),
    (-1006, Cause::Envelope),
    (10, Cause::Busy),
    (11, Cause::Latched),
    (12, Cause::Value),
    (13, Cause::OutOfRange),
    (15, Cause::NotUnderstood),
    (16, Cause::Line),
    (17, Cause::Repeated),
    (18, Cause::Stopped),
];

/// Parts of texts, in small letters, that stand for a cause. The first that fits counts.
const TEXTS: [(&str, Cause); 14] = [
    ("e-stop", Cause::EmergencyStop),
    ("emergency", Cause::EmergencyStop),
    ("power off", Cause::PowerOff),
    ("power disabled", Cause::PowerOff),
    ("not calibrated", Cause::NotCalibrated),
    ("out of range", Cause::OutOfRange),
    ("envelope", Cause::Envelope),
    ("no data received", Cause::Line),
    ("data error", Cause::Line),
    ("overrun", Cause::Line),
    ("unexpected end of file", Cause::Line),
    ("undefined", Cause::Value),
    ("invalid", Cause::Value),
    ("illegal", Cause::NotUnderstood),
];

impl VPlusMessage {
    /// A message by its text alone, as the monitor shows it.
    #[must_use]
    pub fn of_text(text: &str) -> Self {
        Self { code: None, text: text.trim().to_owned() }
    }

    /// The cause that the message stands for.
    #[must_use]
    pub fn cause(&self) -> Cause {
        let text = self.text.to_ascii_lowercase();
        let by_text = TEXTS.iter().find(|(part, _)| text.contains(part)).map(|(_, cause)| *cause);
        let by_number =
            || NUMBERS.iter().find(|(number, _)| self.code == Some(*number)).map(|(_, cause)| *cause);
        by_text.or_else(by_number).unwrap_or(Cause::Other)
    }
}

impl fmt::Display for VPlusMessage {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.code {
            Some(code) => write!(to, "*{}* ({code}): {}", self.text, self.cause().advice()),
            None => write!(to, "*{}*: {}", self.text, self.cause().advice()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_named_by_text_first_then_by_number() {
        let named = |code: Option<i32>, text: &str| VPlusMessage { code, text: text.to_owned() }.cause();
        assert_eq!(named(Some(-999), "Robot power off"), Cause::PowerOff);
        assert_eq!(named(None, "E-STOP from user E-STOP button"), Cause::EmergencyStop);
        assert_eq!(named(Some(-522), ""), Cause::Line);
        assert_eq!(named(Some(11), "latched"), Cause::Latched);
        assert_eq!(named(Some(-777), "Gripper on strike"), Cause::Other);
        assert!(Cause::EmergencyStop.needs_a_person() && !Cause::Line.needs_a_person());
    }

    #[test]
    fn a_message_says_its_number_and_what_to_do() {
        let told = VPlusMessage { code: Some(-605), text: "Robot not calibrated".into() }.to_string();
        assert!(told.contains("-605") && told.contains("CALIBRATE"), "{told}");
    }
}
