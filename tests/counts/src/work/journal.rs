//! The effects of a step on their way to the disk: encoded and handed over on the daemon's thread, then framed, chained and
//! appended to the journal on the writer's. Making them durable is the disk's work and is not counted.

use std::path::Path;
use std::thread;
use std::time::Duration;

use pschema_store::{Cause, Change, Opened};
use pschema_worlds::Mix;
use tempfile::TempDir;

use super::step::{open, resume};
use crate::counted::{Tally, counted};
use crate::failure::CountFailure;

/// The world whose steps are journalled, and how much is known there.
pub(super) const MIX: Mix = Mix::Scenario1;
pub(super) const SCHEMAS: usize = 1_000;
/// Steps whose effects are counted. Fewer than the steps after which a digest is due, so that no digest is made meanwhile.
const ROUNDS: usize = 500;
/// The function that appends on the writer's thread. It is compiled as a function of its own for this.
pub(super) const ON_THE_WRITERS_THREAD: &str = "journal::Journal::append";
/// How long the writer may be waited for at a time before it is asked again.
const PATIENCE: Duration = Duration::from_millis(20);

pub(super) fn carry_out(lives: &Path) -> Result<Tally, CountFailure> {
    let (mut world, _kept) = resume(MIX, SCHEMAS, lives)?;
    // What is appended goes elsewhere: the life is to be found again as it was kept.
    let elsewhere = TempDir::new_in(lives).map_err(CountFailure::Directory)?;
    let Opened { mut store, .. } = open(MIX, elsewhere.path())?;
    let mut tally = Tally::default();
    let mut handed = 0;
    for _ in 0..ROUNDS {
        let frame = world.frame();
        let step = world.learner_mut().step(&frame);
        let change = Change { cause: Cause::Step(&frame), at_unix_ms: 0, effects: &step.effects };
        let content = world.learner().memory().content();
        handed =
            counted(&mut tally, || store.append(&change, content)).map_err(CountFailure::of("journal"))?;
        tally.result += step.effects.len() as u64;
        world.follow(&step.output);
    }
    while !store.is_durable(handed) {
        if let Some(failure) = store.failure() {
            return Err(CountFailure::of("journal")(failure));
        }
        thread::park_timeout(PATIENCE);
    }
    Ok(tally)
}
