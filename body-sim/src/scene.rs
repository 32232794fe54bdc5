//! The arm's links, the finger and the blocks, as solids for the renderer.

use nalgebra::Point3;

use crate::camera::{Shape, Solid, TableTop};
use crate::config::WorldFile;
use crate::gap::Form;
use crate::kinematics::Posture;
use crate::world::World;

/// Radius of the column that carries the arm, in metres.
const COLUMN_RADIUS_M: f64 = 0.040;
/// The arm's paint: greys, in which the eye sees no colour.
const LINK_RGB: [u8; 3] = [150, 153, 158];
const JOINT_RGB: [u8; 3] = [66, 68, 72];
const SHAFT_RGB: [u8; 3] = [48, 49, 52];

/// The table as the camera sees it.
#[must_use]
pub fn table_top(file: &WorldFile) -> TableTop {
    let near_m = -file.table.behind_mm.metres();
    TableTop { width_m: file.table.width_mm.metres(), y_m: (near_m, near_m + file.table.depth_mm.metres()) }
}

/// The solids that never move: the column that carries the arm.
#[must_use]
pub fn fixed(file: &WorldFile) -> Vec<Solid> {
    let shoulder_m = Point3::new(0.0, 0.0, file.arm.shoulder_height_mm.metres());
    vec![Solid { shape: Shape::Capsule(Point3::origin(), shoulder_m, COLUMN_RADIUS_M), rgb: JOINT_RGB }]
}

/// All other solids, for one picture.
#[must_use]
pub fn solids(file: &WorldFile, world: &World, posture: &Posture) -> Vec<Solid> {
    let mut solids = arm(file, posture);
    for (index, object) in file.objects.iter().enumerate() {
        if let Some(pose) = world.block(index) {
            let centre = Point3::from(pose.translation.vector);
            let shape = match world.form(index) {
                Form::Cube(half_m) => Shape::Cube(pose, half_m),
                Form::Ball(radius_m) => Shape::Capsule(centre, centre, radius_m),
            };
            solids.push(Solid { shape, rgb: paint(file, &object.colour) });
        }
    }
    solids
}

fn arm(file: &WorldFile, posture: &Posture) -> Vec<Solid> {
    let link = |from: Point3<f64>, to: Point3<f64>, radius_m: f64, rgb: [u8; 3]| Solid {
        shape: Shape::Capsule(from, to, radius_m),
        rgb,
    };
    let Posture { shoulder_m, elbow_m, wrist_m, tip_m, .. } = *posture;
    let (link_radius_m, joint_radius_m) =
        (file.arm.link_radius_mm.metres(), file.arm.joint_radius_mm.metres());
    vec![
        link(shoulder_m, elbow_m, link_radius_m, LINK_RGB),
        link(elbow_m, elbow_m, joint_radius_m, JOINT_RGB),
        link(elbow_m, wrist_m, link_radius_m, LINK_RGB),
        // The wrist's joint sits on the finger's far end, up the forearm, away from the tip.
        link(wrist_m, wrist_m, joint_radius_m, JOINT_RGB),
        link(tip_m, wrist_m, file.finger.shaft_radius_mm.metres(), SHAFT_RGB),
        link(tip_m, tip_m, file.finger.ball_radius_mm.metres(), paint(file, &file.finger.colour)),
    ]
}

/// The paint of a colour; names were checked when the world was read.
fn paint(file: &WorldFile, colour: &str) -> [u8; 3] {
    file.colour_index(colour).map_or([128; 3], |index| file.colours[index].paint_rgb)
}
