//! The past of a memory, read off its data directory: with a daemon on it or without, and without changing anything.
//!
//! [`Past::open`] reads the manifest alone. Everything else is found by going through the journal again from a snapshot
//! or from the beginning, by the very code that a daemon's start goes through.

mod cut;
mod entry;
pub mod export;
mod making;
mod relearn;
mod repair;
mod scan;
mod verify;

use std::io::Write;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use pschema_learner::decision::Decision;
use pschema_learner::observation::Observation;
use pschema_learner::vocabulary::BodyId;
use pschema_learner::{Frame, Learner};

use crate::codec;
use crate::error::StoreError;
use crate::format::v1::{Cause, Input, Record};
use crate::journal::{self, JournalError, Place, Shown};
use crate::manifest::{self, Manifest};
use crate::recovery::{Replay, unplayable};
use crate::snapshot;
use crate::storage::{Directory, Storage};

pub use entry::{Batch, Caused, Counted, Told};
pub use making::{Made, import};
pub use repair::{Repair, Repaired};
pub use scan::{Files, Segment, Snapshot, Tail};
pub use verify::{Checked, Finding, Progress};

/// How often something is read again that a daemon changed meanwhile.
const READ_AGAIN_MAX: u32 = 16;

/// Why a past can't be told.
#[derive(Debug, thiserror::Error)]
pub enum PastError {
    /// The directory can't be read, or is damaged.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// There is no memory in it.
    #[error(
        "there is no memory in {path}: no manifest and no journal. Give a directory that was given to `pschema server --data`"
    )]
    Nothing {
        /// The directory.
        path: String,
    },
    /// The step is still to come.
    #[error("step {asked} has not been taken yet: the last step on disk in {path} is {last}")]
    Beyond {
        /// The directory.
        path: String,
        /// The step asked for.
        asked: u64,
        /// The last there is.
        last: u64,
    },
    /// The step is no longer kept.
    #[error(
        "step {asked} is no longer kept: {path} goes back to step {first}. `--history` of the daemon says how much is kept"
    )]
    Before {
        /// The directory.
        path: String,
        /// The step asked for.
        asked: u64,
        /// The first there is.
        first: u64,
    },
    /// The step decided nothing.
    #[error("step {step} decided nothing: {why}")]
    Undecided {
        /// The step.
        step: u64,
        /// Why not.
        why: String,
    },
    /// The step can't be taken again.
    #[error(
        "step {step} can't be explained: {why}. It was taken by a release that learns otherwise, or is damaged"
    )]
    Unlike {
        /// The step.
        step: u64,
        /// What came out differently.
        why: String,
    },
    /// Nothing can be saved.
    #[error(
        "nothing in {path} can be saved: no snapshot in it is sound, and the journal does not reach back to its beginning. \
         Put it back from a copy"
    )]
    Lost {
        /// The directory.
        path: String,
    },
    /// There is something in a directory that is to be made.
    #[error("{path} is not empty: name a directory that is not there yet")]
    Taken {
        /// The directory.
        path: String,
    },
    /// Nothing was decided at all.
    #[error("nothing was decided up to step {last}, as far as {path} goes back")]
    NeverDecided {
        /// The directory.
        path: String,
        /// The last step looked at.
        last: u64,
    },
}

impl From<JournalError> for PastError {
    fn from(error: JournalError) -> Self {
        Self::Store(error.into())
    }
}

/// A memory's data directory, to be read.
#[derive(Debug)]
pub struct Past {
    storage: Arc<dyn Storage>,
    directory: PathBuf,
    manifest: Manifest,
}

/// Memory as it was at one moment.
#[derive(Debug)]
pub struct Moment {
    /// What was known, under the parameters and the curriculum of that time.
    pub learner: Learner,
    /// Where it was in the journal: the last frame that is part of it.
    pub frame: u64,
    /// The step of the snapshot that it was rebuilt from; none when it was rebuilt from its beginning.
    pub snapshot_step: Option<u64>,
    /// Frames of the journal that were gone through.
    pub frames: u64,
    /// When the last of it happened, by the machine's clock, in milliseconds since 1970; none when the snapshot is all
    /// of it.
    pub at_unix_ms: Option<u64>,
    /// The body that was perceiving last, and what it perceived.
    pub perceived: Option<(BodyId, Vec<Observation>)>,
    /// The last decision, if it was asked for.
    pub decision: Option<Decision>,
}

/// What a journal said last that is not in memory.
#[derive(Debug, Default)]
struct Seen {
    at_unix_ms: Option<u64>,
    input: Option<Input>,
}

/// Memory rebuilt, and the batch that comes next.
struct Rebuilt {
    replay: Replay,
    last: Place,
    frames: u64,
    snapshot_step: Option<u64>,
    seen: Seen,
    next: Option<Record>,
}

impl Past {
    /// The memory in `directory`. Reads its manifest and changes nothing.
    ///
    /// # Errors
    /// When there is none, or its manifest can't be read.
    pub fn open(directory: &Path) -> Result<Self, PastError> {
        let shown = directory.display().to_string();
        let directory = directory.canonicalize().map_err(StoreError::disk("read", shown.clone()))?;
        Self::of(Arc::new(Directory::new(&directory)), directory)
    }

    fn of(storage: Arc<dyn Storage>, directory: PathBuf) -> Result<Self, PastError> {
        match manifest::read(&*storage)? {
            Some(manifest) => Ok(Self { storage, directory, manifest }),
            None => Err(PastError::Nothing { path: directory.display().to_string() }),
        }
    }

    /// Where it is.
    #[must_use]
    pub fn directory(&self) -> &Path {
        &self.directory
    }

    /// The learner's name when it was begun.
    #[must_use]
    pub fn learner(&self) -> &str {
        &self.manifest.learner
    }

    /// Where its randomness began.
    #[must_use]
    pub fn seed(&self) -> u64 {
        self.manifest.seed
    }

    fn path(&self) -> String {
        self.directory.display().to_string()
    }

    /// Memory as it was after step `until`, and after what orders and bodies changed before the next one; as it is on
    /// disk when no step is named.
    ///
    /// # Errors
    /// When the step is not kept any more or not taken yet, or something that is needed is damaged.
    pub fn moment(&self, until: Option<u64>) -> Result<Moment, PastError> {
        beside(|| self.told(self.rebuild(until)?, None))
    }

    /// As [`Past::moment`], with the last decision: it is made again, by the learner, from what was perceived.
    ///
    /// # Errors
    /// As [`Past::moment`].
    pub fn moment_with_decision(&self, until: Option<u64>) -> Result<Moment, PastError> {
        let mut moment = self.moment(until)?;
        let last = moment.step();
        moment.decision = match beside(|| self.last_decided(last))? {
            Some(step) => self.decided(step)?.decision,
            None => None,
        };
        Ok(moment)
    }

    /// Memory after step `step`, or after the last step up to `until` that decided something, with that decision.
    ///
    /// # Errors
    /// As [`Past::moment`]; and when nothing was decided.
    pub fn decision(&self, step: Option<u64>, until: Option<u64>) -> Result<Moment, PastError> {
        if let Some(step) = step {
            return self.decided(step);
        }
        let last = until.unwrap_or(u64::MAX);
        match beside(|| self.last_decided(last))? {
            Some(step) => self.decided(step),
            None => Err(PastError::NeverDecided { path: self.path(), last: self.rebuild(until)?.step() }),
        }
    }

    fn decided(&self, step: u64) -> Result<Moment, PastError> {
        beside(|| self.decided_once(step))
    }

    fn decided_once(&self, step: u64) -> Result<Moment, PastError> {
        let Some(before) = step.checked_sub(1) else {
            let why = "steps are counted from 1".to_owned();
            return Err(PastError::Undecided { step, why });
        };
        let mut rebuilt = self.rebuild(Some(before))?;
        let Some(Record::Batch { step: next, at_unix_ms, cause: Cause::Step(input), effects }) =
            rebuilt.next.take()
        else {
            return Err(PastError::Beyond { path: self.path(), asked: step, last: rebuilt.step() });
        };
        let why = |why: &str| PastError::Undecided { step, why: why.to_owned() };
        if next != step {
            return Err(why("the journal has another step there"));
        }
        let again = relearn::again(rebuilt.replay, input.clone(), &effects);
        let again = again.map_err(|why| PastError::Unlike { step, why })?;
        let decision = again.decision.ok_or_else(|| {
            why("the surroundings were arranged, or nothing was wanted of the body; `pschema journal` has the step")
        })?;
        rebuilt.replay = again.replay;
        rebuilt.frames += 1;
        rebuilt.last.number += 1;
        rebuilt.seen = Seen { at_unix_ms: Some(at_unix_ms), input: Some(input) };
        self.told(rebuilt, Some(decision))
    }

    fn told(&self, rebuilt: Rebuilt, decision: Option<Decision>) -> Result<Moment, PastError> {
        let step = rebuilt.step();
        let Rebuilt { replay, last, frames, snapshot_step, seen, .. } = rebuilt;
        let Replay { memory, setting, .. } = replay;
        let (_, curriculum) = setting.live().map_err(StoreError::from)?;
        let (at_unix_ms, input) = match seen {
            // What a snapshot does not say, the journal before it may still do.
            Seen { input: None, at_unix_ms } => {
                let before = self.last_input(step)?;
                (at_unix_ms.or(before.at_unix_ms), before.input)
            }
            Seen { at_unix_ms, input } => (at_unix_ms, input),
        };
        let perceived = input.map(Frame::from);
        let learner = Learner::resume(memory, curriculum).map_err(StoreError::from)?;
        let known = learner.memory().content().pending.len();
        let perceived = perceived.filter(|frame| usize::from(frame.body.0) < known);
        Ok(Moment {
            learner,
            frame: last.number,
            snapshot_step,
            frames,
            at_unix_ms,
            perceived: perceived.map(|frame| (frame.body, frame.observations)),
            decision,
        })
    }

    /// Goes through the journal up to and with step `until`, and what came before the next step.
    fn rebuild(&self, until: Option<u64>) -> Result<Rebuilt, PastError> {
        let (replay, from, snapshot_step) = self.base(until)?;
        let mut rebuilt =
            Rebuilt { replay, last: from, frames: 0, snapshot_step, seen: Seen::default(), next: None };
        journal::read::<PastError>(&*self.storage, from, |shown| {
            let record = self.record(&shown)?;
            if let Record::Batch { step, at_unix_ms, cause, .. } = &record {
                if until.is_some_and(|until| *step > until) {
                    rebuilt.next = Some(record);
                    return Ok(ControlFlow::Break(()));
                }
                rebuilt.seen.at_unix_ms = Some(*at_unix_ms);
                if let Cause::Step(input) = cause {
                    rebuilt.seen.input = Some(input.clone());
                }
            }
            rebuilt
                .replay
                .apply(record, shown.place.number)
                .map_err(|problem| unplayable(&*self.storage, &shown, problem))?;
            rebuilt.frames += 1;
            rebuilt.last = shown.place;
            Ok(ControlFlow::Continue(()))
        })?;
        match until.filter(|until| rebuilt.step() < *until) {
            None => Ok(rebuilt),
            Some(asked) => Err(PastError::Beyond { path: self.path(), asked, last: rebuilt.step() }),
        }
    }

    /// The newest sound snapshot not after step `until`, or the beginning.
    fn base(&self, until: Option<u64>) -> Result<(Replay, Place, Option<u64>), PastError> {
        if let Some((whole, place)) = snapshot::newest(&*self.storage, until)? {
            let step = whole.content.step;
            return Ok((Replay::from_snapshot(whole)?, place, Some(step)));
        }
        let firsts = self.segments()?;
        if firsts.first().is_some_and(|first| *first > 1) {
            let first = self.first_step()?;
            if let (Some(asked), Some(first)) = (until, first) {
                return Err(PastError::Before { path: self.path(), asked, first });
            }
        }
        Ok((Replay::birth(&self.manifest)?, Place::default(), None))
    }

    fn record(&self, shown: &Shown<'_>) -> Result<Record, StoreError> {
        codec::decode(shown.payload).map_err(|error| unplayable(&*self.storage, shown, error.to_string()))
    }

    /// Writes memory as it was at a moment as JSON Lines; `told` hears how many lines are done.
    ///
    /// # Errors
    /// When it can't be written.
    pub fn export(
        &self,
        moment: &Moment,
        to: &mut dyn Write,
        told: impl FnMut(u64),
    ) -> Result<export::Lines, export::ExportError> {
        let (memory, curriculum) = (moment.learner.memory(), moment.learner.curriculum());
        let (learner, seed) = (self.learner(), self.seed());
        let about = export::About { learner, seed, parameters: memory.parameters(), curriculum };
        export::write(memory.content(), about, to, told)
    }
}

impl Moment {
    /// Steps taken.
    #[must_use]
    pub fn step(&self) -> u64 {
        self.learner.memory().content().step
    }

    /// The digest of memory.
    #[must_use]
    pub fn memory_digest(&self) -> String {
        pschema_learner::digest::digest(self.learner.memory().content())
    }
}

impl Rebuilt {
    fn step(&self) -> u64 {
        self.replay.memory.content().step
    }
}

/// Reads something a few times over, should a daemon remove meanwhile what it keeps no longer.
fn beside<T>(mut read: impl FnMut() -> Result<T, PastError>) -> Result<T, PastError> {
    for _ in 0..READ_AGAIN_MAX {
        match read() {
            Err(PastError::Store(error)) if is_gone(&error) => (),
            done => return done,
        }
    }
    read()
}

/// Whether a file that was there is there no more, or the journal begins later than it did.
fn is_gone(error: &StoreError) -> bool {
    let error = match error {
        StoreError::Journal(JournalError::Missing { .. }) => return true,
        StoreError::Journal(JournalError::Read { error, .. }) | StoreError::Disk { error, .. } => error,
        _ => return false,
    };
    error.kind() == std::io::ErrorKind::NotFound
}

/// What is damaged, without the advice that a daemon gives that can't start.
fn damage(error: &StoreError) -> String {
    match error {
        StoreError::Journal(JournalError::Damaged { file, offset, lost, claimed }) => format!(
            "{file}, byte {offset}: frame {lost} and what follows it can't be read, though frames up to {claimed} were on \
             disk and acted on"
        ),
        error => error.to_string(),
    }
}

/// What a sound checksum stands before may still be forged; it must not end the process.
fn guarded<T>(work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    let done = catch_unwind(AssertUnwindSafe(work));
    done.unwrap_or_else(|_| Err("what is on disk can't be taken in by a learner".to_owned()))
}

#[cfg(test)]
mod tests;
