//! Pictures, for people: what a body sees, and the visual fields in it. Bodies offer them and tools watch them; the daemon never
//! looks at them.

/// A picture that a body sees at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Picture<'a> {
    /// Pixels in a row.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
    /// Red, green and blue of each pixel, row by row from the top.
    pub rgb: &'a [u8],
    /// The visual fields, in the order in which observations number them, from 0. Empty if the body has none.
    pub fields: &'a [FieldMark],
}

/// Where a visual field is in the picture.
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
    /// How many frames the body had exchanged in the session before it.
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
