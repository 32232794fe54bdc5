//! The keys of an arm file, each value checked as it is read.

use pschema_arm::{PointMm, Side, VisionSection, Within};
use serde::Deserialize;
use toml::Spanned;

/// An arm file. Its keys are explained in `arms/emulated.toml`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct ArmFile {
    /// The serial line.
    pub line: LineSection,
    /// The joints, in the controller's order.
    pub joints: Vec<Spanned<JointEntry>>,
    /// Speeds.
    pub speed: SpeedSection,
    /// How moves go.
    pub motion: MotionSection,
    /// The square that the joint positions span on the table.
    pub plane: PlaneSection,
    /// The touch sensors.
    pub touch: TouchSection,
    /// The camera's picture.
    pub camera: CameraSection,
    /// How pixels become fields.
    pub vision: VisionSection,
    /// The finger.
    pub finger: FingerSection,
    /// The colours that are told apart.
    pub colours: Vec<ColourEntry>,
    /// The objects that can be placed.
    pub objects: ObjectsSection,
    /// The places for objects.
    pub places: PlacesSection,
    /// The taught grid.
    pub taught: TaughtSection,
    /// Taught postures that babbling draws from.
    pub repertoire: RepertoireSection,
    /// The map that `calibrate` wrote, if it was run.
    pub calibration: Option<CalibrationSection>,
}

/// The serial line.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct LineSection {
    /// The program that answers on the line.
    pub mode: LineMode,
    /// Speed in bits a second.
    pub baud: Within<300, 115_200>,
    /// Longest wait for an answer.
    pub answer_ms: Within<50, 10_000>,
}

/// The program that answers on the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LineMode {
    /// The controller's own monitor. Nothing stops the arm when this process dies.
    Monitor,
    /// The program `vplus/pschema.v2`, which has a watchdog.
    Server,
}

/// A joint.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct JointEntry {
    /// Its name, used in messages.
    pub name: String,
    /// Lowest value, in degrees or millimetres.
    pub min: Within<-100_000, 100_000>,
    /// Highest value.
    pub max: Within<-100_000, 100_000>,
    /// Largest distance of the joint from where it should be.
    pub tolerance: Within<0, 100>,
}

/// Speeds, in percent of the arm's full speed.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct SpeedSection {
    /// Speed through the air.
    pub percent: Spanned<Within<1, 100>>,
    /// Speed where the finger may meet an object.
    pub approach_percent: Within<1, 100>,
    /// Confirms a speed above 20 %.
    #[serde(default)]
    pub above_20_percent_is_meant: bool,
}

/// How moves go.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct MotionSection {
    /// How high over the manifold the finger is carried.
    pub lift_mm: Within<0, 500>,
    /// How far before its goal the finger is set down.
    pub approach_mm: Within<0, 500>,
    /// Largest distance between two points of a path.
    pub step_mm: Within<2, 200>,
    /// Longest time that a move may take.
    pub time_max_s: Within<1, 600>,
    /// Longest silence of the daemon, or of this process, while the arm moves.
    pub heartbeat_ms: Within<100, 10_000>,
}

/// The square that the joint positions span on the table.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct PlaneSection {
    /// How far `j1` goes from 0 to 1; half-way is straight ahead.
    pub across_mm: Within<10, 10_000>,
    /// Distance from the base's axis at `j2` = 0.
    pub nearest_mm: Within<0, 5000>,
    /// How far `j2` goes from 0 to 1.
    pub outwards_mm: Within<10, 10_000>,
}

/// The touch sensors.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct TouchSection {
    /// The controller's digital inputs, four. In mode server they are those of `pschema.v2`, in its order.
    pub signals: [Within<1, 9999>; 4],
    /// The side of the finger that each input belongs to.
    pub sides: [Side; 4],
    /// The inputs are on when nothing is touched.
    #[serde(default)]
    pub inverted: bool,
}

/// The camera's picture.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct CameraSection {
    /// Width of the picture.
    pub width_px: Within<64, 2048>,
    /// Height of the picture.
    pub height_px: Within<64, 2048>,
}

/// The finger.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct FingerSection {
    /// The finger's colour: one of the colours of the file.
    pub colour: String,
}

/// A colour.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct ColourEntry {
    /// Its name, the symbol in observations.
    pub name: String,
    /// First and last hue that are seen as this colour. When the first is above the last, the range passes through 360.
    pub hue_deg: [Within<0, 360>; 2],
    /// Smallest saturation, 0 (grey) to 1 (pure).
    pub saturation_min: Within<0, 1>,
    /// Smallest brightness, 0 to 1.
    pub value_min: Within<0, 1>,
}

/// The objects that can be placed.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct ObjectsSection {
    /// Their names, the symbols in scene commands.
    pub names: Vec<String>,
}

/// The places for objects.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct PlacesSection {
    /// The place's x (to the right) and y (outwards) on the table, from the base's axis.
    pub at_mm: Vec<PointMm>,
}

/// The taught grid.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct TaughtSection {
    /// Joint positions of the posture to rest in, out of the camera's sight.
    pub rest: [Within<-1, 2>; 2],
    /// First joint position of each column.
    pub j1: Vec<Within<-1, 2>>,
    /// Second joint position of each row.
    pub j2: Vec<Within<-1, 2>>,
    /// Height of each layer over the manifold; the first is 0.
    pub lift_mm: Vec<Within<0, 1000>>,
    /// The joints at each node: layer by layer, row by row; `[]` where the arm does not reach.
    pub points: Vec<Vec<Spanned<Vec<Vec<f64>>>>>,
}

/// Taught postures.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct RepertoireSection {
    /// Joint positions of each posture.
    pub postures: Vec<Spanned<[Within<0, 1>; 2]>>,
}

/// A map from the square that the joint positions span to the picture, fitted to the places where the finger was seen.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct CalibrationSection {
    /// The projective map from (across, outwards) in millimetres to (u, v) in pixels, row by row.
    pub px_from_mm: [f64; 9],
    /// Mean distance of the finger from where the map puts it, in pixels.
    pub residual_px: f64,
    /// The same distance on the table, in millimetres.
    pub residual_mm: f64,
    /// The largest such distance, in millimetres.
    pub residual_mm_max: f64,
    /// How many postures fitted.
    pub points: usize,
}
