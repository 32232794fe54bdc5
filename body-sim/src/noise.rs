//! Faults of senses and moves (the paper's sections II-A and II-G: sensor noise, poor repeatability), drawn
//! from the body's seed.

use std::str::FromStr;

use pschema_arm::{JointPositions, SplitMix, Within};
use pschema_vision::fields::VisualFields;
use serde::Deserialize;

use crate::manifold::Manifold;

/// Makes a body's faults differ from the errors of the hand with the same seed.
const STREAM: u64 = 0x6A09_E667_F3BC_C909;

/// How often senses fail and how far moves miss. All zero unless the world file says otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default, expecting = "a table")]
pub struct Noise {
    /// Share of frames in which the finger is reported in a field beside its own.
    pub finger_misplaced: Within<0, 1>,
    /// Share of blobs, of the finger or an object, that go unnoticed for one frame.
    pub blob_missed: Within<0, 1>,
    /// Share of frames in which touch is reported though there is none.
    pub touch_false: Within<0, 1>,
    /// Share of frames in which touch is there but not reported.
    pub touch_missed: Within<0, 1>,
    /// Farthest that a move ends from its goal, either way along x and y, in millimetres.
    pub move_error_mm: Within<0, 100>,
}

impl Default for Noise {
    fn default() -> Self {
        Self {
            finger_misplaced: Within::ZERO,
            blob_missed: Within::ZERO,
            touch_false: Within::ZERO,
            touch_missed: Within::ZERO,
            move_error_mm: Within::ZERO,
        }
    }
}

/// Sets one rate to a value, if the value is in range.
type Set = fn(&mut Noise, f64) -> Result<(), String>;

/// The keys of the section, and how each is set.
const KEYS: [(&str, Set); 5] = [
    ("finger_misplaced", |noise, value| put(&mut noise.finger_misplaced, value)),
    ("blob_missed", |noise, value| put(&mut noise.blob_missed, value)),
    ("touch_false", |noise, value| put(&mut noise.touch_false, value)),
    ("touch_missed", |noise, value| put(&mut noise.touch_missed, value)),
    ("move_error_mm", |noise, value| put(&mut noise.move_error_mm, value)),
];

fn put<const MIN: i64, const MAX: i64>(into: &mut Within<MIN, MAX>, value: f64) -> Result<(), String> {
    *into = value.try_into()?;
    Ok(())
}

/// One rate that replaces that of the world file: `KEY=VALUE`, with the file's keys.
#[derive(Clone, Copy, Debug)]
pub struct NoiseSetting {
    set: Set,
    value: f64,
}

impl FromStr for NoiseSetting {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (key, value) = text
            .split_once('=')
            .ok_or_else(|| format!("{text:?} is not KEY=VALUE; an example: finger_misplaced=0.1"))?;
        let value: f64 = value.parse().map_err(|_| format!("{value:?} is not a number"))?;
        let (_, set) = KEYS.into_iter().find(|(known, _)| *known == key).ok_or_else(|| {
            format!("there is no {key:?}; there are {}", KEYS.map(|(known, _)| known).join(", "))
        })?;
        set(&mut Noise::default(), value)?;
        Ok(Self { set, value })
    }
}

impl Noise {
    /// Replaces one rate.
    pub fn set(&mut self, setting: NoiseSetting) {
        // It is in range: that was checked when the setting was read.
        (setting.set)(self, setting.value).ok();
    }
}

/// Draws the faults of one body.
#[derive(Clone, Debug)]
pub struct SenseNoise {
    noise: Noise,
    random: SplitMix,
}

impl SenseNoise {
    /// Faults at these rates, following from a seed.
    #[must_use]
    pub fn new(noise: Noise, seed: u64) -> Self {
        Self { noise, random: SplitMix::new(seed ^ STREAM) }
    }

    /// Whether a blob goes unnoticed.
    pub fn misses_blob(&mut self) -> bool {
        self.random.happens(self.noise.blob_missed.get())
    }

    /// The field that the finger is reported in when it is seen in `field`.
    pub fn finger_field(&mut self, fields: &VisualFields, field: usize) -> usize {
        if !self.random.happens(self.noise.finger_misplaced.get()) {
            return field;
        }
        self.random.one_of(&fields.neighbours(field)).unwrap_or(field)
    }

    /// Whether touch is reported when it is, or is not, there.
    pub fn touch(&mut self, there: bool) -> bool {
        let fault = if there { self.noise.touch_missed } else { self.noise.touch_false };
        there != self.random.happens(fault.get())
    }

    /// Where a move to `to` ends, if nothing is met; never off the manifold.
    pub fn goal(&mut self, manifold: &Manifold, to: JointPositions) -> JointPositions {
        let most_m = self.noise.move_error_mm.metres();
        if most_m <= 0.0 {
            return to;
        }
        let (across_m, outwards_m) = manifold.square.at_m(to);
        let error_m = (most_m * self.random.within_one(), most_m * self.random.within_one());
        let missed = manifold.square.joints((across_m + error_m.0, outwards_m + error_m.1));
        if manifold.at(missed).is_some() { missed } else { to }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::manifold::tests::manifold;

    fn noise(settings: &[&str]) -> Noise {
        let mut noise = Noise::default();
        settings.iter().for_each(|setting| noise.set(setting.parse().unwrap()));
        noise
    }

    #[test]
    fn without_noise_nothing_is_changed() {
        let mut faults = SenseNoise::new(Noise::default(), 3);
        let (manifold, fields) = (manifold(), VisualFields::new(780, 580, 40.0).unwrap());
        let to = JointPositions { j1: 0.4, j2: 0.6 };
        for _ in 0..1000 {
            assert!(!faults.misses_blob() && faults.touch(true) && !faults.touch(false));
            assert_eq!(faults.finger_field(&fields, 200), 200);
            assert_eq!(faults.goal(&manifold, to), to);
        }
    }

    #[test]
    fn faults_come_at_their_rates_and_repeat_for_a_seed() {
        let all = noise(&["blob_missed=0.1", "touch_false=0.2", "touch_missed=0.3", "finger_misplaced=0.4"]);
        let fields = VisualFields::new(780, 580, 40.0).unwrap();
        let run = |seed| {
            let mut faults = SenseNoise::new(all, seed);
            let mut counts = [0; 4];
            for _ in 0..10_000 {
                counts[0] += usize::from(faults.misses_blob());
                counts[1] += usize::from(faults.touch(false));
                counts[2] += usize::from(!faults.touch(true));
                counts[3] += usize::from(faults.finger_field(&fields, 200) != 200);
            }
            counts
        };
        let counts = run(5);
        for (count, share) in counts.iter().zip([0.1, 0.2, 0.3, 0.4]) {
            assert!((*count as f64 / 1e4 - share).abs() < 0.02, "{counts:?}");
        }
        assert_eq!(counts, run(5));
        assert_ne!(counts, run(6));
    }

    #[test]
    fn moves_miss_by_as_much_as_stated_and_stay_on_the_manifold() {
        let manifold = manifold();
        let mut faults = SenseNoise::new(noise(&["move_error_mm=5"]), 1);
        let mut furthest_m = 0.0_f64;
        for (j1, j2) in [(0.5, 0.5), (0.5, 1.0)] {
            let to = JointPositions { j1, j2 };
            let wanted = manifold.square.at_m(to);
            for _ in 0..1000 {
                let goal = faults.goal(&manifold, to);
                assert!(manifold.at(goal).is_some());
                let there = manifold.square.at_m(goal);
                furthest_m = furthest_m.max((there.0 - wanted.0).abs().max((there.1 - wanted.1).abs()));
            }
        }
        assert!((0.0045..=0.005_000_1).contains(&furthest_m), "{furthest_m}");
    }

    #[test]
    fn a_setting_that_makes_no_sense_is_told() {
        for (text, told) in [
            ("blob_missed", "KEY=VALUE"),
            ("blob_missed=lots", "not a number"),
            ("blob_missed=2", "must be 0 to 1"),
            ("blob_missed=nan", "out of range"),
            ("sight=0.1", "finger_misplaced"),
        ] {
            let error = text.parse::<NoiseSetting>().unwrap_err();
            assert!(error.contains(told), "{text}: {error}");
        }
    }
}
