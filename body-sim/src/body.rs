//! The simulated body: what it senses, how it moves, and what can be arranged around it.

use nalgebra::{Isometry3, Translation3};
use pschema_protocol::body::{Body, Outcome, Senses};
use pschema_protocol::description::{Action, Description, Value};
use pschema_vision::image::RgbImage;

use crate::arm::{Motion, Posture};
use crate::camera::Renderer;
use crate::config::{WorldError, WorldFile};
use crate::declare::{self, action, observation, scene};
use crate::eye::{Eye, Seen};
use crate::manifold::JointPositions;
use crate::objects::{Hand, Refusal};
use crate::pace::Pace;
use crate::scene::{solids, table_top};
use crate::touch::{self, GIVE_M};
use crate::workspace::Workspace;
use crate::world::{Gap, STEP_S, World, WorldSetup};

/// A block apart from the finger for this many steps meets it anew when it meets it again.
const APART_STEPS_MIN: u32 = 10;
/// Overlap at which the arm stalls rather than push on, in metres.
const BLOCKED_M: f64 = 0.002;
/// After first contact the finger creeps on at this speed, to come to rest against the block, not short of
/// it, in metres a second;
const PRESS_M_PER_S: f64 = 0.03;
/// for at most this way, in metres,
const PRESS_M_MAX: f64 = 0.006;
/// until it has stayed in contact for this many steps.
const PRESS_STEPS: u32 = 6;
/// Longest wait for blocks to come to rest, in steps.
const SETTLE_STEPS_MAX: u32 = 240;
/// Farther than this from every block, and none moving, the finger can meet nothing in one step.
const MEETING_M: f64 = 0.08;

/// An arm, a table, blocks and a camera.
pub struct SimBody {
    name: String,
    workspace: Workspace,
    world: World,
    renderer: Renderer,
    eye: Eye,
    hand: Hand,
    pace: Option<Pace>,
    joints: JointPositions,
    posture: Posture,
    /// For each block, steps since it last touched the finger.
    apart_steps: Vec<u32>,
    steps: u64,
}

/// How a motion ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ended {
    Arrived,
    Touched,
    Blocked,
    OutOfTime,
    OffManifold,
}

impl SimBody {
    /// A body called `name` in a world, its arm at rest, no block on the table. `realtime` paces it to the
    /// clock on the wall.
    ///
    /// # Errors
    /// When the world file's parts do not fit together.
    pub fn new(
        name: &str,
        file: WorldFile,
        world_name: &str,
        seed: u64,
        realtime: bool,
    ) -> Result<Self, WorldError> {
        let inconsistent =
            |problem: String| WorldError::Inconsistent { name: world_name.to_owned(), problem };
        let workspace = Workspace::new(world_name, file)?;
        let eye = Eye::new(&workspace.file).map_err(|e| inconsistent(e.to_string()))?;
        for (index, colour) in workspace.file.colours.iter().enumerate() {
            if eye.colour_of(colour.paint_rgb) != Some(index) {
                let name = &colour.name;
                return Err(inconsistent(format!(
                    "colour {name}: its paint_rgb is not seen as {name}; correct paint_rgb or hue_deg"
                )));
            }
        }
        let top = table_top(&workspace.file);
        let renderer = Renderer::new(&workspace.camera, top).map_err(|e| inconsistent(e.to_string()))?;
        let joints = workspace.manifold.rest();
        let posture = workspace
            .arm
            .posture_at(&workspace.manifold, joints)
            .ok_or_else(|| inconsistent("the arm does not reach its rest posture".into()))?;
        let file = &workspace.file;
        let setup = WorldSetup {
            table_width_m: top.width_m,
            table_y_m: top.y_m,
            friction: file.table.friction.get(),
            ball_radius_m: file.finger.ball_radius_mm.metres(),
            shaft_radius_m: file.finger.shaft_radius_mm.metres(),
            wrist_from_tip_m: workspace.arm.wrist_from_tip(),
            block_sides_m: file.objects.iter().map(|object| object.side_mm.metres()).collect(),
        };
        let world = World::new(&setup, &finger_pose(&posture));
        Ok(Self {
            name: name.to_owned(),
            apart_steps: vec![u32::MAX; world.block_count()],
            world,
            renderer,
            eye,
            hand: Hand::new(seed),
            pace: realtime.then(Pace::new),
            joints,
            posture,
            steps: 0,
            workspace,
        })
    }

    /// The work space.
    #[must_use]
    pub fn workspace(&self) -> &Workspace {
        &self.workspace
    }

    /// The physical world, to look at.
    #[must_use]
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Where the arm is.
    #[must_use]
    pub fn posture(&self) -> &Posture {
        &self.posture
    }

    /// Steps of simulated time so far, each [`STEP_S`] long.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Takes a picture and looks at it.
    pub fn look(&mut self) -> (&RgbImage, Seen) {
        let image = self.renderer.render(&solids(&self.workspace.file, &self.world, &self.posture));
        let seen = self.eye.look(image);
        (image, seen)
    }

    /// Goes to joint positions: until there, a new contact (the touch reflex), stalled, or out of time.
    fn go(&mut self, to: JointPositions) -> Outcome {
        let Some(motion) = self.workspace.arm.motion(&self.workspace.manifold, self.joints, to) else {
            tracing::debug!(j1 = to.j1, j2 = to.j2, "refused: beyond the end of the arm's manifold");
            return Outcome::Refused;
        };
        let ended = self.follow(&motion);
        self.settle();
        tracing::debug!(j1 = to.j1, j2 = to.j2, ?ended, steps = self.steps, "moved");
        match ended {
            Ended::Arrived | Ended::Touched | Ended::Blocked => Outcome::Done,
            Ended::OutOfTime => Outcome::TimedOut,
            Ended::OffManifold => Outcome::Failed,
        }
    }

    fn follow(&mut self, motion: &Motion) -> Ended {
        let limit_s = self.workspace.file.arm.move_time_max_s.get();
        let steps = (motion.duration_s / STEP_S).ceil();
        let mut step = 0.0;
        while step < steps {
            step += 1.0;
            let time_s = step * STEP_S;
            if time_s > limit_s {
                return Ended::OutOfTime;
            }
            if !self.advance(motion.joints_at(time_s)) {
                return Ended::OffManifold;
            }
            let (new_contact, overlap_m) = self.feel();
            if overlap_m > BLOCKED_M {
                return Ended::Blocked;
            }
            if new_contact {
                return self.press(motion, Motion::share(time_s / motion.duration_s));
            }
        }
        Ended::Arrived
    }

    /// Slows to a creep along the rest of the way, until the finger rests against what it has met.
    fn press(&mut self, motion: &Motion, from_share: f64) -> Ended {
        let manifold = &self.workspace.manifold;
        let across_m = (motion.to.j1 - motion.from.j1) * 2.0 * manifold.lateral_max_m;
        let outwards_m = (motion.to.j2 - motion.from.j2) * (manifold.arc_max_m - manifold.nearest_m);
        let way_m = (across_m * across_m + outwards_m * outwards_m).sqrt().max(1e-6);
        let creep = PRESS_M_PER_S * STEP_S / way_m;
        let (mut share, mut held) = (from_share, 0);
        while share < (from_share + PRESS_M_MAX / way_m).min(1.0) && held < PRESS_STEPS {
            share = (share + creep).min(1.0);
            if !self.advance(motion.joints_along(share)) {
                return Ended::OffManifold;
            }
            let (_, overlap_m) = self.feel();
            if overlap_m > BLOCKED_M {
                return Ended::Blocked;
            }
            held = if self.resting_contact() { held + 1 } else { 0 };
        }
        Ended::Touched
    }

    /// Whether the finger touches a block that does not slide away from it.
    fn resting_contact(&self) -> bool {
        let close = |gap: &Gap| {
            gap.distance_m < GIVE_M / 2.0 && self.world.block_speed(gap.block) < 1.5 * PRESS_M_PER_S
        };
        self.world.gaps().iter().any(close)
    }

    /// One step of time with the arm going to `joints`. False when the arm cannot be there.
    fn advance(&mut self, joints: JointPositions) -> bool {
        let Some(posture) = self.workspace.arm.posture_at(&self.workspace.manifold, joints) else {
            return false;
        };
        let finger = finger_pose(&posture);
        if self.world.nearest_block_m(&posture.tip_m) > MEETING_M && self.world.is_still() {
            self.world.carry_finger(&finger);
        } else {
            self.step_world(&finger);
        }
        self.joints = joints;
        self.posture = posture;
        self.passed_a_step();
        true
    }

    /// Contacts after a step: whether one is new, and the deepest overlap in metres.
    fn feel(&mut self) -> (bool, f64) {
        let (mut new_contact, mut overlap_m) = (false, 0.0_f64);
        let gaps = self.world.gaps();
        for (block, apart) in self.apart_steps.iter_mut().enumerate() {
            *apart = apart.saturating_add(1);
            let Some(gap) = gaps.iter().find(|gap| gap.block == block) else { continue };
            overlap_m = overlap_m.max(-gap.distance_m);
            if gap.distance_m <= GIVE_M {
                new_contact |= *apart > APART_STEPS_MIN;
                *apart = 0;
            }
        }
        (new_contact, overlap_m)
    }

    /// Holds the arm until all blocks rest.
    fn settle(&mut self) {
        let finger = finger_pose(&self.posture);
        let mut waited = 0;
        while waited < SETTLE_STEPS_MAX && !self.world.is_still() {
            self.step_world(&finger);
            self.passed_a_step();
            waited += 1;
        }
        self.feel();
    }

    fn step_world(&mut self, finger: &Isometry3<f64>) {
        for lost in self.world.step(finger) {
            let name = self.workspace.file.objects.get(lost).map_or("?", |object| object.name.as_str());
            tracing::warn!(object = name, "fell off the table and is lost; place it again to go on with it");
        }
    }

    fn passed_a_step(&mut self) {
        self.steps += 1;
        if let Some(pace) = &mut self.pace {
            pace.step();
        }
    }

    /// Takes the arm to its rest posture, lifted clear of everything, as its operator does before reaching
    /// into the work space.
    fn park(&mut self) {
        let rest = self.workspace.manifold.rest();
        if let Some(posture) = self.workspace.arm.posture_at(&self.workspace.manifold, rest) {
            self.world.carry_finger(&finger_pose(&posture));
            self.joints = rest;
            self.posture = posture;
            self.apart_steps.fill(u32::MAX);
        }
    }

    fn place(&mut self, object: usize, position: usize) -> Outcome {
        let Some(place) = self.workspace.places.get(position).copied() else { return Outcome::Refused };
        if object >= self.world.block_count() {
            return Outcome::Refused;
        }
        self.park();
        match self.hand.place(&mut self.world, &self.workspace, object, &place) {
            Ok(()) => {
                self.settle();
                Outcome::Done
            }
            Err(Refusal::Occupied { by }) => {
                let by = self.workspace.file.objects.get(by).map_or("?", |other| other.name.as_str());
                tracing::warn!(position, by, "refused: another object is in the way; remove it first");
                Outcome::Refused
            }
        }
    }

    fn remove(&mut self, object: usize) -> Outcome {
        if object >= self.world.block_count() {
            return Outcome::Refused;
        }
        self.world.remove_block(object);
        Outcome::Done
    }
}

impl Body for SimBody {
    fn describe(&self) -> Description {
        declare::description(&self.name, &self.workspace)
    }

    fn sense(&mut self, frame: &mut Senses) {
        let (_, seen) = self.look();
        let field_at = |(u, v): (f64, f64)| {
            self.workspace.fields.field_at(u, v).map(|field| Value::Integer(field as i64))
        };
        if let Some(field) = seen.finger.and_then(|blob| field_at(blob.centre_px)) {
            frame.observe(observation::FINGER, &[Value::Symbol(0), field]);
        }
        let mut objects: Vec<[Value; 2]> = Vec::new();
        for (colour, blob) in &seen.objects {
            let symbol = declare::colour_symbol(&self.workspace.file, *colour);
            let (Some(symbol), Some(field)) = (symbol, field_at(blob.centre_px)) else { continue };
            let observed = [Value::Symbol(symbol), field];
            // Two things of one colour in one field are one observation.
            if !objects.contains(&observed) {
                frame.observe(observation::OBJECT, &observed);
                objects.push(observed);
            }
        }
        let gaps = self.world.gaps();
        if touch::touching(&gaps) {
            frame.observe(observation::TOUCH, &[]);
            for side in touch::sides(&gaps, &self.posture.finger_turn) {
                frame.observe(observation::CONTACT, &[Value::Symbol(side as u32)]);
            }
        }
    }

    fn act(&mut self, action: &Action) -> Outcome {
        match (action.action, action.parameters.as_slice()) {
            (action::MOVE, &[Value::Real(j1), Value::Real(j2)])
                if (0.0..=1.0).contains(&j1) && (0.0..=1.0).contains(&j2) =>
            {
                self.go(JointPositions { j1, j2 })
            }
            _ => {
                tracing::warn!(?action, "refused: not an action this body declared");
                Outcome::Refused
            }
        }
    }

    fn arrange(&mut self, command: &Action) -> Outcome {
        match (command.action, command.parameters.as_slice()) {
            (scene::PLACE, &[Value::Symbol(object), Value::Integer(position)]) => usize::try_from(position)
                .map_or(Outcome::Refused, |position| self.place(object as usize, position)),
            (scene::REMOVE, &[Value::Symbol(object)]) => self.remove(object as usize),
            (scene::PARK, []) => {
                self.park();
                Outcome::Done
            }
            _ => {
                tracing::warn!(?command, "refused: not a scene command this body declared");
                Outcome::Refused
            }
        }
    }
}

fn finger_pose(posture: &Posture) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::from(posture.tip_m.coords), posture.finger_turn)
}
