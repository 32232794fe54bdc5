//! `arm.toml`: the joints and limits of an arm, its line, its manifold, its camera and its touch sensors. The file is
//! checked value by value as it is read, and then each value against the others. An error names line and column where
//! it can.

mod file;

use std::ops::Range;
use std::path::Path;

use pschema_arm::route::{RouteSetup, Waypoint};
use pschema_arm::{FileError, FileKind, FingerArm, JointPositions, Square, Within, check_names};
use pschema_vision::classify::{ClassifyError, ColourRange};
use pschema_vision::eye::Eye;
use pschema_vision::fields::VisualFields;
use toml::Spanned;

pub use file::*;

use crate::gate::{Gate, JointLimits};
use crate::taught::{GridSetup, TaughtGrid};
use crate::v_plus::JOINTS_MAX;

/// The emulated arm, as shipped.
pub const EMULATED: &str = include_str!("../../arms/emulated.toml");

/// Arm files among the kinds of files.
const ARM_FILE: FileKind = FileKind {
    name: "arm file",
    bytes_max: 8 << 20,
    advice: "name a readable file, as body-adept/arms/emulated.toml",
};
/// Postures one repertoire may have, and places one file may list.
const LISTED_MAX: usize = 4096;
/// Colours and objects one file may name.
const NAMED_MAX: usize = 16;
/// World coordinates of a place, as the monitor prints them beside the joints.
const WORLD_COORDINATES: usize = 6;
/// Percent of full speed above which the file must confirm the speed.
const SPEED_UNCONFIRMED_MAX: f64 = 20.0;

/// An arm file with all that follows from it.
#[derive(Clone, Debug)]
pub struct ArmSetup {
    /// The file.
    pub file: ArmFile,
    /// The gate with its limits and the taught grid.
    pub gate: Gate,
    /// The square that the joint positions span on the table.
    pub plane: Square,
    /// The rest posture.
    pub rest: JointPositions,
    /// The visual fields of the camera's picture.
    pub fields: VisualFields,
    /// An eye for the colours, which has not looked at a picture yet.
    pub eye: Eye,
    /// The postures that babbling draws from.
    pub repertoire: Vec<JointPositions>,
}

/// A problem, and the place in the file that is to blame.
type Problem = (Option<Range<usize>>, String);

impl ArmSetup {
    /// Reads an arm file: `emulated`, or a path to a file.
    ///
    /// # Errors
    /// When the file cannot be read, or is no arm file.
    pub fn load(name: &str) -> Result<Self, FileError> {
        match name {
            "emulated" => Self::parse(name, EMULATED),
            path => Self::parse(path, &ARM_FILE.read(Path::new(path))?),
        }
    }

    /// Reads an arm file from its text; `name` is for error messages.
    ///
    /// # Errors
    /// When the text is no arm file.
    pub fn parse(name: &str, text: &str) -> Result<Self, FileError> {
        Self::build(ARM_FILE.parse(name, text)?).map_err(|(span, problem)| {
            ARM_FILE.inconsistent(name, span.map(|span| (text, span.start)), problem)
        })
    }

    fn build(file: ArmFile) -> Result<Self, Problem> {
        check_lists(&file).map_err(|problem| (None, problem))?;
        let speed = file.speed.percent.get_ref().get();
        if speed > SPEED_UNCONFIRMED_MAX && !file.speed.above_20_percent_is_meant {
            let problem = format!(
                "a speed of {speed} %: above {SPEED_UNCONFIRMED_MAX} % only with speed.above_20_percent_is_meant = true"
            );
            return Err((Some(file.speed.percent.span()), problem));
        }
        if file.speed.approach_percent.get() > speed {
            let problem = "speed.approach_percent must be at most speed.percent".to_owned();
            return Err((Some(file.speed.percent.span()), problem));
        }
        if file.line.mode == LineMode::Monitor && file.joints.len() == WORLD_COORDINATES {
            let problem = "an arm of six joints in mode monitor: WHERE prints six world coordinates beside the six joints, and \
                           which is which is not documented; use mode = \"server\"";
            return Err((None, problem.to_owned()));
        }
        let limits = joint_limits(&file)?;
        let taught = taught(&file, &limits)?;
        let plane = Square {
            across_m: file.plane.across_mm.metres(),
            nearest_m: file.plane.nearest_mm.metres(),
            outwards_m: file.plane.outwards_mm.metres(),
            rest_m: file.plane.nearest_mm.metres()
                + file.taught.rest[1].get() * file.plane.outwards_mm.metres(),
        };
        let rest = JointPositions { j1: file.taught.rest[0].get(), j2: file.taught.rest[1].get() };
        let on_grid = |joints: JointPositions| taught.at(Waypoint { joints, lift_m: 0.0 }).is_some();
        if !on_grid(rest) {
            return Err((None, "taught.rest is not within what was taught".to_owned()));
        }
        let mut repertoire = Vec::new();
        for posture in &file.repertoire.postures {
            let [j1, j2] = posture.get_ref().map(Within::get);
            let joints = JointPositions { j1, j2 };
            if !on_grid(joints) {
                let problem = format!("the posture ({j1}, {j2}) is not within what was taught");
                return Err((Some(posture.span()), problem));
            }
            repertoire.push(joints);
        }
        let (width_px, height_px) = (file.camera.width_px.count(), file.camera.height_px.count());
        let fields = file.vision.fields(width_px, height_px).map_err(|error| (None, error.to_string()))?;
        let eye = eye(&file).map_err(|error| (None, error.to_string()))?;
        // The speed cap comes from the file alone; nothing else can raise it.
        let gate = Gate::new(limits, percent(speed), taught);
        Ok(Self { gate, plane, rest, fields, eye, repertoire, file })
    }

    /// How moves go.
    #[must_use]
    pub fn route(&self) -> RouteSetup {
        let motion = &self.file.motion;
        RouteSetup { lift_m: motion.lift_mm.metres(), approach_m: motion.approach_mm.metres() }
    }

    /// Speeds in percent of full speed: through the air, and where the finger may meet an object.
    #[must_use]
    pub fn speeds(&self) -> (u8, u8) {
        (percent(self.file.speed.percent.get_ref().get()), percent(self.file.speed.approach_percent.get()))
    }

    /// The index of the finger's colour.
    #[must_use]
    pub fn finger_colour(&self) -> usize {
        finger_colour(&self.file)
    }

    /// The properties that the body declares.
    #[must_use]
    pub fn declaration(&self, name: &str) -> FingerArm {
        let colours = self.file.colours.iter().map(|colour| colour.name.clone());
        FingerArm {
            name: name.to_owned(),
            kind: "adept-arm".to_owned(),
            fields: self.fields.count(),
            finger_colour: self.file.finger.colour.clone(),
            object_colours: colours.filter(|name| *name != self.file.finger.colour).collect(),
            objects: self.file.objects.names.clone(),
            places: self.file.places.at_mm.len(),
            moves: self.repertoire.clone(),
            pushes: Vec::new(),
        }
    }
}

fn finger_colour(file: &ArmFile) -> usize {
    file.colours.iter().position(|colour| colour.name == file.finger.colour).unwrap_or_default()
}

fn eye(file: &ArmFile) -> Result<Eye, ClassifyError> {
    let range = |colour: &ColourEntry| ColourRange {
        name: colour.name.clone(),
        hue_from_deg: colour.hue_deg[0].get(),
        hue_to_deg: colour.hue_deg[1].get(),
        saturation_min: colour.saturation_min.get(),
        value_min: colour.value_min.get(),
    };
    let colours: Vec<ColourRange> = file.colours.iter().map(range).collect();
    Eye::new(&colours, finger_colour(file), file.vision.blob_rules())
}

fn percent(percent: f64) -> u8 {
    percent.clamp(1.0, 100.0) as u8
}

fn joint_limits(file: &ArmFile) -> Result<Vec<JointLimits>, Problem> {
    if file.joints.is_empty() || file.joints.len() > JOINTS_MAX {
        return Err((None, format!("{} [[joints]]: there must be 1 to {JOINTS_MAX}", file.joints.len())));
    }
    let limits = |joint: &Spanned<JointEntry>| {
        let JointEntry { name, min, max, tolerance } = joint.get_ref();
        let (min, max, tolerance) = (min.get(), max.get(), tolerance.get());
        if min >= max || tolerance <= 0.0 || tolerance > (max - min) / 2.0 {
            let problem = format!(
                "joint {name}: min {min} must be below max {max}, and tolerance {tolerance} above 0 and at most half of that"
            );
            return Err((Some(joint.span()), problem));
        }
        Ok(JointLimits { min, max, tolerance })
    };
    file.joints.iter().map(limits).collect()
}

fn taught(file: &ArmFile, limits: &[JointLimits]) -> Result<TaughtGrid, Problem> {
    let of = &file.taught;
    let mut nodes = Vec::new();
    if of.points.len() != of.lift_mm.len() || of.points.iter().any(|rows| rows.len() != of.j2.len()) {
        let problem = format!(
            "taught.points must have {} layers (lift_mm) of {} rows (j2)",
            of.lift_mm.len(),
            of.j2.len()
        );
        return Err((None, problem));
    }
    for row in of.points.iter().flatten() {
        if row.get_ref().len() != of.j1.len() {
            let problem =
                format!("this row has {} nodes, taught.j1 has {}", row.get_ref().len(), of.j1.len());
            return Err((Some(row.span()), problem));
        }
        for (column, node) in row.get_ref().iter().enumerate() {
            if node.is_empty() {
                nodes.push(None);
                continue;
            }
            let within = |(value, limits): (&f64, &JointLimits)| (limits.min..=limits.max).contains(value);
            if node.len() != limits.len() || !node.iter().zip(limits).all(within) {
                let problem = format!(
                    "node {} of this row, {node:?}, is not one value a joint, each within the limits of [[joints]]",
                    column + 1
                );
                return Err((Some(row.span()), problem));
            }
            nodes.push(Some(node.clone()));
        }
    }
    let numbers = |axis: &[Within<-1, 2>]| axis.iter().map(|value| value.get()).collect();
    let lift_m: Vec<f64> = of.lift_mm.iter().map(|lift| lift.metres()).collect();
    if lift_m.last().is_none_or(|highest| *highest < file.motion.lift_mm.metres()) {
        let problem = "motion.lift_mm must be at most the last of taught.lift_mm".to_owned();
        return Err((None, problem));
    }
    TaughtGrid::new(GridSetup { j1: numbers(&of.j1), j2: numbers(&of.j2), lift_m, nodes }, limits.len())
        .map_err(|problem| (None, problem))
}

fn check_lists(file: &ArmFile) -> Result<(), String> {
    let colours: Vec<_> = file.colours.iter().map(|colour| &colour.name).collect();
    let objects: Vec<_> = file.objects.names.iter().collect();
    check_names("colours", &colours, NAMED_MAX)?;
    check_names("objects", &objects, NAMED_MAX)?;
    if let Some(name) = colours.iter().chain(&objects).find(|name| name.chars().any(char::is_whitespace)) {
        return Err(format!("the name {name:?} holds a space"));
    }
    if !file.colours.iter().any(|colour| colour.name == file.finger.colour) {
        return Err(format!("finger.colour {:?} is not among [[colours]]", file.finger.colour));
    }
    for (what, count) in
        [("repertoire.postures", file.repertoire.postures.len()), ("places.at_mm", file.places.at_mm.len())]
    {
        if count == 0 || count > LISTED_MAX {
            return Err(format!("{count} {what}: there must be 1 to {LISTED_MAX}"));
        }
    }
    let sides = file.touch.sides;
    if sides.iter().enumerate().any(|(index, side)| sides.iter().take(index).any(|other| other == side)) {
        return Err("touch.sides must name each of left, right, near and far once".to_owned());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const COBRA: &str = include_str!("../../arms/cobra-s600.toml");

    fn broken(from: &str, to: &str) -> String {
        assert!(EMULATED.contains(from), "the shipped arm file has no {from:?} any more");
        ArmSetup::parse("test", &EMULATED.replacen(from, to, 1)).unwrap_err().to_string()
    }

    /// The number of the line that holds a text.
    fn line_of(text: &str) -> String {
        let before = &EMULATED[..EMULATED.find(text).unwrap()];
        format!("line {}", before.matches('\n').count() + 1)
    }

    #[test]
    fn shipped_files_are_arms() {
        let emulated = ArmSetup::load("emulated").unwrap();
        assert_eq!(emulated.repertoire.len(), 112);
        let cobra = ArmSetup::parse("cobra", COBRA).unwrap();
        assert_eq!((cobra.gate.taught().joints(), cobra.speeds()), (4, (5, 2)));
    }

    /// The emulated arm declares the same as the simulated one of the same world, so that memory goes from one to the
    /// other.
    #[test]
    fn the_emulated_arm_declares_what_the_simulated_one_does() {
        let (emulated, _) = ArmSetup::load("emulated").unwrap().declaration("arm").declare();
        let file = pschema_sim::config::WorldFile::load("narrow").unwrap();
        let workspace = pschema_sim::workspace::Workspace::new("narrow", file).unwrap();
        let (mut simulated, _) = pschema_sim::declare::declare("arm", "narrow", &workspace);
        simulated.kind.clone_from(&emulated.kind);
        assert_eq!(emulated.observation_types, simulated.observation_types);
        assert_eq!(emulated.scene_commands, simulated.scene_commands);
        assert_eq!(emulated.actions, simulated.actions);
        assert_eq!(emulated.repertoire.len(), simulated.repertoire.len());
    }

    #[test]
    fn errors_name_line_and_column() {
        let unknown = broken("lift_mm = 50 ", "lfit_mm = 50 ");
        assert!(unknown.contains(&line_of("lift_mm = 50 ")) && unknown.contains("lfit_mm"), "{unknown}");
        let range = broken("approach_mm = 25.5", "approach_mm = nan");
        assert!(range.contains(&line_of("approach_mm")) && range.contains("must be 0 to 500"), "{range}");
    }

    #[test]
    fn what_does_not_fit_together_is_told_with_its_place() {
        let joint = broken("min = -95.0\nmax = 95.0", "min = 95.0\nmax = -95.0");
        assert!(joint.contains(&line_of("[[joints]]")) && joint.contains("joint yaw"), "{joint}");
        let speed = broken("percent = 20\n", "percent = 80\n");
        assert!(
            speed.contains(&line_of("percent = 20\n")) && speed.contains("above_20_percent_is_meant"),
            "{speed}"
        );
        let node = broken("max = 138.0", "max = 100.0");
        assert!(node.contains("line ") && node.contains("within the limits of [[joints]]"), "{node}");
        let posture = broken("postures = [\n  [0.4", "postures = [\n  [0.0");
        assert!(posture.contains("is not within what was taught"), "{posture}");
        for (from, to, told) in [
            ("sides = [\"left\", \"right\"", "sides = [\"left\", \"left\"", "each of left, right"),
            ("colour = \"green\"", "colour = \"pink\"", "not among [[colours]]"),
            ("hue_deg = [200, 255]", "hue_deg = [150, 255]", "colours green and blue overlap"),
            ("lift_mm = 50 ", "lift_mm = 90 ", "at most the last of taught.lift_mm"),
            ("[\"blue-block\", \"red-block\"", "[\"blue-block\", \"blue-block\"", "given twice"),
        ] {
            let error = broken(from, to);
            assert!(error.contains(told), "{error}");
        }
    }

    /// Six world coordinates could be taken for six joints.
    #[test]
    fn the_monitor_is_not_asked_where_an_arm_of_six_joints_is() {
        let two_more = "[[joints]]\nname = \"more\"\nmin = -1.0\nmax = 1.0\ntolerance = 0.1\n\n".repeat(2);
        let six = EMULATED.replacen("[speed]", &format!("{two_more}[speed]"), 1);
        let monitor = six.replacen("mode = \"server\"", "mode = \"monitor\"", 1);
        let refused = ArmSetup::parse("test", &monitor).unwrap_err().to_string();
        assert!(refused.contains("use mode = \"server\""), "{refused}");
        let server = ArmSetup::parse("test", &six).unwrap_err().to_string();
        assert!(server.contains("one value a joint"), "its points were not taught: {server}");
    }
}
