//! How long steps take: exact percentiles of the last few thousand steps, and percentiles of all steps to within a
//! sixteenth.

use std::sync::Arc;
use std::time::{Duration, Instant};

use hdrhistogram::Histogram;

use crate::ring::Ring;

/// Steps that the exact percentiles are over: the last of them.
pub(crate) const RECENT_MAX: usize = 4096;
/// Steps whose times are in one shared chunk.
const CHUNK_LEN: usize = 256;
/// Seconds that the rate is over.
const RATE_SECONDS: u64 = 10;
/// A longer time is counted as this one: a day, in nanoseconds.
const TIME_NS_MAX: u64 = 24 * 3600 * 1_000_000_000;

/// How long one step took, and when it ended.
#[derive(Clone, Copy, Debug)]
struct Sample {
    nanoseconds: u64,
    ended: Instant,
}

/// Times of steps. A clone shares them, at the cost of three pointers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Latencies {
    /// The last [`RECENT_MAX`] steps and at most one chunk more, for room is made by the chunk.
    recent: Ring<Sample, { RECENT_MAX + CHUNK_LEN }, CHUNK_LEN>,
    all: Arc<Times>,
}

impl Latencies {
    /// Counts a step that took `time` and ended at `now`.
    pub(crate) fn count(&mut self, time: Duration, now: Instant) {
        let nanoseconds = u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
        self.recent.push(Sample { nanoseconds, ended: now });
        Arc::make_mut(&mut self.all).count(time);
    }

    fn recent(&self) -> impl DoubleEndedIterator<Item = &Sample> {
        self.recent.from(self.recent.total().saturating_sub(RECENT_MAX as u64)).1
    }

    /// The time that the share `of` (0 to 1) of the last [`RECENT_MAX`] steps did not exceed, in µs; 0 without
    /// steps.
    pub(crate) fn recent_us(&self, of: f64) -> f64 {
        let mut sorted: Vec<u64> = self.recent().map(|sample| sample.nanoseconds).collect();
        sorted.sort_unstable();
        // The rank counts from 1. Shares are constants in 0..=1 and there are few steps, so nothing is lost.
        let rank = (of.clamp(0.0, 1.0) * sorted.len() as f64).ceil() as usize;
        sorted.get(rank.saturating_sub(1)).map_or(0.0, |time| *time as f64 / 1000.0)
    }

    /// The time that the share `of` (0 to 1) of all steps did not exceed, to within a sixteenth of itself, in µs; 0
    /// without steps.
    pub(crate) fn all_us(&self, of: f64) -> f64 {
        self.all.quantile_us(of)
    }

    /// Steps a second over the last 10 s before `now`, or since `start` when that is later.
    pub(crate) fn rate(&self, now: Instant, start: Instant) -> f64 {
        let span = now.saturating_duration_since(start).min(Duration::from_secs(RATE_SECONDS));
        let age = |sample: &Sample| now.saturating_duration_since(sample.ended);
        let within = self.recent().rev().take_while(|sample| age(sample) <= span).count();
        // A fast learner takes all of these steps in less than the span: then their own span counts.
        let oldest = self.recent().next().map_or(span, age);
        let span = if within == RECENT_MAX { oldest } else { span };
        if span.is_zero() { 0.0 } else { within as f64 / span.as_secs_f64() }
    }
}

/// How often there were times of each length, to within a sixteenth of the length.
#[derive(Clone, Debug)]
pub(crate) struct Times(Histogram<u64>);

impl Default for Times {
    fn default() -> Self {
        // One significant digit is 16 to 32 buckets for each doubling: 5.5 KiB that never grow.
        match Histogram::new_with_bounds(1, TIME_NS_MAX, 1) {
            Ok(histogram) => Self(histogram),
            Err(error) => unreachable!("the bounds are constants that a histogram takes: {error}"),
        }
    }
}

impl Times {
    /// Counts a time.
    pub(crate) fn count(&mut self, time: Duration) {
        self.0.saturating_record(u64::try_from(time.as_nanos()).unwrap_or(u64::MAX));
    }

    /// How many times were counted.
    pub(crate) fn total(&self) -> u64 {
        self.0.len()
    }

    /// The time that the share `of` (0 to 1) of them did not exceed, in µs; 0 without any.
    pub(crate) fn quantile_us(&self, of: f64) -> f64 {
        if self.0.is_empty() { 0.0 } else { self.0.value_at_quantile(of) as f64 / 1000.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_of_all_steps_are_within_a_sixteenth() {
        let mut latencies = Latencies::default();
        let now = Instant::now();
        for microseconds in 1..=10_000_u64 {
            latencies.count(Duration::from_micros(microseconds), now);
        }
        for (of, expected) in [(0.5, 5_000.0), (0.99, 9_900.0), (1.0, 10_000.0)] {
            let found = latencies.all_us(of);
            assert!(found >= expected && found <= expected * (1.0 + 1.0 / 15.0), "{of}: {found}");
        }
        // The last 4,096 are 5,905 to 10,000.
        assert!((latencies.recent_us(0.0) - 5_905.0).abs() < 0.001);
        assert!((latencies.recent_us(0.5) - 7_952.0).abs() < 0.001, "{}", latencies.recent_us(0.5));
    }

    #[test]
    fn every_time_up_to_a_day_is_told_within_a_sixteenth_and_a_longer_one_as_a_day() {
        let times = (0..64).flat_map(|shift| [0, 1, 3].map(|more| (1_u64 << shift).saturating_add(more)));
        for nanoseconds in times.chain([0, u64::MAX]) {
            let mut times = Times::default();
            times.count(Duration::from_nanos(nanoseconds));
            let counted = nanoseconds.min(TIME_NS_MAX) as f64 / 1000.0;
            let told = times.quantile_us(0.5);
            assert!(told >= counted && told <= counted * (1.0 + 1.0 / 15.0), "{nanoseconds} ns: {told} µs");
            assert_eq!(times.total(), 1);
        }
    }

    #[test]
    fn nothing_counted_is_nothing() {
        let latencies = Latencies::default();
        let now = Instant::now();
        assert_eq!((latencies.recent_us(0.99), latencies.all_us(0.99)), (0.0, 0.0));
        assert_eq!(latencies.rate(now, now), 0.0);
    }

    #[test]
    fn the_rate_is_over_the_last_seconds() {
        let mut latencies = Latencies::default();
        let start = Instant::now();
        for step in 0..300_u64 {
            latencies.count(Duration::from_micros(5), start + Duration::from_millis(100 * step));
        }
        let now = start + Duration::from_millis(29_900);
        assert!((latencies.rate(now, start) - 10.0).abs() < 0.2, "{}", latencies.rate(now, start));
    }
}
