//! How long to poll before sleeping. A message mostly follows another within microseconds, and waking from sleep
//! costs some 20 µs and more; but who polls keeps a core from others. So: only right after something happened, and not for
//! long.

use std::thread::available_parallelism;
use std::time::{Duration, Instant};

/// Environment variable that says how many microseconds to poll, 0 to [`SPIN_US_MAX`]; read by daemons and bodies.
pub const SPIN_VARIABLE: &str = "PSCHEMA_SPIN_US";
/// The longest anyone may ask for, in microseconds: an idle process must not keep a core busy.
pub const SPIN_US_MAX: u64 = 10_000;
/// How long unless asked: longer than a round trip with the learner's step in it, and too short to be seen in what a
/// process uses.
const SPIN_US: u64 = 50;

/// When to poll and when to sleep. Holds no clock: whoever waits says what time it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spin {
    most: Duration,
    until: Option<Instant>,
}

impl Spin {
    /// Polls for at most so many microseconds after each sign of life; for none at all, 0. More than [`SPIN_US_MAX`]
    /// is as much.
    #[must_use]
    pub fn new(us: u64) -> Self {
        Self { most: Duration::from_micros(us.min(SPIN_US_MAX)), until: None }
    }

    /// As [`SPIN_VARIABLE`] says; else 50 µs, and not at all on a machine with a single core, where nothing can come
    /// while one polls.
    #[must_use]
    pub fn usual() -> Self {
        let asked = std::env::var(SPIN_VARIABLE).ok();
        let cores = available_parallelism().map_or(1, usize::from);
        Self::of(asked.as_deref(), cores).unwrap_or_else(|| {
            tracing::warn!(
                "{SPIN_VARIABLE} is {:?}: it must be a number of microseconds, 0 to {SPIN_US_MAX}; going on with the \
                 usual",
                asked.unwrap_or_default()
            );
            Self::new(SPIN_US)
        })
    }

    /// What is usual when `asked` is what the variable says; none when that is no such number.
    fn of(asked: Option<&str>, cores: usize) -> Option<Self> {
        match asked {
            Some(text) => text.trim().parse().ok().filter(|us| *us <= SPIN_US_MAX).map(Self::new),
            None => Some(Self::new(if cores > 1 { SPIN_US } else { 0 })),
        }
    }

    /// For how many microseconds it polls.
    #[must_use]
    pub fn us(&self) -> u64 {
        u64::try_from(self.most.as_micros()).unwrap_or(SPIN_US_MAX)
    }

    /// Something came, or was asked for: more may follow soon.
    pub(super) fn happened(&mut self, now: Instant) {
        self.until = now.checked_add(self.most);
    }

    /// Whether to go on polling. Once it says no, it does so until something happens again.
    pub(super) fn goes_on(&mut self, now: Instant) -> bool {
        if self.until.is_some_and(|until| now >= until) {
            self.until = None;
        }
        self.until.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const US: Duration = Duration::from_micros(1);

    #[test]
    fn nothing_is_polled_for_until_something_happens() {
        let now = Instant::now();
        let mut spin = Spin::new(50);
        assert!(!spin.goes_on(now));
        assert!(!spin.goes_on(now + 1000 * US), "an idle process sleeps at once, every time");
    }

    #[test]
    fn after_a_sign_of_life_it_polls_for_its_time_and_then_sleeps_until_the_next() {
        let now = Instant::now();
        let mut spin = Spin::new(50);
        spin.happened(now);
        assert!(spin.goes_on(now) && spin.goes_on(now + 49 * US));
        assert!(!spin.goes_on(now + 50 * US));
        assert!(!spin.goes_on(now + 10 * US), "once asleep, only something that happens gets it up");
        spin.happened(now + 60 * US);
        assert!(spin.goes_on(now + 109 * US) && !spin.goes_on(now + 110 * US));
    }

    #[test]
    fn each_sign_of_life_begins_the_time_anew() {
        let now = Instant::now();
        let mut spin = Spin::new(50);
        for at in (0..500).step_by(40) {
            spin.happened(now + at * US);
            assert!(spin.goes_on(now + (at + 39) * US));
        }
    }

    #[test]
    fn none_is_none() {
        let now = Instant::now();
        let mut spin = Spin::new(0);
        spin.happened(now);
        assert!(!spin.goes_on(now));
    }

    #[test]
    fn one_core_does_not_poll_and_what_is_asked_for_has_limits() {
        assert_eq!(Spin::of(None, 1), Some(Spin::new(0)));
        assert_eq!(Spin::of(None, 2), Some(Spin::new(SPIN_US)));
        assert_eq!(Spin::of(Some("20"), 1), Some(Spin::new(20)));
        assert_eq!(Spin::of(Some("0"), 8), Some(Spin::new(0)));
        for wrong in ["", "-1", "fast", "10001", "99999999999999999999"] {
            assert_eq!(Spin::of(Some(wrong), 2), None, "{wrong:?}");
        }
        assert_eq!(Spin::new(u64::MAX), Spin::new(SPIN_US_MAX));
    }
}
