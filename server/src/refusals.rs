//! What was refused, counted by reason; and how much of what peers do goes into the log, so that none of them can fill
//! a disk with it.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use pschema_inspect::RefusalCount;
use pschema_protocol::refusal;

/// Lines that peers may cause in the log within [`WINDOW`].
const LINES_MAX: u32 = 60;
const WINDOW: Duration = Duration::from_secs(60);

/// Messages refused, by the number of the refusal: of which there are few, whatever peers send.
#[derive(Debug, Default)]
pub(crate) struct Refusals {
    counts: BTreeMap<u32, u64>,
}

impl Refusals {
    /// Counts one, and logs it: of each reason the first, the second, the fourth and so on.
    pub(crate) fn count(&mut self, session: Option<u64>, code: u32, reason: &str, log: &mut LogBudget) {
        let count = self.counts.entry(code).or_default();
        *count += 1;
        if count.is_power_of_two() && log.takes() {
            tracing::warn!(session, code, count, %reason, "refused");
        } else {
            tracing::debug!(session, code, count, %reason, "refused");
        }
    }

    /// How many of each.
    pub(crate) fn counts(&self) -> Vec<RefusalCount> {
        let told = |(code, count): (&u32, &u64)| RefusalCount {
            code: *code,
            reason: refusal::reason(*code).to_owned(),
            count: *count,
        };
        self.counts.iter().map(told).collect()
    }
}

/// Lines that may still be written.
#[derive(Debug, Default)]
pub(crate) struct LogBudget {
    since: Option<Instant>,
    taken: u32,
    kept_back: u64,
}

impl LogBudget {
    /// Whether one more line may be written. The first that may after some that might not says how many those were.
    pub(crate) fn takes(&mut self) -> bool {
        self.takes_at(Instant::now())
    }

    fn takes_at(&mut self, now: Instant) -> bool {
        if self.since.is_none_or(|since| now.saturating_duration_since(since) >= WINDOW) {
            if self.kept_back > 0 {
                tracing::warn!(lines = self.kept_back, "peers caused more lines than are written");
            }
            *self = Self { since: Some(now), taken: 0, kept_back: 0 };
        }
        if self.taken < LINES_MAX {
            self.taken += 1;
            return true;
        }
        self.kept_back += 1;
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flood_writes_a_bounded_number_of_lines_in_a_window() {
        let mut log = LogBudget::default();
        let begin = Instant::now();
        let lines = |log: &mut LogBudget, at| (0..10_000).filter(|_| log.takes_at(at)).count();
        assert_eq!(lines(&mut log, begin), LINES_MAX as usize);
        assert_eq!(lines(&mut log, begin + WINDOW / 2), 0);
        assert_eq!(lines(&mut log, begin + WINDOW), LINES_MAX as usize);
    }

    #[test]
    fn refusals_are_counted_by_reason() {
        let (mut refusals, mut log) = (Refusals::default(), LogBudget::default());
        for code in [12, 3, 12] {
            refusals.count(None, code, "why", &mut log);
        }
        let told: Vec<_> =
            refusals.counts().into_iter().map(|one| (one.code, one.reason, one.count)).collect();
        assert_eq!(told, [(3, "session".to_owned(), 1), (12, "value range".to_owned(), 2)]);
    }
}
