//! Numbers of world and arm files, checked as they are read.

use serde::Deserialize;

/// A number read from a world or arm file, within `MIN..=MAX`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(try_from = "f64")]
pub struct Within<const MIN: i64, const MAX: i64>(f64);

impl<const MIN: i64, const MAX: i64> TryFrom<f64> for Within<MIN, MAX> {
    type Error = String;

    fn try_from(value: f64) -> Result<Self, String> {
        if (MIN as f64..=MAX as f64).contains(&value) {
            Ok(Self(value))
        } else {
            Err(format!("{value} is out of range: must be {MIN} to {MAX}"))
        }
    }
}

impl<const MAX: i64> Within<0, MAX> {
    /// The number 0.
    pub const ZERO: Self = Self(0.0);
}

impl<const MIN: i64, const MAX: i64> Within<MIN, MAX> {
    /// The number as written.
    #[must_use]
    pub fn get(self) -> f64 {
        self.0
    }

    /// Millimetres as metres.
    #[must_use]
    pub fn metres(self) -> f64 {
        self.0 / 1000.0
    }

    /// Degrees as radians.
    #[must_use]
    pub fn radians(self) -> f64 {
        self.0.to_radians()
    }

    /// A number of things or pixels, rounded.
    #[must_use]
    pub fn count(self) -> usize {
        self.0.round().max(0.0) as usize
    }
}

/// A point of the table: x (to the right) and y (outwards) from the base's axis, in millimetres.
pub type PointMm = [Within<-10_000, 10_000>; 2];
