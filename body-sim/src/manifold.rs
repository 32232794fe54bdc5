//! The two-dimensional manifold that the finger tip works on (section III-A of the paper): flat above the
//! table, curving up at the outer limit of reach, so that the raised finger points at objects beyond it.
//!
//! It is a surface of revolution about the base's axis. A point on it has a bearing (from straight ahead to
//! the right) and an arc length along the profile (outwards over the table, then up the rim). The two joint
//! positions that command the arm are fractions of a square laid over it: with arc length as distance and
//! bearing as direction from the base, `j1` runs across and `j2` outwards. A straight line from the rest
//! posture in these coordinates approaches every place from its near side.

use nalgebra::Point3;
use pschema_arm::{JointPositions, Square};
use pschema_vision::camera::Camera;

/// Bisection steps: enough to use up a f64.
const BISECTIONS: usize = 60;

/// A point on the manifold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnManifold {
    /// Direction from the base's axis: 0 straight ahead (+y), positive to the right (+x).
    pub bearing_rad: f64,
    /// Distance along the profile from the base's axis.
    pub arc_m: f64,
}

/// The manifold's shape, all lengths in metres.
#[derive(Clone, Debug, PartialEq)]
pub struct Manifold {
    /// Height of the tip over the table on the flat part.
    pub tip_height_m: f64,
    /// Distance from the axis at which the flat part ends.
    pub flat_reach_m: f64,
    /// Arc length at which the rim ends.
    pub arc_max_m: f64,
    /// The square that the joint positions span, laid over the manifold.
    pub square: Square,
    /// Centre of the circle of reach in the arm's plane: distance from the axis, height.
    reach_centre_m: (f64, f64),
    /// Radius of the circle of reach.
    reach_radius_m: f64,
    /// Angle on that circle at which the rim begins.
    rim_from_rad: f64,
    /// Angle at which it ends.
    rim_to_rad: f64,
}

/// The lengths that a manifold is made from, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ManifoldSetup {
    /// Height of the tip on the flat part.
    pub tip_height_m: f64,
    /// Height at which the rim ends.
    pub rim_height_m: f64,
    /// Distance straight ahead at which `j2` is 0.
    pub nearest_m: f64,
    /// Distance of the rest posture, at most `nearest_m`.
    pub rest_m: f64,
    /// Range of `j1`, either way.
    pub lateral_max_m: f64,
    /// Centre of the circle that bounds the tip's reach in the arm's plane: distance from axis, height.
    pub reach_centre_m: (f64, f64),
    /// Radius of that circle.
    pub reach_radius_m: f64,
}

impl Manifold {
    /// Lays the manifold into the arm's reach.
    ///
    /// # Errors
    /// When there is no room for it; the message has the figures.
    pub fn new(setup: ManifoldSetup) -> Result<Self, String> {
        let ManifoldSetup { tip_height_m, rim_height_m, reach_centre_m, reach_radius_m, .. } = setup;
        let (centre_m, centre_height_m) = reach_centre_m;
        let sine = |height_m: f64| (height_m - centre_height_m) / reach_radius_m;
        if rim_height_m <= tip_height_m || sine(tip_height_m) <= -1.0 || sine(rim_height_m) >= 1.0 {
            return Err(format!(
                "the rim should rise from {:.0} mm (manifold.tip_height_mm) to {:.0} mm (manifold.rim_height_mm), but \
                 the arm reaches heights of {:.0} to {:.0} mm; change these heights or the arm's lengths",
                tip_height_m * 1e3,
                rim_height_m * 1e3,
                (centre_height_m - reach_radius_m) * 1e3,
                (centre_height_m + reach_radius_m) * 1e3,
            ));
        }
        let (rim_from_rad, rim_to_rad) = (libm::asin(sine(tip_height_m)), libm::asin(sine(rim_height_m)));
        let flat_reach_m = centre_m + reach_radius_m * libm::cos(rim_from_rad);
        if setup.rest_m > setup.nearest_m {
            return Err("manifold.rest_mm must be at most manifold.nearest_mm".into());
        }
        if flat_reach_m <= setup.nearest_m {
            return Err(format!(
                "the arm reaches {:.0} mm over the table, not beyond manifold.nearest_mm; lengthen the arm",
                flat_reach_m * 1e3
            ));
        }
        let arc_max_m = flat_reach_m + reach_radius_m * (rim_to_rad - rim_from_rad);
        let square = Square {
            across_m: 2.0 * setup.lateral_max_m,
            nearest_m: setup.nearest_m,
            outwards_m: arc_max_m - setup.nearest_m,
            rest_m: setup.rest_m,
        };
        Ok(Self {
            tip_height_m,
            flat_reach_m,
            arc_max_m,
            square,
            reach_centre_m,
            reach_radius_m,
            rim_from_rad,
            rim_to_rad,
        })
    }

    /// The point that joint positions command. None where the square sticks out over the end of the rim.
    #[must_use]
    pub fn at(&self, joints: JointPositions) -> Option<OnManifold> {
        let (across_m, outwards_m) = self.square.at_m(joints);
        let arc_m = (across_m * across_m + outwards_m * outwards_m).sqrt();
        let inside = arc_m <= self.arc_max_m + 1e-9;
        inside.then(|| OnManifold { bearing_rad: libm::atan2(across_m, outwards_m), arc_m })
    }

    /// The joint positions that command a point. They are outside 0 to 1 when the square does not cover the point.
    #[must_use]
    pub fn joints(&self, point: OnManifold) -> JointPositions {
        let (sine, cosine) = libm::sincos(point.bearing_rad);
        self.square.joints((point.arc_m * sine, point.arc_m * cosine))
    }

    /// The rest posture, a little before the range of `j2`.
    #[must_use]
    pub fn rest(&self) -> JointPositions {
        self.joints(OnManifold { bearing_rad: 0.0, arc_m: self.square.rest_m })
    }

    /// The profile: distance from the axis and height at an arc length.
    #[must_use]
    pub fn profile(&self, arc_m: f64) -> (f64, f64) {
        if arc_m <= self.flat_reach_m {
            return (arc_m, self.tip_height_m);
        }
        let angle = self.rim_from_rad + (arc_m - self.flat_reach_m) / self.reach_radius_m;
        let (sine, cosine) = libm::sincos(angle);
        (
            self.reach_centre_m.0 + self.reach_radius_m * cosine,
            self.reach_centre_m.1 + self.reach_radius_m * sine,
        )
    }

    /// The position of a point of the manifold in the world.
    #[must_use]
    pub fn tip(&self, point: OnManifold) -> Point3<f64> {
        let (radius_m, height_m) = self.profile(point.arc_m);
        let (sine, cosine) = libm::sincos(point.bearing_rad);
        Point3::new(radius_m * sine, radius_m * cosine, height_m)
    }

    /// The point of the manifold that the camera sees at picture position (u, v): on the flat part where
    /// the line of sight meets it, else on the rim. None when it passes the end of the rim.
    #[must_use]
    pub fn seen_at(&self, camera: &Camera, u: f64, v: f64) -> Option<OnManifold> {
        let flat = camera.on_plane(u, v, self.tip_height_m)?;
        let radius_m = (flat.x * flat.x + flat.y * flat.y).sqrt();
        if radius_m <= self.flat_reach_m {
            return Some(OnManifold { bearing_rad: libm::atan2(flat.x, flat.y), arc_m: radius_m });
        }
        // How far outside the rim the line of sight passes, at an angle up the rim: positive at its foot.
        let outside = |angle: f64| {
            let (sine, cosine) = libm::sincos(angle);
            let height_m = self.reach_centre_m.1 + self.reach_radius_m * sine;
            let rim_m = self.reach_centre_m.0 + self.reach_radius_m * cosine;
            camera.on_plane(u, v, height_m).map(|p| ((p.x * p.x + p.y * p.y).sqrt() - rim_m, p))
        };
        let (mut low, mut high) = (self.rim_from_rad, self.rim_to_rad);
        if outside(high)?.0 > 0.0 {
            return None;
        }
        for _ in 0..BISECTIONS {
            let middle = (low + high) / 2.0;
            if outside(middle)?.0 > 0.0 { low = middle } else { high = middle }
        }
        let (_, point) = outside(high)?;
        let arc_m = self.flat_reach_m + (high - self.rim_from_rad) * self.reach_radius_m;
        Some(OnManifold { bearing_rad: libm::atan2(point.x, point.y), arc_m })
    }

    /// Whether a point is on the flat part, at table height.
    #[must_use]
    pub fn is_flat(&self, point: OnManifold) -> bool {
        point.arc_m <= self.flat_reach_m
    }

    /// Height of the tip where the profile is `radius_m` from the axis; None beyond the rim's end.
    #[must_use]
    pub fn height_at(&self, radius_m: f64) -> Option<f64> {
        if radius_m <= self.flat_reach_m {
            return Some(self.tip_height_m);
        }
        let cosine = (radius_m - self.reach_centre_m.0) / self.reach_radius_m;
        let angle = -libm::acos(cosine.min(1.0));
        (cosine <= 1.0 && angle <= self.rim_to_rad)
            .then(|| self.reach_centre_m.1 + self.reach_radius_m * libm::sin(angle))
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use nalgebra::Point3;
    use pschema_vision::camera::CameraSetup;

    pub(crate) fn manifold() -> Manifold {
        Manifold::new(ManifoldSetup {
            tip_height_m: 0.012,
            rim_height_m: 0.2,
            nearest_m: 0.12,
            rest_m: 0.06,
            lateral_max_m: 0.8,
            reach_centre_m: (0.08, 0.435),
            reach_radius_m: 0.746,
        })
        .unwrap()
    }

    #[test]
    fn the_profile_is_continuous_and_rises_only_at_the_rim() {
        let manifold = manifold();
        let steps = 2000;
        let mut before = manifold.profile(manifold.square.nearest_m);
        for step in 1..=steps {
            let arc_m = manifold.square.nearest_m
                + (manifold.arc_max_m - manifold.square.nearest_m) * f64::from(step) / f64::from(steps);
            let here = manifold.profile(arc_m);
            let moved = ((here.0 - before.0).powi(2) + (here.1 - before.1).powi(2)).sqrt();
            assert!(
                (moved - (manifold.arc_max_m - manifold.square.nearest_m) / f64::from(steps)).abs() < 1e-4
            );
            assert!(here.1 >= before.1 - 1e-12 && here.0 > before.0);
            assert!((manifold.height_at(here.0).unwrap() - here.1).abs() < 1e-6);
            before = here;
        }
        assert!((before.1 - 0.2).abs() < 1e-9);
        assert_eq!(manifold.height_at(before.0 + 1e-3), None);
    }

    #[test]
    fn joint_positions_and_points_are_inverse() {
        let manifold = manifold();
        for (j1, j2) in [(0.5, 0.0), (0.43, 0.84), (0.1, 0.3), (0.9, 0.1)] {
            let there = manifold.at(JointPositions { j1, j2 }).unwrap();
            let back = manifold.joints(there);
            assert!((back.j1 - j1).abs() < 1e-12 && (back.j2 - j2).abs() < 1e-12);
        }
        assert_eq!(manifold.at(JointPositions { j1: 1.0, j2: 1.0 }), None, "a corner beyond the rim");
    }

    #[test]
    fn what_is_seen_at_a_place_projects_back_to_it() {
        let manifold = manifold();
        let camera = Camera::new(CameraSetup {
            position_m: Point3::new(0.0, 0.585, 1.2),
            pan_rad: 0.0,
            tilt_rad: 0.0,
            focal_px: 800.0,
            width_px: 780,
            height_px: 580,
        })
        .unwrap();
        let (mut flat, mut rim) = (0, 0);
        for v in (5..580).step_by(25) {
            for u in (5..780).step_by(25) {
                let (u, v) = (f64::from(u), f64::from(v));
                let Some(point) = manifold.seen_at(&camera, u, v) else { continue };
                let (u2, v2) = camera.project(&manifold.tip(point)).unwrap();
                assert!((u - u2).abs() < 1e-6 && (v - v2).abs() < 1e-6, "({u}, {v}) -> ({u2}, {v2})");
                if manifold.is_flat(point) { flat += 1 } else { rim += 1 }
            }
        }
        assert!(flat > 200 && rim > 20, "{flat} {rim}");
    }
}
