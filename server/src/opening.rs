//! Opening a data directory: how a daemon goes on with the memory that is kept there.

use pschema_learner::LearnerError;
use pschema_store::{Opened, Options, Store};

use crate::error::ServerError;
use crate::keeper::{Keeping, now_unix_ms};
use crate::mind::Mind;
use crate::setup::Setup;
use crate::waker::Waker;

/// The mind whose memory is in the data directory of `keeping`, or a new one with `setup` if nothing is there; and the
/// store that goes on with it. `waker` is called when something has become durable.
///
/// # Errors
/// When memory can't be found again, or lives under another setup than is asked for.
pub(crate) fn open(
    name: &str,
    setup: Setup,
    keeping: &Keeping,
    waker: Waker,
) -> Result<(Mind, Store), ServerError> {
    let Setup { seed, parameters, curriculum } = setup;
    parameters.check().map_err(LearnerError::from)?;
    curriculum.check().map_err(LearnerError::from)?;
    let options = Options {
        learner: name,
        seed,
        parameters: &parameters,
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
            "it goes on under other parameters or another curriculum from here, as asked"
        );
    }
    Ok((Mind::resume(learner, seed), store))
}
