//! The errors of V+ that the emulated controller reports.
//!
//! The vendor's numbering is documented: 0 to 49 inform, 50 to 299 warn, -300 to -1300 are errors, shown between
//! asterisks. Of the errors here, the number -524 is documented. All other numbers are **from memory and not
//! verified**; no driver may depend on them. The texts are the vendor's, as far as remembered.

/// An error of V+.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VPlusMessage {
    /// Its number.
    pub code: i32,
    /// Its text, without the asterisks.
    pub text: &'static str,
}

macro_rules! messages {
    ($($(#[$doc:meta])* $name:ident = $code:literal $text:literal;)*) => {
        $($(#[$doc])* pub(crate) const $name: VPlusMessage = VPlusMessage { code: $code, text: $text };)*
    };
}

messages! {
    /// There is no command of that name.
    ILLEGAL_COMMAND = -300 "Illegal monitor command";
    /// `DO` is not followed by an instruction.
    ILLEGAL_INSTRUCTION = -307 "Illegal instruction";
    /// The rest of the line is not in the form that the command takes.
    BAD_SYNTAX = -350 "Syntax error";
    /// A number that is not allowed here.
    ILLEGAL_VALUE = -402 "Invalid argument";
    /// A location that was never set.
    UNDEFINED = -408 "Undefined value";
    /// More bytes came than could be taken (documented).
    OVERRUN = -524 "Communications overrun";
    /// A motion was asked for without power.
    POWER_OFF = -604 "Robot power off";
    /// A motion was asked for before calibration.
    NOT_CALIBRATED = -605 "Robot not calibrated";
    /// A joint would pass its softstop.
    OUT_OF_RANGE = -610 "Position out of range";
    /// Power was asked for, or a motion was under way, with an emergency stop pressed.
    E_STOP = -645 "E-STOP from user E-STOP button";
    /// The arm did not follow its path: it met an obstacle that does not give way.
    ENVELOPE = -1006 "Envelope error";
}

impl VPlusMessage {
    /// The text as the monitor shows it.
    #[must_use]
    pub fn starred(self) -> String {
        format!("*{}*", self.text)
    }
}
