//! The way a move takes from one posture to the next: away from what was touched, over what stands on the
//! table, down beside the goal and up to it along the manifold.
//!
//! Arms that are programmed in V+ do so with `DEPART` and `APPRO`. A finger that slid all the way would sweep
//! the table clear: what it meets would stop it short and be pushed on, move after move.

use crate::manifold::{JointPositions, Manifold};

/// How far the finger draws back from what it may be touching while it is lifted, in metres.
const WITHDRAWAL_M: f64 = 0.010;

/// The square that the joint positions span, in metres across and outwards from the base's axis: of the simulated
/// arm's manifold, or as taught to a real arm.
pub trait Square {
    /// Where joint positions are on it.
    fn square_m(&self, joints: JointPositions) -> (f64, f64);
    /// The joint positions at a place on it.
    fn joints_on_square(&self, place_m: (f64, f64)) -> JointPositions;
    /// How far the rest posture is from the base's axis.
    fn rest_m(&self) -> f64;
}

impl Square for Manifold {
    fn square_m(&self, joints: JointPositions) -> (f64, f64) {
        self.square_m(joints)
    }

    fn joints_on_square(&self, place_m: (f64, f64)) -> JointPositions {
        self.joints_on_square(place_m)
    }

    fn rest_m(&self) -> f64 {
        self.rest_m
    }
}

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

/// What decides how moves go, in metres.
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
    square: &impl Square,
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
    square: &impl Square,
    from: Waypoint,
    heading: Heading,
    to: JointPositions,
) -> Vec<Waypoint> {
    let lift_m = setup.lift_m.max(from.lift_m);
    let departed = shifted(square, from.joints, heading, -WITHDRAWAL_M);
    vec![Waypoint { joints: departed, lift_m }, Waypoint { joints: to, lift_m }]
}

/// Where the finger is set down for a goal: before it, seen from the base, but not behind the rest posture.
fn set_down(setup: RouteSetup, square: &impl Square, to: JointPositions) -> JointPositions {
    let (across_m, outwards_m) = square.square_m(to);
    let arc_m = (across_m * across_m + outwards_m * outwards_m).sqrt();
    let before_m = setup.approach_m.min(arc_m - square.rest_m()).max(0.0);
    let (sine, cosine) = libm::sincos(libm::atan2(across_m, outwards_m));
    square.joints_on_square(((arc_m - before_m) * sine, (arc_m - before_m) * cosine))
}

/// Joint positions some way along a heading.
fn shifted(square: &impl Square, joints: JointPositions, heading: Heading, way_m: f64) -> JointPositions {
    let (across_m, outwards_m) = square.square_m(joints);
    square.joints_on_square((across_m + heading.0 * way_m, outwards_m + heading.1 * way_m))
}

/// The heading from one posture to another; None when they are the same.
#[must_use]
pub fn heading(square: &impl Square, from: JointPositions, to: JointPositions) -> Option<Heading> {
    let (from, to) = (square.square_m(from), square.square_m(to));
    let (across_m, outwards_m) = (to.0 - from.0, to.1 - from.1);
    let way_m = (across_m * across_m + outwards_m * outwards_m).sqrt();
    (way_m > 1e-6).then(|| (across_m / way_m, outwards_m / way_m))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::manifold::tests::manifold;

    const SETUP: RouteSetup = RouteSetup { lift_m: 0.05, approach_m: 0.03 };

    fn at(manifold: &Manifold, x_m: f64, y_m: f64) -> JointPositions {
        manifold.joints_on_square((x_m, y_m))
    }

    #[test]
    fn a_move_draws_back_goes_over_and_comes_up_to_its_goal_from_the_near_side() {
        let manifold = manifold();
        let from = Waypoint { joints: at(&manifold, 0.1, 0.3), lift_m: 0.0 };
        let points = route(SETUP, &manifold, from, OUTWARDS, at(&manifold, -0.3, 0.4));
        let tips: Vec<(f64, f64, f64)> = points
            .iter()
            .map(|point| {
                let tip = manifold.tip(manifold.at(point.joints).unwrap());
                (tip.x, tip.y, tip.z - manifold.tip_height_m + point.lift_m)
            })
            .collect();
        let expected = [(0.1, 0.29, 0.05), (-0.282, 0.376, 0.05), (-0.282, 0.376, 0.0), (-0.3, 0.4, 0.0)];
        assert_eq!(tips.len(), expected.len());
        for (tip, wanted) in tips.iter().zip(expected) {
            let off = (tip.0 - wanted.0).abs() + (tip.1 - wanted.1).abs() + (tip.2 - wanted.2).abs();
            assert!(off < 1e-9, "{tip:?} instead of {wanted:?}");
        }
    }

    #[test]
    fn without_lift_it_slides() {
        let manifold = manifold();
        let from = Waypoint { joints: manifold.rest(), lift_m: 0.0 };
        let to = at(&manifold, 0.2, 0.5);
        let setup = RouteSetup { lift_m: 0.0, approach_m: 0.03 };
        assert_eq!(route(setup, &manifold, from, OUTWARDS, to), [Waypoint { joints: to, lift_m: 0.0 }]);
    }

    #[test]
    fn nothing_is_set_down_behind_the_rest_posture() {
        let manifold = manifold();
        let from = Waypoint { joints: manifold.rest(), lift_m: 0.0 };
        let near = at(&manifold, 0.0, manifold.rest_m + 0.01);
        let points = route(SETUP, &manifold, from, OUTWARDS, near);
        let set_down_m = manifold.square_m(points[2].joints).1;
        assert!((set_down_m - manifold.rest_m).abs() < 1e-9, "{set_down_m}");
    }
}
