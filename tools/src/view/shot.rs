//! Pictures for the page.

use hyper::body::Bytes;
use pschema_protocol::picture::{FieldMark, PictureMessage};
use serde::Serialize;

/// A picture ready to be sent to any number of pages.
#[derive(Debug)]
pub(super) struct Shot {
    /// The number of the picture, counted from 1 in this process.
    pub(super) number: u64,
    /// Counts changes of the fields, so that a page asks for them only then.
    pub(super) fields_version: u64,
    /// The picture as PNG.
    pub(super) png: Bytes,
    /// The fields, by number.
    pub(super) fields: Vec<FieldMark>,
}

/// The fields of a picture as JSON.
#[derive(Serialize)]
pub(super) struct Fields {
    version: u64,
    /// Middle and radius, in pixels: `[x, y, radius]`.
    fields: Vec<[f32; 3]>,
}

impl From<&Shot> for Fields {
    fn from(shot: &Shot) -> Self {
        let fields = shot.fields.iter().map(|mark| [mark.x_px, mark.y_px, mark.radius_px]).collect();
        Self { version: shot.fields_version, fields }
    }
}

/// A picture as PNG. Speed matters more than size: it is shown for a thirtieth of a second, on the same machine.
///
/// # Errors
/// When the picture has not the size that it claims.
pub(super) fn png(seen: &PictureMessage) -> Result<Bytes, png::EncodingError> {
    let mut bytes = Vec::with_capacity(seen.rgb.len() / 8);
    let mut encoder = png::Encoder::new(&mut bytes, seen.width_px, seen.height_px);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fastest);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&seen.rgb)?;
    writer.finish()?;
    Ok(bytes.into())
}
