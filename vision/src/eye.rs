//! The robot's eye: from a picture to the finger and the objects it shows.

use std::ops::Range;

use crate::blobs::{Blob, BlobFinder, BlobRules};
use crate::classify::{Classifier, ClassifyError, ColourRange};
use crate::image::RgbImage;

/// Sees blobs of known colours.
#[derive(Clone, Debug)]
pub struct Eye {
    classifier: Classifier,
    finder: BlobFinder,
    rules: BlobRules,
    classes: Vec<u8>,
    finger_colour: usize,
}

/// The finger and the objects that one picture shows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sighting {
    /// The finger's ball: the largest blob of its colour.
    pub finger: Option<Blob>,
    /// All other blobs, each with the index of its colour.
    pub objects: Vec<(usize, Blob)>,
}

impl Eye {
    /// An eye for these colours; `finger_colour` is the index of the finger's own.
    ///
    /// # Errors
    /// When the colours cannot be told apart.
    pub fn new(
        colours: &[ColourRange],
        finger_colour: usize,
        rules: BlobRules,
    ) -> Result<Self, ClassifyError> {
        let classifier = Classifier::new(colours)?;
        Ok(Self { classifier, finder: BlobFinder::default(), rules, classes: Vec::new(), finger_colour })
    }

    /// The colour that a paint is seen as in full light, as an index.
    #[must_use]
    pub fn colour_of(&self, paint_rgb: [u8; 3]) -> Option<usize> {
        usize::from(self.classifier.class(paint_rgb)).checked_sub(1)
    }

    /// Looks at a picture.
    pub fn look(&mut self, image: &RgbImage) -> Sighting {
        self.classifier.classify(image, &mut self.classes);
        self.see(image)
    }

    /// Looks at a picture that differs from the one looked at last in these ranges of pixels alone. The result is that
    /// of [`Self::look`], and comes sooner.
    pub fn look_again<'a>(
        &mut self,
        image: &RgbImage,
        changed: impl Iterator<Item = &'a Range<usize>>,
    ) -> Sighting {
        if self.classes.len() != image.pixels().len() {
            return self.look(image);
        }
        changed.for_each(|part| self.classifier.classify_part(image, part.clone(), &mut self.classes));
        self.see(image)
    }

    fn see(&mut self, image: &RgbImage) -> Sighting {
        let mut seen = Sighting::default();
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
