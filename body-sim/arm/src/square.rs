//! The two joint positions that command an arm, and the square that they span in front of it.

/// Joint positions are declared, compared and taught in steps of this.
pub const JOINT_RESOLUTION: f64 = 0.001;

/// The two numbers that command the arm, each a fraction 0 to 1 of its travel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointPositions {
    /// Across: 0 far left, 1 far right.
    pub j1: f64,
    /// Outwards: 0 where the work space begins, 1 where it ends straight ahead. The rest posture is nearer than 0.
    pub j2: f64,
}

impl JointPositions {
    /// Whether both are within the range that the arm may be commanded to.
    #[must_use]
    pub fn are_commandable(self) -> bool {
        (0.0..=1.0).contains(&self.j1) && (0.0..=1.0).contains(&self.j2)
    }
}

/// The square that the joint positions span, in metres across (to the right) and outwards from the base's axis. Over
/// the flat part of the manifold a place on it is a place on the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Square {
    /// How far `j1` goes from 0 to 1, in metres; 0.5 is straight ahead of the base.
    pub across_m: f64,
    /// Distance from the base's axis at which `j2` is 0, in metres.
    pub nearest_m: f64,
    /// How far `j2` goes from 0 to 1, in metres.
    pub outwards_m: f64,
    /// Distance of the rest posture from the base's axis, in metres.
    pub rest_m: f64,
}

impl Square {
    /// Where joint positions are on the square: metres across and outwards.
    #[must_use]
    pub fn at_m(&self, joints: JointPositions) -> (f64, f64) {
        ((joints.j1 - 0.5) * self.across_m, self.nearest_m + joints.j2 * self.outwards_m)
    }

    /// The joint positions of a place on the square; the inverse of [`Self::at_m`].
    #[must_use]
    pub fn joints(&self, (across_m, outwards_m): (f64, f64)) -> JointPositions {
        JointPositions {
            j1: across_m / self.across_m + 0.5,
            j2: (outwards_m - self.nearest_m) / self.outwards_m,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joint_positions_and_places_are_inverse() {
        let square = Square { across_m: 1.6, nearest_m: 0.12, outwards_m: 0.7, rest_m: 0.06 };
        assert_eq!(square.at_m(JointPositions { j1: 0.5, j2: 0.0 }), (0.0, 0.12));
        for (j1, j2) in [(0.5, 0.0), (0.43, 0.84), (0.0, 1.0)] {
            let back = square.joints(square.at_m(JointPositions { j1, j2 }));
            assert!((back.j1 - j1).abs() < 1e-12 && (back.j2 - j2).abs() < 1e-12);
        }
    }
}
