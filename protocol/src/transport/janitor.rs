//! Cleaning up after processes that died, on a thread of its own: it costs up to milliseconds, which no
//! frame shall wait for.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use super::{TransportError, services};
use crate::domain::{DomainRecord, Place};

/// How often the dead are looked for.
const TICK: Duration = Duration::from_millis(100);

/// The janitor's thread; it ends when this is dropped.
#[derive(Debug)]
pub(super) struct Janitor {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Janitor {
    pub(super) fn start(place: &Place, record: &DomainRecord) -> Result<Self, TransportError> {
        let stop = Arc::new(AtomicBool::new(false));
        let (place, record, told) = (place.clone(), record.clone(), stop.clone());
        let thread =
            thread::Builder::new().name("janitor".to_owned()).spawn(move || run(&place, &record, &told));
        let thread = thread.map_err(super::setup("start the janitor's thread"))?;
        Ok(Self { stop, thread: Some(thread) })
    }
}

impl Drop for Janitor {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            if thread.join().is_err() {
                tracing::error!("the janitor's thread panicked; the dead were not cleaned up since");
            }
        }
    }
}

fn run(place: &Place, record: &DomainRecord, stop: &AtomicBool) {
    let node = match services::node::<services::Ipc>(place, record, "janitor") {
        Ok(node) => node,
        Err(error) => {
            tracing::error!(%error, "no janitor: processes that die keep their places until a restart");
            return;
        }
    };
    while !stop.load(Ordering::Acquire) {
        let found = node.try_cleanup_dead_nodes();
        if found.cleanups > 0 {
            tracing::debug!(dead = found.cleanups, "cleaned up after dead processes");
        }
        thread::park_timeout(TICK);
    }
}
