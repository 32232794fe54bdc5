//! What there is to see: the arm's links, the finger and the blocks, as solids for the renderer.

use nalgebra::{Point3, Vector3};

use crate::arm::Posture;
use crate::camera::{Shape, Solid, TableTop};
use crate::config::WorldFile;
use crate::world::World;

/// Thickness of the links in metres, and their paint: greys, which are no colour to the eye.
const COLUMN_RADIUS_M: f64 = 0.055;
const UPPER_ARM_RADIUS_M: f64 = 0.034;
const FOREARM_RADIUS_M: f64 = 0.024;
const ELBOW_RADIUS_M: f64 = 0.040;
const WRIST_RADIUS_M: f64 = 0.019;
const LINK_RGB: [u8; 3] = [150, 153, 158];
const JOINT_RGB: [u8; 3] = [66, 68, 72];
const SHAFT_RGB: [u8; 3] = [48, 49, 52];

/// The table as the camera sees it.
#[must_use]
pub fn table_top(file: &WorldFile) -> TableTop {
    let near_m = -file.table.behind_mm.metres();
    TableTop { width_m: file.table.width_mm.metres(), y_m: (near_m, near_m + file.table.depth_mm.metres()) }
}

/// Everything on the table, for one picture.
#[must_use]
pub fn solids(file: &WorldFile, world: &World, posture: &Posture) -> Vec<Solid> {
    let mut solids = arm(file, posture);
    for (index, object) in file.objects.iter().enumerate() {
        if let Some(pose) = world.block(index) {
            let shape = Shape::Cube(pose, object.side_mm.metres() / 2.0);
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
    let foot_m = shoulder_m - Vector3::z() * shoulder_m.z;
    vec![
        link(foot_m, shoulder_m, COLUMN_RADIUS_M, JOINT_RGB),
        link(shoulder_m, elbow_m, UPPER_ARM_RADIUS_M, LINK_RGB),
        link(elbow_m, elbow_m, ELBOW_RADIUS_M, JOINT_RGB),
        link(elbow_m, wrist_m, FOREARM_RADIUS_M, LINK_RGB),
        // The wrist's joint sits on the finger's far end, up the forearm, away from the tip.
        link(wrist_m, wrist_m, WRIST_RADIUS_M, JOINT_RGB),
        link(tip_m, wrist_m, file.finger.shaft_radius_mm.metres(), SHAFT_RGB),
        link(tip_m, tip_m, file.finger.ball_radius_mm.metres(), paint(file, &file.finger.colour)),
    ]
}

/// The paint of a colour; names were checked when the world was read.
fn paint(file: &WorldFile, colour: &str) -> [u8; 3] {
    file.colour_index(colour).map_or([128; 3], |index| file.colours[index].paint_rgb)
}
