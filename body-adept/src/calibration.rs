//! Calibrating the camera: the finger is sent to taught points and looked for in the picture, and a map is fitted from
//! the square of the joint positions to the picture. Where the manifold is flat, the map is projective. The points of
//! the rim, where the manifold is not flat, do not fit and are left out.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use pschema_arm::SplitMix;
use pschema_process::{Occupied, OutputError, OutputFile};
use pschema_protocol::body::Outcome;
use thiserror::Error;
use toml_edit::{Array, DocumentMut, Item, Table, value};

use crate::body::AdeptBody;
use crate::config::CalibrationSection;

/// Postures visited, at most.
const POSTURES_MAX: usize = 60;
/// Points that a map needs, so that its residuals mean something.
const POINTS_MIN: usize = 8;
/// Maps tried out on four points each.
const TRIALS: u64 = 2000;
/// A point fits when it is this near to where the map puts it, in pixels, or nearer than a multiple of the median
/// distance.
const FITS_PX: f64 = 3.0;
const FITS_MEDIANS: f64 = 3.0;
/// A map between coordinates of a common scale whose determinant is below this folds the plane.
const FOLDED: f64 = 1e-6;
/// Seed of the trials: the same points give the same map.
const SEED: u64 = 0xCA11_B8A7;

/// Why the camera was not calibrated.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CalibrationError {
    /// The arm file is built in, or comes from stdin, and cannot be written to.
    #[error(
        "the map is written into the arm file: give one with --arm FILE (a copy of body-adept/arms/emulated.toml)"
    )]
    BuiltIn,
    /// The calibration was ended.
    #[error("ended before all postures were visited; the arm file is as it was")]
    Stopped,
    /// A motion failed.
    #[error("the motion to ({j1}, {j2}) came to {outcome:?}; see to the arm and calibrate again")]
    Motion {
        /// First joint position.
        j1: f64,
        /// Second joint position.
        j2: f64,
        /// Outcome of the motion.
        outcome: Outcome,
    },
    /// There is no picture.
    #[error(transparent)]
    Sight(#[from] crate::sight::SightError),
    /// Too few points to fit a map to.
    #[error(
        "the finger was seen in {seen} of {visited} postures, and {fitting} of them fit one map: at least {POINTS_MIN} must; \
         check the finger's colour in arm.toml, the light, and where the camera looks"
    )]
    TooFew {
        /// Number of postures visited.
        visited: usize,
        /// Number of postures with the finger in sight.
        seen: usize,
        /// Number of postures that fit.
        fitting: usize,
    },
    /// The arm file cannot be written.
    #[error(transparent)]
    ArmFile(#[from] OutputError),
    /// The arm file cannot be written any more.
    #[error(
        "{problem}\nThe map is not lost; put this into the arm file in place of its [calibration]:\n{map}"
    )]
    Write {
        /// The cause.
        problem: String,
        /// The section that was to be written.
        map: String,
    },
}

/// An arm file that a map can be written into.
#[derive(Debug)]
pub struct ArmFile {
    path: PathBuf,
    output: OutputFile,
}

impl ArmFile {
    /// The arm file of a name or path, as `--arm` takes it, found fit to be written before the arm moves.
    ///
    /// # Errors
    /// When it is built in or comes from stdin, or cannot be written.
    pub fn prepare(arm: &str, stop: &Arc<AtomicBool>) -> Result<Self, CalibrationError> {
        if ["emulated", "-"].contains(&arm) {
            return Err(CalibrationError::BuiltIn);
        }
        Ok(Self { path: arm.into(), output: OutputFile::prepare(Path::new(arm), Occupied::Replaced, stop)? })
    }

    /// Writes the map. Everything else stays as it is, comments included.
    fn store(self, calibration: &CalibrationSection) -> Result<(), CalibrationError> {
        let lost = |problem: String| {
            let map = with_calibration("", calibration).unwrap_or_else(|_| format!("{calibration:?}"));
            CalibrationError::Write { problem, map }
        };
        let unread = |error| lost(format!("cannot read {} again: {error}", self.path.display()));
        let text = fs::read_to_string(&self.path).map_err(unread)?;
        let text = with_calibration(&text, calibration).map_err(lost)?;
        self.output.hold(text.as_bytes()).map_err(|error| lost(error.to_string()))
    }
}

/// A place of the finger on the square in millimetres, and its position in the picture in pixels.
pub type FingerSighting = ((f64, f64), (f64, f64));

/// Visits taught points, fits the map, and writes it into the arm file.
///
/// # Errors
/// When there is no map. The arm file is unchanged then.
pub fn calibrate(
    body: &mut AdeptBody,
    file: ArmFile,
    stop: &AtomicBool,
) -> Result<CalibrationSection, CalibrationError> {
    let points = visit(body, stop)?;
    let calibration = fit(&points.seen).ok_or(CalibrationError::TooFew {
        visited: points.visited,
        seen: points.seen.len(),
        fitting: 0,
    })?;
    if calibration.points < POINTS_MIN {
        let (visited, seen) = (points.visited, points.seen.len());
        return Err(CalibrationError::TooFew { visited, seen, fitting: calibration.points });
    }
    tracing::info!(
        visited = points.visited,
        seen = points.seen.len(),
        fitting = calibration.points,
        residual_px = calibration.residual_px,
        residual_mm = calibration.residual_mm,
        residual_mm_max = calibration.residual_mm_max,
        "calibrated"
    );
    file.store(&calibration)?;
    Ok(calibration)
}

struct FingerSurvey {
    visited: usize,
    seen: Vec<FingerSighting>,
}

fn visit(body: &mut AdeptBody, stop: &AtomicBool) -> Result<FingerSurvey, CalibrationError> {
    let setup = body.arm().setup().clone();
    let inside = |joints: &f64| (0.0..=1.0).contains(joints);
    let nodes: Vec<_> =
        setup.gate.taught().nodes().filter(|node| inside(&node.j1) && inside(&node.j2)).collect();
    let every = nodes.len().div_ceil(POSTURES_MAX).max(1);
    let mut visited = FingerSurvey { visited: 0, seen: Vec::new() };
    for node in nodes.into_iter().step_by(every) {
        if stop.load(Ordering::Relaxed) {
            return Err(CalibrationError::Stopped);
        }
        match body.arm().go(node) {
            Outcome::Done => {}
            // At the edge of the taught grid there may be no way to a node.
            Outcome::Refused(_) if *body.arm().phase() == crate::arm::Phase::Active => continue,
            outcome => return Err(CalibrationError::Motion { j1: node.j1, j2: node.j2, outcome }),
        }
        visited.visited += 1;
        let finger = body.find_finger()?;
        let (across_m, outwards_m) = setup.plane.at_m(node);
        tracing::info!(across_mm = across_m * 1e3, outwards_mm = outwards_m * 1e3, ?finger, "visited");
        visited.seen.extend(finger.map(|seen_px| ((across_m * 1e3, outwards_m * 1e3), seen_px)));
    }
    Ok(visited)
}

/// The map that most points fit, with its residuals. None when there are fewer points than a map needs.
#[must_use]
pub fn fit(points: &[FingerSighting]) -> Option<CalibrationSection> {
    if points.len() < POINTS_MIN {
        return None;
    }
    let mut random = SplitMix::new(SEED);
    let all: Vec<usize> = (0..points.len()).collect();
    let mut best: Option<(f64, Matrix3<f64>)> = None;
    for _ in 0..TRIALS {
        let four: Option<Vec<FingerSighting>> =
            (0..4).map(|_| random.one_of(&all).and_then(|index| points.get(index).copied())).collect();
        let Some(map) = least_squares(&four?) else { continue };
        let middle = median(points.iter().map(|point| off_px(&map, point)).collect());
        if best.is_none_or(|(least, _)| middle < least) {
            best = Some((middle, map));
        }
    }
    let (middle, map) = best?;
    let most_px = FITS_PX.max(FITS_MEDIANS * middle);
    let fitting: Vec<FingerSighting> =
        points.iter().copied().filter(|point| off_px(&map, point) <= most_px).collect();
    let map = least_squares(&fitting)?;
    let back = map.try_inverse()?;
    let count = fitting.len() as f64;
    let off_mm: Vec<f64> = fitting.iter().map(|(mm, px)| distance(through(&back, *px), *mm)).collect();
    let map = map / map[(2, 2)];
    Some(CalibrationSection {
        px_from_mm: std::array::from_fn(|index| map[(index / 3, index % 3)]),
        residual_px: fitting.iter().map(|point| off_px(&map, point)).sum::<f64>() / count,
        residual_mm: off_mm.iter().sum::<f64>() / count,
        residual_mm_max: off_mm.iter().copied().fold(0.0, f64::max),
        points: fitting.len(),
    })
}

/// The projective map nearest to points, by the direct linear method on coordinates brought to a common scale.
fn least_squares(points: &[FingerSighting]) -> Option<Matrix3<f64>> {
    let to_mm = scale(points.iter().map(|(mm, _)| *mm))?;
    let to_px = scale(points.iter().map(|(_, px)| *px))?;
    let mut rows = DMatrix::zeros(2 * points.len(), 8);
    let mut wanted = DVector::zeros(2 * points.len());
    for (index, (mm, px)) in points.iter().enumerate() {
        let ((x, y), (u, v)) = (through(&to_mm, *mm), through(&to_px, *px));
        rows.row_mut(2 * index).copy_from_slice(&[x, y, 1.0, 0.0, 0.0, 0.0, -u * x, -u * y]);
        rows.row_mut(2 * index + 1).copy_from_slice(&[0.0, 0.0, 0.0, x, y, 1.0, -v * x, -v * y]);
        (wanted[2 * index], wanted[2 * index + 1]) = (u, v);
    }
    let solved = rows.svd(true, true).solve(&wanted, 1e-12).ok()?;
    let [a, b, c, d, e, f, g, h] = <[f64; 8]>::try_from(solved.as_slice()).ok()?;
    let map = Matrix3::new(a, b, c, d, e, f, g, h, 1.0);
    // A map that folds the plane onto a line, as points on one line give, is no map.
    if !map.iter().all(|value| value.is_finite()) || map.determinant().abs() < FOLDED {
        return None;
    }
    Some(to_px.try_inverse()? * map * to_mm)
}

/// The map that brings points around the origin, about 1 away from it. None when all points are the same.
fn scale(points: impl Iterator<Item = (f64, f64)> + Clone) -> Option<Matrix3<f64>> {
    let count = points.clone().count() as f64;
    let (x, y) = points.clone().fold((0.0, 0.0), |(x, y), (u, v)| (x + u / count, y + v / count));
    let spread = points.map(|point| distance(point, (x, y))).sum::<f64>() / count;
    let by = 1.0 / spread;
    by.is_finite().then(|| Matrix3::new(by, 0.0, -x * by, 0.0, by, -y * by, 0.0, 0.0, 1.0))
}

fn through(map: &Matrix3<f64>, (x, y): (f64, f64)) -> (f64, f64) {
    let there = map * Vector3::new(x, y, 1.0);
    (there.x / there.z, there.y / there.z)
}

fn distance(one: (f64, f64), other: (f64, f64)) -> f64 {
    (one.0 - other.0).hypot(one.1 - other.1)
}

fn off_px(map: &Matrix3<f64>, (mm, px): &FingerSighting) -> f64 {
    distance(through(map, *mm), *px)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::INFINITY)
}

fn with_calibration(text: &str, calibration: &CalibrationSection) -> Result<String, String> {
    let mut document: DocumentMut = text.parse().map_err(|error: toml_edit::TomlError| error.to_string())?;
    let mut table = document.get("calibration").and_then(Item::as_table).cloned().unwrap_or_else(Table::new);
    table.insert("px_from_mm", value(Array::from_iter(calibration.px_from_mm)));
    table.insert("residual_px", value(calibration.residual_px));
    table.insert("residual_mm", value(calibration.residual_mm));
    table.insert("residual_mm_max", value(calibration.residual_mm_max));
    table.insert("points", value(i64::try_from(calibration.points).unwrap_or(i64::MAX)));
    document.insert("calibration", Item::Table(table));
    Ok(document.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A camera that looks at the square at a slant.
    fn seen((x, y): (f64, f64)) -> (f64, f64) {
        through(&Matrix3::new(0.8, 0.05, 400.0, 0.02, -0.7, 600.0, 1e-5, 2e-4, 1.0), (x, y))
    }

    fn points() -> Vec<FingerSighting> {
        (0..36)
            .map(|index| (f64::from(index % 6) * 120.0 - 300.0, f64::from(index / 6) * 100.0 + 150.0))
            .map(|mm| (mm, seen(mm)))
            .collect()
    }

    #[test]
    fn a_map_is_found_whatever_the_rim_does() {
        let mut points = points();
        // A third of them is on the rim, where the finger rises towards the camera.
        for (index, (_, px)) in points.iter_mut().enumerate().filter(|(index, _)| index % 3 == 0) {
            px.1 -= 20.0 + index as f64;
        }
        let calibration = fit(&points).unwrap();
        assert_eq!(calibration.points, 24);
        assert!(calibration.residual_px < 1e-6 && calibration.residual_mm_max < 1e-6, "{calibration:?}");
        let map = Matrix3::from_row_slice(&calibration.px_from_mm);
        assert!(off_px(&map, &((10.0, 300.0), seen((10.0, 300.0)))) < 1e-6);
    }

    #[test]
    fn residuals_are_those_of_the_noise() {
        let mut random = SplitMix::new(3);
        let noisy: Vec<FingerSighting> = points()
            .into_iter()
            .map(|(mm, (u, v))| (mm, (u + random.within_one(), v + random.within_one())))
            .collect();
        let calibration = fit(&noisy).unwrap();
        assert_eq!(calibration.points, 36);
        assert!((0.3..0.9).contains(&calibration.residual_px), "{calibration:?}");
        assert!((0.3..1.5).contains(&calibration.residual_mm), "{calibration:?}");
    }

    #[test]
    fn too_few_points_or_points_on_a_line_give_no_map() {
        assert_eq!(fit(&points()[..7]), None);
        let line: Vec<FingerSighting> =
            (0..20).map(|x| ((f64::from(x), 5.0), (f64::from(x) * 2.0, 7.0))).collect();
        assert_eq!(fit(&line), None);
    }

    #[test]
    fn the_arm_file_keeps_its_comments() {
        let calibration = fit(&points()).unwrap();
        let text = "# The arm in the hall.\n[line]\nbaud = 9600 # as the cabinet says\n";
        let once = with_calibration(text, &calibration).unwrap();
        assert!(once.starts_with(text) && once.contains("[calibration]"), "{once}");
        assert_eq!(with_calibration(&once, &calibration).unwrap(), once, "replaced, not added");
        let read: toml::Table = toml::from_str(&once).unwrap();
        let back: CalibrationSection = read["calibration"].clone().try_into().unwrap();
        assert_eq!(back, calibration);
    }
}
