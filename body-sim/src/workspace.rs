//! The work space that a world file describes: the fields that the finger can be seen in, with the posture taught for
//! each, and the places for blocks.

use nalgebra::Point3;
use pschema_arm::route::Waypoint;
use pschema_arm::{FileError, JOINT_RESOLUTION, JointPositions, PointMm};
use pschema_vision::camera::{Camera, CameraSetup};
use pschema_vision::fields::VisualFields;

use crate::config::{PushEntry, WORLD_FILE, WorldFile};
use crate::kinematics::Kinematics;
use crate::manifold::{Manifold, ManifoldSetup, OnManifold};

/// Height of a block's apparent centre, as a share of its edge: the camera above sees its top and one side.
const SEEN_HEIGHT_SHARE: f64 = 0.8;
/// The arm's joints stay at least this far above the table, so that only the finger can meet a block.
const JOINT_HEIGHT_M_MIN: f64 = 0.08;
/// The finger passes over a block beyond reach by at least this, in metres.
const CLEARANCE_M: f64 = 0.004;

/// A taught posture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TaughtPosture {
    /// The visual field that the finger is then seen in.
    pub field: usize,
    /// The joint positions, whole multiples of [`JOINT_RESOLUTION`].
    pub joints: JointPositions,
    /// Whether the tip is then at table height; otherwise it is raised on the rim.
    pub flat: bool,
}

/// A push in the repertoire.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TaughtPush {
    /// Where the finger is set down, in whole multiples of [`JOINT_RESOLUTION`].
    pub from: JointPositions,
    /// Where the push ends, in whole multiples of [`JOINT_RESOLUTION`].
    pub to: JointPositions,
}

/// A place for a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TablePlace {
    /// The visual field that a block there is seen in.
    pub field: usize,
    /// The block's centre on the table in metres: x, y.
    pub centre_m: (f64, f64),
    /// Whether the arm can touch a block there; otherwise it can only point at it.
    pub within_reach: bool,
}

/// Everything in a world that does not change.
#[derive(Clone, Debug)]
pub struct Workspace {
    /// The world file.
    pub file: WorldFile,
    /// The geometry of the arm.
    pub arm: Kinematics,
    /// The manifold that the finger tip works on.
    pub manifold: Manifold,
    /// The geometry of the camera.
    pub camera: Camera,
    /// The visual fields of the camera's picture.
    pub fields: VisualFields,
    /// One posture for each reachable field, ordered by field.
    pub taught: Vec<TaughtPosture>,
    /// The pushes that the file lists.
    pub pushes: Vec<TaughtPush>,
    /// Places for blocks: those within reach first, then those beyond, each ordered by field; then those that
    /// the file lists.
    pub places: Vec<TablePlace>,
}

impl Workspace {
    /// Works out the work space of a world file.
    ///
    /// # Errors
    /// When the parts do not fit together, or the fields and places do not come out in the numbers that
    /// the file states.
    pub fn new(name: &str, file: WorldFile) -> Result<Self, FileError> {
        Self::build(file).map_err(|problem| WORLD_FILE.inconsistent(name, None, problem))
    }

    fn build(file: WorldFile) -> Result<Self, String> {
        let arm = Kinematics::new(&file.arm);
        let (reach_centre_m, reach_radius_m) = arm.reach_m();
        let manifold = Manifold::new(ManifoldSetup {
            tip_height_m: file.manifold.tip_height_mm.metres(),
            rim_height_m: file.manifold.rim_height_mm.metres(),
            nearest_m: file.manifold.nearest_mm.metres(),
            rest_m: file.manifold.rest_mm.metres(),
            lateral_max_m: file.manifold.lateral_max_mm.metres(),
            reach_centre_m,
            reach_radius_m,
        })?;
        check_arm(&file, &arm, &manifold)?;
        let camera = camera(&file)?;
        let (width_px, height_px) = (camera.setup().width_px, camera.setup().height_px);
        let fields = file.vision.fields(width_px, height_px).map_err(|e| e.to_string())?;
        let mut workspace = Self {
            file,
            arm,
            manifold,
            camera,
            fields,
            taught: Vec::new(),
            pushes: Vec::new(),
            places: Vec::new(),
        };
        workspace.check_rest_is_out_of_sight()?;
        workspace.taught = workspace.teach();
        let (found, stated) = (workspace.taught.len(), workspace.file.repertoire.fields.count());
        if found != stated {
            return Err(format!(
                "the finger can be seen in {found} fields, but repertoire.fields states {stated}; change the number, \
                 or the arm's lengths, the camera or vision.field_pitch_px"
            ));
        }
        workspace.pushes =
            workspace.file.pushes.iter().map(|push| workspace.pushing(push)).collect::<Result<_, _>>()?;
        workspace.places = workspace.lay_places()?;
        Ok(workspace)
    }

    /// The posture taught for a field.
    #[must_use]
    pub fn taught_for(&self, field: usize) -> Option<&TaughtPosture> {
        self.taught.binary_search_by_key(&field, |taught| taught.field).ok().map(|index| &self.taught[index])
    }

    /// At rest the finger is out of the picture, so that an empty table looks empty.
    fn check_rest_is_out_of_sight(&self) -> Result<(), String> {
        let Some(rest) = self.manifold.at(self.manifold.rest()) else {
            return Err("the rest posture is not on the manifold; lower manifold.rest_mm".into());
        };
        let tip = self.manifold.tip(rest);
        let ball_m = self.file.finger.ball_radius_mm.metres();
        let radius_px = ball_m * self.camera.setup().focal_px / self.camera.depth_m(&tip).max(ball_m);
        match self.camera.project(&tip) {
            Some((u, v)) if self.inside_px(u, v, -2.0 * radius_px) => Err(format!(
                "at rest the finger is in sight, at ({u:.0}, {v:.0}) px; lower manifold.rest_mm or move the camera out"
            )),
            _ => Ok(()),
        }
    }

    /// Shows the arm, field by field, the posture in which its finger is at the field's centre.
    fn teach(&self) -> Vec<TaughtPosture> {
        let edge_px = self.file.repertoire.edge_px.get();
        let taught = self.fields.centres_px().iter().enumerate().filter_map(|(field, &(u, v))| {
            if !self.inside_px(u, v, edge_px) {
                return None;
            }
            let joints = rounded(self.manifold.joints(self.manifold.seen_at(&self.camera, u, v)?));
            // Rounded joint positions may lie beyond the end of the rim.
            let point = self.manifold.at(joints).filter(|_| joints.are_commandable())?;
            Some(TaughtPosture { field, joints, flat: self.manifold.is_flat(point) })
        });
        taught.collect()
    }

    fn pushing(&self, push: &PushEntry) -> Result<TaughtPush, String> {
        let joints = |point_mm: &PointMm| {
            let (x_m, y_m) = (point_mm[0].metres(), point_mm[1].metres());
            let joints = rounded(self.manifold.square.joints((x_m, y_m)));
            let flat = self.manifold.at(joints).is_some_and(|point| self.manifold.is_flat(point));
            if joints.are_commandable() && flat {
                return Ok(joints);
            }
            Err(format!(
                "a push at ({:.0}, {:.0}) mm: not a point that the finger reaches over the table; it must be {:.0} \
                 to {:.0} mm from the base and y at least {:.0} mm",
                x_m * 1e3,
                y_m * 1e3,
                self.manifold.square.nearest_m * 1e3,
                self.manifold.flat_reach_m * 1e3,
                self.manifold.square.nearest_m * 1e3
            ))
        };
        Ok(TaughtPush { from: joints(&push.from_mm)?, to: joints(&push.to_mm)? })
    }

    fn lay_places(&self) -> Result<Vec<TablePlace>, String> {
        let positions = &self.file.positions;
        let within = self.candidates(|taught| taught.flat, true);
        let beyond = self.candidates(|taught| !taught.flat, false);
        let mut places = Vec::new();
        for (what, candidates, wanted) in [
            ("positions.table", within, positions.table.count()),
            ("positions.beyond_reach", beyond, positions.beyond_reach.count()),
        ] {
            if candidates.is_empty() && wanted > 0 {
                return Err(format!(
                    "{what} is {wanted}, but there is no such field; make it 0 or change the set-up"
                ));
            }
            // Spread evenly over all candidates. When there are more places than fields, some share a field.
            places.extend((0..wanted).map(|index| candidates[index * candidates.len() / wanted]));
        }
        for point_mm in &positions.at_mm {
            places.push(self.listed(point_mm)?);
        }
        Ok(places)
    }

    /// A place that the file lists.
    fn listed(&self, point_mm: &PointMm) -> Result<TablePlace, String> {
        let (x, y) = (point_mm[0].metres(), point_mm[1].metres());
        let apparent = Point3::new(x, y, self.block_side_m_max() * SEEN_HEIGHT_SHARE);
        let seen = self.camera.project(&apparent).and_then(|(u, v)| self.fields.field_at(u, v));
        let place = seen.map(|field| {
            let within_reach = (x * x + y * y).sqrt() <= self.manifold.flat_reach_m;
            TablePlace { field, centre_m: (x, y), within_reach }
        });
        place.filter(|place| self.on_table(place, self.block_side_m_max() / 2.0)).ok_or_else(|| {
            format!(
                "positions.at_mm: ({:.0}, {:.0}) mm is not on the table, or the camera does not see it",
                x * 1e3,
                y * 1e3
            )
        })
    }

    /// Places for the largest block at the centre of taught fields.
    fn candidates(&self, wanted: impl Fn(&TaughtPosture) -> bool, within_reach: bool) -> Vec<TablePlace> {
        let block_m = self.block_side_m_max();
        let edge_px = self.file.positions.block_edge_px.get();
        let at_field = |taught: &TaughtPosture| {
            let (u, v) = self.fields.centres_px()[taught.field];
            if !self.inside_px(u, v, edge_px) {
                return None;
            }
            let centre = self.camera.on_plane(u, v, block_m * SEEN_HEIGHT_SHARE)?;
            let place = TablePlace { field: taught.field, centre_m: (centre.x, centre.y), within_reach };
            let possible = if within_reach { self.clear_of_rest(&place) } else { self.out_of_reach(&place) };
            (possible && self.on_table(&place, block_m)).then_some(place)
        };
        self.taught.iter().filter(|taught| wanted(taught)).filter_map(at_field).collect()
    }

    /// Whether a block there keeps clear of the finger at rest.
    fn clear_of_rest(&self, place: &TablePlace) -> bool {
        let (x, y) = place.centre_m;
        let apart = (x * x + (y - self.manifold.square.rest_m) * (y - self.manifold.square.rest_m)).sqrt();
        apart > self.meeting_distance_m() + CLEARANCE_M
    }

    /// Whether the finger passes over a block there wherever it could meet it.
    fn out_of_reach(&self, place: &TablePlace) -> bool {
        let (x, y) = place.centre_m;
        let first_m = (x * x + y * y).sqrt() - self.meeting_distance_m();
        let lowest_m = self.block_side_m_max() + self.file.finger.ball_radius_mm.metres() + CLEARANCE_M;
        self.manifold.height_at(first_m).is_none_or(|height_m| height_m > lowest_m)
    }

    /// Farthest that the finger's and a block's centre can be apart and still meet, placement error included.
    fn meeting_distance_m(&self) -> f64 {
        let half_diagonal_m = self.block_side_m_max() * std::f64::consts::FRAC_1_SQRT_2;
        let jitter_m = self.file.positions.jitter_mm.metres() * std::f64::consts::SQRT_2;
        half_diagonal_m + self.file.finger.ball_radius_mm.metres() + jitter_m
    }

    fn block_side_m_max(&self) -> f64 {
        self.file.objects.iter().map(|object| object.side_mm.metres()).fold(0.0, f64::max)
    }

    /// Whether a place is on the table, at least `margin_m` from its edge.
    fn on_table(&self, place: &TablePlace, margin_m: f64) -> bool {
        let table = &self.file.table;
        let front_m = table.depth_mm.metres() - table.behind_mm.metres();
        place.centre_m.0.abs() + margin_m < table.width_mm.metres() / 2.0
            && place.centre_m.1 + margin_m < front_m
            && place.centre_m.1 - margin_m > -table.behind_mm.metres()
    }

    fn inside_px(&self, u: f64, v: f64, edge_px: f64) -> bool {
        let (width, height) = (self.camera.setup().width_px as f64, self.camera.setup().height_px as f64);
        (edge_px..=width - edge_px).contains(&u) && (edge_px..=height - edge_px).contains(&v)
    }
}

fn rounded(joints: JointPositions) -> JointPositions {
    let round = |position: f64| (position / JOINT_RESOLUTION).round() * JOINT_RESOLUTION;
    JointPositions { j1: round(joints.j1), j2: round(joints.j2) }
}

fn camera(file: &WorldFile) -> Result<Camera, String> {
    let camera = &file.camera;
    Camera::new(CameraSetup {
        position_m: Point3::new(camera.x_mm.metres(), camera.y_mm.metres(), camera.height_mm.metres()),
        pan_rad: camera.pan_deg.radians(),
        tilt_rad: camera.tilt_deg.radians(),
        focal_px: camera.focal_px.get(),
        width_px: camera.width_px.count(),
        height_px: camera.height_px.count(),
    })
    .map_err(|error| error.to_string())
}

/// Checks that the arm reaches its whole manifold, that its joints stay above the table, and that the ball does not
/// scrape the table.
fn check_arm(file: &WorldFile, arm: &Kinematics, manifold: &Manifold) -> Result<(), String> {
    if file.finger.ball_radius_mm.get() >= file.manifold.tip_height_mm.get() {
        return Err(
            "finger.ball_radius_mm must be less than manifold.tip_height_mm, or it scrapes the table".into(),
        );
    }
    if file.finger.shaft_radius_mm.get() >= file.finger.ball_radius_mm.get() {
        return Err(
            "finger.shaft_radius_mm must be less than finger.ball_radius_mm, or it hides the ball".into()
        );
    }
    let carried_m = file.manifold.tip_height_mm.metres() + file.arm.lift_mm.metres();
    let tallest_m = file.objects.iter().map(|object| object.side_mm.metres()).fold(0.0, f64::max);
    let clear_m = tallest_m + file.finger.ball_radius_mm.metres() + CLEARANCE_M;
    if file.arm.lift_mm.get() > 0.0 && carried_m < clear_m {
        return Err(format!(
            "the finger is carried {:.0} mm over the table but must be {:.0} mm over it to pass over every object; \
             raise arm.lift_mm, or make it 0 for a finger that slides along its manifold",
            carried_m * 1e3,
            clear_m * 1e3
        ));
    }
    let steps = 200;
    for step in 0..=steps {
        let share = f64::from(step) / f64::from(steps);
        let arc_m = manifold.square.rest_m + (manifold.arc_max_m - manifold.square.rest_m) * share;
        let Some(posture) = arm.posture(manifold, OnManifold { bearing_rad: 0.0, arc_m }) else {
            return Err(format!(
                "the links do not reach the manifold {:.0} mm from the axis; change arm.upper_arm_mm, \
                 arm.forearm_mm or manifold.rest_mm",
                arc_m * 1e3
            ));
        };
        let point = OnManifold { bearing_rad: 0.0, arc_m };
        let lifted = Waypoint { joints: manifold.joints(point), lift_m: file.arm.lift_mm.metres() };
        if arm.posture_by(manifold, lifted).is_none() {
            return Err(format!(
                "the links do not reach {:.0} mm above the manifold {:.0} mm from the axis; lower arm.lift_mm",
                lifted.lift_m * 1e3,
                arc_m * 1e3
            ));
        }
        if posture.elbow_m.z < JOINT_HEIGHT_M_MIN || posture.wrist_m.z < JOINT_HEIGHT_M_MIN {
            return Err(format!(
                "elbow or wrist come within {:.0} mm of the table when the finger is {:.0} mm from the axis; raise \
                 arm.shoulder_height_mm or lengthen the finger",
                JOINT_HEIGHT_M_MIN * 1e3,
                arc_m * 1e3
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{BLOCK_AND_BALL, WIDE};

    fn workspace(world: &str) -> Workspace {
        Workspace::new(world, WorldFile::load(world).unwrap()).unwrap()
    }

    #[test]
    fn shipped_worlds_have_the_published_numbers_of_fields() {
        for (world, fields, beyond) in [("wide", 224, 24), ("narrow", 112, 16)] {
            let workspace = workspace(world);
            assert_eq!(workspace.taught.len(), fields);
            let within = workspace.places.iter().filter(|p| p.within_reach).count();
            assert_eq!(within, 100, "{world}");
            assert_eq!(workspace.places.len() - within, beyond, "{world}");
            assert!(workspace.taught.iter().filter(|t| t.flat).count() * 2 > fields, "{world}: mostly flat");
            assert!(workspace.taught.windows(2).all(|w| w[0].field < w[1].field));
        }
    }

    #[test]
    fn a_number_of_fields_that_does_not_come_out_is_refused_with_the_right_one() {
        let mut file = WorldFile::load("wide").unwrap();
        file.repertoire.fields = pschema_arm::Within::try_from(100.0).unwrap();
        let error = Workspace::new("wide", file).unwrap_err().to_string();
        assert!(error.contains("224 fields") && error.contains("states 100"), "{error}");
    }

    /// The refusal of a shipped world in which a text was replaced.
    fn refused(world: &str, from: &str, to: &str) -> String {
        assert!(world.contains(from), "the shipped world has no {from:?} any more");
        let file = WorldFile::parse("test", &world.replacen(from, to, 1)).unwrap();
        Workspace::new("test", file).unwrap_err().to_string()
    }

    #[test]
    fn listed_places_come_last_and_must_be_on_the_table_in_sight() {
        let file = WorldFile::load("block-and-ball").unwrap();
        let workspace = Workspace::new("block-and-ball", file).unwrap();
        let [.., block, ball] = workspace.places.as_slice() else { panic!("there are listed places") };
        assert_eq!((block.centre_m, ball.centre_m), ((0.132, 0.444), (0.29, 0.444)));
        assert!(block.within_reach && ball.within_reach && ball.field == block.field + 2);
        for elsewhere in ["[400, 444]", "[0, 5000]"] {
            let error = refused(BLOCK_AND_BALL, "[290, 444]", elsewhere);
            assert!(error.contains("positions.at_mm"), "{error}");
        }
    }

    #[test]
    fn a_push_beyond_reach_is_refused_with_figures() {
        let error = refused(BLOCK_AND_BALL, "to_mm = [149, 444]", "to_mm = [149, 944]");
        assert!(error.contains("(149, 944) mm") && error.contains("120 to"), "{error}");
    }

    #[test]
    fn a_finger_carried_too_low_or_too_high_is_refused_with_figures() {
        let high_rim = WIDE.replacen("rim_height_mm = 180", "rim_height_mm = 300", 1);
        let error = refused(&high_rim, "lift_mm = 50", "lift_mm = 500");
        assert!(error.contains("500 mm above the manifold"), "{error}");
        let error = refused(WIDE, "lift_mm = 50", "lift_mm = 10");
        assert!(error.contains("22 mm over the table") && error.contains("34 mm"), "{error}");
    }

    #[test]
    fn an_arm_that_does_not_fit_is_refused_with_figures() {
        let mut file = WorldFile::load("wide").unwrap();
        file.arm.upper_arm_mm = pschema_arm::Within::try_from(900.0).unwrap();
        let error = Workspace::new("wide", file).unwrap_err().to_string();
        assert!(error.contains("mm"), "{error}");
    }
}
