//! Waking the daemon's loop from its other threads, whatever the epoch.

use std::sync::{Arc, Mutex, PoisonError};

use pschema_protocol::transport::DaemonWaker;

/// The waker of the epoch that is served now.
#[derive(Clone, Debug)]
pub(crate) struct Waker(Arc<Mutex<DaemonWaker>>);

impl Waker {
    pub(crate) fn new(waker: DaemonWaker) -> Self {
        Self(Arc::new(Mutex::new(waker)))
    }

    /// Wakes the loop.
    pub(crate) fn wake(&self) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).wake();
    }

    /// Puts the waker of a new epoch in place of that of an epoch that has ended.
    pub(crate) fn renew(&self, waker: DaemonWaker) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = waker;
    }
}
