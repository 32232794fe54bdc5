//! Floating-point figures that may overflow. JSON has no word for infinity: such a figure is written as `null`, and an
//! answer that holds one is still an answer.

use serde::{Deserialize, Deserializer};

/// Reads a figure; `null` is NaN.
pub(crate) fn or_nan<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f64::NAN))
}
