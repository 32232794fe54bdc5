//! The sides of the finger, each with a touch pad.

use serde::Deserialize;

/// A touch pad, by the side of the finger that it is on. The order is that of the declared symbols.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// Towards the finger's left.
    Left,
    /// Towards the finger's right.
    Right,
    /// Towards the arm's base.
    Near,
    /// Away from the arm's base.
    Far,
}

impl Side {
    /// All sides, in the order of their symbols.
    pub const ALL: [Self; 4] = [Self::Left, Self::Right, Self::Near, Self::Far];

    /// The symbol that stands for this side in observations.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
            Self::Near => "near",
            Self::Far => "far",
        }
    }
}
