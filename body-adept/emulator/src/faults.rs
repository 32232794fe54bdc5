//! Faults of the line, from a seed: what a serial line in a workshop does to text.

use std::str::FromStr;
use std::time::Duration;

use pschema_arm::SplitMix;

/// How often each fault happens: a share, 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FaultRates {
    /// Of bytes, either way: it is lost.
    pub lose: f64,
    /// Of bytes, either way: one of its bits is flipped.
    pub flip: f64,
    /// Of bytes, either way: a byte of noise comes before it.
    pub noise: f64,
    /// Of answers: it breaks off in the middle.
    pub cut: f64,
    /// Of answers: it never comes.
    pub mute: f64,
    /// Of answers: it comes late.
    pub late: f64,
    /// Of answers: text that nobody asked for comes before it.
    pub chatter: f64,
    /// Of answers: it comes twice.
    pub twice: f64,
    /// Of answers: the plug is pulled before it, and put back a moment later.
    pub unplug: f64,
}

/// The names of the rates, in the order of their fields.
const NAMES: [&str; 9] = ["lose", "flip", "noise", "cut", "mute", "late", "chatter", "twice", "unplug"];

impl FaultRates {
    fn rate_mut(&mut self, name: &str) -> Option<&mut f64> {
        Some(match name {
            "lose" => &mut self.lose,
            "flip" => &mut self.flip,
            "noise" => &mut self.noise,
            "cut" => &mut self.cut,
            "mute" => &mut self.mute,
            "late" => &mut self.late,
            "chatter" => &mut self.chatter,
            "twice" => &mut self.twice,
            "unplug" => &mut self.unplug,
            _ => return None,
        })
    }

    /// Sets one rate.
    pub fn set(&mut self, setting: &FaultSetting) {
        if let Some(rate) = self.rate_mut(setting.name) {
            *rate = setting.share;
        }
    }
}

/// `KEY=SHARE`, as given on a command line.
#[derive(Clone, Debug, PartialEq)]
pub struct FaultSetting {
    name: &'static str,
    share: f64,
}

impl FromStr for FaultSetting {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known =
            || format!("the faults are {}, each a share from 0 to 1, as in flip=0.01", NAMES.join(", "));
        let (name, share) = text.split_once('=').ok_or_else(known)?;
        let name = NAMES.into_iter().find(|known| *known == name).ok_or_else(known)?;
        let share = share.parse().ok().filter(|share| (0.0..=1.0).contains(share)).ok_or_else(known)?;
        Ok(Self { name, share })
    }
}

/// What becomes of an answer.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Sent {
    /// The bytes that go out.
    pub(crate) bytes: Vec<u8>,
    /// How long they are held back.
    pub(crate) late: Duration,
    /// Whether the plug is pulled first, and for how long.
    pub(crate) unplug: Option<Duration>,
}

/// Longest that a late answer is held back, and that the plug stays out.
const LATE_MAX: Duration = Duration::from_millis(400);
const UNPLUGGED: Duration = Duration::from_millis(60);
/// What is said unasked: a message, a prompt out of turn, something like an answer.
const CHATTER: [&str; 5] = [
    "\r\n*Warning: backup battery low*\r\n",
    "\r\n.",
    "\r\n*E-STOP from user E-STOP button*\r\n.",
    "OK 1 0 0 0\r\n",
    "END 1 0\r\n",
];

/// The faults of one line.
#[derive(Clone, Debug)]
pub(crate) struct Faults {
    pub(crate) rates: FaultRates,
    random: SplitMix,
    injected: u64,
    max: u64,
}

impl Faults {
    /// At most `max` faults in all.
    pub(crate) fn new(rates: FaultRates, seed: u64, max: u64) -> Self {
        Self { rates, random: SplitMix::new(seed ^ 0x5EED_1A5E), injected: 0, max }
    }

    /// How many there were.
    pub(crate) fn injected(&self) -> u64 {
        self.injected
    }

    fn happens(&mut self, rate: f64) -> bool {
        if rate <= 0.0 || self.injected >= self.max || !self.random.happens(rate) {
            return false;
        }
        self.injected += 1;
        true
    }

    /// What becomes of bytes on their way.
    pub(crate) fn bytes(&mut self, bytes: &[u8]) -> Vec<u8> {
        let FaultRates { lose, flip, noise, .. } = self.rates;
        let mut passed = Vec::with_capacity(bytes.len());
        for byte in bytes {
            if self.happens(noise) {
                passed.push(self.any_byte());
            }
            if self.happens(lose) {
                continue;
            }
            let bit = if self.happens(flip) {
                self.random.one_of(&[1, 2, 4, 8, 16, 32, 64]).unwrap_or(1)
            } else {
                0
            };
            passed.push(byte ^ bit);
        }
        passed
    }

    fn any_byte(&mut self) -> u8 {
        let all: Vec<u8> = (0..=255).collect();
        self.random.one_of(&all).unwrap_or_default()
    }

    /// What becomes of an answer on its way out.
    pub(crate) fn answer(&mut self, text: &str) -> Sent {
        let FaultRates { cut, mute, late, chatter, twice, unplug, .. } = self.rates;
        let mut sent = Sent::default();
        if self.happens(unplug) {
            sent.unplug = Some(UNPLUGGED);
        }
        if self.happens(late) {
            sent.late = LATE_MAX.mul_f64((self.random.within_one() + 1.0) / 2.0);
        }
        let mut text = text.to_owned();
        if self.happens(twice) {
            text = text.repeat(2);
        }
        if self.happens(chatter) {
            text.insert_str(0, self.random.one_of(&CHATTER).unwrap_or_default());
        }
        if self.happens(mute) {
            text.clear();
        }
        let mut bytes = text.into_bytes();
        if self.happens(cut) {
            let lengths: Vec<usize> = (0..bytes.len()).collect();
            bytes.truncate(self.random.one_of(&lengths).unwrap_or(0));
        }
        sent.bytes = self.bytes(&bytes);
        sent
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_read_and_slips_are_explained() {
        let mut rates = FaultRates::default();
        for name in NAMES {
            rates.set(&format!("{name}=0.25").parse().unwrap());
            assert_eq!(rates.rate_mut(name).copied(), Some(0.25));
        }
        for slip in ["flip", "flip=2", "flip=nan", "flop=0.1"] {
            let error = slip.parse::<FaultSetting>().unwrap_err();
            assert!(error.contains("chatter"), "{error}");
        }
    }

    #[test]
    fn without_faults_nothing_is_changed_and_with_them_the_same_seed_changes_the_same() {
        let mut none = Faults::new(FaultRates::default(), 1, u64::MAX);
        assert_eq!(none.answer("OK 1\r\n"), Sent { bytes: b"OK 1\r\n".to_vec(), ..Sent::default() });
        assert_eq!(none.injected(), 0);
        let rates =
            FaultRates { lose: 0.1, flip: 0.1, noise: 0.1, cut: 0.1, late: 0.1, ..FaultRates::default() };
        let run = |seed| {
            let mut faults = Faults::new(rates, seed, 50);
            let sent: Vec<Sent> = (0..100).map(|_| faults.answer("OK 12 1 2 3\r\n")).collect();
            assert_eq!(faults.injected(), 50, "no more than asked for");
            sent
        };
        assert_eq!(run(3), run(3));
        assert_ne!(run(3), run(4));
    }
}
