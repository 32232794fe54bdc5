//! Teaching the emulated arm, as a person teaches a real one with the pendant: the precision points over its work
//! space, the places for objects, and the postures that it tries. The result is the second half of
//! `arms/emulated.toml`.

use pschema_arm::{FileError, JointPositions, Square};
use pschema_sim::config::WorldFile;
use pschema_sim::manifold::OnManifold;
use pschema_sim::workspace::Workspace;

use crate::path::Joints;

/// Distance between taught points over the table, in metres.
const SPACING_M: f64 = 0.03;
/// Heights over the manifold at which points are taught, in metres; the second is that of a carried finger.
const LIFTS: usize = 2;

/// The taught points, places and postures, as tables for an arm file.
///
/// # Errors
/// When the world cannot be used.
pub fn tables(world: &str) -> Result<String, FileError> {
    let workspace = Workspace::new(world, WorldFile::load(world)?)?;
    Ok(lines(world, &workspace).join("\n") + "\n")
}

fn lines(world: &str, workspace: &Workspace) -> Vec<String> {
    let mut lines = Vec::new();
    let mut line = |text: String| lines.push(text);
    let square = &workspace.manifold.square;
    let mm = |metres: f64| (metres * 1e6).round() / 1e3;
    line(format!("# Taught by `pschema-vplus-emulator --teach {world}`; written anew by it, not by hand.\n"));
    line("# What the two joint positions mean on the table, straight ahead of the base.\n[plane]".into());
    line(format!("across_mm = {:?}", mm(square.across_m)));
    line(format!("nearest_mm = {:?}", mm(square.nearest_m)));
    line(format!("outwards_mm = {:?}\n", mm(square.outwards_m)));

    line(
        "# The postures to try, one for each visual field that the finger can be seen in.\n[repertoire]"
            .into(),
    );
    line("postures = [".into());
    for taught in &workspace.taught {
        line(format!("  [{:.3}, {:.3}],", taught.joints.j1, taught.joints.j2));
    }
    line("]\n".into());

    line("# Where a person puts objects: x to the right, y outwards, from the base's axis.\n[places]\nat_mm = [".into());
    for place in &workspace.places {
        line(format!("  [{:.1}, {:.1}],", place.centre_m.0 * 1e3, place.centre_m.1 * 1e3));
    }
    line("]\n".into());

    let grid = Grid::taught(workspace);
    line(
        "# Precision points, in degrees: at each of the joint positions, at each height over the manifold."
            .into(),
    );
    let rest = workspace.manifold.rest();
    line(format!("[taught]\nrest = [{:?}, {:?}]", rounded(rest.j1), rounded(rest.j2)));
    line(format!("j1 = {:?}\nj2 = {:?}", grid.j1, grid.j2));
    line(format!("lift_mm = {:?}\npoints = [", grid.lift_m.map(mm)));
    for layer in &grid.points {
        line("  [".into());
        for row in layer {
            let points: Vec<String> = row.iter().map(point).collect();
            line(format!("    [{}],", points.join(", ")));
        }
        line("  ],".into());
    }
    line("]".into());
    lines
}

fn point(joints: &Option<Joints>) -> String {
    let values: Vec<String> = joints.iter().flatten().map(|value| format!("{value:.3}")).collect();
    format!("[{}]", values.join(", "))
}

/// The taught points: `[layer][row outwards][column across]`, None where the arm does not reach.
pub(crate) struct Grid {
    pub(crate) j1: Vec<f64>,
    pub(crate) j2: Vec<f64>,
    pub(crate) lift_m: [f64; LIFTS],
    pub(crate) points: Vec<Vec<Vec<Option<Joints>>>>,
}

impl Grid {
    /// Teaches the arm of a work space.
    pub(crate) fn taught(workspace: &Workspace) -> Self {
        let manifold = &workspace.manifold;
        let Square { across_m, nearest_m, outwards_m, rest_m } = manifold.square;
        let columns = (across_m / SPACING_M).ceil() as usize;
        // From behind the rest posture to the end of the rim.
        let first = (rest_m - nearest_m - SPACING_M / 2.0) / outwards_m;
        let rows = ((1.0 - first) * outwards_m / SPACING_M).ceil() as usize;
        let even = |count: usize, from: f64, to: f64| -> Vec<f64> {
            (0..=count).map(|at| rounded(from + (to - from) * at as f64 / count as f64)).collect()
        };
        let (j1, j2) = (even(columns, 0.0, 1.0), even(rows, first, 1.0));
        let lift_m = [0.0, workspace.file.arm.lift_mm.metres()];
        let reach_m = manifold.arc_max_m + SPACING_M * std::f64::consts::SQRT_2;
        let point = |j1: f64, j2: f64, lift_m: f64| {
            let (across_m, outwards_m) = manifold.square.at_m(JointPositions { j1, j2 });
            let arc_m = (across_m * across_m + outwards_m * outwards_m).sqrt();
            let at = OnManifold { bearing_rad: across_m.atan2(outwards_m), arc_m };
            let posture = workspace.arm.posture_above(manifold, at, lift_m).filter(|_| arc_m <= reach_m)?;
            Some(posture.angles_rad.map(f64::to_degrees))
        };
        let layer =
            |lift_m: f64| j2.iter().map(|j2| j1.iter().map(|j1| point(*j1, *j2, lift_m)).collect()).collect();
        let points = lift_m.into_iter().map(layer).collect();
        Self { j1, j2, lift_m, points }
    }

    /// The joints at a place between four taught points, as a driver works them out.
    #[cfg(test)]
    fn between(&self, layer: usize, joints: JointPositions) -> Option<Joints> {
        let cell = |values: &[f64], at: f64| {
            let next = values.partition_point(|value| *value <= at).clamp(1, values.len() - 1);
            (next - 1, (at - values[next - 1]) / (values[next] - values[next - 1]))
        };
        let ((column, x), (row, y)) = (cell(&self.j1, joints.j1), cell(&self.j2, joints.j2));
        let layer = self.points.get(layer)?;
        let corner = |row: usize, column: usize| *layer.get(row)?.get(column)?;
        let (a, b) = (corner(row, column)?, corner(row, column + 1)?);
        let (c, d) = (corner(row + 1, column)?, corner(row + 1, column + 1)?);
        let mut joints = a;
        for (at, value) in joints.iter_mut().enumerate() {
            let (near, far) = (a[at] + (b[at] - a[at]) * x, c[at] + (d[at] - c[at]) * x);
            *value = near + (far - near) * y;
        }
        Some(joints)
    }
}

fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Between taught points the finger keeps near to where it should be: so near that it neither scrapes the table nor
    /// leaves a visual field, which is 56 pixels across or 65 mm.
    #[test]
    fn between_taught_points_the_finger_is_where_it_should_be() {
        let workspace = Workspace::new("narrow", WorldFile::load("narrow").unwrap()).unwrap();
        let grid = Grid::taught(&workspace);
        for taught in &workspace.taught {
            for (layer, lift_m) in grid.lift_m.into_iter().enumerate() {
                let joints =
                    grid.between(layer, taught.joints).expect("every posture is between taught points");
                assert!(crate::machine::within_softstops(&joints), "{joints:?}");
                let tip_m = workspace.arm.posture_of(joints.map(f64::to_radians)).tip_m;
                let point = workspace.manifold.at(taught.joints).unwrap();
                let mut wanted_m = workspace.manifold.tip(point);
                wanted_m.z += lift_m;
                let off_mm = (tip_m - wanted_m) * 1e3;
                assert!(off_mm.norm() < 2.0, "field {}: off by {off_mm:?} mm", taught.field);
            }
        }
    }

    #[test]
    fn the_tables_are_toml_with_the_worlds_postures_and_places() {
        let text = tables("narrow").unwrap();
        let read: toml::Table = text.parse().unwrap();
        assert_eq!(read["repertoire"]["postures"].as_array().unwrap().len(), 112);
        assert_eq!(read["places"]["at_mm"].as_array().unwrap().len(), 116);
        assert_eq!(read["taught"]["points"].as_array().unwrap().len(), LIFTS);
        assert!(tables("/nowhere/w.toml").is_err());
    }
}
