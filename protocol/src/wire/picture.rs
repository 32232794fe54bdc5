//! Pictures as bytes: written by bodies, read and checked by tools.

use super::layout::{MAGIC, PICTURE_FIELD_BYTES, PICTURES_VERSION, PictureHeader};
use crate::limits::{PICTURE_FIELDS_MAX, PICTURE_PIXELS_MAX};
use crate::picture::{FieldMark, Picture, PictureMessage};
use crate::refusal::Refusal;

impl Picture<'_> {
    /// How many bytes it takes on the wire; none if it may not be sent because it is empty, too large, has another number of
    /// bytes than its size says, or a field that is nowhere.
    #[must_use]
    pub fn bytes(&self) -> Option<usize> {
        let finite =
            |field: &FieldMark| [field.x_px, field.y_px, field.radius_px].iter().all(|at| at.is_finite());
        length(self.width_px, self.height_px, self.fields.len())
            .filter(|_| pixel_bytes(self.width_px, self.height_px) == Some(self.rgb.len()))
            .filter(|_| self.fields.iter().all(finite))
    }

    /// Its header, as of a picture of `session` after so many frames.
    pub(crate) fn header(&self, session: u64, frame: u64) -> PictureHeader {
        PictureHeader {
            magic: MAGIC,
            version: PICTURES_VERSION,
            session,
            frame,
            width_px: self.width_px,
            height_px: self.height_px,
            field_count: u32::try_from(self.fields.len()).unwrap_or(u32::MAX),
            reserved: 0,
        }
    }

    /// Writes it into `to`, which has room for [`Picture::bytes`].
    pub(crate) fn write(&self, to: &mut [u8]) {
        let (fields, pixels) = to.split_at_mut(to.len().min(self.fields.len() * PICTURE_FIELD_BYTES));
        for (to, field) in fields.chunks_exact_mut(PICTURE_FIELD_BYTES).zip(self.fields) {
            for (to, number) in to.chunks_exact_mut(4).zip([field.x_px, field.y_px, field.radius_px]) {
                to.copy_from_slice(&number.to_le_bytes());
            }
        }
        let count = pixels.len().min(self.rgb.len());
        pixels[..count].copy_from_slice(&self.rgb[..count]);
    }
}

/// Reads a picture that a body sent.
///
/// # Errors
/// What is wrong with it.
pub fn read(header: &PictureHeader, bytes: &[u8]) -> Result<PictureMessage, Refusal> {
    let wrong = |problem: &str| Refusal::Request { problem: format!("a picture {problem}") };
    if header.magic != MAGIC || header.version != PICTURES_VERSION {
        return Err(wrong("of another version"));
    }
    let field_count = usize::try_from(header.field_count).unwrap_or(usize::MAX);
    let expected = length(header.width_px, header.height_px, field_count);
    if expected != Some(bytes.len()) {
        return Err(wrong("whose size is not what it says, or too large"));
    }
    let (fields, rgb) = bytes.split_at(field_count * PICTURE_FIELD_BYTES);
    let fields = fields.chunks_exact(PICTURE_FIELD_BYTES).map(|field| {
        let number = |at: usize| {
            let bytes = field.get(at..at + 4).and_then(|bytes| <[u8; 4]>::try_from(bytes).ok());
            bytes.map(f32::from_le_bytes).filter(|number| number.is_finite())
        };
        Some(FieldMark { x_px: number(0)?, y_px: number(4)?, radius_px: number(8)? })
    });
    Ok(PictureMessage {
        session: header.session,
        frame: header.frame,
        width_px: header.width_px,
        height_px: header.height_px,
        fields: fields.collect::<Option<_>>().ok_or_else(|| wrong("with a field that is nowhere"))?,
        rgb: rgb.to_vec(),
    })
}

fn pixel_bytes(width_px: u32, height_px: u32) -> Option<usize> {
    let pixels = width_px.checked_mul(height_px).filter(|count| (1..=PICTURE_PIXELS_MAX).contains(count))?;
    usize::try_from(pixels).ok()?.checked_mul(3)
}

fn length(width_px: u32, height_px: u32, fields: usize) -> Option<usize> {
    (fields <= PICTURE_FIELDS_MAX)
        .then(|| pixel_bytes(width_px, height_px)?.checked_add(fields * PICTURE_FIELD_BYTES))
        .flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen() -> (PictureHeader, Vec<u8>, PictureMessage) {
        let rgb: Vec<u8> = (0..5 * 3 * 3).collect();
        let fields = [FieldMark { x_px: 1.5, y_px: 2.0, radius_px: 1.0 }; 2];
        let picture = Picture { width_px: 5, height_px: 3, rgb: &rgb, fields: &fields };
        let mut bytes = vec![0; picture.bytes().expect("a sound picture")];
        picture.write(&mut bytes);
        let kept = PictureMessage {
            session: 7,
            frame: 9,
            width_px: 5,
            height_px: 3,
            rgb: rgb.clone(),
            fields: fields.to_vec(),
        };
        (picture.header(7, 9), bytes, kept)
    }

    #[test]
    fn a_picture_is_read_as_it_was_written() {
        let (header, bytes, kept) = seen();
        assert_eq!(read(&header, &bytes).expect("read"), kept);
    }

    #[test]
    fn what_is_no_picture_is_refused() {
        let (header, bytes, _) = seen();
        let refused = |header: PictureHeader, bytes: &[u8]| read(&header, bytes).is_err();
        assert!(refused(PictureHeader { magic: 1, ..header }, &bytes));
        assert!(refused(PictureHeader { version: 99, ..header }, &bytes));
        assert!(refused(PictureHeader { width_px: 0, ..header }, &bytes));
        assert!(refused(PictureHeader { width_px: u32::MAX, height_px: u32::MAX, ..header }, &bytes));
        assert!(refused(PictureHeader { field_count: u32::MAX, ..header }, &bytes));
        assert!(refused(header, &bytes[1..]));
        let mut nowhere = bytes;
        nowhere[..4].copy_from_slice(&f32::NAN.to_le_bytes());
        assert!(refused(header, &nowhere));
        let short = Picture { width_px: 2, height_px: 2, rgb: &[0; 11], fields: &[] };
        assert_eq!(short.bytes(), None);
        let nowhere = FieldMark { x_px: 1.0, y_px: 1.0, radius_px: f32::NAN };
        let lost = Picture { width_px: 2, height_px: 2, rgb: &[0; 12], fields: &[nowhere] };
        assert_eq!(lost.bytes(), None);
    }
}
