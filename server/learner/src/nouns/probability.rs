//! How often something was tried and how often it happened (paper, II-A), and what may be concluded.

/// Trials and occurrences, kept as counts: a probability is never shown without them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Count {
    /// How often it happened.
    pub occurrences: u32,
    /// How often it could have happened.
    pub trials: u32,
}

impl Count {
    /// Tried once, happened once.
    pub const ONCE: Count = Count { occurrences: 1, trials: 1 };

    /// Counts one trial. At the largest number both are halved, which keeps the ratio.
    pub fn observe(&mut self, occurred: bool) {
        if self.trials == u32::MAX {
            self.trials /= 2;
            self.occurrences /= 2;
        }
        self.trials += 1;
        self.occurrences += u32::from(occurred);
    }

    /// The share of trials in which it happened, in 0..=1; 0 when never tried.
    #[must_use]
    pub fn ratio(self) -> f64 {
        if self.trials == 0 { 0.0 } else { f64::from(self.occurrences) / f64::from(self.trials) }
    }

    /// The Wilson score interval at 95 %: where the true probability lies, as `(low, high)` in 0..=1.
    #[must_use]
    pub fn interval(self) -> (f64, f64) {
        if self.trials == 0 {
            return (0.0, 1.0);
        }
        const Z: f64 = 1.959_963_984_540_054;
        let trials = f64::from(self.trials);
        let ratio = self.ratio();
        let spread = Z * (ratio * (1.0 - ratio) / trials + Z * Z / (4.0 * trials * trials)).sqrt();
        let centre = ratio + Z * Z / (2.0 * trials);
        let scale = 1.0 + Z * Z / trials;
        (((centre - spread) / scale).max(0.0), ((centre + spread) / scale).min(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::Count;

    #[test]
    fn the_interval_is_wilsons() {
        // 8 of 10 at 95 %: (0.4902, 0.9433), as in Newcombe (1998), table I's method.
        let (low, high) = Count { occurrences: 8, trials: 10 }.interval();
        assert!((low - 0.4902).abs() < 1e-4 && (high - 0.9433).abs() < 1e-4, "{low} {high}");
    }

    #[test]
    fn one_success_is_not_certainty() {
        let (low, high) = Count::ONCE.interval();
        assert!(low > 0.2 && low < 0.21 && high > 0.999, "{low} {high}");
    }

    #[test]
    fn counts_do_not_overflow() {
        let mut count = Count { occurrences: u32::MAX, trials: u32::MAX };
        count.observe(false);
        assert!(count.ratio() > 0.999 && count.trials > 1_000_000);
    }
}
