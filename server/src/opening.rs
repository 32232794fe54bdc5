//! Opening a data directory: how a daemon goes on with the memory that is kept there.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::thread;
use std::time::Duration;

use pschema_learner::LearnerError;
use pschema_store::{Opened, Options, Store};

use crate::error::ServerError;
use crate::keeper::{Keeping, now_unix_ms};
use crate::mind::Mind;
use crate::setup::{LearnerSettings, Setup};
use crate::waker::Waker;

/// How often it is looked, while memory is being found, whether the daemon is to end.
const LOOK_EVERY: Duration = Duration::from_millis(100);

/// As [`open`], for a daemon that may be asked to end meanwhile: none if `stop` was raised before memory was found. A slow disk or a
/// long journal takes as long as it takes, so it has a thread of its own, which is then left to itself and ends with the process. That
/// loses no more than a killed daemon does: nothing.
///
/// # Errors
/// As [`open`]; and when no thread can be started.
pub(crate) fn open_unless_stopped(
    name: &Arc<str>,
    setup: Setup,
    keeping: &Keeping,
    waker: Waker,
    stop: &AtomicBool,
) -> Result<Option<(Mind, Store)>, ServerError> {
    let (found, opened) = sync_channel(1);
    let (name, keeping) = (Arc::clone(name), keeping.clone());
    let directory = keeping.directory.clone();
    let work = move || drop(found.send(open(&name, setup, &keeping, waker)));
    let thread =
        thread::Builder::new().name("opening".to_owned()).spawn(work).map_err(ServerError::Thread)?;
    loop {
        match opened.recv_timeout(LOOK_EVERY) {
            Ok(opened) => return opened.map(Some),
            Err(RecvTimeoutError::Timeout) if stop.load(Ordering::Relaxed) => {
                tracing::warn!(
                    directory = %directory.display(),
                    "ended before memory was found, as it was asked to: what is on disk stays as it is"
                );
                return Ok(None);
            }
            Err(RecvTimeoutError::Timeout) => {}
            // Nothing was sent, so the thread has panicked.
            Err(RecvTimeoutError::Disconnected) => match thread.join() {
                Err(panicked) => std::panic::resume_unwind(panicked),
                Ok(()) => return Ok(None),
            },
        }
    }
}

/// The mind whose memory is in the data directory of `keeping`, or a new one with `setup` if nothing is there; and the
/// store that goes on with it. `waker` is called when something has become durable.
///
/// # Errors
/// When memory can't be found again, or lives under another setup than is asked for.
fn open(name: &str, setup: Setup, keeping: &Keeping, waker: Waker) -> Result<(Mind, Store), ServerError> {
    let Setup { seed, learner: LearnerSettings { parameters, mechanisms, .. }, curriculum } = setup;
    parameters.check().map_err(LearnerError::from)?;
    curriculum.check().map_err(LearnerError::from)?;
    let options = Options {
        learner: name,
        seed,
        parameters: &parameters,
        mechanisms,
        curriculum: &curriculum,
        seed_given: keeping.seed_given,
        setting_given: keeping.setting_given,
        change: keeping.change,
        at_unix_ms: now_unix_ms(),
        durability: keeping.durability,
        retention: keeping.retention,
    };
    let wake = move || waker.wake();
    let Opened { learner, seed, begun, changed, store } =
        pschema_store::open(&keeping.directory, options, wake)?;
    let recovered = store.recovered();
    if begun {
        tracing::info!(
            directory = %store.directory().display(), seed, curriculum = learner.curriculum().name, "memory begun"
        );
        return Ok((Mind::resume(learner, seed), store));
    }
    tracing::info!(
        step = recovered.step,
        snapshot = recovered.snapshot_step,
        frames = recovered.frames,
        schemas = learner.memory().content().schemas.len(),
        seed,
        curriculum = learner.curriculum().name,
        "memory found"
    );
    if changed {
        tracing::warn!(
            curriculum = learner.curriculum().name,
            "it goes on under other parameters, another profile or another curriculum from here, as asked"
        );
    }
    Ok((Mind::resume(learner, seed), store))
}
