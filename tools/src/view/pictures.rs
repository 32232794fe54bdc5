//! Watches the pictures of the bodies, on a thread of its own, and only while a page asks for them.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use pschema_protocol::domain::Place;
use pschema_protocol::transport::pictures::PictureWatch;
use tokio::sync::watch;

use super::shot::{self, Shot};
use crate::failure::Failure;

/// The time without a request for a picture after which the bodies are told that nobody watches.
const WATCH_ON: Duration = Duration::from_secs(2);
/// The time for which one request waits for a picture.
const LOOK_FOR: Duration = Duration::from_secs(1);
/// The time from one look for a picture to the next; a body sends none sooner than 30 ms after the last.
const LOOK_EVERY: Duration = Duration::from_millis(3);
/// The pause after watching failed.
const TRY_AGAIN_AFTER: Duration = Duration::from_secs(1);

/// The thread that watches.
pub(super) struct PictureThread {
    pictures: Pictures,
    thread: JoinHandle<()>,
}

/// Asks for pictures.
#[derive(Clone, Debug)]
pub(super) struct Pictures {
    wanted: SyncSender<()>,
    newest: watch::Receiver<Option<Arc<Shot>>>,
}

/// Begins to watch, once somebody asks.
///
/// # Errors
/// When the system has no thread left.
pub(super) fn watch(place: Place) -> Result<PictureThread, Failure> {
    // All requests are for the same picture, so one may stand for several.
    let (wanted, requests) = sync_channel(1);
    let (to, newest) = watch::channel(None);
    let thread = std::thread::Builder::new().name("watches".to_owned());
    let thread = thread
        .spawn(move || Watcher { place, to, watch: None, failed: None, said: false }.run(&requests))
        .map_err(|error| Failure::Failed(format!("cannot start a thread: {error}")))?;
    Ok(PictureThread { pictures: Pictures { wanted, newest }, thread })
}

impl PictureThread {
    /// A handle to ask for pictures.
    pub(super) fn pictures(&self) -> Pictures {
        self.pictures.clone()
    }

    /// Ends the thread, which gives back its place in shared memory.
    pub(super) fn end(self) {
        let Self { pictures, thread } = self;
        drop(pictures);
        if thread.join().is_err() {
            tracing::debug!("the thread that watches pictures ended with a panic");
        }
    }
}

impl Pictures {
    /// The newest picture that is not the one of number `after`, if one comes soon.
    pub(super) async fn after(&self, after: u64) -> Option<Arc<Shot>> {
        if self.wanted.try_send(()).is_err() {
            tracing::trace!("a request for a picture is under way already");
        }
        let mut newest = self.newest.clone();
        let other = |shot: &Option<Arc<Shot>>| shot.as_ref().is_some_and(|shot| shot.number != after);
        let found = tokio::time::timeout(LOOK_FOR, newest.wait_for(other)).await;
        found.ok()?.ok().and_then(|shot| shot.clone())
    }

    /// The last picture there was.
    pub(super) fn last(&self) -> Option<Arc<Shot>> {
        self.newest.borrow().clone()
    }
}

struct Watcher {
    place: Place,
    to: watch::Sender<Option<Arc<Shot>>>,
    watch: Option<PictureWatch>,
    failed: Option<Instant>,
    /// Whether it was said why nothing is watched.
    said: bool,
}

impl Watcher {
    fn run(mut self, requests: &Receiver<()>) {
        loop {
            let request = if self.watch.is_some() {
                requests.recv_timeout(WATCH_ON)
            } else {
                requests.recv().map_err(|_| RecvTimeoutError::Disconnected)
            };
            match request {
                Ok(()) => self.look(),
                Err(RecvTimeoutError::Timeout) => {
                    self.watch = None;
                    // A visitor who comes back in an hour is not shown a picture from an hour ago.
                    self.to.send_replace(None);
                }
                Err(RecvTimeoutError::Disconnected) => return,
            }
        }
    }

    /// Looks for a picture for a while.
    fn look(&mut self) {
        let begun = Instant::now();
        while begun.elapsed() < LOOK_FOR {
            if !self.is_watching() || self.take() {
                return;
            }
            std::thread::sleep(LOOK_EVERY);
        }
        // Another daemon may serve the learner by now.
        self.watch.take_if(|watch| !watch.is_current());
    }

    fn is_watching(&mut self) -> bool {
        if self.watch.is_none() && self.failed.is_none_or(|at| at.elapsed() >= TRY_AGAIN_AFTER) {
            match PictureWatch::open(&self.place) {
                Ok(watch) => {
                    self.watch = Some(watch);
                    (self.failed, self.said) = (None, false);
                }
                Err(error) => {
                    self.failed = Some(Instant::now());
                    if !std::mem::replace(&mut self.said, true) {
                        tracing::info!(%error, "no pictures are watched");
                    }
                }
            }
        }
        self.watch.is_some()
    }

    /// Takes the newest picture, if there is one.
    fn take(&mut self) -> bool {
        let Some(watch) = &self.watch else { return false };
        let seen = match watch.newest() {
            Ok(Some(seen)) => seen,
            Ok(None) => return false,
            Err(error) => {
                tracing::warn!(%error, "a picture could not be had");
                return false;
            }
        };
        let png = match shot::png(&seen) {
            Ok(png) => png,
            Err(error) => {
                tracing::warn!(%error, "a picture could not be written as PNG");
                return false;
            }
        };
        self.to.send_modify(|newest| {
            let (number, version, known) = newest
                .as_ref()
                .map_or((0, 0, None), |shot| (shot.number, shot.fields_version, Some(&shot.fields)));
            let fields_version = if known == Some(&seen.fields) { version } else { version + 1 };
            *newest = Some(Arc::new(Shot { number: number + 1, fields_version, png, fields: seen.fields }));
        });
        true
    }
}
