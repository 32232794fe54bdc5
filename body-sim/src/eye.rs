//! The robot's eye: from a picture to the finger and the objects it shows, each in its visual field.

use std::ops::Range;

use pschema_vision::blobs::{Blob, BlobFinder, BlobRules};
use pschema_vision::classify::{Classifier, ClassifyError, ColourRange};
use pschema_vision::image::RgbImage;

use crate::config::WorldFile;

/// Paint in the shade of the scene's lamp keeps well above these.
const SATURATION_MIN: f64 = 0.4;
const VALUE_MIN: f64 = 0.12;

/// Sees blobs of known colours.
#[derive(Clone, Debug)]
pub struct Eye {
    classifier: Classifier,
    finder: BlobFinder,
    rules: BlobRules,
    classes: Vec<u8>,
    finger_colour: usize,
}

/// What is in a picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Seen {
    /// The finger's ball: the largest blob of its colour.
    pub finger: Option<Blob>,
    /// Everything else, with the index of its colour in the world file.
    pub objects: Vec<(usize, Blob)>,
}

impl Eye {
    /// An eye for a world's colours.
    ///
    /// # Errors
    /// When the colours cannot be told apart.
    pub fn new(file: &WorldFile) -> Result<Self, ClassifyError> {
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
        let vision = &file.vision;
        let px = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
        Ok(Self {
            classifier: Classifier::new(&ranges)?,
            finder: BlobFinder::new(),
            rules: BlobRules {
                area_px_min: px(vision.blob_area_px_min.count()),
                gap_px_max: px(vision.blob_gap_px_max.count()),
            },
            classes: Vec::new(),
            finger_colour: file.colour_index(&file.finger.colour).unwrap_or_default(),
        })
    }

    /// The colour that a paint is seen as in full light, as an index.
    #[must_use]
    pub fn colour_of(&self, paint_rgb: [u8; 3]) -> Option<usize> {
        usize::from(self.classifier.class(paint_rgb)).checked_sub(1)
    }

    /// Looks at a picture.
    pub fn look(&mut self, image: &RgbImage) -> Seen {
        self.classifier.classify(image, &mut self.classes);
        self.see(image)
    }

    /// Looks at a picture that differs from the one looked at last in these ranges of pixels alone. Sees what
    /// [`Self::look`] sees, sooner.
    pub fn look_again<'a>(
        &mut self,
        image: &RgbImage,
        changed: impl Iterator<Item = &'a Range<usize>>,
    ) -> Seen {
        if self.classes.len() != image.pixels().len() {
            return self.look(image);
        }
        changed.for_each(|part| self.classifier.classify_part(image, part.clone(), &mut self.classes));
        self.see(image)
    }

    fn see(&mut self, image: &RgbImage) -> Seen {
        let mut seen = Seen::default();
        for blob in self.finder.find(&self.classes, image.width_px(), self.rules) {
            let Some(colour) = usize::from(blob.class).checked_sub(1) else { continue };
            if colour != self.finger_colour {
                seen.objects.push((colour, blob));
            } else if seen.finger.is_none() {
                // Blobs of a colour come largest first.
                seen.finger = Some(blob);
            }
        }
        seen
    }
}
