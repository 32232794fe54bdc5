//! The median of some figures, with its confidence interval.

/// A median with its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// The middle.
    pub median: f64,
    /// The lower end of its 95 % interval, or the smallest figure where there are too few for one.
    pub low: f64,
    /// The upper end of it, or the largest figure.
    pub high: f64,
    /// How many figures there are.
    pub n: usize,
}

impl Summary {
    /// Median, low and high.
    pub(crate) fn ends(self) -> [f64; 3] {
        [self.median, self.low, self.high]
    }
}

/// `None` for no figures.
#[must_use]
pub fn summary(mut figures: Vec<f64>) -> Option<Summary> {
    figures.sort_by(f64::total_cmp);
    let (n, first, last) = (figures.len(), *figures.first()?, *figures.last()?);
    let median = f64::midpoint(figures[(n - 1) / 2], figures[n / 2]);
    let (low, high) = order_statistic(n).map_or((first, last), |at| (figures[at], figures[n - 1 - at]));
    Some(Summary { median, low, high, n })
}

/// `None` for no figures.
pub(crate) fn median(figures: Vec<f64>) -> Option<f64> {
    summary(figures).map(|summary| summary.median)
}

/// The figure that the share `of` (0 to 1) of `sorted` does not exceed; `None` for no figures.
pub fn percentile(sorted: &[f64], of: f64) -> Option<f64> {
    #[expect(clippy::cast_precision_loss, reason = "numbers of steps")]
    let rank = (of.clamp(0.0, 1.0) * sorted.len() as f64).ceil();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0 and the length")]
    sorted.get((rank as usize).saturating_sub(1)).copied()
}

/// What the interval of so many figures is.
#[must_use]
pub fn interval(n: usize) -> &'static str {
    match order_statistic(n) {
        Some(_) => "the 95 % interval of the median",
        None => "the smallest and the largest (fewer than 6 runs give no 95 % interval)",
    }
}

/// How many of `n` figures to leave out at each end so that the rest still covers the median of what they were
/// drawn from with at least 95 %, whatever its distribution; `None` when even all of them do not.
pub(crate) fn order_statistic(n: usize) -> Option<usize> {
    // P(at most k of n below the median) for k = 0, 1, …: the binomial distribution with p = 1/2.
    let mut term = 0.5_f64.powi(i32::try_from(n).ok()?);
    let (mut tail, mut out) = (0.0, None);
    for k in 0..n / 2 {
        tail += term;
        if tail > 0.025 {
            break;
        }
        out = Some(k);
        #[expect(clippy::cast_precision_loss, reason = "numbers of runs")]
        let ratio = (n - k) as f64 / (k + 1) as f64;
        term *= ratio;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_of_the_median_is_the_textbooks() {
        // Tables of the sign test: 6 figures, the extremes; 10, the 2nd and 9th; 20, the 6th and 15th; 5 none.
        assert_eq!([5, 6, 10, 20].map(order_statistic), [None, Some(0), Some(1), Some(5)]);
        assert_eq!(order_statistic(0), None);
    }

    #[test]
    fn a_summary_has_the_middle_and_the_ends() {
        assert_eq!(summary(Vec::new()), None);
        assert_eq!(summary(vec![3.0, 1.0]).unwrap().ends(), [2.0, 1.0, 3.0]);
        let ten = summary((1..=10).map(f64::from).collect()).unwrap();
        assert_eq!((ten.ends(), ten.n), ([5.5, 2.0, 9.0], 10));
    }

    #[test]
    fn percentiles_are_figures_of_the_list() {
        let list: Vec<_> = (1..=200).map(f64::from).collect();
        assert_eq!(
            [0.0, 0.5, 0.99, 1.0].map(|of| percentile(&list, of).unwrap()),
            [1.0, 100.0, 198.0, 200.0]
        );
        assert_eq!(percentile(&[], 0.5), None);
    }
}
