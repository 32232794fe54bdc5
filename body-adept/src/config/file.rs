//! The keys of an arm file, each value checked as it is read.

use pschema_arm::{PointMm, Side, Within};
use serde::Deserialize;
use toml::Spanned;

use crate::calibration::Calibration;

/// An arm file. Its keys are explained in `arms/emulated.toml`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArmFile {
    /// The serial line.
    pub line: Line,
    /// The joints, in the controller's order.
    pub joints: Vec<Spanned<Joint>>,
    /// Speeds.
    pub speed: Speed,
    /// How moves go.
    pub motion: Motion,
    /// What the joint positions mean on the table.
    pub plane: PlaneFile,
    /// The touch sensors.
    pub touch: Touch,
    /// The camera's picture.
    pub camera: Camera,
    /// From pixels to fields.
    pub vision: Vision,
    /// The finger.
    pub finger: Finger,
    /// Colours told apart.
    pub colours: Vec<Colour>,
    /// Things that can be placed.
    pub objects: Objects,
    /// Where they can be placed.
    pub places: Places,
    /// The taught grid.
    pub taught: TaughtFile,
    /// Taught postures that babbling draws from.
    pub repertoire: Repertoire,
    /// What `calibrate` found, if it was run.
    pub calibration: Option<Calibration>,
}

/// The serial line.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Line {
    /// Who answers there.
    pub mode: Mode,
    /// Bits a second.
    pub baud: Within<300, 115_200>,
    /// Longest wait for an answer.
    pub answer_ms: Within<50, 10_000>,
}

/// Who answers on the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// The controller's own monitor. Nothing stops the arm when this process dies.
    Monitor,
    /// The program `vplus/pschema.v2`, which has a watchdog.
    Server,
}

/// A joint.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Joint {
    /// Its name, for messages.
    pub name: String,
    /// Lowest value, in degrees or millimetres.
    pub min: Within<-100_000, 100_000>,
    /// Highest value.
    pub max: Within<-100_000, 100_000>,
    /// How far it may be from where it should be.
    pub tolerance: Within<0, 100>,
}

/// Speeds, in percent of the arm's full speed.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Speed {
    /// Through the air.
    pub percent: Spanned<Within<1, 100>>,
    /// Where something may be met.
    pub approach_percent: Within<1, 100>,
    /// Says that a speed above 20 % is meant.
    #[serde(default)]
    pub above_20_percent_is_meant: bool,
}

/// How moves go.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Motion {
    /// How high over the manifold the finger is carried.
    pub lift_mm: Within<0, 500>,
    /// How far before its goal the finger is set down.
    pub approach_mm: Within<0, 500>,
    /// Farthest that two points of a path are apart.
    pub step_mm: Within<2, 200>,
    /// Longest that a move may take.
    pub time_max_s: Within<1, 600>,
    /// Longest that the daemon, or this process, may be silent while the arm moves.
    pub heartbeat_ms: Within<100, 10_000>,
}

/// What the joint positions mean on the table.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaneFile {
    /// How far `j1` goes from 0 to 1; half-way is straight ahead.
    pub across_mm: Within<10, 10_000>,
    /// Distance from the base's axis at `j2` = 0.
    pub nearest_mm: Within<0, 5000>,
    /// How far `j2` goes from 0 to 1.
    pub outwards_mm: Within<10, 10_000>,
}

/// The touch sensors.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Touch {
    /// The controller's digital inputs, four. In mode server they are those of `pschema.v2`, in its order.
    pub signals: [Within<1, 9999>; 4],
    /// Which side of the finger each is on.
    pub sides: [Side; 4],
    /// The inputs are on when nothing is touched.
    #[serde(default)]
    pub inverted: bool,
}

/// The camera's picture.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Width of the picture.
    pub width_px: Within<64, 2048>,
    /// Height of the picture.
    pub height_px: Within<64, 2048>,
}

/// From pixels to fields.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Vision {
    /// Distance between centres of neighbouring visual fields.
    pub field_pitch_px: Within<4, 1000>,
    /// Smaller blobs are noise.
    pub blob_area_px_min: Within<1, 100_000>,
    /// Parts of one colour at most this far apart are one blob.
    pub blob_gap_px_max: Within<0, 100>,
}

/// The finger.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Finger {
    /// Its colour: one of the colours.
    pub colour: String,
}

/// A colour.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Colour {
    /// Its name, the symbol in observations.
    pub name: String,
    /// Hues seen as this colour: from, to. From above to: the range passes through 360.
    pub hue_deg: [Within<0, 360>; 2],
    /// Smallest saturation, 0 (grey) to 1 (pure).
    pub saturation_min: Within<0, 1>,
    /// Smallest brightness, 0 to 1.
    pub value_min: Within<0, 1>,
}

/// Things that can be placed.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Objects {
    /// Their names, the symbols in scene commands.
    pub names: Vec<String>,
}

/// Where things can be placed.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Places {
    /// x (to the right) and y (outwards) of each, from the base's axis on the table.
    pub at_mm: Vec<PointMm>,
}

/// The taught grid.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TaughtFile {
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
#[serde(deny_unknown_fields)]
pub struct Repertoire {
    /// Joint positions of each.
    pub postures: Vec<Spanned<[Within<0, 1>; 2]>>,
}
