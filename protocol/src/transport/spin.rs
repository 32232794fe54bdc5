//! How long to poll before sleeping. A message mostly follows another within microseconds, and to wake from sleep
//! takes 20 µs and more; but a process that polls keeps a core from others. So a process polls only right after a message,
//! and not for long.

use std::thread::available_parallelism;
use std::time::{Duration, Instant};

/// The environment variable that says how many microseconds daemons and bodies poll: 0 to [`SPIN_US_MAX`].
pub const SPIN_VARIABLE: &str = "PSCHEMA_SPIN_US";
/// The longest time to poll that may be asked for, in microseconds: an idle process must not keep a core busy.
pub const SPIN_US_MAX: u64 = 10_000;
/// How long to poll unless the variable says otherwise, in microseconds. This is longer than a round trip with a step of the
/// learner, and too short to show in the processor time of a process.
const SPIN_US: u64 = 50;

/// When to poll and when to sleep. It reads no clock: its methods are told the time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spin {
    most: Duration,
    until: Option<Instant>,
}

impl Spin {
    /// Polling for `us` microseconds after each message, or not at all for 0. More than [`SPIN_US_MAX`] counts as that.
    #[must_use]
    pub fn new(us: u64) -> Self {
        Self { most: Duration::from_micros(us.min(SPIN_US_MAX)), until: None }
    }

    /// Polling as [`SPIN_VARIABLE`] says. Without it a process polls for 50 µs, and on a machine with a single core not at
    /// all, because no message can come there while it polls.
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

    /// The usual polling if the variable says `asked`; none if that is no number in the range.
    fn of(asked: Option<&str>, cores: usize) -> Option<Self> {
        match asked {
            Some(text) => text.trim().parse().ok().filter(|us| *us <= SPIN_US_MAX).map(Self::new),
            None => Some(Self::new(if cores > 1 { SPIN_US } else { 0 })),
        }
    }

    /// How many microseconds it polls.
    #[must_use]
    pub fn us(&self) -> u64 {
        u64::try_from(self.most.as_micros()).unwrap_or(SPIN_US_MAX)
    }

    /// Notes that a message came or was sent: more may follow soon.
    pub fn happened(&mut self, now: Instant) {
        self.until = now.checked_add(self.most);
    }

    /// Whether to go on polling. Once the answer is no, it stays no until the next message.
    #[must_use]
    pub fn goes_on(&mut self, now: Instant) -> bool {
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
