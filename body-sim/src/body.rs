//! The simulated body: what it senses, how it moves, and what can be arranged around it.

use nalgebra::{Isometry3, Translation3};
use pschema_arm::route::{Heading, OUTWARDS, Waypoint};
use pschema_arm::{ArmIds, FileError, JointPositions, Percept, field_marks, object_symbol};
use pschema_protocol::body::{Body, Outcome, Senses};
use pschema_protocol::description::{Action, Description, Value};
use pschema_protocol::picture::{FieldMark, Picture};
use pschema_vision::blobs::Blob;
use pschema_vision::image::RgbImage;

use crate::camera::Renderer;
use crate::config::{ObjectEntry, WORLD_FILE, WorldFile};
use crate::declare;
use crate::eye::{self, Eye, Sighting};
use crate::kinematics::Posture;
use crate::noise::SenseNoise;
use crate::objects::Hand;
use crate::pace::Pace;
use crate::scene::{fixed, solids, table_top};
use crate::touch;
use crate::workspace::Workspace;
use crate::world::{World, WorldSetup};

mod driven;
mod moves;

/// An arm, a table, blocks and a camera.
pub struct SimBody {
    description: Description,
    ids: ArmIds,
    workspace: Workspace,
    world: World,
    renderer: Renderer,
    eye: Eye,
    hand: Hand,
    faults: SenseNoise,
    /// The places of the visual fields in the picture, for people who look at it.
    marks: Vec<FieldMark>,
    pace: Option<Pace>,
    /// The point that the finger is at.
    at: Waypoint,
    /// The direction in which the finger came there.
    heading: Heading,
    posture: Posture,
    /// For each block, steps since it last touched the finger.
    apart_steps: Vec<u32>,
    steps: u64,
    /// The pose of the finger after each step, while a measurement wants to know it.
    path: Option<Vec<Isometry3<f64>>>,
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
    ) -> Result<Self, FileError> {
        let inconsistent = |problem| WORLD_FILE.inconsistent(world_name, None, problem);
        let workspace = Workspace::new(world_name, file)?;
        let eye = eye::for_world(&workspace.file).map_err(|e| inconsistent(e.to_string()))?;
        for (index, colour) in workspace.file.colours.iter().enumerate() {
            if eye.colour_of(colour.paint_rgb) != Some(index) {
                let name = &colour.name;
                return Err(inconsistent(format!(
                    "colour {name}: its paint_rgb is not seen as {name}; correct paint_rgb or hue_deg"
                )));
            }
        }
        let top = table_top(&workspace.file);
        let renderer = Renderer::new(&workspace.camera, top, &fixed(&workspace.file))
            .map_err(|e| inconsistent(e.to_string()))?;
        let at = at_rest(&workspace);
        let posture = workspace
            .arm
            .posture_by(&workspace.manifold, at)
            .ok_or_else(|| inconsistent("the arm does not reach its rest posture".into()))?;
        let world = World::new(&world_setup(&workspace), &finger_pose(&posture));
        let (description, ids) = declare::declare(name, world_name, &workspace);
        Ok(Self {
            description,
            ids,
            apart_steps: vec![u32::MAX; world.block_count()],
            world,
            renderer,
            eye,
            marks: field_marks(&workspace.fields),
            hand: Hand::new(seed),
            faults: SenseNoise::new(workspace.file.noise, seed),
            pace: realtime.then(Pace::default),
            at,
            heading: OUTWARDS,
            posture,
            steps: 0,
            path: None,
            workspace,
        })
    }

    /// The ids of what the body declares.
    #[must_use]
    pub fn ids(&self) -> ArmIds {
        self.ids
    }

    /// The work space.
    #[must_use]
    pub fn workspace(&self) -> &Workspace {
        &self.workspace
    }

    /// The physical world, to be looked at.
    #[must_use]
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The posture of the arm now.
    #[must_use]
    pub fn posture(&self) -> &Posture {
        &self.posture
    }

    /// Steps of simulated time so far, each [`crate::world::STEP_S`] long.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// The pose of the finger.
    #[must_use]
    pub fn finger_pose(&self) -> Isometry3<f64> {
        finger_pose(&self.posture)
    }

    /// The physics engine by itself, in a world built like this body's: with the same blocks, none of them on the table.
    #[must_use]
    pub fn bare_world(&self) -> World {
        World::new(&world_setup(&self.workspace), &self.finger_pose())
    }

    /// Records the pose of the finger after each step, until [`Self::take_path`].
    pub fn record_path(&mut self) {
        self.path = Some(Vec::new());
    }

    /// The poses that were recorded, one a step. The recording ends.
    pub fn take_path(&mut self) -> Vec<Isometry3<f64>> {
        self.path.take().unwrap_or_default()
    }

    /// Takes a picture and looks at it.
    pub fn look(&mut self) -> (&RgbImage, Sighting) {
        self.render();
        let seen = self.look_at_picture();
        (self.renderer.image(), seen)
    }

    /// Takes a picture. Each picture is to be looked at before the next one is taken.
    pub fn render(&mut self) {
        self.renderer.render(&solids(&self.workspace.file, &self.world, &self.posture));
    }

    /// Looks at the picture that was just taken, where it differs from the one before.
    pub fn look_at_picture(&mut self) -> Sighting {
        self.eye.look_again(self.renderer.image(), self.renderer.changed())
    }

    /// Looks at the whole picture, as at one of a camera that does not say which pixels have changed.
    pub fn look_at_all(&mut self) -> Sighting {
        self.eye.look(self.renderer.image())
    }

    /// The picture that was taken last.
    #[must_use]
    pub fn image(&self) -> &RgbImage {
        self.renderer.image()
    }

    /// Takes the arm to its rest posture, lifted clear of everything, as its operator does before reaching
    /// into the work space.
    fn park(&mut self) {
        let rest = at_rest(&self.workspace);
        if let Some(posture) = self.workspace.arm.posture_by(&self.workspace.manifold, rest) {
            self.world.carry_finger(&finger_pose(&posture));
            self.at = rest;
            self.heading = OUTWARDS;
            self.posture = posture;
            self.apart_steps.fill(u32::MAX);
        }
    }

    /// Puts an object down, the arm parked first.
    fn place(&mut self, object: usize, position: usize) -> Outcome {
        if position >= self.workspace.places.len() || object >= self.world.block_count() {
            return Outcome::refused("there is no such object or position");
        }
        self.park();
        self.put(object, position)
    }
}

impl Body for SimBody {
    fn describe(&self) -> Description {
        self.description.clone()
    }

    fn sense(&mut self, frame: &mut Senses) {
        let (_, seen) = self.look();
        let Self { workspace, faults, .. } = self;
        let finger_colour = workspace.file.finger_colour();
        let mut noticed = |blob: &Blob| {
            let (u, v) = blob.centre_px;
            workspace.fields.field_at(u, v).filter(|_| !faults.misses_blob())
        };
        let finger = seen.finger.as_ref().and_then(&mut noticed);
        let mut sensed = Percept::default();
        for (colour, blob) in &seen.objects {
            let symbol = object_symbol(*colour, finger_colour);
            let (Some(symbol), Some(field)) = (symbol, noticed(blob)) else { continue };
            sensed.objects.push((symbol, field));
        }
        sensed.finger = finger.map(|field| faults.finger_field(&workspace.fields, field));
        let gaps = self.world.gaps();
        sensed.touching = self.faults.touch(touch::touching(&gaps));
        if sensed.touching {
            sensed.sides = touch::sides(&gaps, &self.posture.finger_turn);
        }
        sensed.report(self.ids, frame);
    }

    fn picture(&mut self) -> Option<Picture<'_>> {
        let image = self.renderer.image();
        Some(Picture {
            width_px: u32::try_from(image.width_px()).ok()?,
            height_px: u32::try_from(image.height_px()).ok()?,
            rgb: image.as_rgb_bytes(),
            fields: &self.marks,
        })
    }

    fn act(&mut self, action: &Action) -> Outcome {
        let joints = |j1: f64, j2: f64| {
            let joints = JointPositions { j1, j2 };
            joints.are_commandable().then_some(joints)
        };
        let ordered = match action.parameters[..] {
            [Value::Real(j1), Value::Real(j2)] if action.id == self.ids.move_to => {
                joints(j1, j2).map(|to| self.go(to))
            }
            [Value::Real(j1), Value::Real(j2), Value::Real(to_j1), Value::Real(to_j2)]
                if Some(action.id) == self.ids.push =>
            {
                joints(j1, j2).zip(joints(to_j1, to_j2)).map(|(from, to)| self.push(from, to))
            }
            _ => None,
        };
        ordered.unwrap_or_else(|| {
            tracing::warn!(?action, "refused: not an action this body declared");
            Outcome::refused("not an action this body declared")
        })
    }

    fn arrange(&mut self, command: &Action) -> Outcome {
        match command.parameters[..] {
            [Value::Symbol(object), Value::Integer(position)] if command.id == self.ids.place => {
                // A position below 0 is none either.
                self.place(object as usize, usize::try_from(position).unwrap_or(usize::MAX))
            }
            [Value::Symbol(object)] if command.id == self.ids.remove => self.take_away(object as usize),
            [] if command.id == self.ids.park => {
                self.park();
                Outcome::Done
            }
            _ => {
                tracing::warn!(?command, "refused: not a scene command this body declared");
                Outcome::refused("not a scene command this body declared")
            }
        }
    }
}

fn world_setup(workspace: &Workspace) -> WorldSetup {
    let file = &workspace.file;
    let top = table_top(file);
    WorldSetup {
        table_width_m: top.width_m,
        table_y_m: top.y_m,
        friction: file.table.friction.get(),
        ball_radius_m: file.finger.ball_radius_mm.metres(),
        shaft_radius_m: file.finger.shaft_radius_mm.metres(),
        wrist_from_tip_m: workspace.arm.wrist_from_tip(),
        blocks: file.objects.iter().map(ObjectEntry::form).collect(),
    }
}

fn at_rest(workspace: &Workspace) -> Waypoint {
    Waypoint { joints: workspace.manifold.rest(), lift_m: 0.0 }
}

fn finger_pose(posture: &Posture) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::from(posture.tip_m.coords), posture.finger_turn)
}
