//! How the picture of an arm's camera is divided and searched: a section that world and arm files share.

use pschema_protocol::picture::FieldMark;
use pschema_vision::blobs::BlobRules;
use pschema_vision::fields::{FieldsError, VisualFields};
use serde::Deserialize;

use crate::units::Within;

/// How pixels become fields.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VisionSection {
    /// Distance between centres of neighbouring visual fields.
    pub field_pitch_px: Within<4, 1000>,
    /// Smallest area of a blob; a smaller one is noise.
    pub blob_area_px_min: Within<1, 100_000>,
    /// Largest gap between two parts of one colour that count as one blob.
    pub blob_gap_px_max: Within<0, 100>,
}

impl VisionSection {
    /// The visual fields of a picture of this size.
    ///
    /// # Errors
    /// When there would be too many.
    pub fn fields(&self, width_px: usize, height_px: usize) -> Result<VisualFields, FieldsError> {
        VisualFields::new(width_px, height_px, self.field_pitch_px.get())
    }

    /// The rules that decide which pixels make a blob.
    #[must_use]
    pub fn blob_rules(&self) -> BlobRules {
        let px = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
        BlobRules {
            area_px_min: px(self.blob_area_px_min.count()),
            gap_px_max: px(self.blob_gap_px_max.count()),
        }
    }
}

/// The places of the visual fields in the picture, for the people who look at it.
#[must_use]
pub fn field_marks(fields: &VisualFields) -> Vec<FieldMark> {
    let radius_px = fields.radius_px() as f32;
    let mark = |&(u, v): &(f64, f64)| FieldMark { x_px: u as f32, y_px: v as f32, radius_px };
    fields.centres_px().iter().map(mark).collect()
}
