//! The path of the arm to a posture: the finger is lifted, carried, set down before the goal and brought up to it, like
//! that of the simulated arm. The points of the path, in the arm's own joints, are so near to each other that the arm,
//! which goes straight in its joints, stays on the taught manifold.

use pschema_arm::JointPositions;
use pschema_arm::route::{self, Heading, Waypoint};

use crate::config::{ArmSetup, LineMode};
use crate::gate::{LEGS_MAX, Leg, PermittedPath};
use crate::taught::Joints;

/// Points of an approach are this near to each other, in metres: without a program on the controller, touch is looked
/// at between them.
const APPROACH_STEP_M: f64 = 0.003;
/// The same on the way down to the manifold, where the finger may meet a block's edge. They are fewer, because the
/// number of points of a path is limited.
const DESCENT_STEP_M: f64 = 0.005;
/// Largest distance of a planned path from the taught manifold, in multiples of the tolerance. The gate lets 1 pass.
const OFF_MAX: f64 = 0.5;
/// How often a part of a path may be halved to keep that distance.
const STRAIGHTENINGS_MAX: usize = 5;

/// The path to joint positions from where the arm was measured, and the heading at its end. None when there is no path.
pub(crate) fn path(
    setup: &ArmSetup,
    heading: Heading,
    from: &[f64],
    to: JointPositions,
) -> Option<(PermittedPath, Heading)> {
    let (gate, plane) = (&setup.gate, &setup.plane);
    let start = gate.taught().locate(from, gate.tolerances())?.at;
    let route = setup.route();
    let mut points = route::route(route, plane, start, heading, to);
    if let Some(departed) = points.first_mut()
        && gate.taught().at(*departed).is_none()
    {
        // When there is no room to draw back or to lift higher, the finger goes straight up.
        *departed = Waypoint { joints: start.joints, lift_m: route.lift_m };
    }
    let before =
        points.len().checked_sub(2).and_then(|index| points.get(index)).map_or(start, |point| *point);
    let heading = route::heading(plane, before.joints, to).unwrap_or(heading);
    let Some(legs) = legs(setup, start, &points) else {
        tracing::debug!(j1 = to.j1, j2 = to.j2, "refused: beyond what was taught");
        return None;
    };
    match gate.permit(from, legs, true) {
        Ok(path) => Some((path, heading)),
        Err(refused) => {
            tracing::warn!(%refused, j1 = to.j1, j2 = to.j2, "refused");
            None
        }
    }
}

/// The arm's joints along straight lines through points. None when a point is off the taught grid, or when the path
/// takes more points than one motion may have.
fn legs(setup: &ArmSetup, start: Waypoint, points: &[Waypoint]) -> Option<Vec<Leg>> {
    let (fast, slow) = setup.speeds();
    let step_m = setup.file.motion.step_mm.metres();
    // A program on the controller brakes at a touch wherever it is; without one it is looked at between points.
    let descent_m =
        if setup.file.line.mode == LineMode::Monitor { DESCENT_STEP_M.min(step_m) } else { step_m };
    let mut legs = Vec::new();
    let mut from = (start, setup.gate.taught().at(start)?);
    for to in points {
        // The last part, on the manifold, is the approach.
        let (speed_percent, apart_m) = match (from.0.lift_m <= 0.0, to.lift_m <= 0.0) {
            (true, true) => (slow, APPROACH_STEP_M),
            (false, true) => (slow, descent_m),
            (_, false) => (fast, step_m),
        };
        let count = steps(way_m(setup, &(from.0, *to)), apart_m);
        let begin = from.0;
        for step in 1..=count {
            let point = between(begin, *to, step as f64 / count as f64);
            let joints = setup.gate.taught().at(point)?;
            straighten(setup, &from, &(point, joints.clone()), speed_percent, STRAIGHTENINGS_MAX, &mut legs)?;
            from = (point, joints);
        }
    }
    (legs.len() <= LEGS_MAX).then_some(legs)
}

/// Adds the way from one point to another. Points between them are added where the arm, which goes straight in its
/// joints, would leave the taught manifold.
fn straighten(
    setup: &ArmSetup,
    from: &(Waypoint, Joints),
    to: &(Waypoint, Joints),
    speed_percent: u8,
    more: usize,
    legs: &mut Vec<Leg>,
) -> Option<()> {
    let gate = &setup.gate;
    let middle = between(from.0, to.0, 0.5);
    let taught = gate.taught().at(middle)?;
    let mean = from.1.iter().zip(&to.1).map(|(a, b)| (a + b) / 2.0);
    let off =
        mean.zip(&taught).zip(gate.tolerances()).map(|((mean, there), most)| (mean - there).abs() / most);
    if more > 0 && off.fold(0.0, f64::max) > OFF_MAX {
        let middle = (middle, taught);
        straighten(setup, from, &middle, speed_percent, more - 1, legs)?;
        return straighten(setup, &middle, to, speed_percent, more - 1, legs);
    }
    legs.push(Leg { to: to.1.clone(), speed_percent });
    Some(())
}

/// Distance between two points, in metres.
pub(crate) fn way_m(setup: &ArmSetup, (from, to): &(Waypoint, Waypoint)) -> f64 {
    let (a, b) = (setup.plane.at_m(from.joints), setup.plane.at_m(to.joints));
    ((a.0 - b.0).powi(2) + (a.1 - b.1).powi(2) + (from.lift_m - to.lift_m).powi(2)).sqrt()
}

fn steps(way_m: f64, step_m: f64) -> usize {
    ((way_m / step_m).ceil() as usize).clamp(1, LEGS_MAX)
}

/// The point at a share of the way from one point to another.
pub(crate) fn between(from: Waypoint, to: Waypoint, share: f64) -> Waypoint {
    let mix = |a: f64, b: f64| a + (b - a) * share;
    let joints =
        JointPositions { j1: mix(from.joints.j1, to.joints.j1), j2: mix(from.joints.j2, to.joints.j2) };
    Waypoint { joints, lift_m: mix(from.lift_m, to.lift_m) }
}
