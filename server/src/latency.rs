//! How long steps take: exact percentiles of the last few thousand, and of all of them to within a few
//! percent.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Steps that the exact percentiles are over.
pub const RECENT_MAX: usize = 4096;
/// Seconds that the rate is over.
const RATE_SECONDS: u64 = 10;

/// Buckets for each doubling of the time.
const BUCKETS_PER_OCTAVE: usize = 16;
/// Doublings from 1 ns on: more than a century.
const OCTAVES: usize = 64;

/// Times of steps.
#[derive(Clone, Debug)]
pub struct Latencies {
    recent: VecDeque<u64>,
    all: Histogram,
    ended: VecDeque<Instant>,
}

impl Default for Latencies {
    fn default() -> Self {
        Self {
            recent: VecDeque::with_capacity(RECENT_MAX),
            all: Histogram::default(),
            ended: VecDeque::with_capacity(RECENT_MAX),
        }
    }
}

impl Latencies {
    /// Counts a step that took `time` and ended at `now`.
    pub fn count(&mut self, time: Duration, now: Instant) {
        let nanoseconds = u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
        if self.recent.len() == RECENT_MAX {
            self.recent.pop_front();
            self.ended.pop_front();
        }
        self.recent.push_back(nanoseconds);
        self.ended.push_back(now);
        self.all.count(nanoseconds);
    }

    /// The time that the share `of` (0 to 1) of the last [`RECENT_MAX`] steps did not exceed, in µs; 0
    /// without steps.
    #[must_use]
    pub fn recent_us(&self, of: f64) -> f64 {
        let mut sorted: Vec<u64> = self.recent.iter().copied().collect();
        sorted.sort_unstable();
        let at = rank(of, sorted.len() as u64).saturating_sub(1);
        let time = usize::try_from(at).ok().and_then(|at| sorted.get(at)).copied().unwrap_or(0);
        time as f64 / 1000.0
    }

    /// The same of all steps, to within a sixteenth of itself, in µs.
    #[must_use]
    pub fn all_us(&self, of: f64) -> f64 {
        self.all.quantile_us(of)
    }

    /// Steps a second over the last 10 s before `now`, or since `start` when that is later.
    #[must_use]
    pub fn rate(&self, now: Instant, start: Instant) -> f64 {
        let span = now.saturating_duration_since(start).min(Duration::from_secs(RATE_SECONDS));
        let recent = self.ended.iter().rev();
        let within = recent.take_while(|ended| now.saturating_duration_since(**ended) <= span).count();
        // A fast learner fills the list in less than the span: then the list says it.
        let oldest = self.ended.front().map_or(span, |ended| now.saturating_duration_since(*ended));
        let span = if within == RECENT_MAX { oldest } else { span };
        if span.is_zero() { 0.0 } else { within as f64 / span.as_secs_f64() }
    }
}

/// How often there were times of each length, to within a sixteenth.
#[derive(Clone, Debug)]
pub(crate) struct Histogram {
    buckets: Vec<u64>,
}

impl Default for Histogram {
    fn default() -> Self {
        Self { buckets: vec![0; OCTAVES * BUCKETS_PER_OCTAVE] }
    }
}

impl Histogram {
    /// Counts a time.
    pub(crate) fn count(&mut self, nanoseconds: u64) {
        if let Some(bucket) = self.buckets.get_mut(bucket(nanoseconds)) {
            *bucket += 1;
        }
    }

    /// How many there were.
    pub(crate) fn total(&self) -> u64 {
        self.buckets.iter().sum()
    }

    /// The time that the share `of` (0 to 1) of them did not exceed, in µs; 0 without any.
    pub(crate) fn quantile_us(&self, of: f64) -> f64 {
        let rank = rank(of, self.total());
        let mut below = 0;
        for (at, count) in self.buckets.iter().enumerate() {
            below += count;
            if rank > 0 && below >= rank {
                return upper_end(at) / 1000.0;
            }
        }
        0.0
    }
}

/// The rank, from 1, of the share `of` among `count`; 0 without any.
fn rank(of: f64, count: u64) -> u64 {
    // Shares are constants in 0..=1 and counts far below 2^53, so nothing is lost.
    (of.clamp(0.0, 1.0) * count as f64).ceil().max(if count == 0 { 0.0 } else { 1.0 }) as u64
}

/// Times below 16 ns have a bucket each; from there on each doubling has 16.
fn bucket(nanoseconds: u64) -> usize {
    let octave = nanoseconds.checked_ilog2().unwrap_or(0) as usize;
    let shift = octave.saturating_sub(4);
    let within = usize::try_from(nanoseconds >> shift).unwrap_or(usize::MAX);
    // `within` is below 16 for the small ones and 16..32 otherwise.
    shift * BUCKETS_PER_OCTAVE + within
}

/// The end of a bucket, in ns.
fn upper_end(bucket: usize) -> f64 {
    let shift = (bucket / BUCKETS_PER_OCTAVE).saturating_sub(1);
    let within = bucket - shift * BUCKETS_PER_OCTAVE;
    (within as f64 + 1.0) * 2f64.powi(i32::try_from(shift).unwrap_or(i32::MAX))
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
    fn every_time_has_a_bucket_and_buckets_are_in_order() {
        let times = (0..64).flat_map(|shift| [0, 1, 3].map(|more| (1_u64 << shift).saturating_add(more)));
        let mut times: Vec<u64> = times.chain([0, u64::MAX]).collect();
        times.sort_unstable();
        let buckets: Vec<_> = times.iter().map(|time| bucket(*time)).collect();
        assert!(
            buckets.is_sorted() && buckets.iter().all(|at| *at < OCTAVES * BUCKETS_PER_OCTAVE),
            "{buckets:?}"
        );
        for (time, bucket) in times.iter().zip(&buckets) {
            assert!(*time as f64 <= upper_end(*bucket), "{time} is beyond the end of its bucket");
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
