//! The physics: blocks on a table and the finger that meets them, in rapier. This is the only file that names rapier,
//! and rapier's own vectors stay within it.
//!
//! The finger is kinematic: it goes exactly where the arm's motion puts it, as a stiffly controlled arm does.
//! The other links are not solid here, because the work space is checked to keep them above every block.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rapier3d::prelude::{
    ColliderBuilder, Group, InteractionGroups, InteractionTestMode, PhysicsWorld, Pose, RigidBodyBuilder,
    RigidBodyHandle, Rotation, Vector,
};

use crate::gap::{Form, gap, near};

/// Steps of physics in a second. At a fourth of it the finger sinks millimetres into blocks.
pub const STEPS_PER_S: u32 = 240;
/// Length of a step in seconds.
pub const STEP_S: f64 = 1.0 / STEPS_PER_S as f64;
/// A block that has fallen this far below the table is lost.
const LOST_BELOW_M: f64 = 0.05;
/// A block slower than this rests, in metres and radians a second.
const STILL_M_PER_S: f32 = 0.002;
const STILL_RAD_PER_S: f32 = 0.05;
/// Density of blocks in kg/m3: beech.
const DENSITY: f32 = 700.0;
/// Distance from the finger within which contacts are looked for, in metres.
const LOOK_M: f64 = 0.005;
/// Damping of a rolling ball, in 1/s: as on felt under the table's paper.
const ROLLING_DAMPING: f32 = 0.8;
const TABLE_THICKNESS_M: f64 = 0.04;

/// The lengths that a world is built from, in metres.
#[derive(Clone, Debug, PartialEq)]
pub struct WorldSetup {
    /// Extent of the table along x, centred on 0.
    pub table_width_m: f64,
    /// First and last y of the table.
    pub table_y_m: (f64, f64),
    /// Coefficient of friction of everything.
    pub friction: f64,
    /// Radius of the finger's ball, whose centre is the finger's origin.
    pub ball_radius_m: f64,
    /// Radius of the finger's shaft.
    pub shaft_radius_m: f64,
    /// Where the shaft ends at the wrist, in the finger's frame.
    pub wrist_from_tip_m: Vector3<f64>,
    /// Form and size of each block. A ball is a block that rolls.
    pub blocks: Vec<Form>,
}

/// The gap between the finger and one block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Index of the block.
    pub block: usize,
    /// Distance between their surfaces in metres; negative when they overlap.
    pub distance_m: f64,
    /// From the finger to the block, a unit vector in the world.
    pub direction: Vector3<f64>,
}

/// The physical world.
pub struct World {
    physics: PhysicsWorld,
    finger: RigidBodyHandle,
    ball_radius_m: f64,
    shaft_radius_m: f64,
    wrist_from_tip_m: Point3<f64>,
    blocks: Vec<Block>,
}

struct Block {
    body: RigidBodyHandle,
    form: Form,
    present: bool,
}

impl World {
    /// A table, a finger standing at `finger`, and blocks that are not there yet.
    #[must_use]
    pub fn new(setup: &WorldSetup, finger: &Isometry3<f64>) -> Self {
        let mut physics = PhysicsWorld::new();
        physics.gravity = Vector::new(0.0, 0.0, -9.81);
        physics.integration_parameters.dt = 1.0 / STEPS_PER_S as f32;
        // Contacts kept from earlier steps let a kinematic finger sink up to 28 mm into a block.
        physics.integration_parameters.contact_recycling = false;
        let friction = setup.friction as f32;

        let (near_m, far_m) = setup.table_y_m;
        let half = vector(&Vector3::new(setup.table_width_m, far_m - near_m, TABLE_THICKNESS_M)) * 0.5;
        let centre = vector(&Vector3::new(0.0, (near_m + far_m) / 2.0, -TABLE_THICKNESS_M / 2.0));
        physics.insert(
            RigidBodyBuilder::fixed().translation(centre),
            ColliderBuilder::cuboid(half.x, half.y, half.z).friction(friction),
        );

        // The finger meets blocks and nothing else.
        let (finger_group, block_group) = (Group::GROUP_1, Group::GROUP_2);
        let only_blocks = InteractionGroups::new(finger_group, block_group, InteractionTestMode::And);
        let (finger, _) = physics.insert(
            RigidBodyBuilder::kinematic_position_based().pose(pose(finger)).can_sleep(false),
            ColliderBuilder::ball(setup.ball_radius_m as f32)
                .friction(friction)
                .collision_groups(only_blocks),
        );
        let shaft = ColliderBuilder::capsule_from_endpoints(
            Vector::ZERO,
            vector(&setup.wrist_from_tip_m),
            setup.shaft_radius_m as f32,
        );
        physics.insert_collider(shaft.friction(friction).collision_groups(only_blocks), Some(finger));

        let all = InteractionGroups::new(block_group, Group::ALL, InteractionTestMode::And);
        let blocks = setup.blocks.iter().map(|&form| {
            let half = form.half_m() as f32;
            let (shape, damping) = match form {
                Form::Cube(_) => (ColliderBuilder::cuboid(half, half, half), 0.0),
                Form::Ball(_) => (ColliderBuilder::ball(half), ROLLING_DAMPING),
            };
            let away = RigidBodyBuilder::dynamic().translation(Vector::new(0.0, 0.0, -1.0)).enabled(false);
            let shape = shape.density(DENSITY).friction(friction).collision_groups(all);
            let (body, _) = physics.insert(away.angular_damping(damping), shape);
            Block { body, form, present: false }
        });
        let blocks = blocks.collect();
        let wrist_from_tip_m = Point3::from(setup.wrist_from_tip_m);
        let WorldSetup { ball_radius_m, shaft_radius_m, .. } = *setup;
        Self { physics, finger, ball_radius_m, shaft_radius_m, wrist_from_tip_m, blocks }
    }

    /// How many blocks there are, present or not.
    #[must_use]
    pub fn block_count(&self) -> usize {
        self.blocks.len()
    }

    /// A block's form and size.
    #[must_use]
    pub fn form(&self, block: usize) -> Form {
        self.blocks[block].form
    }

    /// The pose of a block's centre. None when the block is not on the table.
    #[must_use]
    pub fn block(&self, block: usize) -> Option<Isometry3<f64>> {
        let block = self.blocks.get(block).filter(|block| block.present)?;
        Some(isometry(self.physics.bodies[block.body].position()))
    }

    /// Puts a block on the table, upright: x, y of its centre and its turn about the vertical.
    pub fn place_block(&mut self, block: usize, (x_m, y_m): (f64, f64), yaw_rad: f64) {
        let block = &mut self.blocks[block];
        block.present = true;
        let (sine, cosine) = libm::sincos(yaw_rad / 2.0);
        let turn = UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(cosine, 0.0, 0.0, sine));
        let at = Isometry3::from_parts(Translation3::new(x_m, y_m, block.form.half_m()), turn);
        let body = &mut self.physics.bodies[block.body];
        body.set_enabled(true);
        body.set_position(pose(&at), true);
        body.set_linvel(Vector::ZERO, true);
        body.set_angvel(Vector::ZERO, true);
    }

    /// Takes a block away.
    pub fn remove_block(&mut self, block: usize) {
        let block = &mut self.blocks[block];
        block.present = false;
        self.physics.bodies[block.body].set_enabled(false);
    }

    /// Advances everything by one step of the physics, the finger to `finger`. Lost blocks are not looked for.
    pub fn step_alone(&mut self, finger: &Isometry3<f64>) {
        self.physics.bodies[self.finger].set_next_kinematic_position(pose(finger));
        self.physics.step();
    }

    /// Puts blocks and finger where they are in another world that was built from the same setup.
    pub fn be_as(&mut self, other: &Self) {
        for (own, others) in self.blocks.iter_mut().zip(&other.blocks) {
            own.present = others.present;
            let at = *other.physics.bodies[others.body].position();
            let body = &mut self.physics.bodies[own.body];
            body.set_enabled(others.present);
            body.set_position(at, true);
            body.set_linvel(Vector::ZERO, true);
            body.set_angvel(Vector::ZERO, true);
        }
        let finger = *other.physics.bodies[other.finger].position();
        self.physics.bodies[self.finger].set_position(finger, true);
    }

    /// Advances everything by one step, the finger to `finger`. Returns the indexes of the blocks that were lost in it.
    pub fn step(&mut self, finger: &Isometry3<f64>) -> Vec<usize> {
        self.step_alone(finger);
        let lost = |world: &Self, index: usize| {
            let block = &world.blocks[index];
            let at = world.physics.bodies[block.body].translation();
            // A block whose position is not finite counts as lost, too.
            block.present && !(at.is_finite() && f64::from(at.z) > -LOST_BELOW_M)
        };
        let gone: Vec<usize> = (0..self.blocks.len()).filter(|&index| lost(self, index)).collect();
        for &index in &gone {
            self.remove_block(index);
        }
        gone
    }

    /// Puts the finger elsewhere at once, touching nothing on the way.
    pub fn carry_finger(&mut self, finger: &Isometry3<f64>) {
        self.physics.bodies[self.finger].set_position(pose(finger), true);
    }

    /// Whether every block rests.
    #[must_use]
    pub fn is_still(&self) -> bool {
        self.blocks.iter().filter(|block| block.present).all(|block| {
            let body = &self.physics.bodies[block.body];
            body.is_sleeping()
                || (body.linvel().length() < STILL_M_PER_S && body.angvel().length() < STILL_RAD_PER_S)
        })
    }

    /// Speed of a block in metres a second.
    #[must_use]
    pub fn block_speed(&self, block: usize) -> f64 {
        f64::from(self.physics.bodies[self.blocks[block].body].linvel().length())
    }

    /// How far the finger's tip is from the nearest block's centre, in metres; infinite without blocks.
    #[must_use]
    pub fn nearest_block_m(&self, tip: &Point3<f64>) -> f64 {
        let present = (0..self.blocks.len()).filter_map(|index| self.block(index));
        present.map(|at| (at.translation.vector - tip.coords).norm()).fold(f64::INFINITY, f64::min)
    }

    /// The gaps to the blocks within a few millimetres of the finger, in the order of the blocks.
    #[must_use]
    pub fn gaps(&self) -> Vec<Gap> {
        (0..self.blocks.len()).filter_map(|index| self.gap(index)).collect()
    }

    fn gap(&self, index: usize) -> Option<Gap> {
        let at = self.block(index)?;
        let form = self.blocks[index].form;
        let finger = isometry(self.physics.bodies[self.finger].position());
        let tip = Point3::from(finger.translation.vector);
        let wrist = finger * self.wrist_from_tip_m;
        let parts = [(tip, tip, self.ball_radius_m), (tip, wrist, self.shaft_radius_m)];
        let centre = Point3::from(at.translation.vector);
        if !parts.iter().any(|part| near(*part, &centre, form, LOOK_M)) {
            return None;
        }
        let gaps = parts.map(|part| gap(part, &at, form));
        let (distance_m, direction) = if gaps[1].0 < gaps[0].0 { gaps[1] } else { gaps[0] };
        (distance_m < LOOK_M).then_some(Gap { block: index, distance_m, direction })
    }
}

fn vector(v: &Vector3<f64>) -> Vector {
    Vector::new(v.x as f32, v.y as f32, v.z as f32)
}

fn pose(at: &Isometry3<f64>) -> Pose {
    let r = at.rotation.coords.map(|x| x as f32);
    Pose::from_parts(vector(&at.translation.vector), Rotation::from_xyzw(r.x, r.y, r.z, r.w))
}

fn isometry(pose: &Pose) -> Isometry3<f64> {
    let (t, r) = (pose.translation, pose.rotation);
    let turn = nalgebra::Quaternion::new(f64::from(r.w), f64::from(r.x), f64::from(r.y), f64::from(r.z));
    let translation = Translation3::new(f64::from(t.x), f64::from(t.y), f64::from(t.z));
    Isometry3::from_parts(translation, UnitQuaternion::new_normalize(turn))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, y: f64, z: f64) -> Isometry3<f64> {
        Isometry3::translation(x, y, z)
    }

    fn world(finger: &Isometry3<f64>) -> World {
        let setup = WorldSetup {
            table_width_m: 1.0,
            table_y_m: (-0.5, 0.5),
            friction: 0.9,
            ball_radius_m: 0.008,
            shaft_radius_m: 0.003,
            wrist_from_tip_m: Vector3::new(0.0, -0.08, 0.115),
            blocks: vec![Form::Cube(0.0125), Form::Cube(0.0125)],
        };
        World::new(&setup, finger)
    }

    #[test]
    fn a_block_stands_where_it_is_put_until_it_is_taken_away() {
        let away = at(0.0, -0.4, 0.3);
        let mut world = world(&away);
        assert_eq!(world.block(0), None);
        world.place_block(0, (0.1, 0.2), 0.3);
        for _ in 0..480 {
            assert!(world.step(&away).is_empty());
        }
        let stands = world.block(0).unwrap();
        assert!((stands.translation.vector - Vector3::new(0.1, 0.2, 0.0125)).norm() < 1e-3, "{stands}");
        assert!(world.is_still() && world.gaps().is_empty());
        world.remove_block(0);
        assert_eq!(world.block(0), None);
    }

    /// Contacts kept from earlier steps once let the finger sink 28 mm into a block it pushed.
    #[test]
    fn the_finger_pushes_a_block_and_does_not_sink_into_it() {
        let mut world = world(&at(0.0, -0.05, 0.012));
        world.place_block(0, (0.0, 0.0), 0.0);
        let mut deepest_m = 0.0_f64;
        for step in 0..240 {
            world.step(&at(0.0, -0.05 + 0.1 * f64::from(step) / 240.0, 0.012));
            for gap in world.gaps() {
                deepest_m = deepest_m.max(-gap.distance_m);
                assert!(gap.direction.y > 0.5, "the block is ahead: {gap:?}");
            }
        }
        let pushed_m = world.block(0).unwrap().translation.vector.y;
        assert!((0.06..0.09).contains(&pushed_m), "{pushed_m} m");
        assert!(deepest_m < 0.0015, "{deepest_m} m deep");
    }

    #[test]
    fn a_block_off_the_table_is_lost_once_and_can_be_placed_again() {
        let away = at(0.0, -0.4, 0.3);
        let mut world = world(&away);
        world.place_block(1, (0.7, 0.0), 0.0);
        let lost: Vec<usize> = (0..240).flat_map(|_| world.step(&away)).collect();
        assert_eq!(lost, [1]);
        assert_eq!(world.block(1), None);
        assert_eq!(world.nearest_block_m(&Point3::origin()), f64::INFINITY);
        world.place_block(1, (0.0, 0.0), 0.0);
        assert!(world.step(&away).is_empty() && world.block(1).is_some());
    }
}
