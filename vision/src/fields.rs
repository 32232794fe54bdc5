//! The circular visual fields that divide the visual space (section III-A of the paper).
//!
//! Centres lie on a hexagonal grid laid symmetrically over the picture. The circles are as wide as is needed
//! for them to leave no holes, so neighbours overlap a little; a point belongs to the field whose centre is
//! nearest. Fields are numbered from 0 in reading order.

use thiserror::Error;

/// Fields one picture may be divided into.
pub const FIELDS_MAX: usize = 16_384;

/// Height of a row of the grid relative to the pitch: the square root of 3/4.
const ROW_PER_PITCH: f64 = 0.866_025_403_784_438_6;
/// Radius at which the circles leave no holes, relative to the pitch: 1 over the square root of 3.
const RADIUS_PER_PITCH: f64 = 0.577_350_269_189_625_8;

/// Why a grid of fields cannot be laid.
#[derive(Debug, Error, PartialEq)]
pub enum FieldsError {
    /// The pitch is not a positive number, or so small that the fields would be too many.
    #[error(
        "a pitch of {pitch_px} px over {width_px}x{height_px} px: it must be above zero and give at most \
         {FIELDS_MAX} fields; set a larger pitch"
    )]
    Pitch {
        /// Pitch asked for.
        pitch_px: f64,
        /// Width of the picture.
        width_px: usize,
        /// Height of the picture.
        height_px: usize,
    },
}

/// A picture's visual fields.
#[derive(Clone, Debug, PartialEq)]
pub struct VisualFields {
    width_px: f64,
    height_px: f64,
    pitch_px: f64,
    centres_px: Vec<(f64, f64)>,
}

impl VisualFields {
    /// Lays fields `pitch_px` apart, centre to centre, over a picture.
    ///
    /// # Errors
    /// When the pitch is not above zero or gives more than [`FIELDS_MAX`] fields.
    pub fn new(width_px: usize, height_px: usize, pitch_px: f64) -> Result<Self, FieldsError> {
        let refused = FieldsError::Pitch { pitch_px, width_px, height_px };
        let (width, height) = (width_px as f64, height_px as f64);
        // One lattice point for each such area, a border of one pitch allowed for.
        let expected =
            (width + 2.0 * pitch_px) * (height + 2.0 * pitch_px) / (pitch_px * pitch_px * ROW_PER_PITCH);
        if pitch_px <= 0.0 || expected.is_nan() || expected > FIELDS_MAX as f64 {
            return Err(refused);
        }
        let mut fields = Self { width_px: width, height_px: height, pitch_px, centres_px: Vec::new() };
        let rows = (height / 2.0 / (pitch_px * ROW_PER_PITCH)).ceil() as i64 + 1;
        let columns = (width / 2.0 / pitch_px).ceil() as i64 + 1;
        for row in -rows..=rows {
            let v = height / 2.0 + row as f64 * pitch_px * ROW_PER_PITCH;
            let shift = if row.rem_euclid(2) == 1 { 0.5 } else { 0.0 };
            for column in -columns..=columns {
                let u = width / 2.0 + (column as f64 + shift) * pitch_px;
                if fields.outside_px(u, v) < fields.radius_px() {
                    fields.centres_px.push((u, v));
                }
            }
        }
        Ok(fields)
    }

    /// How many fields there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.centres_px.len()
    }

    /// Centres in pixels (u, v), by field number. Some lie a little outside the picture.
    #[must_use]
    pub fn centres_px(&self) -> &[(f64, f64)] {
        &self.centres_px
    }

    /// Radius of every field in pixels.
    #[must_use]
    pub fn radius_px(&self) -> f64 {
        self.pitch_px * RADIUS_PER_PITCH
    }

    /// Distance between neighbouring centres in pixels.
    #[must_use]
    pub fn pitch_px(&self) -> f64 {
        self.pitch_px
    }

    /// The field that a point of the picture belongs to: that with the nearest centre, the lower number at
    /// equal distance. None outside the picture.
    #[must_use]
    pub fn field_at(&self, u: f64, v: f64) -> Option<usize> {
        if !(0.0..=self.width_px).contains(&u) || !(0.0..=self.height_px).contains(&v) {
            return None;
        }
        let distance = |&(cu, cv): &(f64, f64)| (cu - u) * (cu - u) + (cv - v) * (cv - v);
        let nearest =
            self.centres_px.iter().enumerate().min_by(|(_, a), (_, b)| distance(a).total_cmp(&distance(b)));
        nearest.map(|(index, _)| index)
    }

    /// The fields beside a field: up to six, fewer at the picture's edge, in ascending order. None of a number
    /// that is no field's.
    #[must_use]
    pub fn neighbours(&self, field: usize) -> Vec<usize> {
        let Some(&(u, v)) = self.centres_px.get(field) else { return Vec::new() };
        let beside = |&(cu, cv): &(f64, f64)| {
            let distance = ((cu - u) * (cu - u) + (cv - v) * (cv - v)).sqrt();
            // The next but one is the square root of 3 away.
            distance > 0.0 && distance < self.pitch_px * 1.3
        };
        let all = self.centres_px.iter().enumerate();
        all.filter(|(_, centre)| beside(centre)).map(|(index, _)| index).collect()
    }

    /// How far a point lies outside the picture, 0 inside.
    fn outside_px(&self, u: f64, v: f64) -> f64 {
        let du = (-u).max(u - self.width_px).max(0.0);
        let dv = (-v).max(v - self.height_px).max(0.0);
        (du * du + dv * dv).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_holes_every_pixel_is_inside_the_circle_of_its_field() {
        let fields = VisualFields::new(780, 580, 40.0).unwrap();
        for v in (0..580).step_by(3) {
            for u in (0..780).step_by(3) {
                let (u, v) = (f64::from(u) + 0.5, f64::from(v) + 0.5);
                let (cu, cv) = fields.centres_px()[fields.field_at(u, v).unwrap()];
                let distance = ((cu - u) * (cu - u) + (cv - v) * (cv - v)).sqrt();
                assert!(distance <= fields.radius_px() + 1e-9, "({u}, {v}) is {distance} px from its centre");
            }
        }
    }

    #[test]
    fn a_centre_belongs_to_its_own_field_and_outside_to_none() {
        let fields = VisualFields::new(780, 580, 37.0).unwrap();
        let mut inside = 0;
        for (index, &(u, v)) in fields.centres_px().iter().enumerate() {
            if (0.0..=780.0).contains(&u) && (0.0..=580.0).contains(&v) {
                assert_eq!(fields.field_at(u, v), Some(index));
                inside += 1;
            } else {
                assert_eq!(fields.field_at(u, v), None);
            }
        }
        assert!(inside > 350, "{inside}");
        assert_eq!(fields.field_at(f64::NAN, 3.0), None);
    }

    #[test]
    fn a_field_in_the_middle_has_six_neighbours_and_is_theirs() {
        let fields = VisualFields::new(780, 580, 40.0).unwrap();
        let middle = fields.field_at(390.0, 290.0).unwrap();
        let neighbours = fields.neighbours(middle);
        assert_eq!(neighbours.len(), 6);
        assert!(neighbours.iter().all(|other| fields.neighbours(*other).contains(&middle)));
        assert!((1..6).contains(&fields.neighbours(0).len()));
        assert!(fields.neighbours(fields.count()).is_empty());
    }

    #[test]
    fn numbers_run_in_reading_order() {
        let fields = VisualFields::new(780, 580, 40.0).unwrap();
        let key = |(u, v): (f64, f64)| (v, u);
        assert!(fields.centres_px().windows(2).all(|w| key(w[0]) < key(w[1])));
    }

    #[test]
    fn a_pitch_without_sense_is_refused() {
        for pitch_px in [0.0, -3.0, f64::NAN, f64::INFINITY, 1e-3] {
            assert!(VisualFields::new(780, 580, pitch_px).is_err(), "{pitch_px}");
        }
    }
}
