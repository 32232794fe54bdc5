//! The arm: a yaw at the base, shoulder, elbow and wrist. Closed-form inverse kinematics for a finger that
//! keeps its slant, and the motion between two postures.
//!
//! The elbow stays on the base's side of the line from shoulder to wrist, below it, and the finger leans
//! back to a wrist that is nearer and higher than the tip: seen from above, nothing of the arm covers the
//! tip.

use nalgebra::{Point3, UnitQuaternion, Vector3};
use pschema_arm::JointPositions;
use pschema_arm::route::Waypoint;

use crate::config;
use crate::manifold::{Manifold, OnManifold};

/// Share of the stretched arm's length that is used: a straight elbow is a singularity.
const STRETCH_MAX: f64 = 0.995;
/// Points on a path at which speeds are compared with their limits.
const SPEED_SAMPLES: usize = 128;
/// The quickest move, in seconds.
const DURATION_S_MIN: f64 = 0.05;

/// The geometry of the arm and the limits of its speed. Lengths are in metres, speeds in radians and metres a second.
#[derive(Clone, Debug, PartialEq)]
pub struct Kinematics {
    shoulder_height_m: f64,
    upper_arm_m: f64,
    forearm_m: f64,
    /// Wrist relative to the tip in the arm's plane: outwards (negative: behind it), up.
    wrist_from_tip_m: (f64, f64),
    joint_speed_max: f64,
    tip_speed_max: f64,
}

/// The positions of the arm's joints in the world, in metres, and the turn of the finger.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Posture {
    /// Shoulder, on the base's axis.
    pub shoulder_m: Point3<f64>,
    /// Elbow.
    pub elbow_m: Point3<f64>,
    /// Wrist, where the finger begins.
    pub wrist_m: Point3<f64>,
    /// Finger tip: the centre of its ball.
    pub tip_m: Point3<f64>,
    /// Turn of the finger: its local +y is outwards from the base, +x to the right, +z up.
    pub finger_turn: UnitQuaternion<f64>,
    /// Joint angles (yaw, shoulder, elbow, wrist) in radians.
    pub angles_rad: [f64; 4],
}

impl Kinematics {
    /// The arm of a world file.
    #[must_use]
    pub fn new(config: &config::ArmSection) -> Self {
        let (sine, cosine) = libm::sincos(config.finger_slant_deg.radians());
        let finger_m = config.finger_mm.metres();
        Self {
            shoulder_height_m: config.shoulder_height_mm.metres(),
            upper_arm_m: config.upper_arm_mm.metres(),
            forearm_m: config.forearm_mm.metres(),
            wrist_from_tip_m: (-finger_m * sine, finger_m * cosine),
            joint_speed_max: config.joint_speed_max_deg_per_s.radians(),
            tip_speed_max: config.tip_speed_max_mm_per_s.metres(),
        }
    }

    /// Wrist relative to the tip in the finger's own frame.
    #[must_use]
    pub fn wrist_from_tip(&self) -> Vector3<f64> {
        Vector3::new(0.0, self.wrist_from_tip_m.0, self.wrist_from_tip_m.1)
    }

    /// Centre (distance from axis, height) and radius of the circle that bounds the tip's reach.
    #[must_use]
    pub fn reach_m(&self) -> ((f64, f64), f64) {
        let centre = (-self.wrist_from_tip_m.0, self.shoulder_height_m - self.wrist_from_tip_m.1);
        (centre, (self.upper_arm_m + self.forearm_m) * STRETCH_MAX)
    }

    /// The posture whose tip is at a point of the manifold; None when the links do not reach.
    #[must_use]
    pub fn posture(&self, manifold: &Manifold, point: OnManifold) -> Option<Posture> {
        self.posture_above(manifold, point, 0.0)
    }

    /// The posture whose tip is straight above a point of the manifold, or of its rim carried on beyond its end, by
    /// `lift_m`; None when the links do not reach.
    #[must_use]
    pub fn posture_above(&self, manifold: &Manifold, point: OnManifold, lift_m: f64) -> Option<Posture> {
        let (tip_out, tip_up) = manifold.profile(point.arc_m);
        let tip_up = tip_up + lift_m;
        let wrist = (tip_out + self.wrist_from_tip_m.0, tip_up + self.wrist_from_tip_m.1);
        let (out, up) = (wrist.0, wrist.1 - self.shoulder_height_m);
        let distance = (out * out + up * up).sqrt();
        let (a, b) = (self.upper_arm_m, self.forearm_m);
        if distance > a + b || distance < (a - b).abs() || distance <= 0.0 {
            return None;
        }
        // The elbow lies off the line from shoulder to wrist, on its lower, near side.
        let along = (a * a - b * b + distance * distance) / (2.0 * distance);
        let off = (a * a - along * along).max(0.0).sqrt();
        let (line_out, line_up) = (out / distance, up / distance);
        let (side_out, side_up) = (line_up, -line_out);
        let elbow = (line_out * along + side_out * off, line_up * along + side_up * off);

        let (sine, cosine) = libm::sincos(point.bearing_rad);
        let in_world = |out_m: f64, up_m: f64| Point3::new(out_m * sine, out_m * cosine, up_m);
        let (half_sine, half_cosine) = libm::sincos(-point.bearing_rad / 2.0);
        let shoulder_rad = libm::atan2(elbow.1, elbow.0);
        let forearm_rad = libm::atan2(up - elbow.1, out - elbow.0);
        let finger_rad = libm::atan2(-self.wrist_from_tip_m.1, -self.wrist_from_tip_m.0);
        Some(Posture {
            shoulder_m: in_world(0.0, self.shoulder_height_m),
            elbow_m: in_world(elbow.0, elbow.1 + self.shoulder_height_m),
            wrist_m: in_world(wrist.0, wrist.1),
            tip_m: in_world(tip_out, tip_up),
            finger_turn: UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(
                half_cosine,
                0.0,
                0.0,
                half_sine,
            )),
            angles_rad: [
                point.bearing_rad,
                shoulder_rad,
                wrapped(forearm_rad - shoulder_rad),
                wrapped(finger_rad - forearm_rad),
            ],
        })
    }

    /// The posture of an arm with these joint angles (yaw, shoulder, elbow, wrist, in radians), on the manifold or off
    /// it, above the table or below it. The inverse of [`Self::posture`].
    #[must_use]
    pub fn posture_of(&self, angles_rad: [f64; 4]) -> Posture {
        let [yaw_rad, shoulder_rad, elbow_rad, wrist_rad] = angles_rad;
        let (sine, cosine) = libm::sincos(yaw_rad);
        let in_world = |(out_m, up_m): (f64, f64)| Point3::new(out_m * sine, out_m * cosine, up_m);
        let further = |(out_m, up_m): (f64, f64), angle_rad: f64, length_m: f64| {
            let (sine, cosine) = libm::sincos(angle_rad);
            (out_m + length_m * cosine, up_m + length_m * sine)
        };
        let shoulder = (0.0, self.shoulder_height_m);
        let elbow = further(shoulder, shoulder_rad, self.upper_arm_m);
        let wrist = further(elbow, shoulder_rad + elbow_rad, self.forearm_m);
        let (back_m, up_m) = self.wrist_from_tip_m;
        let finger_rad = shoulder_rad + elbow_rad + wrist_rad;
        let tip = further(wrist, finger_rad, (back_m * back_m + up_m * up_m).sqrt());
        // A finger that leans as on the manifold is turned about the vertical alone.
        let lean_rad = finger_rad - libm::atan2(-up_m, -back_m);
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -yaw_rad)
            * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), lean_rad);
        let [shoulder_m, elbow_m, wrist_m, tip_m] = [shoulder, elbow, wrist, tip].map(in_world);
        Posture { shoulder_m, elbow_m, wrist_m, tip_m, finger_turn: turn, angles_rad }
    }

    /// The posture at a waypoint; None where there is none.
    #[must_use]
    pub fn posture_by(&self, manifold: &Manifold, point: Waypoint) -> Option<Posture> {
        self.posture_above(manifold, manifold.at(point.joints)?, point.lift_m)
    }

    /// The motion straight from one waypoint to another. None when some of the way cannot be taken.
    #[must_use]
    pub fn motion(&self, manifold: &Manifold, from: Waypoint, to: Waypoint) -> Option<Motion> {
        let mut motion = Motion { from, to, duration_s: 1.0 };
        let mut before = self.posture_by(manifold, from)?;
        // The highest speeds of the motion, if it took one second, as multiples of their limits.
        let mut excess: f64 = DURATION_S_MIN;
        for sample in 1..=SPEED_SAMPLES {
            let here = self.posture_by(manifold, motion.at(sample as f64 / SPEED_SAMPLES as f64))?;
            for (now, then) in here.angles_rad.iter().zip(before.angles_rad) {
                excess = excess.max(wrapped(now - then).abs() * SPEED_SAMPLES as f64 / self.joint_speed_max);
            }
            let tip_m = (here.tip_m - before.tip_m).norm();
            excess = excess.max(tip_m * SPEED_SAMPLES as f64 / self.tip_speed_max);
            before = here;
        }
        motion.duration_s = excess;
        Some(motion)
    }
}

/// A straight part of a move. It is straight in joint positions and in height over the manifold, never in joint angles,
/// so that the points that it passes are known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// The point where the motion begins.
    pub from: Waypoint,
    /// The point where it ends.
    pub to: Waypoint,
    /// How long it takes, in seconds.
    pub duration_s: f64,
}

impl Motion {
    /// The point that is reached `time_s` after the start: a minimum-jerk profile (Flash and Hogan 1985).
    #[must_use]
    pub fn at(&self, time_s: f64) -> Waypoint {
        self.along(Self::share(time_s / self.duration_s))
    }

    /// The share of the way that is gone after a share of the time.
    #[must_use]
    pub fn share(time: f64) -> f64 {
        let t = time.clamp(0.0, 1.0);
        t * t * t * (10.0 + t * (6.0 * t - 15.0))
    }

    /// The point at a share of the way, 0 to 1.
    #[must_use]
    pub fn along(&self, share: f64) -> Waypoint {
        let between = |from: f64, to: f64| if share >= 1.0 { to } else { from + (to - from) * share };
        let (from, to) = (&self.from, &self.to);
        Waypoint {
            joints: JointPositions {
                j1: between(from.joints.j1, to.joints.j1),
                j2: between(from.joints.j2, to.joints.j2),
            },
            lift_m: between(from.lift_m, to.lift_m),
        }
    }

    /// Length of the way in metres, along the manifold and up.
    #[must_use]
    pub fn way_m(&self, manifold: &Manifold) -> f64 {
        let (from, to) = (manifold.square.at_m(self.from.joints), manifold.square.at_m(self.to.joints));
        Vector3::new(to.0 - from.0, to.1 - from.1, self.to.lift_m - self.from.lift_m).norm()
    }
}

/// An angle within half a turn of zero.
fn wrapped(angle_rad: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    angle_rad - turn * (angle_rad / turn).round()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::WorldFile;
    use crate::manifold::ManifoldSetup;

    fn arm_and_manifold() -> (Kinematics, Manifold) {
        let file = WorldFile::load("wide").unwrap();
        let arm = Kinematics::new(&file.arm);
        let (reach_centre_m, reach_radius_m) = arm.reach_m();
        let manifold = Manifold::new(ManifoldSetup {
            tip_height_m: file.manifold.tip_height_mm.metres(),
            rim_height_m: file.manifold.rim_height_mm.metres(),
            nearest_m: file.manifold.nearest_mm.metres(),
            rest_m: file.manifold.rest_mm.metres(),
            lateral_max_m: file.manifold.lateral_max_mm.metres(),
            reach_centre_m,
            reach_radius_m,
        });
        (arm, manifold.unwrap())
    }

    #[test]
    fn links_keep_their_lengths_and_stay_above_the_table() {
        let (arm, manifold) = arm_and_manifold();
        for j1 in (0..=100).map(|i| f64::from(i) / 100.0) {
            for j2 in (0..=100).map(|i| f64::from(i) / 100.0) {
                let Some(point) = manifold.at(JointPositions { j1, j2 }) else { continue };
                let posture = arm.posture(&manifold, point).expect("the whole manifold is within reach");
                assert!(((posture.elbow_m - posture.shoulder_m).norm() - arm.upper_arm_m).abs() < 1e-9);
                assert!(((posture.wrist_m - posture.elbow_m).norm() - arm.forearm_m).abs() < 1e-9);
                assert!((posture.tip_m - manifold.tip(point)).norm() < 1e-9);
                let finger = posture.finger_turn * arm.wrist_from_tip();
                assert!((posture.tip_m + finger - posture.wrist_m).norm() < 1e-9);
                assert!(posture.elbow_m.z > 0.1, "elbow at {} m", posture.elbow_m.z);
            }
        }
    }

    #[test]
    fn joint_angles_are_the_posture_that_they_were_worked_out_for() {
        let (arm, manifold) = arm_and_manifold();
        for (j1, j2) in [(0.5, 0.0), (0.1, 0.4), (0.9, 0.2), (0.4, 0.9)] {
            let at = Waypoint { joints: JointPositions { j1, j2 }, lift_m: 0.03 };
            let Some(posture) = arm.posture_by(&manifold, at) else { panic!("{at:?} is within reach") };
            let again = arm.posture_of(posture.angles_rad);
            for (point, other) in [
                (posture.shoulder_m, again.shoulder_m),
                (posture.elbow_m, again.elbow_m),
                (posture.wrist_m, again.wrist_m),
                (posture.tip_m, again.tip_m),
            ] {
                assert!((point - other).norm() < 1e-9, "{posture:?} is not {again:?}");
            }
            assert!(posture.finger_turn.angle_to(&again.finger_turn) < 1e-9);
        }
    }

    #[test]
    fn motion_ends_exactly_where_it_should_and_keeps_speed_limits() {
        let (arm, manifold) = arm_and_manifold();
        let from = Waypoint { joints: manifold.rest(), lift_m: 0.0 };
        let to = Waypoint { joints: JointPositions { j1: 0.13, j2: 0.31 }, lift_m: 0.04 };
        let motion = arm.motion(&manifold, from, to).unwrap();
        assert_eq!(motion.at(0.0), from);
        assert_eq!(motion.at(motion.duration_s), to);
        let dt = 1.0 / 240.0;
        let steps = (motion.duration_s / dt) as usize;
        for step in 0..steps {
            let at = |s: usize| arm.posture_by(&manifold, motion.at(s as f64 * dt)).unwrap();
            let (a, b) = (at(step), at(step + 1));
            assert!((b.tip_m - a.tip_m).norm() / dt < arm.tip_speed_max * 1.01);
            for (x, y) in a.angles_rad.iter().zip(b.angles_rad) {
                assert!(wrapped(y - x).abs() / dt < arm.joint_speed_max * 1.01);
            }
        }
    }
}
