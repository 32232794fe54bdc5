//! The way a move takes from one posture to the next: away from the object that was touched, over the objects on the
//! table, down beside the goal, and up to the goal along the manifold.
//!
//! Arms that are programmed in V+ do so with `DEPART` and `APPRO`. A finger that slid all the way would sweep the table
//! clear: each object in its way would stop it short and be pushed on, move after move.

use crate::square::{JointPositions, Square};

/// How far the finger draws back from an object that it may be touching while it is lifted, in metres.
const WITHDRAWAL_M: f64 = 0.010;

/// A point that the finger passes: on the manifold, or straight above it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waypoint {
    /// The joint positions of the point of the manifold.
    pub joints: JointPositions,
    /// Height above that point, in metres.
    pub lift_m: f64,
}

/// A direction on the square that the joint positions span, which over the flat part of the manifold is a
/// direction on the table: across (+x) and outwards (+y), of length one.
pub type Heading = (f64, f64);

/// Straight ahead, away from the base: how the finger stands at rest.
pub const OUTWARDS: Heading = (0.0, 1.0);

/// The lengths that decide how moves go, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RouteSetup {
    /// How high over the manifold the finger is carried; 0: it slides along the manifold all the way.
    pub lift_m: f64,
    /// How far before its goal the finger is set down.
    pub approach_m: f64,
}

/// The points to pass on the way from `from`, reached with `heading`, to the posture `to`, itself the last.
/// Between them the finger goes straight.
#[must_use]
pub fn route(
    setup: RouteSetup,
    square: &Square,
    from: Waypoint,
    heading: Heading,
    to: JointPositions,
) -> Vec<Waypoint> {
    let goal = Waypoint { joints: to, lift_m: 0.0 };
    if setup.lift_m <= 0.0 {
        return vec![goal];
    }
    let set_down = set_down(setup, square, to);
    let mut points = carried(setup, square, from, heading, set_down);
    points.extend([Waypoint { joints: set_down, lift_m: 0.0 }, goal]);
    points
}

/// The points of the way through the air to a point above `to`.
#[must_use]
pub fn carried(
    setup: RouteSetup,
    square: &Square,
    from: Waypoint,
    heading: Heading,
    to: JointPositions,
) -> Vec<Waypoint> {
    let lift_m = setup.lift_m.max(from.lift_m);
    let departed = shifted(square, from.joints, heading, -WITHDRAWAL_M);
    vec![Waypoint { joints: departed, lift_m }, Waypoint { joints: to, lift_m }]
}

/// Where the finger is set down for a goal: before it, seen from the base, but not behind the rest posture.
fn set_down(setup: RouteSetup, square: &Square, to: JointPositions) -> JointPositions {
    let (across_m, outwards_m) = square.at_m(to);
    let arc_m = (across_m * across_m + outwards_m * outwards_m).sqrt();
    let before_m = setup.approach_m.min(arc_m - square.rest_m).max(0.0);
    let (sine, cosine) = libm::sincos(libm::atan2(across_m, outwards_m));
    square.joints(((arc_m - before_m) * sine, (arc_m - before_m) * cosine))
}

/// Joint positions some way along a heading.
fn shifted(square: &Square, joints: JointPositions, heading: Heading, way_m: f64) -> JointPositions {
    let (across_m, outwards_m) = square.at_m(joints);
    square.joints((across_m + heading.0 * way_m, outwards_m + heading.1 * way_m))
}

/// The heading from one posture to another; None when they are the same.
#[must_use]
pub fn heading(square: &Square, from: JointPositions, to: JointPositions) -> Option<Heading> {
    let (from, to) = (square.at_m(from), square.at_m(to));
    let (across_m, outwards_m) = (to.0 - from.0, to.1 - from.1);
    let way_m = (across_m * across_m + outwards_m * outwards_m).sqrt();
    (way_m > 1e-6).then(|| (across_m / way_m, outwards_m / way_m))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETUP: RouteSetup = RouteSetup { lift_m: 0.05, approach_m: 0.03 };
    const SQUARE: Square = Square { across_m: 1.6, nearest_m: 0.12, outwards_m: 0.7, rest_m: 0.06 };
    const REST: JointPositions = JointPositions { j1: 0.5, j2: -0.06 / 0.7 };

    #[test]
    fn a_move_draws_back_goes_over_and_comes_up_to_its_goal_from_the_near_side() {
        let from = Waypoint { joints: SQUARE.joints((0.1, 0.3)), lift_m: 0.0 };
        let points = route(SETUP, &SQUARE, from, OUTWARDS, SQUARE.joints((-0.3, 0.4)));
        let expected = [(0.1, 0.29, 0.05), (-0.282, 0.376, 0.05), (-0.282, 0.376, 0.0), (-0.3, 0.4, 0.0)];
        assert_eq!(points.len(), expected.len());
        for (point, wanted) in points.iter().zip(expected) {
            let (x_m, y_m) = SQUARE.at_m(point.joints);
            let off = (x_m - wanted.0).abs() + (y_m - wanted.1).abs() + (point.lift_m - wanted.2).abs();
            assert!(off < 1e-9, "{point:?} instead of {wanted:?}");
        }
    }

    #[test]
    fn without_lift_it_slides() {
        let from = Waypoint { joints: REST, lift_m: 0.0 };
        let to = SQUARE.joints((0.2, 0.5));
        let setup = RouteSetup { lift_m: 0.0, approach_m: 0.03 };
        assert_eq!(route(setup, &SQUARE, from, OUTWARDS, to), [Waypoint { joints: to, lift_m: 0.0 }]);
    }

    #[test]
    fn nothing_is_set_down_behind_the_rest_posture() {
        let from = Waypoint { joints: REST, lift_m: 0.0 };
        let points = route(SETUP, &SQUARE, from, OUTWARDS, SQUARE.joints((0.0, SQUARE.rest_m + 0.01)));
        let set_down_m = SQUARE.at_m(points[2].joints).1;
        assert!((set_down_m - SQUARE.rest_m).abs() < 1e-9, "{set_down_m}");
    }
}
