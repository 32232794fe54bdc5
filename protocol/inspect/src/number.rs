//! Floating-point figures that may overflow. JSON has no word for infinity: such a figure is written as `null`, and an
//! answer that holds one is still an answer.

use serde::{Deserialize, Deserializer};

/// Sizes of numbers that a person reads without counting digits.
const READ_AT_SIGHT: std::ops::Range<f64> = 1e-9..1e15;

/// A difference, with a power of ten where people would count its digits.
pub(crate) fn signed(difference: f64) -> String {
    let at_sight = difference == 0.0 || READ_AT_SIGHT.contains(&difference.abs());
    if at_sight || !difference.is_finite() { format!("{difference:+}") } else { format!("{difference:+e}") }
}

/// Reads a figure; `null` is NaN.
pub(crate) fn or_nan<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f64::NAN))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_is_told_with_a_power_of_ten_where_its_zeros_would_be_counted() {
        let told = [1.0, -0.25, 1e300, -2e-10, 0.0].map(signed);
        assert_eq!(told, ["+1", "-0.25", "+1e300", "-2e-10", "+0"]);
    }
}
