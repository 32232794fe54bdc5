//! From camera pixels to observations: camera geometry, colour blobs, circular visual fields.
//!
//! The paper's eye (section III-A): a 780x580 camera on a pan/tilt mount above the work space, blobs told
//! apart by their colour, a visual space divided into small circular fields. A simulated and a real camera
//! see with the same code: everything here starts from plain RGB pixels.
//!
//! [`image::RgbImage`] -> [`classify::Classifier`] -> [`blobs::BlobFinder`] ([`eye::Eye`]: the finger
//! and the objects) -> [`fields::VisualFields`]

pub mod blobs;
pub mod camera;
pub mod classify;
pub mod eye;
pub mod fields;
pub mod image;
