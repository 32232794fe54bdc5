//! Pictures: rows of RGB pixels.

use thiserror::Error;

/// Widest and highest picture handled, in pixels. Bounds all memory that a picture can claim.
pub const SIDE_PX_MAX: usize = 4096;

/// Why bytes are not a picture.
#[derive(Debug, Error, PartialEq, Eq)]
pub enum ImageError {
    /// A side is zero or too long.
    #[error("a picture of {width_px}x{height_px} pixels: each side must be 1 to {SIDE_PX_MAX}")]
    Size {
        /// Width asked for.
        width_px: usize,
        /// Height asked for.
        height_px: usize,
    },
    /// The bytes do not fill the picture exactly.
    #[error("a picture of {width_px}x{height_px} RGB pixels has {expected} bytes, but {found} were given")]
    Length {
        /// Width of the picture.
        width_px: usize,
        /// Height of the picture.
        height_px: usize,
        /// Bytes such a picture has.
        expected: usize,
        /// Bytes given.
        found: usize,
    },
}

/// A picture of 8-bit RGB pixels, row by row from the top left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RgbImage {
    width_px: usize,
    height_px: usize,
    pixels: Vec<[u8; 3]>,
}

impl RgbImage {
    /// A black picture.
    ///
    /// # Errors
    /// When a side is zero or above [`SIDE_PX_MAX`].
    pub fn new(width_px: usize, height_px: usize) -> Result<Self, ImageError> {
        let sides = 1..=SIDE_PX_MAX;
        if !sides.contains(&width_px) || !sides.contains(&height_px) {
            return Err(ImageError::Size { width_px, height_px });
        }
        Ok(Self { width_px, height_px, pixels: vec![[0; 3]; width_px * height_px] })
    }

    /// A picture from packed RGB bytes, as a frame grabber delivers them.
    ///
    /// # Errors
    /// When a side is out of range or the number of bytes is not `width * height * 3`.
    pub fn from_rgb_bytes(width_px: usize, height_px: usize, bytes: &[u8]) -> Result<Self, ImageError> {
        let mut image = Self::new(width_px, height_px)?;
        let expected = width_px * height_px * 3;
        if bytes.len() != expected {
            return Err(ImageError::Length { width_px, height_px, expected, found: bytes.len() });
        }
        image.pixels.as_flattened_mut().copy_from_slice(bytes);
        Ok(image)
    }

    /// Width in pixels.
    #[must_use]
    pub fn width_px(&self) -> usize {
        self.width_px
    }

    /// Height in pixels.
    #[must_use]
    pub fn height_px(&self) -> usize {
        self.height_px
    }

    /// All pixels, row by row from the top left.
    #[must_use]
    pub fn pixels(&self) -> &[[u8; 3]] {
        &self.pixels
    }

    /// All pixels, to be painted.
    pub fn pixels_mut(&mut self) -> &mut [[u8; 3]] {
        &mut self.pixels
    }

    /// The packed RGB bytes.
    #[must_use]
    pub fn as_rgb_bytes(&self) -> &[u8] {
        self.pixels.as_flattened()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_must_fill_the_picture_exactly() {
        let bytes: Vec<u8> = (0..18).collect();
        let image = RgbImage::from_rgb_bytes(3, 2, &bytes).unwrap();
        assert_eq!(image.pixels()[4], [12, 13, 14]);
        assert_eq!(image.as_rgb_bytes(), &bytes);
        let short = RgbImage::from_rgb_bytes(3, 2, &bytes[1..]);
        assert!(matches!(short, Err(ImageError::Length { expected: 18, found: 17, .. })));
    }

    #[test]
    fn sizes_are_limited() {
        assert!(RgbImage::new(0, 5).is_err());
        assert!(RgbImage::new(5, SIDE_PX_MAX + 1).is_err());
    }
}
