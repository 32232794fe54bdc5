//! The manifold that the arm's finger works on (section III-A of the paper), as it was taught: the arm's joints at the
//! nodes of a grid over the two joint positions that command the arm, in layers of height. Between nodes the joints are
//! interpolated, so that they never leave the range of the taught values, whatever arm it is.

use nalgebra::{DVector, Matrix3, Vector3};
use pschema_arm::JointPositions;
use pschema_arm::route::Waypoint;

use crate::v_plus::JOINTS_MAX;

/// Nodes one grid may have, all layers together.
pub const NODES_MAX: usize = 65_536;
/// Weight below which a node does not count.
const WEIGHT_MIN: f64 = 1e-9;
/// Distance, in multiples of the tolerance, at which the search ends because nothing is gained by coming nearer.
const NEAR_ENOUGH: f64 = 1e-3;
/// Distance, in multiples of the tolerance, at which no other guess is tried, and the number of guesses.
const GOOD_ENOUGH: f64 = 0.1;
const GUESSES_MAX: usize = 16;
/// Tries to improve one guess of the point at which the joints are.
const REFINEMENTS: usize = 30;

/// One value a joint, in degrees or millimetres.
pub type Joints = Vec<f64>;

/// The axes and nodes that a grid is made from.
#[derive(Clone, Debug, PartialEq)]
pub struct GridSetup {
    /// First joint position of each column, ascending.
    pub j1: Vec<f64>,
    /// Second joint position of each row, ascending.
    pub j2: Vec<f64>,
    /// Height of each layer over the manifold in metres, ascending from 0.
    pub lift_m: Vec<f64>,
    /// The arm's joints at each node: layer by layer, row by row. None where the arm does not reach.
    pub nodes: Vec<Option<Joints>>,
}

/// A taught grid.
#[derive(Clone, Debug, PartialEq)]
pub struct TaughtGrid {
    setup: GridSetup,
    joints: usize,
}

/// The point of the grid that fits some joint values best.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridFit {
    /// The nearest point.
    pub at: Waypoint,
    /// Distance of the worst joint from its value at that point, as a multiple of its tolerance.
    pub off: f64,
}

impl TaughtGrid {
    /// A grid for an arm of so many joints.
    ///
    /// # Errors
    /// When there are too few or too many nodes, an axis does not ascend, or a node has another number of joints.
    pub fn new(setup: GridSetup, joints: usize) -> Result<Self, String> {
        for (what, axis) in [("j1", &setup.j1), ("j2", &setup.j2), ("lift_mm", &setup.lift_m)] {
            if axis.len() < 2 || !axis.is_sorted_by(|one, next| one < next) {
                return Err(format!("taught.{what} must have two values or more, each above the one before"));
            }
        }
        if setup.lift_m.first().copied() != Some(0.0) {
            return Err("taught.lift_mm must begin with 0, the manifold itself".into());
        }
        let expected = setup.j1.len() * setup.j2.len() * setup.lift_m.len();
        if setup.nodes.len() != expected || expected > NODES_MAX {
            return Err(format!(
                "taught.points has {} nodes: there must be {expected} (layers x rows x columns), at most {NODES_MAX}",
                setup.nodes.len()
            ));
        }
        if joints > JOINTS_MAX || setup.nodes.iter().flatten().any(|node| node.len() != joints) {
            return Err(format!(
                "every node of taught.points must have {joints} joints, or none where the arm does not reach"
            ));
        }
        Ok(Self { setup, joints })
    }

    /// How many joints the arm has.
    #[must_use]
    pub fn joints(&self) -> usize {
        self.joints
    }

    /// The arm's joints at a point. None when a node around the point was not taught.
    #[must_use]
    pub fn at(&self, point: Waypoint) -> Option<Joints> {
        let (columns, rows) = (self.setup.j1.len(), self.setup.j2.len());
        let (column, across) = cell(&self.setup.j1, point.joints.j1)?;
        let (row, outwards) = cell(&self.setup.j2, point.joints.j2)?;
        let (layer, up) = cell(&self.setup.lift_m, point.lift_m)?;
        let mut joints = vec![0.0; self.joints];
        for corner in 0..8 {
            let part = |bit: usize, share: f64| if corner & bit == 0 { 1.0 - share } else { share };
            let weight = part(1, across) * part(2, outwards) * part(4, up);
            if weight < WEIGHT_MIN {
                continue;
            }
            let step = |bit: usize| usize::from(corner & bit != 0);
            let index = ((layer + step(4)) * rows + row + step(2)) * columns + column + step(1);
            let node = self.setup.nodes.get(index)?.as_ref()?;
            joints.iter_mut().zip(node).for_each(|(sum, value)| *sum += weight * value);
        }
        Some(joints)
    }

    /// The taught point nearest to some joint values, in multiples of `tolerance`, one a joint. None when their number
    /// is not the arm's, or one is not finite.
    #[must_use]
    pub fn locate(&self, joints: &[f64], tolerance: &[f64]) -> Option<GridFit> {
        let fits = joints.len() == self.joints && tolerance.len() == self.joints;
        if !fits || joints.iter().chain(tolerance).any(|value| !value.is_finite()) {
            return None;
        }
        let nodes = self.setup.nodes.iter().enumerate();
        let mut nearest: Vec<(usize, f64)> = nodes
            .filter_map(|(index, node)| {
                Some((index, differences(node.as_ref()?, joints, tolerance).map(|off| off * off).sum()))
            })
            .collect();
        nearest.sort_by(|(_, one), (_, other)| one.total_cmp(other));
        // From the nearest node the search may end at a fold between cells, or at the edge of the taught nodes.
        let mut best: Option<GridFit> = None;
        for (node, _) in nearest.into_iter().take(GUESSES_MAX) {
            let Some(located) = self.node_at(node).and_then(|guess| self.refined(guess, joints, tolerance))
            else {
                continue;
            };
            if best.is_none_or(|best| located.off < best.off) {
                best = Some(located);
            }
            if located.off < GOOD_ENOUGH {
                break;
            }
        }
        best
    }

    /// The same as [`Self::locate`], sooner, for joint values near a point.
    #[must_use]
    pub fn locate_near(&self, near: Waypoint, joints: &[f64], tolerance: &[f64]) -> Option<GridFit> {
        let fits = joints.len() == self.joints && tolerance.len() == self.joints;
        let located = if fits { self.refined(near, joints, tolerance) } else { None };
        // A point that is not near may still be elsewhere on the grid.
        located.filter(|located| located.off <= 1.0).or_else(|| self.locate(joints, tolerance))
    }

    /// The taught point nearest to joint values, from a guess.
    fn refined(&self, guess: Waypoint, joints: &[f64], tolerance: &[f64]) -> Option<GridFit> {
        let off = |there: &[f64]| DVector::from_iterator(self.joints, differences(there, joints, tolerance));
        let mut best = guess;
        let mut error = off(&self.at(best)?);
        let mut damping = 1e-3;
        for _ in 0..REFINEMENTS {
            if error.amax() < NEAR_ENOUGH {
                break;
            }
            let Some(next) = self.improved(best, &error, damping, &off) else { break };
            match self.at(next).map(|there| off(&there)) {
                Some(other) if other.norm_squared() < error.norm_squared() => {
                    (best, error) = (next, other);
                    damping /= 4.0;
                }
                _ => damping *= 8.0,
            }
        }
        let off = error.amax();
        off.is_finite().then_some(GridFit { at: best, off })
    }

    /// A step of Levenberg and Marquardt, kept on the grid. None when the joints do not change around a point.
    fn improved(
        &self,
        from: Waypoint,
        error: &DVector<f64>,
        damping: f64,
        off: &impl Fn(&[f64]) -> DVector<f64>,
    ) -> Option<Waypoint> {
        let span = self.span();
        let coordinates = |point: Waypoint| Vector3::new(point.joints.j1, point.joints.j2, point.lift_m);
        let point =
            |at: Vector3<f64>| Waypoint { joints: JointPositions { j1: at.x, j2: at.y }, lift_m: at.z };
        let here = coordinates(from);
        let slopes: Vec<DVector<f64>> = (0..3)
            .map(|axis| {
                let step = (span.1[axis] - span.0[axis]) * 1e-4;
                let beside = |step: f64| {
                    let mut there = here;
                    there[axis] += step;
                    Some((off(&self.at(point(there))?) - error) / step)
                };
                beside(step).or_else(|| beside(-step))
            })
            .collect::<Option<_>>()?;
        let mut normal = Matrix3::zeros();
        let mut gradient = Vector3::zeros();
        for (row, slope) in slopes.iter().enumerate() {
            gradient[row] = slope.dot(error);
            for (column, other) in slopes.iter().enumerate() {
                normal[(row, column)] = slope.dot(other);
            }
        }
        for axis in 0..3 {
            normal[(axis, axis)] = normal[(axis, axis)] * (1.0 + damping) + f64::MIN_POSITIVE;
        }
        let step = normal.try_inverse()? * gradient;
        let next = (here - step).zip_zip_map(&span.0, &span.1, |value, low, high| value.clamp(low, high));
        next.iter().all(|value| value.is_finite()).then(|| point(next))
    }

    /// First and last value of each axis.
    fn span(&self) -> (Vector3<f64>, Vector3<f64>) {
        let axes = [&self.setup.j1, &self.setup.j2, &self.setup.lift_m];
        let ends =
            axes.map(|axis| (axis.first().copied().unwrap_or(0.0), axis.last().copied().unwrap_or(0.0)));
        (Vector3::from(ends.map(|(first, _)| first)), Vector3::from(ends.map(|(_, last)| last)))
    }

    fn node_at(&self, index: usize) -> Option<Waypoint> {
        let (columns, rows) = (self.setup.j1.len(), self.setup.j2.len());
        let (column, row, layer) = (index % columns, index / columns % rows, index / columns / rows);
        let joints = JointPositions { j1: *self.setup.j1.get(column)?, j2: *self.setup.j2.get(row)? };
        Some(Waypoint { joints, lift_m: *self.setup.lift_m.get(layer)? })
    }

    /// The points of the manifold itself that were taught, node by node.
    pub fn nodes(&self) -> impl Iterator<Item = JointPositions> {
        let on_manifold = self.setup.j1.len() * self.setup.j2.len();
        let taught = self.setup.nodes.iter().take(on_manifold).enumerate().filter(|(_, node)| node.is_some());
        taught.filter_map(|(index, _)| self.node_at(index)).map(|point| point.joints)
    }
}

/// The distance of each joint from `here` to `there`, in multiples of its tolerance.
fn differences<'a>(
    there: &'a [f64],
    here: &'a [f64],
    tolerance: &'a [f64],
) -> impl Iterator<Item = f64> + use<'a> {
    there.iter().zip(here).zip(tolerance).map(|((there, here), tolerance)| (there - here) / tolerance)
}

/// The step of an ascending axis that holds a value, and the share of the step before the value. None outside the axis.
fn cell(axis: &[f64], value: f64) -> Option<(usize, f64)> {
    let (first, last) = (axis.first()?, axis.last()?);
    if !(*first..=*last).contains(&value) {
        return None;
    }
    let above = axis.partition_point(|node| *node <= value).clamp(1, axis.len() - 1);
    let (low, high) = (axis.get(above - 1)?, axis.get(above)?);
    Some((above - 1, (value - low) / (high - low)))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A grid of an arm of three joints: two turn with the joint positions, not straight, the third is a quill.
    pub(crate) fn grid() -> TaughtGrid {
        let axis = |from: f64, to: f64, count: usize| -> Vec<f64> {
            (0..count).map(|i| from + (to - from) * i as f64 / (count - 1) as f64).collect()
        };
        let setup = |j1: Vec<f64>, j2: Vec<f64>, lift_m: Vec<f64>| {
            let mut nodes = Vec::new();
            for lift in &lift_m {
                for outwards in &j2 {
                    for across in &j1 {
                        let reached = across + outwards < 1.9;
                        nodes.push(reached.then(|| joints(*across, *outwards, *lift)));
                    }
                }
            }
            GridSetup { j1, j2, lift_m, nodes }
        };
        TaughtGrid::new(setup(axis(0.0, 1.0, 21), axis(-0.1, 1.0, 23), vec![0.0, 0.05]), 3).unwrap()
    }

    fn joints(j1: f64, j2: f64, lift_m: f64) -> Joints {
        vec![
            -60.0 + 120.0 * j1 + 5.0 * j2 * j2,
            20.0 + 70.0 * j2 - 8.0 * j1,
            150.0 - lift_m * 1000.0 + 20.0 * j2 * j2,
        ]
    }

    fn point(j1: f64, j2: f64, lift_m: f64) -> Waypoint {
        Waypoint { joints: JointPositions { j1, j2 }, lift_m }
    }

    #[test]
    fn nodes_are_exact_and_between_them_joints_stay_between() {
        let grid = grid();
        assert_eq!(grid.at(point(0.5, 0.4, 0.0)), Some(joints(0.5, 0.4, 0.0)));
        let (here, next) = (joints(0.5, 0.4, 0.0), joints(0.55, 0.45, 0.05));
        let between = grid.at(point(0.525, 0.425, 0.025)).unwrap();
        for ((value, a), b) in between.iter().zip(&here).zip(&next) {
            assert!((a.min(*b)..=a.max(*b)).contains(value), "{value} {a} {b}");
        }
        assert!((between[0] - joints(0.525, 0.425, 0.025)[0]).abs() < 0.01);
    }

    #[test]
    fn outside_what_was_taught_there_is_nothing() {
        let grid = grid();
        for (j1, j2, lift_m) in
            [(-0.01, 0.5, 0.0), (0.5, 1.01, 0.0), (0.5, 0.5, 0.06), (0.97, 0.97, 0.0), (f64::NAN, 0.5, 0.0)]
        {
            assert_eq!(grid.at(point(j1, j2, lift_m)), None);
        }
    }

    #[test]
    fn joints_are_located_where_they_are() {
        let grid = grid();
        for at in
            [point(0.5, 0.4, 0.0), point(0.333, 0.777, 0.02), point(0.01, -0.09, 0.05), point(0.9, 0.88, 0.0)]
        {
            let joints = grid.at(at).unwrap();
            let found = grid.locate(&joints, &[0.2, 0.2, 0.2]).unwrap();
            assert!(found.off < 0.01, "{found:?}");
            let apart = (found.at.joints.j1 - at.joints.j1).abs() + (found.at.joints.j2 - at.joints.j2).abs();
            assert!(
                apart < 1e-3 && (found.at.lift_m - at.lift_m).abs() < 1e-4,
                "{found:?} instead of {at:?}"
            );
        }
        let elsewhere = grid.locate(&[0.0, 50.0, 230.0], &[0.2, 0.2, 0.2]).unwrap();
        assert!(elsewhere.off > 10.0, "{elsewhere:?}");
        assert_eq!(grid.locate(&[0.0, f64::NAN, 0.0], &[0.2; 3]), None);
        assert_eq!(grid.locate(&[0.0, 0.0], &[0.2; 3]), None);
    }

    /// Of 100,000 random postures of the emulated arm the 5290th was not found again, and the arm stood still for good.
    #[test]
    fn every_point_of_the_shipped_grid_is_located() {
        let setup = crate::config::ArmSetup::load("emulated").unwrap();
        let (taught, tolerances) = (setup.gate.taught(), setup.gate.tolerances());
        let mut random = pschema_arm::SplitMix::new(7);
        let mut share = || (random.within_one() + 1.0) / 2.0;
        let mut found = 0;
        for _ in 0..3000 {
            let at = point(share(), share() * 1.09 - 0.09, if share() < 0.5 { 0.0 } else { 0.05 * share() });
            let Some(joints) = taught.at(at) else { continue };
            let off = taught.locate(&joints, tolerances).unwrap().off;
            assert!(off < 0.5, "{at:?} is {off} times the tolerance off");
            found += 1;
        }
        assert!(found > 1000, "{found}");
    }

    #[test]
    fn a_grid_that_is_none_is_refused() {
        let good = grid().setup;
        let refused = |change: &dyn Fn(&mut GridSetup)| {
            let mut setup = good.clone();
            change(&mut setup);
            TaughtGrid::new(setup, 3).unwrap_err()
        };
        assert!(refused(&|setup| setup.j1.swap(0, 1)).contains("taught.j1"));
        assert!(refused(&|setup| setup.j2[3] = f64::NAN).contains("taught.j2"));
        assert!(refused(&|setup| setup.lift_m[0] = 0.01).contains("begin with 0"));
        assert!(refused(&|setup| setup.nodes.truncate(9)).contains("9 nodes"));
        assert!(refused(&|setup| setup.nodes[5] = Some(vec![1.0])).contains("3 joints"));
    }
}
