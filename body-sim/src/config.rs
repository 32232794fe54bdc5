//! World files: TOML, checked value by value as it is read, so that an error names line and column.

use std::path::Path;

pub use pschema_arm::FileError;
use pschema_arm::{FileKind, PointMm, VisionSection, Within, check_names};
use serde::Deserialize;

use crate::gap::Form;
use crate::noise::Noise;

/// The wide set-up, as shipped.
pub const WIDE: &str = include_str!("../worlds/wide.toml");
/// The narrow set-up, as shipped.
pub const NARROW: &str = include_str!("../worlds/narrow.toml");
/// A block, a ball and the edge of the table, as shipped.
pub const BLOCK_AND_BALL: &str = include_str!("../worlds/block-and-ball.toml");

/// World files among the kinds of files.
pub const WORLD_FILE: FileKind = FileKind {
    name: "world file",
    bytes_max: 1 << 20,
    advice: "name a readable file, or use the built-in `wide`, `narrow` or `block-and-ball`",
};
/// Objects one world may have.
pub const OBJECTS_MAX: usize = 16;
/// Pushes one repertoire may have, and places that one world may list.
pub const LISTED_MAX: usize = 256;
/// Colours one world may have.
pub const COLOURS_MAX: usize = 16;

/// A world file. Its keys are explained in `worlds/wide.toml`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct WorldFile {
    /// The table top.
    pub table: TableSection,
    /// Links of the arm and how fast they move.
    pub arm: ArmSection,
    /// The last link's shape.
    pub finger: FingerSection,
    /// The manifold that the finger tip works on.
    pub manifold: ManifoldSection,
    /// Position and view of the camera.
    pub camera: CameraSection,
    /// How pixels become fields.
    pub vision: VisionSection,
    /// Taught postures.
    pub repertoire: RepertoireSection,
    /// Places for blocks.
    pub positions: PositionsSection,
    /// Pushes in the repertoire. Most worlds have none, and then pushing is no action of the body.
    #[serde(default)]
    pub pushes: Vec<PushEntry>,
    /// Faults of senses and moves. There are none unless the file states them.
    #[serde(default)]
    pub noise: Noise,
    /// The colours that are told apart.
    pub colours: Vec<ColourEntry>,
    /// The blocks and balls.
    pub objects: Vec<ObjectEntry>,
}

/// The table top.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct TableSection {
    /// Extent along x, centred on the base.
    pub width_mm: Within<100, 10_000>,
    /// Extent along y, from the back-plane.
    pub depth_mm: Within<100, 10_000>,
    /// Distance from the base's axis back to the back-plane.
    pub behind_mm: Within<0, 1000>,
    /// Coefficient of friction of everything on the table.
    pub friction: Within<0, 2>,
}

/// The arm's links and speeds.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct ArmSection {
    /// Height of the shoulder's axis over the table.
    pub shoulder_height_mm: Within<50, 5000>,
    /// Length from shoulder to elbow.
    pub upper_arm_mm: Within<50, 5000>,
    /// Length from elbow to wrist.
    pub forearm_mm: Within<50, 5000>,
    /// Length from wrist to finger tip.
    pub finger_mm: Within<20, 1000>,
    /// The finger's lean from the vertical, back towards the wrist.
    pub finger_slant_deg: Within<0, 80>,
    /// The highest speed of any joint.
    pub joint_speed_max_deg_per_s: Within<1, 360>,
    /// The highest speed of the finger tip.
    pub tip_speed_max_mm_per_s: Within<1, 2000>,
    /// How high over the manifold the finger is carried from posture to posture; 0: it slides along it.
    pub lift_mm: Within<0, 500>,
    /// How far before its goal, seen from the base, the finger is set down.
    pub approach_mm: Within<0, 500>,
    /// Radius of the links.
    pub link_radius_mm: Within<1, 200>,
    /// Radius of elbow and wrist.
    pub joint_radius_mm: Within<1, 200>,
    /// A move that takes longer ends as timed out.
    pub move_time_max_s: Within<1, 600>,
}

/// The last link's shape.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct FingerSection {
    /// Radius of the ball at the tip.
    pub ball_radius_mm: Within<1, 100>,
    /// Radius of the shaft that carries the ball.
    pub shaft_radius_mm: Within<1, 50>,
    /// The ball's colour: one of the world's colours, and that of no object.
    pub colour: String,
}

/// The manifold.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct ManifoldSection {
    /// The ball's centre over the table on the flat part.
    pub tip_height_mm: Within<2, 500>,
    /// Height at which the rim ends.
    pub rim_height_mm: Within<2, 2000>,
    /// Where the second joint position begins: distance from the base's axis.
    pub nearest_mm: Within<10, 2000>,
    /// Distance of the rest posture from the base's axis: nearer than `nearest_mm`, and out of the camera's sight.
    pub rest_mm: Within<0, 2000>,
    /// Range of the first joint position, either way.
    pub lateral_max_mm: Within<10, 5000>,
}

/// The camera.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct CameraSection {
    /// Position along x.
    pub x_mm: Within<-5000, 5000>,
    /// Position along y.
    pub y_mm: Within<-5000, 5000>,
    /// Height over the table.
    pub height_mm: Within<300, 10_000>,
    /// Turn to the right.
    pub pan_deg: Within<-80, 80>,
    /// Turn outwards.
    pub tilt_deg: Within<-80, 80>,
    /// Focal length.
    pub focal_px: Within<50, 10_000>,
    /// Width of the picture.
    pub width_px: Within<64, 2048>,
    /// Height of the picture.
    pub height_px: Within<64, 2048>,
}

/// Taught postures.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct RepertoireSection {
    /// How many fields the finger must turn out to reach.
    pub fields: Within<1, 4096>,
    /// Distance to the picture's edge below which no posture is taught.
    pub edge_px: Within<0, 500>,
}

/// Places for blocks.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct PositionsSection {
    /// Places that can be touched.
    pub table: Within<1, 4096>,
    /// Places that can only be pointed at.
    pub beyond_reach: Within<0, 1024>,
    /// More places, after those: x, y of each.
    #[serde(default)]
    pub at_mm: Vec<PointMm>,
    /// Distance to the picture's edge below which there is no place.
    pub block_edge_px: Within<0, 500>,
    /// Largest error of a placement along x and y.
    pub jitter_mm: Within<0, 100>,
    /// Largest error of a placement's turn.
    pub jitter_deg: Within<0, 180>,
}

/// A push: the finger is set down at one point of the table and goes straight to another, on through the blocks that it
/// meets.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct PushEntry {
    /// Where the finger is set down: x, y.
    pub from_mm: PointMm,
    /// Where the push ends: x, y.
    pub to_mm: PointMm,
}

/// A colour.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct ColourEntry {
    /// Its name, the symbol in observations.
    pub name: String,
    /// First and last hue that are seen as this colour. When the first is above the last, the range passes through 360.
    pub hue_deg: [Within<0, 360>; 2],
    /// The paint of solids of this colour.
    pub paint_rgb: [u8; 3],
}

/// A block or a ball.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct ObjectEntry {
    /// Its name, the symbol in scene commands.
    pub name: String,
    /// Its colour: one of the world's colours.
    pub colour: String,
    /// Its form.
    #[serde(default)]
    pub shape: ObjectShape,
    /// Length of its edges; of a ball, its diameter.
    pub side_mm: Within<5, 200>,
}

/// The form of an object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ObjectShape {
    /// A cube.
    #[default]
    Block,
    /// A ball, which rolls.
    Ball,
}

impl ObjectEntry {
    /// The object's form and size.
    #[must_use]
    pub fn form(&self) -> Form {
        let half_m = self.side_mm.metres() / 2.0;
        match self.shape {
            ObjectShape::Block => Form::Cube(half_m),
            ObjectShape::Ball => Form::Ball(half_m),
        }
    }
}

impl WorldFile {
    /// Reads a world: `wide`, `narrow`, `block-and-ball`, or a path to a file.
    ///
    /// # Errors
    /// When the file cannot be read or is not a world; the message has line and column.
    pub fn load(name: &str) -> Result<Self, FileError> {
        match name {
            "wide" => Self::parse(name, WIDE),
            "narrow" => Self::parse(name, NARROW),
            "block-and-ball" => Self::parse(name, BLOCK_AND_BALL),
            path => Self::parse(name, &WORLD_FILE.read(Path::new(path))?),
        }
    }

    /// Reads a world from its text; `name` is for error messages.
    ///
    /// # Errors
    /// When the text is not a world; the message has line and column.
    pub fn parse(name: &str, text: &str) -> Result<Self, FileError> {
        let world: Self = WORLD_FILE.parse(name, text)?;
        world.check().map_err(|problem| WORLD_FILE.inconsistent(name, None, problem))?;
        Ok(world)
    }

    /// The index of a colour by its name.
    #[must_use]
    pub fn colour_index(&self, name: &str) -> Option<usize> {
        self.colours.iter().position(|colour| colour.name == name)
    }

    /// The index of the finger's colour; its name was checked when the world was read.
    #[must_use]
    pub fn finger_colour(&self) -> usize {
        self.colour_index(&self.finger.colour).unwrap_or_default()
    }

    fn check(&self) -> Result<(), String> {
        let colours: Vec<_> = self.colours.iter().map(|colour| &colour.name).collect();
        let objects: Vec<_> = self.objects.iter().map(|object| &object.name).collect();
        check_names("colours", &colours, COLOURS_MAX)?;
        check_names("objects", &objects, OBJECTS_MAX)?;
        for (what, count) in [("pushes", self.pushes.len()), ("positions.at_mm", self.positions.at_mm.len())]
        {
            if count > LISTED_MAX {
                return Err(format!("{count} {what}: there may be {LISTED_MAX}"));
            }
        }
        if self.colour_index(&self.finger.colour).is_none() {
            return Err(format!("finger.colour {:?} is not among [[colours]]", self.finger.colour));
        }
        for object in &self.objects {
            if self.colour_index(&object.colour).is_none() {
                return Err(format!(
                    "object {:?}: colour {:?} is not among [[colours]]",
                    object.name, object.colour
                ));
            }
            if object.colour == self.finger.colour {
                let (name, colour) = (&object.name, &object.colour);
                return Err(format!("object {name:?} has the finger's colour {colour:?}; give it another"));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn broken(from: &str, to: &str) -> String {
        assert!(WIDE.contains(from), "the shipped world has no {from:?} any more");
        WorldFile::parse("test", &WIDE.replacen(from, to, 1)).unwrap_err().to_string()
    }

    #[test]
    fn shipped_worlds_parse() {
        WorldFile::load("wide").unwrap();
        WorldFile::load("narrow").unwrap();
        WorldFile::load("block-and-ball").unwrap();
    }

    #[test]
    fn errors_name_line_and_column() {
        let unknown = broken("friction = 0.9", "frictoin = 0.9");
        assert!(unknown.contains("line 12") && unknown.contains("frictoin"), "{unknown}");
        let range = broken("friction = 0.9", "friction = -1");
        assert!(range.contains("line 12, column 12") && range.contains("must be 0 to 2"), "{range}");
        let nan = broken("friction = 0.9", "friction = nan");
        assert!(nan.contains("line 12") && nan.contains("NaN"), "{nan}");
        let kind = broken("friction = 0.9", "friction = \"much\"");
        assert!(kind.contains("line 12"), "{kind}");
    }

    #[test]
    fn noise_is_checked_like_the_rest_and_may_be_left_out() {
        let range = broken("blob_missed = 0 ", "blob_missed = 1.5 ");
        assert!(range.contains("column 15") && range.contains("must be 0 to 1"), "{range}");
        let unknown = broken("touch_false", "touch_flase");
        assert!(unknown.contains("line ") && unknown.contains("touch_flase"), "{unknown}");
        let (before, after) = (WIDE.find("[noise]").unwrap(), WIDE.find("[[colours]]").unwrap());
        let without = format!("{}{}", &WIDE[..before], &WIDE[after..]);
        assert_eq!(WorldFile::parse("test", &without).unwrap(), WorldFile::parse("wide", WIDE).unwrap());
    }

    #[test]
    fn lists_have_limits() {
        let places = "[1, 2], ".repeat(LISTED_MAX + 1);
        let error = broken("jitter_mm", &format!("at_mm = [{places}]\njitter_mm"));
        assert!(error.contains("257 positions.at_mm") && error.contains("256"), "{error}");
    }

    #[test]
    fn names_must_agree() {
        let unknown =
            broken("name = \"blue-block\"\ncolour = \"blue\"", "name = \"blue-block\"\ncolour = \"blu\"");
        assert!(unknown.contains("\"blu\" is not among"), "{unknown}");
        assert!(broken("colour = \"blue\"", "colour = \"green\"").contains("finger's colour"));
        assert!(broken("name = \"red-block\"", "name = \"blue-block\"").contains("twice"));
    }

    #[test]
    fn a_missing_file_is_named() {
        let error = WorldFile::load("/nonexistent/world.toml").unwrap_err().to_string();
        assert!(error.contains("/nonexistent/world.toml") && error.contains("wide"), "{error}");
    }
}
