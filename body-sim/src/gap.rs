//! How far the finger is from an object: exact distances between its parts and cubes or balls.
//!
//! The physics engine's own query (parry's `contact`) now and then reports millimetres of overlap between a
//! capsule and a cube that are apart, which would stop the arm for nothing.

use nalgebra::{Isometry3, Point3, Vector3};

/// Narrowing steps of the search along the shaft: to a millionth of its length.
const SEARCH_STEPS: usize = 34;

/// Form of an object, by half its width in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// A cube, by half its edge.
    Cube(f64),
    /// A ball, by its radius.
    Ball(f64),
}

impl Form {
    /// Half the object's width, and so the height of its centre when it stands, in metres.
    #[must_use]
    pub fn half_m(self) -> f64 {
        match self {
            Self::Cube(half_m) | Self::Ball(half_m) => half_m,
        }
    }

    /// How far a standing object reaches sideways from its centre, however it is turned, in metres.
    #[must_use]
    pub fn reach_m(self) -> f64 {
        match self {
            Self::Cube(half_m) => half_m * std::f64::consts::SQRT_2,
            Self::Ball(radius_m) => radius_m,
        }
    }

    /// Distance of a point from the surface, negative inside, and the direction from the surface to the point;
    /// in the object's own frame.
    fn distance_m(self, point: &Vector3<f64>) -> (f64, Vector3<f64>) {
        match self {
            Self::Ball(radius_m) => {
                let distance_m = point.norm();
                let outwards = point.try_normalize(1e-12).unwrap_or_else(Vector3::z);
                (distance_m - radius_m, outwards)
            }
            Self::Cube(half_m) => {
                let beyond = point.abs() - Vector3::repeat(half_m);
                let outside = beyond.map(|x| x.max(0.0));
                if let Some((direction, distance_m)) = nalgebra::Unit::try_new_and_get(outside, 1e-12)
                    .map(|(unit, norm)| (unit.into_inner(), norm))
                {
                    return (distance_m, direction.zip_map(point, f64::copysign));
                }
                // Inside: out through the nearest face.
                let axis = beyond.imax();
                let mut direction = Vector3::zeros();
                direction[axis] = 1.0_f64.copysign(point[axis]);
                (beyond[axis], direction)
            }
        }
    }
}

/// Whether a capsule and an object may be as near as `within_m`. The answer comes quickly, from the ball around the
/// object, and is nearly always no.
#[must_use]
pub fn near(
    (from, to, radius_m): (Point3<f64>, Point3<f64>, f64),
    object: &Point3<f64>,
    form: Form,
    within_m: f64,
) -> bool {
    let (axis, off) = (to - from, object - from);
    let share = off.dot(&axis) / axis.norm_squared().max(1e-12);
    let apart_m = (off - axis * share.clamp(0.0, 1.0)).norm();
    // A cube's half diagonal is the square root of 3 times its half edge.
    apart_m <= radius_m + form.half_m() * 1.733 + within_m
}

/// Distance in metres between an object and a capsule from `from` to `to`, which is a ball when the two are one.
/// Negative when object and capsule overlap. With the distance comes the direction from the capsule to the object, a
/// unit vector.
#[must_use]
pub fn gap(
    (from, to, radius_m): (Point3<f64>, Point3<f64>, f64),
    object: &Isometry3<f64>,
    form: Form,
) -> (f64, Vector3<f64>) {
    let (from, to) =
        (object.inverse_transform_point(&from).coords, object.inverse_transform_point(&to).coords);
    let at = |share: f64| form.distance_m(&(from + (to - from) * share));
    // The distance from a convex body is convex along a line: it has one valley.
    let (mut low, mut high) = (0.0, 1.0);
    if from != to {
        for _ in 0..SEARCH_STEPS {
            let (first, second) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if at(first).0 <= at(second).0 { high = second } else { low = first }
        }
    }
    // The low end of the search: where all distances are equal it is the tip.
    let (distance_m, outwards) = at(low);
    (distance_m - radius_m, -(object.rotation * outwards))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ball_at(x: f64, y: f64, z: f64) -> (Point3<f64>, Point3<f64>, f64) {
        (Point3::new(x, y, z), Point3::new(x, y, z), 0.008)
    }

    fn close(found: (f64, Vector3<f64>), distance_m: f64, direction: Vector3<f64>) {
        assert!((found.0 - distance_m).abs() < 1e-6, "{} instead of {distance_m}", found.0);
        assert!((found.1 - direction).norm() < 1e-4, "{} instead of {direction}", found.1);
    }

    #[test]
    fn a_ball_beside_a_cube_by_face_edge_and_from_within() {
        let cube = Form::Cube(0.0125);
        let here = Isometry3::identity();
        close(gap(ball_at(0.0, -0.0225, 0.003), &here, cube), 0.002, Vector3::y());
        let edge = 0.0125 + 0.01;
        let expected = 0.01 * 2.0_f64.sqrt() - 0.008;
        close(
            gap(ball_at(edge, edge, 0.0), &here, cube),
            expected,
            Vector3::new(-1.0, -1.0, 0.0).normalize(),
        );
        close(gap(ball_at(0.0, 0.0, 0.0115), &here, cube), -0.009, -Vector3::z());
    }

    #[test]
    fn a_ball_beside_a_ball() {
        let there = Isometry3::translation(0.1, 0.0, 0.0);
        close(gap(ball_at(0.07, 0.0, 0.0), &there, Form::Ball(0.02)), 0.002, Vector3::x());
    }

    /// The engine's query said 7 mm of overlap here, and the arm was stuck beside the block for ever.
    #[test]
    fn a_shaft_that_leans_away_from_a_block_is_apart_from_it() {
        let (sine, cosine) = libm::sincos(35.0_f64.to_radians());
        let tip = Point3::new(-0.1686, 0.3963, 0.0148);
        let shaft = (tip, tip + Vector3::new(0.0, -sine, cosine) * 0.14, 0.003);
        let block = Isometry3::translation(-0.17835, 0.41809, 0.01246);
        let (distance_m, direction) = gap(shaft, &block, Form::Cube(0.0125));
        assert!((0.005..0.008).contains(&distance_m), "{distance_m}");
        assert!(direction.y > 0.9, "{direction}");
    }

    /// Against the plainest method there is: many points along the axis.
    #[test]
    fn agrees_with_sampling() {
        let mut state = 3_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / (1_u64 << 31) as f64 - 0.5
        };
        for _ in 0..300 {
            let mut point = || Point3::new(random(), random(), random()) * 0.2;
            let (from, to) = (point(), point());
            let turn = point().coords * 10.0;
            let object = Isometry3::new(Vector3::zeros(), turn);
            for form in [Form::Cube(0.02), Form::Ball(0.03)] {
                let found = gap((from, to, 0.0), &object, form).0;
                let sampled = (0..=2000)
                    .map(|step| {
                        let at = from + (to - from) * (f64::from(step) / 2000.0);
                        gap((at, at, 0.0), &object, form).0
                    })
                    .fold(f64::INFINITY, f64::min);
                let ((centre, within_m), capsule) =
                    ((Point3::from(object.translation.vector), 0.03), (from, to, 0.0));
                assert!(found > within_m || near(capsule, &centre, form, within_m), "{found}");
                assert!(found <= sampled + 1e-6 && found >= sampled - 1e-4, "{found} {sampled}");
            }
        }
    }
}
