//! Ctrl-C and SIGTERM, as a flag to look at.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::flag;

use crate::failure::Failure;

/// Whether this process was asked to stop.
#[derive(Clone, Debug)]
pub(crate) struct Stop {
    raised: Arc<AtomicBool>,
    /// Whether those who share this were told to stop by one of their own.
    cancelled: Arc<AtomicBool>,
}

impl Stop {
    /// From now on, SIGINT, SIGTERM and SIGHUP raise the flag. A second SIGINT or SIGTERM ends the process at
    /// once: for someone who does not want to wait.
    pub(crate) fn on_signals() -> Result<Self, Failure> {
        let raised = Arc::new(AtomicBool::new(false));
        let register = || -> io::Result<()> {
            flag::register(SIGHUP, Arc::clone(&raised))?;
            for signal in [SIGINT, SIGTERM] {
                // In this order: the first signal finds the flag still down and only then raises it.
                flag::register_conditional_shutdown(signal, 1, Arc::clone(&raised))?;
                flag::register(signal, Arc::clone(&raised))?;
            }
            Ok(())
        };
        register().map_err(|error| Failure::Failed(format!("cannot listen to signals: {error}")))?;
        Ok(Self { raised, cancelled: Arc::default() })
    }

    /// One that no signal raises.
    #[cfg(test)]
    pub(crate) fn never() -> Self {
        Self { raised: Arc::default(), cancelled: Arc::default() }
    }

    /// Whether it was.
    pub(crate) fn raised(&self) -> bool {
        self.raised.load(Ordering::Relaxed)
    }

    /// The flag itself, for code that looks at it while it works.
    pub(crate) fn flag(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.raised)
    }

    /// The same, which can also be raised by those who share it alone.
    pub(crate) fn cancellable(&self) -> Self {
        Self { raised: Arc::clone(&self.raised), cancelled: Arc::default() }
    }

    /// Stops those who share this.
    pub(crate) fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// An interruption, if it was.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        if self.raised() || self.cancelled.load(Ordering::Relaxed) {
            Err(Failure::Interrupted)
        } else {
            Ok(())
        }
    }
}
