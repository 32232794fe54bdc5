//! Memory as it was at one moment, rebuilt from its data directory.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use pschema_learner::decision::Decision;
use pschema_learner::observation::Observation;
use pschema_learner::vocabulary::BodyId;
use pschema_learner::{Frame, Learner};
use pschema_process::no_directory;

use super::error::{PastError, beside};
use super::{export, relearn};
use crate::codec;
use crate::error::StoreError;
use crate::extent::Extent;
use crate::format::mirror::Mirror;
use crate::format::v1::{Cause, Record};
use crate::journal::JournalFrame;
use crate::manifest::{self, Manifest};
use crate::recovery::{self, LastFrame, Recovery, Replay, unplayable};
use crate::storage::{Directory, Storage};

/// A memory's data directory, to be read.
#[derive(Debug)]
pub struct Past {
    pub(super) storage: Arc<dyn Storage>,
    pub(super) directory: PathBuf,
    pub(super) manifest: Manifest,
}

/// Memory as it was at one moment.
#[derive(Debug)]
pub struct Moment {
    /// The learner with the memory, the parameters and the curriculum of that moment.
    pub learner: Learner,
    /// The last frame of the journal that is part of this memory.
    pub frame: u64,
    /// The step of the snapshot that the memory was rebuilt from; none when it was rebuilt from its beginning.
    pub snapshot_step: Option<u64>,
    /// How many frames of the journal were replayed.
    pub frames: u64,
    /// The time of the last change by the machine's clock, in milliseconds since 1970; none when the journal does not tell it.
    pub at_unix_ms: Option<u64>,
    /// The body that sent the last frame, and the observations in it.
    pub perceived: Option<(BodyId, Vec<Observation>)>,
    /// The last decision, if it was asked for.
    pub decision: Option<Decision>,
}

impl Past {
    /// The memory in `directory`. Reads its manifest and changes nothing.
    ///
    /// # Errors
    /// When there is no memory, or its manifest can't be read.
    pub fn open(directory: &Path) -> Result<Self, PastError> {
        let shown = directory.display().to_string();
        let found = directory.canonicalize().and_then(|found| {
            if found.is_dir() { Ok(found) } else { Err(io::ErrorKind::NotADirectory.into()) }
        });
        let found = found.map_err(|error| no_directory(directory, error));
        let directory = found.map_err(StoreError::disk("read", shown))?;
        Self::of(Arc::new(Directory::new(&directory)), directory)
    }

    pub(super) fn of(storage: Arc<dyn Storage>, directory: PathBuf) -> Result<Self, PastError> {
        match manifest::read(&*storage)? {
            Some(manifest) => Ok(Self { storage, directory, manifest }),
            None => Err(PastError::Nothing { path: directory.display().to_string() }),
        }
    }

    /// The data directory.
    #[must_use]
    pub fn directory(&self) -> &Path {
        &self.directory
    }

    /// The name of the learner when the memory was begun.
    #[must_use]
    pub fn learner(&self) -> &str {
        &self.manifest.learner
    }

    /// The seed that the memory was begun with.
    #[must_use]
    pub fn seed(&self) -> u64 {
        self.manifest.seed
    }

    pub(super) fn path(&self) -> String {
        self.directory.display().to_string()
    }

    /// Memory as it was after step `until` and the orders and attachments before the next step; memory as it is on disk if no
    /// step is given.
    ///
    /// # Errors
    /// When the step is no longer kept or not yet taken, or a file that is needed is damaged.
    pub fn moment(&self, until: Option<u64>) -> Result<Moment, PastError> {
        beside(|| self.finish(self.rebuild(until)?, None))
    }

    /// As [`Past::moment`], with the last decision, which the learner makes again from the frame in the journal.
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

    /// Memory after step `step`, or after the last step up to `until` that decided something, and the decision of that step.
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
            None => Err(PastError::NeverDecided { path: self.path(), last: self.rebuild(until)?.found.step }),
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
        // Memory as it was before the step is looked for; the step itself is what was asked about.
        let mut rebuilt = self.rebuild(Some(before)).map_err(|error| match error {
            PastError::Beyond { path, last, .. } => PastError::Beyond { path, asked: step, last },
            PastError::Before { path, first, .. } => {
                PastError::Before { path, asked: step, first: first + 1 }
            }
            error => error,
        })?;
        let Some(Record::Batch { step: next, at_unix_ms, cause: Cause::Step(input), effects }) =
            rebuilt.next.take()
        else {
            return Err(PastError::Beyond { path: self.path(), asked: step, last: rebuilt.found.step });
        };
        let why = |why: &str| PastError::Undecided { step, why: why.to_owned() };
        if next != step {
            return Err(why("the journal has another step there"));
        }
        let unlike = |why| PastError::Unlike { step, why };
        let mut learner = relearn::lend(&mut rebuilt.replay).map_err(unlike)?;
        let decision = relearn::step(&mut learner, input.clone(), &effects).map_err(unlike)?;
        let decision = decision.ok_or_else(|| {
            why("the surroundings were arranged, or nothing was wanted of the body; `pschema journal` has the step")
        })?;
        rebuilt.replay.memory = learner.into_memory();
        rebuilt.replay.seen = LastFrame { at_unix_ms: Some(at_unix_ms), input: Some(input) };
        rebuilt.found.frames += 1;
        rebuilt.end.last.number += 1;
        self.finish(rebuilt, Some(decision))
    }

    /// The moment that a rebuilt memory is.
    fn finish(&self, rebuilt: Recovery, decision: Option<Decision>) -> Result<Moment, PastError> {
        let Recovery { replay, end, found, .. } = rebuilt;
        let Replay { memory, setting, seen, .. } = replay;
        let (_, curriculum) = setting.checked().map_err(StoreError::from)?;
        let (at_unix_ms, input) = match seen {
            // The journal before a snapshot may have the frame that the snapshot does not have.
            LastFrame { input: None, at_unix_ms } => {
                let before = self.last_input(memory.content().step)?;
                (at_unix_ms.or(before.at_unix_ms), before.input)
            }
            LastFrame { at_unix_ms, input } => (at_unix_ms, input),
        };
        let learner = Learner::resume(memory, curriculum).map_err(StoreError::from)?;
        let extent = Extent::of(learner.memory().content());
        let perceived: Option<Frame> = input.map(Mirror::live).filter(|frame| extent.frame(frame).is_ok());
        Ok(Moment {
            learner,
            frame: end.last.number,
            snapshot_step: found.snapshot_step,
            frames: found.frames,
            at_unix_ms,
            perceived: perceived.map(|frame| (frame.body, frame.observations)),
            decision,
        })
    }

    /// Memory after step `until` and the orders and attachments before the next step.
    fn rebuild(&self, until: Option<u64>) -> Result<Recovery, PastError> {
        let base = recovery::base(&*self.storage, &self.manifest, until)?;
        if base.snapshot_step.is_none()
            && self.segments()?.first().is_some_and(|first| *first > 1)
            && let (Some(asked), Some(first)) = (until, self.first_step()?)
        {
            return Err(PastError::Before { path: self.path(), asked, first });
        }
        let rebuilt = recovery::recover(&*self.storage, base, until)?;
        match until.filter(|until| rebuilt.found.step < *until) {
            None => Ok(rebuilt),
            Some(asked) => Err(PastError::Beyond { path: self.path(), asked, last: rebuilt.found.step }),
        }
    }

    pub(super) fn record(&self, shown: &JournalFrame<'_>) -> Result<Record, StoreError> {
        codec::decode(shown.payload).map_err(|error| unplayable(&*self.storage, shown, error.to_string()))
    }

    /// Writes memory as it was at a moment as JSON Lines; `progress` is told after each line how many lines are written.
    ///
    /// # Errors
    /// When it can't be written.
    pub fn export(
        &self,
        moment: &Moment,
        to: &mut dyn Write,
        progress: impl FnMut(u64),
    ) -> Result<export::ExportSummary, export::ExportError> {
        let (memory, curriculum) = (moment.learner.memory(), moment.learner.curriculum());
        let (learner, seed) = (self.learner(), self.seed());
        let identity = export::Identity { learner, seed, parameters: memory.parameters(), curriculum };
        export::write(memory.content(), identity, to, progress)
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
