//! Pictures, for people: what a body sees, with the fields it divides it into. The daemon never looks at them;
//! a body offers them and tools watch.

/// What a body sees at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Picture<'a> {
    /// Pixels in a row.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
    /// Red, green and blue of each pixel, row by row from the top.
    pub rgb: &'a [u8],
    /// The fields, numbered as observations number them, from 0. Empty where the body has none.
    pub fields: &'a [FieldMark],
}

/// Where a field of the camera is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldMark {
    /// Middle, in pixels from the left.
    pub x_px: f32,
    /// Middle, in pixels from the top.
    pub y_px: f32,
    /// Radius, in pixels.
    pub radius_px: f32,
}

/// A picture as it comes to a tool.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureMessage {
    /// The session of the body that took it.
    pub session: u64,
    /// How many frames the body had exchanged before it.
    pub frame: u64,
    /// Pixels in a row.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
    /// Red, green and blue of each pixel, row by row from the top.
    pub rgb: Vec<u8>,
    /// The fields, by number.
    pub fields: Vec<FieldMark>,
}
