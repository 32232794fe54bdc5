//! Refused messages, counted by reason; and a budget for the lines of the log that peers cause, so that no peer can fill a
//! disk with them.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use pschema_inspect::RefusalCount;
use pschema_protocol::refusal;

/// Lines that peers may cause in the log within [`WINDOW`].
const LINES_MAX: u32 = 60;
const WINDOW: Duration = Duration::from_secs(60);

/// Counts of refused messages, by the number of the refusal. There are few such numbers, whatever peers send.
#[derive(Clone, Debug, Default)]
pub(crate) struct Refusals {
    counts: BTreeMap<u32, u64>,
}

impl Refusals {
    /// Counts one refusal. Of each reason the first, the second, the fourth and so on are logged as warnings.
    pub(crate) fn count(&mut self, session: Option<u64>, code: u32, reason: &str, log: &mut LogBudget) {
        let count = self.counts.entry(code).or_default();
        *count += 1;
        if count.is_power_of_two() && log.takes() {
            tracing::warn!(session, code, count, %reason, "refused");
        } else {
            tracing::debug!(session, code, count, %reason, "refused");
        }
    }

    /// How many messages were refused for each reason.
    pub(crate) fn counts(&self) -> Vec<RefusalCount> {
        let count = |(code, count): (&u32, &u64)| RefusalCount {
            code: *code,
            reason: refusal::reason(*code).to_owned(),
            count: *count,
        };
        self.counts.iter().map(count).collect()
    }
}

/// How many more lines of the log peers may cause within the present window.
#[derive(Debug, Default)]
pub(crate) struct LogBudget {
    since: Option<Instant>,
    taken: u32,
    suppressed: u64,
}

impl LogBudget {
    /// Whether one more line may be written. The first line of a window is preceded by one that says how many lines of the
    /// last window were not written.
    pub(crate) fn takes(&mut self) -> bool {
        self.takes_at(Instant::now())
    }

    fn takes_at(&mut self, now: Instant) -> bool {
        if self.since.is_none_or(|since| now.saturating_duration_since(since) >= WINDOW) {
            if self.suppressed > 0 {
                tracing::warn!(lines = self.suppressed, "peers caused more lines than are written");
            }
            *self = Self { since: Some(now), taken: 0, suppressed: 0 };
        }
        if self.taken < LINES_MAX {
            self.taken += 1;
            return true;
        }
        self.suppressed += 1;
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
