//! Which colour a pixel is: ranges of hue, saturation and value, looked up in a table.

use std::ops::Range;

use thiserror::Error;

use crate::image::RgbImage;

/// Colours one classifier can tell apart.
pub const COLOURS_MAX: usize = 32;
/// The class of pixels of no known colour.
pub const NO_COLOUR: u8 = 0;

/// Bits of each channel that index the table.
const BITS: u32 = 5;
const SIDE: usize = 1 << BITS;

/// A colour to look for.
#[derive(Clone, Debug, PartialEq)]
pub struct ColourRange {
    /// The colour's name, for error messages.
    pub name: String,
    /// First hue of the range in degrees, 0 to 360 (red 0, green 120, blue 240).
    pub hue_from_deg: f64,
    /// First hue beyond the range in degrees. Below `hue_from_deg` when the range passes through 360.
    pub hue_to_deg: f64,
    /// Smallest saturation, 0 (grey) to 1 (pure).
    pub saturation_min: f64,
    /// Smallest value (brightness), 0 to 1.
    pub value_min: f64,
}

impl ColourRange {
    fn has_hue(&self, hue_deg: f64) -> bool {
        if self.hue_from_deg <= self.hue_to_deg {
            (self.hue_from_deg..self.hue_to_deg).contains(&hue_deg)
        } else {
            hue_deg >= self.hue_from_deg || hue_deg < self.hue_to_deg
        }
    }
}

/// Why colour ranges cannot be told apart.
#[derive(Debug, Error, PartialEq)]
pub enum ClassifyError {
    /// There are no colours, or too many.
    #[error("{0} colours: there must be 1 to {COLOURS_MAX}")]
    Count(usize),
    /// A number of a range is out of bounds.
    #[error("colour {name}: hues must be in 0..=360 degrees, saturation_min and value_min in 0..=1")]
    Range {
        /// The colour.
        name: String,
    },
    /// Two colours share hues.
    #[error("colours {first} and {second} overlap: give each its own range of hues")]
    Overlap {
        /// One of the two.
        first: String,
        /// The other.
        second: String,
    },
}

/// A table from RGB to colour class, 32 steps a channel.
#[derive(Clone, Debug)]
pub struct Classifier {
    table: Vec<u8>,
}

impl Classifier {
    /// A classifier for these colours; colour `i` becomes class `i + 1`.
    ///
    /// # Errors
    /// When there are none or too many, a number is out of range, or two colours share hues.
    pub fn new(colours: &[ColourRange]) -> Result<Self, ClassifyError> {
        if colours.is_empty() || colours.len() > COLOURS_MAX {
            return Err(ClassifyError::Count(colours.len()));
        }
        for (index, colour) in colours.iter().enumerate() {
            let hues_ok = [colour.hue_from_deg, colour.hue_to_deg].iter().all(|h| (0.0..=360.0).contains(h));
            let rest_ok = [colour.saturation_min, colour.value_min].iter().all(|x| (0.0..=1.0).contains(x));
            if !hues_ok || !rest_ok {
                return Err(ClassifyError::Range { name: colour.name.clone() });
            }
            // Two ranges overlap when one contains the start of the other.
            if let Some(other) = colours[..index]
                .iter()
                .find(|other| other.has_hue(colour.hue_from_deg) || colour.has_hue(other.hue_from_deg))
            {
                let (first, second) = (other.name.clone(), colour.name.clone());
                return Err(ClassifyError::Overlap { first, second });
            }
        }
        let mut table = vec![NO_COLOUR; SIDE * SIDE * SIDE];
        for (cell, class) in table.iter_mut().enumerate() {
            let channel = |shift: u32| {
                let step = (cell >> shift) & (SIDE - 1);
                (step as f64 + 0.5) / SIDE as f64
            };
            *class = class_of(colours, channel(2 * BITS), channel(BITS), channel(0));
        }
        Ok(Self { table })
    }

    /// The class of every pixel, row by row, into `classes` (resized to fit).
    pub fn classify(&self, image: &RgbImage, classes: &mut Vec<u8>) {
        classes.clear();
        classes.extend(image.pixels().iter().map(|pixel| self.class(*pixel)));
    }

    /// The classes of a range of pixels, counted row by row, into their places in `classes`. What is beyond the
    /// picture or `classes` is left out.
    pub fn classify_part(&self, image: &RgbImage, part: Range<usize>, classes: &mut [u8]) {
        let (Some(pixels), Some(classes)) = (image.pixels().get(part.clone()), classes.get_mut(part)) else {
            return;
        };
        for (pixel, class) in pixels.iter().zip(classes) {
            *class = self.class(*pixel);
        }
    }

    /// The class of one pixel: [`NO_COLOUR`], or one more than the colour's index.
    #[must_use]
    pub fn class(&self, [red, green, blue]: [u8; 3]) -> u8 {
        let step = |channel: u8| usize::from(channel >> (8 - BITS));
        // In range by construction: three numbers below SIDE.
        self.table[(step(red) * SIDE + step(green)) * SIDE + step(blue)]
    }
}

fn class_of(colours: &[ColourRange], red: f64, green: f64, blue: f64) -> u8 {
    let (hue_deg, saturation, value) = hsv(red, green, blue);
    let matches =
        |c: &ColourRange| c.has_hue(hue_deg) && saturation >= c.saturation_min && value >= c.value_min;
    colours.iter().position(matches).map_or(NO_COLOUR, |index| index as u8 + 1)
}

/// Hue in degrees 0..360, saturation and value 0..=1, of channels 0..=1.
#[must_use]
pub fn hsv(red: f64, green: f64, blue: f64) -> (f64, f64, f64) {
    let value = red.max(green).max(blue);
    let chroma = value - red.min(green).min(blue);
    if chroma <= 0.0 {
        return (0.0, 0.0, value);
    }
    let sixth = if value == red {
        (green - blue) / chroma
    } else if value == green {
        2.0 + (blue - red) / chroma
    } else {
        4.0 + (red - green) / chroma
    };
    let hue_deg = if sixth < 0.0 { (sixth + 6.0) * 60.0 } else { sixth * 60.0 };
    (hue_deg, chroma / value, value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn range(name: &str, hue_from_deg: f64, hue_to_deg: f64) -> ColourRange {
        ColourRange { name: name.into(), hue_from_deg, hue_to_deg, saturation_min: 0.4, value_min: 0.15 }
    }

    #[test]
    fn colours_are_told_apart_in_light_and_shade() {
        let classifier = Classifier::new(&[
            range("green", 90.0, 150.0),
            range("blue", 200.0, 260.0),
            range("red", 340.0, 15.0),
        ])
        .unwrap();
        for (pixel, class) in [
            ([20, 200, 30], 1),
            ([10, 90, 14], 1),
            ([20, 60, 220], 2),
            ([12, 30, 100], 2),
            ([210, 20, 20], 3),
            ([200, 20, 40], 3),
            ([200, 200, 200], NO_COLOUR),
            ([3, 3, 3], NO_COLOUR),
            ([230, 200, 20], NO_COLOUR),
        ] {
            assert_eq!(classifier.class(pixel), class, "{pixel:?}");
        }
    }

    #[test]
    fn a_part_is_classified_in_its_place() {
        let classifier = Classifier::new(&[range("green", 90.0, 150.0)]).unwrap();
        let mut image = RgbImage::new(4, 2).unwrap();
        image.pixels_mut()[2..6].fill([20, 200, 30]);
        let mut classes = Vec::new();
        classifier.classify(&image, &mut classes);
        assert_eq!(classes, [0, 0, 1, 1, 1, 1, 0, 0]);
        image.pixels_mut()[3..5].fill([0; 3]);
        classifier.classify_part(&image, 3..4, &mut classes);
        assert_eq!(classes, [0, 0, 1, 0, 1, 1, 0, 0]);
        classifier.classify_part(&image, 3..99, &mut classes);
        assert_eq!(classes, [0, 0, 1, 0, 1, 1, 0, 0]);
    }

    #[test]
    fn overlapping_and_impossible_ranges_are_refused() {
        let overlap = Classifier::new(&[range("red", 340.0, 15.0), range("orange", 10.0, 40.0)]);
        assert!(matches!(overlap, Err(ClassifyError::Overlap { .. })));
        assert!(matches!(Classifier::new(&[range("x", -5.0, 4.0)]), Err(ClassifyError::Range { .. })));
        assert!(matches!(Classifier::new(&[range("x", f64::NAN, 4.0)]), Err(ClassifyError::Range { .. })));
        assert!(matches!(Classifier::new(&[]), Err(ClassifyError::Count(0))));
    }

    #[test]
    fn hsv_of_known_colours() {
        assert_eq!(hsv(1.0, 0.0, 0.0), (0.0, 1.0, 1.0));
        assert_eq!(hsv(0.0, 0.5, 0.0), (120.0, 1.0, 0.5));
        assert_eq!(hsv(0.5, 0.5, 1.0), (240.0, 0.5, 1.0));
        assert_eq!(hsv(1.0, 0.0, 1.0), (300.0, 1.0, 1.0));
    }
}
