//! The robot's eye, set up for the colours of a world.

use pschema_vision::classify::{ClassifyError, ColourRange};
pub use pschema_vision::eye::{Eye, Sighting};

use crate::config::WorldFile;

/// Paint in the shade of the scene's lamp keeps well above these.
const SATURATION_MIN: f64 = 0.4;
const VALUE_MIN: f64 = 0.12;

/// An eye for a world's colours; indexes of colours are those of the world file.
///
/// # Errors
/// When the colours cannot be told apart.
pub fn for_world(file: &WorldFile) -> Result<Eye, ClassifyError> {
    let ranges: Vec<ColourRange> = file
        .colours
        .iter()
        .map(|colour| ColourRange {
            name: colour.name.clone(),
            hue_from_deg: colour.hue_deg[0].get(),
            hue_to_deg: colour.hue_deg[1].get(),
            saturation_min: SATURATION_MIN,
            value_min: VALUE_MIN,
        })
        .collect();
    Eye::new(&ranges, file.finger_colour(), file.vision.blob_rules())
}
