//! Waking the daemon's loop from its other threads, whatever the epoch.

use std::sync::{Arc, Mutex, PoisonError};

use pschema_protocol::transport::DaemonWaker;

/// The waker of the epoch that is served now; it wakes nobody before the first.
#[derive(Clone, Debug, Default)]
pub(crate) struct Waker(Arc<Mutex<Option<DaemonWaker>>>);

impl Waker {
    /// Wakes the loop.
    pub(crate) fn wake(&self) {
        if let Some(waker) = &*self.0.lock().unwrap_or_else(PoisonError::into_inner) {
            waker.wake();
        }
    }

    /// Puts the waker of a new epoch in place of that of an epoch that has ended, if there was one.
    pub(crate) fn renew(&self, waker: DaemonWaker) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(waker);
    }
}
