//! V+ as text: the lines to the controller and its answers. There is no I/O here.
//!
//! [`monitor`] is the controller's own command line, with nothing installed; [`program`] is the server program
//! `vplus/pschema.v2`, whose lines end with a sum. A refusal of the controller is a [`message::VPlusMessage`].

pub mod message;
pub mod monitor;
pub mod program;
pub mod sum;

/// Longest answer, in bytes. Longer text is no answer.
pub const ANSWER_BYTES_MAX: usize = 4096;
/// Joints an arm may have.
pub const JOINTS_MAX: usize = 6;

/// The controller's state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ControllerState {
    /// High power is on.
    pub power: bool,
    /// The arm is calibrated, and under the controller's control. Known only while high power is on.
    pub calibrated: bool,
    /// An emergency stop is pressed.
    pub emergency_stop: bool,
    /// A motion is under way, or something else that may move the arm.
    pub moving: bool,
    /// The controller refuses motions until a reset.
    pub latched: bool,
    /// The touch inputs: bit 0 the first.
    pub signals: u8,
}

/// A decimal number as V+ writes it: sign, digits, at most one point. No exponent, no `nan`, no `inf`.
#[must_use]
pub fn decimal(text: &str) -> Option<f64> {
    let digits = text.strip_prefix(['-', '+']).unwrap_or(text);
    let plain = (1..=16).contains(&digits.len())
        && digits.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.')
        && digits.bytes().any(|byte| byte.is_ascii_digit());
    if plain { text.parse().ok() } else { None }
}

/// Joint values as V+ reads them, in thousandths of a degree or millimetre, with `between` them.
pub(crate) fn values(joints: &[f64], between: &str) -> String {
    // Adding zero turns a rounded minus zero into zero.
    let value = |joint: &f64| format!("{:.3}", (joint * 1000.0).round() / 1000.0 + 0.0);
    joints.iter().map(value).collect::<Vec<_>>().join(between)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_plain_decimals() {
        for (text, value) in [("1", 1.0), ("-12.500", -12.5), ("+.5", 0.5), ("7.", 7.0)] {
            assert_eq!(decimal(text), Some(value));
        }
        for text in ["", "-", ".", "1e3", "nan", "inf", "0x1", "1.2.3", "--1", "1 2", "99999999999999999"] {
            assert_eq!(decimal(text), None, "{text}");
        }
        assert_eq!(values(&[-0.0001, 12.3456], ","), "0.000,12.346");
    }
}
