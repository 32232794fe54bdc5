//! From camera pixels to observations: camera geometry, colour blobs, circular visual fields.
//!
//! The paper's eye (section III-A): a 780x580 camera on a pan/tilt mount above the work space, blobs told
//! apart by their colour, a visual space divided into small circular fields. A simulated and a real camera
//! see with the same code: everything here starts from plain RGB pixels.
//!
//! [`image::RgbImage`] -> [`classify::Classifier`] -> [`blobs::BlobFinder`] ([`eye::Eye`]: the finger
//! and the objects) -> [`fields::VisualFields`]
//!
//! ```
//! use pschema_vision::blobs::BlobRules;
//! use pschema_vision::classify::ColourRange;
//! use pschema_vision::eye::Eye;
//! use pschema_vision::fields::VisualFields;
//! use pschema_vision::image::RgbImage;
//!
//! // A grey picture with a blue square in it.
//! let mut image = RgbImage::new(64, 48)?;
//! for (at, pixel) in image.pixels_mut().iter_mut().enumerate() {
//!     let in_square = (20..30).contains(&(at % 64)) && (10..20).contains(&(at / 64));
//!     *pixel = if in_square { [20, 40, 220] } else { [128; 3] };
//! }
//! let colour = |name: &str, hue_from_deg, hue_to_deg| ColourRange {
//!     name: name.to_owned(),
//!     hue_from_deg,
//!     hue_to_deg,
//!     saturation_min: 0.4,
//!     value_min: 0.2,
//! };
//! // The finger is green, the first of the colours.
//! let colours = [colour("green", 90.0, 150.0), colour("blue", 200.0, 260.0)];
//! let mut eye = Eye::new(&colours, 0, BlobRules { area_px_min: 10, gap_px_max: 2 })?;
//! let sighting = eye.look(&image);
//! assert_eq!(sighting.finger, None);
//! let (index, blob) = &sighting.objects[0];
//! assert_eq!((colours[*index].name.as_str(), blob.centre_px), ("blue", (25.0, 15.0)));
//!
//! // The field that the square is seen in.
//! let fields = VisualFields::new(64, 48, 16.0)?;
//! assert!(fields.field_at(25.0, 15.0).is_some());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![deny(missing_docs)]

pub mod blobs;
pub mod camera;
pub mod classify;
pub mod eye;
pub mod fields;
pub mod image;
