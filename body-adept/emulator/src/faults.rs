//! Faults of the line, from a seed: those that text meets on a serial line in a workshop.

use std::str::FromStr;
use std::time::Duration;

use pschema_arm::SplitMix;

/// A fault of the line. Its rate is a share of the bytes, in both directions, or of the answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fault {
    /// A byte is lost.
    Lose,
    /// One bit of a byte is flipped.
    Flip,
    /// A byte of noise comes before a byte.
    Noise,
    /// An answer breaks off in the middle.
    Cut,
    /// An answer never comes.
    Mute,
    /// An answer comes late.
    Late,
    /// Text that nobody asked for comes before an answer.
    Chatter,
    /// An answer comes twice.
    Twice,
    /// The plug is pulled before an answer, and put back a moment later.
    Unplug,
}

/// The faults by their names on a command line, in the order of their declaration.
const FAULTS: [(&str, Fault); 9] = [
    ("lose", Fault::Lose),
    ("flip", Fault::Flip),
    ("noise", Fault::Noise),
    ("cut", Fault::Cut),
    ("mute", Fault::Mute),
    ("late", Fault::Late),
    ("chatter", Fault::Chatter),
    ("twice", Fault::Twice),
    ("unplug", Fault::Unplug),
];

/// How often each fault happens: a share, 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct FaultRates([f64; FAULTS.len()]);

impl FaultRates {
    /// The rates that these settings say; 0 for every other fault.
    pub(crate) fn new(settings: &[FaultSetting]) -> Self {
        let mut rates = Self::default();
        settings.iter().for_each(|setting| rates.0[setting.fault as usize] = setting.share);
        rates
    }
}

/// The rate of one fault: `KEY=SHARE`, as given on a command line.
#[derive(Clone, Debug, PartialEq)]
pub struct FaultSetting {
    fault: Fault,
    share: f64,
}

impl FromStr for FaultSetting {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = || {
            let names = FAULTS.map(|(name, _)| name).join(", ");
            format!("the faults are {names}, each a share from 0 to 1, as in flip=0.01")
        };
        let (name, share) = text.split_once('=').ok_or_else(known)?;
        let (_, fault) = FAULTS.into_iter().find(|(known, _)| *known == name).ok_or_else(known)?;
        let share = share.parse().ok().filter(|share| (0.0..=1.0).contains(share)).ok_or_else(known)?;
        Ok(Self { fault, share })
    }
}

/// An answer on its way out, with the faults that it met.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Transmission {
    /// The bytes that go out.
    pub(crate) bytes: Vec<u8>,
    /// How long the bytes are held back.
    pub(crate) late: Duration,
    /// Whether the plug is pulled first, and for how long.
    pub(crate) unplug: Option<Duration>,
}

/// Longest that a late answer is held back, and that the plug stays out.
const LATE_MAX: Duration = Duration::from_millis(400);
const UNPLUGGED: Duration = Duration::from_millis(60);
/// Texts that nobody asked for: a message, a prompt out of turn, something like an answer.
const CHATTER: [&str; 5] = [
    "\r\n*Warning: backup battery low*\r\n",
    "\r\n.",
    "\r\n*E-STOP from user E-STOP button*\r\n.",
    "OK 1 0 0 0\r\n",
    "END 1 0\r\n",
];

/// The faults of one line.
#[derive(Clone, Debug)]
pub(crate) struct LineFaults {
    rates: FaultRates,
    random: SplitMix,
    injected: u64,
    max: u64,
}

impl LineFaults {
    /// Faults at these rates from a seed, at most `max` of them in all.
    pub(crate) fn new(rates: FaultRates, seed: u64, max: u64) -> Self {
        Self { rates, random: SplitMix::new(seed ^ 0x5EED_1A5E), injected: 0, max }
    }

    /// How many there were.
    pub(crate) fn injected(&self) -> u64 {
        self.injected
    }

    fn happens(&mut self, fault: Fault) -> bool {
        let rate = self.rates.0[fault as usize];
        if rate <= 0.0 || self.injected >= self.max || !self.random.happens(rate) {
            return false;
        }
        self.injected += 1;
        true
    }

    /// Bytes after the faults of their way.
    pub(crate) fn bytes(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut passed = Vec::with_capacity(bytes.len());
        for byte in bytes {
            if self.happens(Fault::Noise) {
                passed.push(self.any_byte());
            }
            if self.happens(Fault::Lose) {
                continue;
            }
            let bit = if self.happens(Fault::Flip) {
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

    /// An answer after the faults of its way out.
    pub(crate) fn answer(&mut self, text: &str) -> Transmission {
        let mut sent = Transmission::default();
        if self.happens(Fault::Unplug) {
            sent.unplug = Some(UNPLUGGED);
        }
        if self.happens(Fault::Late) {
            sent.late = LATE_MAX.mul_f64((self.random.within_one() + 1.0) / 2.0);
        }
        let mut text = text.to_owned();
        if self.happens(Fault::Twice) {
            text = text.repeat(2);
        }
        if self.happens(Fault::Chatter) {
            text.insert_str(0, self.random.one_of(&CHATTER).unwrap_or_default());
        }
        if self.happens(Fault::Mute) {
            text.clear();
        }
        let mut bytes = text.into_bytes();
        if self.happens(Fault::Cut) {
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

    fn rates(settings: &[&str]) -> FaultRates {
        let settings: Vec<FaultSetting> = settings.iter().map(|setting| setting.parse().unwrap()).collect();
        FaultRates::new(&settings)
    }

    #[test]
    fn rates_are_read_and_slips_are_explained() {
        for (index, (name, fault)) in FAULTS.into_iter().enumerate() {
            assert_eq!(fault as usize, index, "in the order of declaration");
            assert_eq!(rates(&[&format!("{name}=0.25")]).0[index], 0.25);
        }
        for slip in ["flip", "flip=2", "flip=nan", "flop=0.1"] {
            let error = slip.parse::<FaultSetting>().unwrap_err();
            assert!(error.contains("chatter"), "{error}");
        }
    }

    #[test]
    fn without_faults_nothing_is_changed_and_with_them_the_same_seed_changes_the_same() {
        let mut none = LineFaults::new(FaultRates::default(), 1, u64::MAX);
        let unchanged = Transmission { bytes: b"OK 1\r\n".to_vec(), ..Transmission::default() };
        assert_eq!(none.answer("OK 1\r\n"), unchanged);
        assert_eq!(none.injected(), 0);
        let rates = rates(&["lose=0.1", "flip=0.1", "noise=0.1", "cut=0.1", "late=0.1"]);
        let run = |seed| {
            let mut faults = LineFaults::new(rates, seed, 50);
            let sent: Vec<Transmission> = (0..100).map(|_| faults.answer("OK 12 1 2 3\r\n")).collect();
            assert_eq!(faults.injected(), 50, "no more than asked for");
            sent
        };
        assert_eq!(run(3), run(3));
        assert_ne!(run(3), run(4));
    }
}
