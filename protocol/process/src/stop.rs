//! The wish that a process ends, as a flag to look at.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
use signal_hook::flag;

/// A flag that is raised when this process is asked to end. Clones share it.
#[derive(Clone, Debug, Default)]
pub struct Stop {
    raised: Arc<AtomicBool>,
    /// Raised by [`Stop::cancel`], for those who share this flag alone.
    cancelled: Arc<AtomicBool>,
}

/// Work was given up because the process, or the group that the work belongs to, was asked to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("stopped before the end")]
pub struct Interrupted;

/// The system refused to handle a signal.
#[derive(Debug, thiserror::Error)]
#[error("cannot handle signals: {0}")]
pub struct SignalError(#[from] io::Error);

impl Stop {
    /// From now on SIGINT and SIGTERM raise the flag. A second one ends the process at once, for a person who does not
    /// want to wait, or should the work never look at the flag.
    ///
    /// # Errors
    /// When the system refuses to handle a signal.
    pub fn on_signals() -> Result<Self, SignalError> {
        let stop = Self::patient(&[])?;
        for signal in [SIGINT, SIGTERM] {
            // In this order: the first signal finds the flag still down, and only then raises it.
            flag::register_conditional_shutdown(signal, 1, Arc::clone(&stop.raised))?;
            flag::register(signal, Arc::clone(&stop.raised))?;
        }
        Ok(stop)
    }

    /// As [`Stop::on_signals`]; SIGHUP raises the flag as well: it comes when the terminal is closed, or when the process
    /// that started this one dies.
    ///
    /// # Errors
    /// When the system refuses to handle a signal.
    pub fn on_signals_and_hangup() -> Result<Self, SignalError> {
        let stop = Self::on_signals()?;
        flag::register(SIGHUP, Arc::clone(&stop.raised))?;
        Ok(stop)
    }

    /// SIGINT, SIGTERM and SIGHUP raise the flag, and no number of them ends the process at once: for a program that must
    /// put its terminal in order first.
    ///
    /// # Errors
    /// When the system refuses to handle a signal.
    pub fn on_signals_without_haste() -> Result<Self, SignalError> {
        Self::patient(&[SIGINT, SIGTERM, SIGHUP])
    }

    fn patient(signals: &[i32]) -> Result<Self, SignalError> {
        let stop = Self::default();
        for signal in signals {
            flag::register(*signal, Arc::clone(&stop.raised))?;
        }
        // A file that may not grow further (`ulimit -f`) shall be an error to report; the signal would end the process
        // without a word.
        flag::register(SIGXFSZ, Arc::default())?;
        Ok(stop)
    }

    /// Whether the process was asked to end.
    #[must_use]
    pub fn is_raised(&self) -> bool {
        self.raised.load(Ordering::Relaxed)
    }

    /// The flag itself, for code that looks at it while it works.
    #[must_use]
    pub fn flag(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.raised)
    }

    /// A flag that is raised together with this one, and that a group of threads can also raise for themselves alone, with
    /// [`Stop::cancel`].
    #[must_use]
    pub fn cancellable(&self) -> Self {
        Self { raised: Arc::clone(&self.raised), cancelled: Arc::default() }
    }

    /// Stops the group that shares this flag.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Nothing while the work may go on.
    ///
    /// # Errors
    /// [`Interrupted`] once the process was asked to end, or the group was cancelled.
    pub fn check(&self) -> Result<(), Interrupted> {
        if self.is_raised() || self.cancelled.load(Ordering::Relaxed) { Err(Interrupted) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_signal_raises_the_flag_and_every_clone_sees_it() {
        let stop = Stop::on_signals_and_hangup().expect("signals can be handled");
        let group = stop.cancellable();
        assert_eq!((stop.check(), group.check()), (Ok(()), Ok(())));
        signal_hook::low_level::raise(SIGHUP).expect("a signal can be raised");
        assert!(stop.is_raised() && group.is_raised() && stop.flag().load(Ordering::Relaxed));
        assert_eq!(group.check(), Err(Interrupted));
    }

    #[test]
    fn a_group_that_is_cancelled_stops_alone() {
        let stop = Stop::default();
        let (one, other) = (stop.cancellable(), stop.cancellable());
        one.cancel();
        assert_eq!((one.clone().check(), other.check(), stop.check()), (Err(Interrupted), Ok(()), Ok(())));
    }
}
