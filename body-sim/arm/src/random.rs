//! Random numbers from a seed: the same on every machine.

/// SplitMix64 (Steele, Lea and Flood 2014).
#[derive(Clone, Debug)]
pub struct SplitMix(u64);

impl SplitMix {
    /// A generator; equal seeds give equal numbers.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// The next number, evenly distributed from -1 up to 1.
    pub fn within_one(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// True on this share of calls, from 0 to 1.
    pub fn happens(&mut self, share: f64) -> bool {
        ((self.next() >> 11) as f64 / (1_u64 << 53) as f64) < share
    }

    /// One of the choices, each equally likely. None when there are no choices.
    pub fn one_of<T: Copy>(&mut self, choices: &[T]) -> Option<T> {
        let index = self.next().checked_rem(choices.len() as u64)?;
        choices.get(index as usize).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_even_and_bounded() {
        let mut random = SplitMix::new(42);
        let drawn: Vec<f64> = (0..10_000).map(|_| random.within_one()).collect();
        assert!(drawn.iter().all(|x| (-1.0..1.0).contains(x)));
        let mean = drawn.iter().sum::<f64>() / 1e4;
        let square = drawn.iter().map(|x| x * x).sum::<f64>() / 1e4;
        assert!(mean.abs() < 0.02 && (square - 1.0 / 3.0).abs() < 0.02, "{mean} {square}");
    }

    #[test]
    fn what_happens_at_a_share_happens_at_that_share() {
        let mut random = SplitMix::new(7);
        for share in [0.0, 0.1, 0.5, 1.0] {
            let count = (0..10_000).filter(|_| random.happens(share)).count() as f64;
            assert!((count / 1e4 - share).abs() < 0.02, "{share}: {count}");
            assert!(share != 0.0 || count == 0.0);
            assert!(share != 1.0 || count == 1e4);
        }
        assert_eq!(random.one_of::<u8>(&[]), None);
        let counts = (0..9000).fold([0; 3], |mut counts, _| {
            counts[random.one_of(&[0, 1, 2]).unwrap()] += 1;
            counts
        });
        assert!(counts.iter().all(|count| (2700..3300).contains(count)), "{counts:?}");
    }
}
