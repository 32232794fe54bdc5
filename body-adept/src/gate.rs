//! The one gate to the arm: joint limits, the work space and the speed cap, applied to every motion just before it is
//! written, whoever asks for it.
//!
//! A [`PermittedPath`] can be made nowhere else, and the controllers take no other path.

use pschema_arm::route::Waypoint;
use thiserror::Error;

use crate::taught::{Joints, TaughtGrid};

/// Points one path may have.
pub const LEGS_MAX: usize = crate::v_plus::program::VIAS_MAX + 1;

/// Limits of one joint, in degrees or millimetres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimits {
    /// Lowest value.
    pub min: f64,
    /// Highest value.
    pub max: f64,
    /// Largest distance of the joint from where it should be, and of a path from the taught manifold.
    pub tolerance: f64,
}

/// The limits of every motion.
#[derive(Clone, Debug)]
pub struct Gate {
    joints: Vec<JointLimits>,
    tolerances: Vec<f64>,
    speed_percent_max: u8,
    taught: TaughtGrid,
}

/// A part of a path as it is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Leg {
    /// Where the part ends.
    pub to: Joints,
    /// Percent of full speed.
    pub speed_percent: u8,
}

/// A path that has passed the gate.
#[derive(Clone, Debug, PartialEq)]
pub struct PermittedPath {
    legs: Vec<Leg>,
    guarded: bool,
}

impl PermittedPath {
    /// The parts of the path, in order; at least one.
    #[must_use]
    pub fn legs(&self) -> &[Leg] {
        &self.legs
    }

    /// Whether a touch ends the motion.
    #[must_use]
    pub fn guarded(&self) -> bool {
        self.guarded
    }

    /// Where the path ends.
    #[must_use]
    pub fn end(&self) -> &[f64] {
        self.legs.last().map_or(&[], |leg| &leg.to)
    }
}

/// Why a path may not be taken.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PathRefusal {
    /// The path has no part, or too many.
    #[error("a path of {0} parts: it must have 1 to {LEGS_MAX}")]
    Parts(usize),
    /// The path has values for another number of joints than the arm has.
    #[error("{found} joint values for an arm of {joints} joints")]
    Count {
        /// How many values there are.
        found: usize,
        /// How many joints the arm has.
        joints: usize,
    },
    /// A joint would be beyond its limit, or its value is no number.
    #[error("joint {joint} at {value}: its limits in arm.toml are {} to {}", .limits.0, .limits.1)]
    Joint {
        /// Number of the joint, from 1.
        joint: usize,
        /// The value asked for.
        value: f64,
        /// The joint's limits, lowest and highest.
        limits: (f64, f64),
    },
    /// The speed is 0 or above the cap.
    #[error("a speed of {percent} %: it must be 1 to {max} %")]
    Speed {
        /// Percent of full speed asked for.
        percent: u8,
        /// The cap, in percent.
        max: u8,
    },
    /// The path would leave the taught manifold.
    #[error("the path would leave what was taught by {off:.1} times the tolerance")]
    OffManifold {
        /// By how much, in multiples of the tolerance.
        off: f64,
    },
}

impl Gate {
    /// A gate with these limits, one a joint.
    #[must_use]
    pub fn new(joints: Vec<JointLimits>, speed_percent_max: u8, taught: TaughtGrid) -> Self {
        let tolerances = joints.iter().map(|limits| limits.tolerance).collect();
        Self { joints, tolerances, speed_percent_max, taught }
    }

    /// The taught grid.
    #[must_use]
    pub fn taught(&self) -> &TaughtGrid {
        &self.taught
    }

    /// Each joint's tolerance.
    #[must_use]
    pub fn tolerances(&self) -> &[f64] {
        &self.tolerances
    }

    /// Lets a path pass that begins at `from`, where the arm was measured to be.
    ///
    /// # Errors
    /// The first limit that the path does not keep.
    pub fn permit(&self, from: &[f64], legs: Vec<Leg>, guarded: bool) -> Result<PermittedPath, PathRefusal> {
        if legs.is_empty() || legs.len() > LEGS_MAX {
            return Err(PathRefusal::Parts(legs.len()));
        }
        self.check_joints(from)?;
        let mut before = from;
        let mut near = None;
        for leg in &legs {
            if leg.speed_percent == 0 || leg.speed_percent > self.speed_percent_max {
                return Err(PathRefusal::Speed { percent: leg.speed_percent, max: self.speed_percent_max });
            }
            self.check_joints(&leg.to)?;
            // The arm goes straight in its joints, which is not straight on the manifold: half-way it is farthest off.
            let half_way: Joints = before.iter().zip(&leg.to).map(|(a, b)| (a + b) / 2.0).collect();
            near = Some(self.check_taught(&half_way, near)?);
            near = Some(self.check_taught(&leg.to, near)?);
            before = &leg.to;
        }
        Ok(PermittedPath { legs, guarded })
    }

    /// Whether joint values are the arm's, numbers, and within their limits.
    ///
    /// # Errors
    /// The first joint value that is not.
    pub fn check_joints(&self, joints: &[f64]) -> Result<(), PathRefusal> {
        if joints.len() != self.joints.len() {
            return Err(PathRefusal::Count { found: joints.len(), joints: self.joints.len() });
        }
        for (index, (value, limits)) in joints.iter().zip(&self.joints).enumerate() {
            if !(limits.min..=limits.max).contains(value) {
                return Err(PathRefusal::Joint {
                    joint: index + 1,
                    value: *value,
                    limits: (limits.min, limits.max),
                });
            }
        }
        Ok(())
    }

    /// The point of the taught grid at joint values, which is looked for first near the point before.
    fn check_taught(&self, joints: &[f64], near: Option<Waypoint>) -> Result<Waypoint, PathRefusal> {
        let located = match near {
            Some(near) => self.taught.locate_near(near, joints, &self.tolerances),
            None => self.taught.locate(joints, &self.tolerances),
        };
        match located {
            Some(located) if located.off <= 1.0 => Ok(located.at),
            located => {
                Err(PathRefusal::OffManifold { off: located.map_or(f64::INFINITY, |located| located.off) })
            }
        }
    }

    /// Whether an arm that should be at `wanted` is there, within the tolerances.
    #[must_use]
    pub fn is_at(&self, wanted: &[f64], measured: &[f64]) -> bool {
        wanted.len() == self.joints.len()
            && measured.len() == self.joints.len()
            && wanted.iter().zip(measured).zip(&self.tolerances).all(|((a, b), most)| (a - b).abs() <= *most)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use pschema_arm::JointPositions;

    use super::*;
    use crate::taught::tests::grid;

    pub(crate) fn gate() -> Gate {
        let limits = |min, max, tolerance| JointLimits { min, max, tolerance };
        let joints = vec![limits(-70.0, 70.0, 0.5), limits(0.0, 100.0, 0.5), limits(0.0, 200.0, 1.0)];
        Gate::new(joints, 20, grid())
    }

    fn at(gate: &Gate, j1: f64, j2: f64) -> Joints {
        gate.taught().at(Waypoint { joints: JointPositions { j1, j2 }, lift_m: 0.0 }).unwrap()
    }

    fn leg(to: Joints) -> Leg {
        Leg { to, speed_percent: 10 }
    }

    #[test]
    fn a_short_path_on_the_manifold_passes() {
        let gate = gate();
        let path = gate.permit(
            &at(&gate, 0.5, 0.5),
            vec![leg(at(&gate, 0.52, 0.5)), leg(at(&gate, 0.54, 0.52))],
            true,
        );
        let path = path.unwrap();
        assert_eq!((path.legs().len(), path.guarded()), (2, true));
        assert_eq!(path.end(), at(&gate, 0.54, 0.52));
    }

    #[test]
    fn everything_else_is_refused_with_its_figure() {
        let gate = gate();
        let from = at(&gate, 0.5, 0.5);
        let refused = |legs: Vec<Leg>| gate.permit(&from, legs, false).unwrap_err();
        assert_eq!(refused(vec![]), PathRefusal::Parts(0));
        assert_eq!(refused(vec![leg(from.clone()); LEGS_MAX + 1]), PathRefusal::Parts(LEGS_MAX + 1));
        assert_eq!(refused(vec![leg(vec![1.0])]), PathRefusal::Count { found: 1, joints: 3 });
        let mut not_a_number = from.clone();
        not_a_number[1] = f64::NAN;
        assert!(matches!(refused(vec![leg(not_a_number)]), PathRefusal::Joint { joint: 2, .. }));
        let beyond = refused(vec![leg(vec![71.0, 50.0, 155.0])]);
        assert!(
            beyond.to_string().contains("joint 1 at 71: its limits in arm.toml are -70 to 70"),
            "{beyond}"
        );
        let mut below = from.clone();
        below[2] += 12.0;
        assert!(matches!(refused(vec![leg(below)]), PathRefusal::OffManifold { .. }), "under the table");
        for speed_percent in [0, 21, 255] {
            let refused = refused(vec![Leg { to: from.clone(), speed_percent }]);
            assert_eq!(refused, PathRefusal::Speed { percent: speed_percent, max: 20 });
        }
    }

    #[test]
    fn a_short_cut_under_the_manifold_is_refused() {
        let gate = gate();
        // From one end to the other in one go: half-way the quill would be 5 mm off.
        let refused = gate.permit(&at(&gate, 0.5, 0.0), vec![leg(at(&gate, 0.5, 1.0))], false).unwrap_err();
        assert!(matches!(refused, PathRefusal::OffManifold { .. }), "{refused}");
    }

    #[test]
    fn an_arm_that_was_measured_outside_its_limits_does_not_move() {
        let gate = gate();
        let refused = gate.permit(&[99.0, 50.0, 155.0], vec![leg(at(&gate, 0.5, 0.5))], false).unwrap_err();
        assert!(matches!(refused, PathRefusal::Joint { joint: 1, .. }));
    }
}
