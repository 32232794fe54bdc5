//! Checking all of a data directory: every byte that says something, and that its parts fit together.

use std::ops::ControlFlow;

use pschema_learner::Learner;
use pschema_learner::digest::{self, digest};
use pschema_learner::memory::Memory;

use super::error::{PastError, READ_AGAIN_MAX, damage_text, is_gone};
use super::moment::Past;
use super::relearn;
use super::scan::Tail;
use crate::codec;
use crate::error::StoreError;
use crate::format::v1::{Cause, Record};
use crate::frame::{self, JOURNAL};
use crate::journal::{self, JournalError, JournalFrame, Place, segment_name};
use crate::recovery::{Replay, unplayable};
use crate::snapshot;

/// What was checked in a data directory, and what is wrong in it.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Verification {
    /// The directory.
    pub directory: String,
    /// Whether nothing is wrong.
    pub sound: bool,
    /// How many segments the journal has.
    pub segments: u64,
    /// The length of the sound frames in them, in bytes.
    pub journal_bytes: u64,
    /// How many sound frames there are.
    pub frames: u64,
    /// How many of them changed memory, and were replayed.
    pub batches: u64,
    /// How many digests in the journal are equal to those of the replayed memory.
    pub digests: u64,
    /// How many snapshots are sound, and equal to the replayed memory at their place.
    pub snapshots: u64,
    /// The first step that can be returned to; none when nothing could be replayed.
    pub first_step: Option<u64>,
    /// The last step that is sound; none when nothing could be replayed.
    pub last_step: Option<u64>,
    /// The digest of memory after that step.
    pub memory_digest: Option<String>,
    /// How many steps were learnt again with the same effects as then; none when that was not asked for.
    pub relearnt: Option<u64>,
    /// How the journal ends.
    pub tail: Tail,
    /// What is wrong.
    pub findings: Vec<Finding>,
}

/// Something that is wrong.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Finding {
    /// The file; none when it is about the whole directory.
    pub file: Option<String>,
    /// The place in the file, if it is known.
    pub offset: Option<u64>,
    /// The first step that is lost by it; none when no step is lost.
    pub lost_from: Option<u64>,
    /// The last step that is lost by it, as far as is known.
    pub lost_to: Option<u64>,
    /// What is wrong.
    pub problem: String,
}

/// How far a verification is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VerificationProgress {
    /// How many bytes were checked.
    pub bytes: u64,
    /// How many bytes there are.
    pub of: u64,
    /// The step that it is at.
    pub step: u64,
}

struct Check<'a> {
    past: &'a Past,
    progress: &'a mut dyn FnMut(VerificationProgress),
    of: u64,
    bytes: u64,
    checked: Verification,
    /// The sound snapshots, with the digest of each, and those of what was found of experiences.
    snapshots: Vec<(Place, String, Vec<String>)>,
    /// The replayed memory, from the place on from which it can be replayed.
    replay: Option<Replay>,
    /// The learner that takes the steps again; it has the memory meanwhile.
    learner: Option<Learner>,
    relearn: bool,
    /// Whether a missing file is taken for damage, and not for one that a daemon has removed meanwhile.
    last_try: bool,
}

impl Past {
    /// Checks everything; with `relearn`, every step is learnt again from its frame as well. What is wrong is in the result.
    ///
    /// # Errors
    /// When the directory can't be read.
    pub fn verify(
        &self,
        relearn: bool,
        progress: &mut dyn FnMut(VerificationProgress),
    ) -> Result<Verification, PastError> {
        for left in (0..READ_AGAIN_MAX).rev() {
            let before = self.names()?;
            match self.verify_once(relearn, left == 0, progress) {
                // A daemon removed files meanwhile that it keeps no longer, and the rest looks damaged.
                Err(PastError::Store(error)) if left > 0 && is_gone(&error) => (),
                Ok(checked) if left > 0 && !checked.sound && self.names()? != before => (),
                done => return done,
            }
        }
        self.verify_once(relearn, true, progress)
    }

    fn verify_once(
        &self,
        relearn: bool,
        last_try: bool,
        progress: &mut dyn FnMut(VerificationProgress),
    ) -> Result<Verification, PastError> {
        let files = self.files()?;
        let sizes =
            files.segments.iter().map(|one| one.bytes).chain(files.snapshots.iter().map(|one| one.bytes));
        let checked = Verification {
            directory: self.path(),
            segments: files.segments.len() as u64,
            relearnt: relearn.then_some(0),
            ..Verification::default()
        };
        let mut check = Check {
            past: self,
            progress,
            of: sizes.sum(),
            bytes: 0,
            checked,
            snapshots: Vec::new(),
            replay: None,
            learner: None,
            relearn,
            last_try,
        };
        check.snapshots()?;
        check.journal()?;
        Ok(check.end())
    }

    /// The last step that a sound frame of the journal speaks of, wherever the frame stands.
    pub(super) fn last_known_step(&self) -> Result<u64, PastError> {
        let mut last = self.begins()?.iter().map(|head| head.step).max().unwrap_or(0);
        for first in self.segments()?.into_iter().rev() {
            let name = segment_name(first);
            let bytes =
                self.storage.read(&name).map_err(StoreError::disk("read", self.storage.path(&name)))?;
            let steps = frame::scan(JOURNAL, &bytes).filter_map(|(_, found)| {
                match codec::decode(found.payload).ok()? {
                    Record::Batch { step, .. } | Record::Mark { step } => Some(step),
                    Record::Digest { .. } => None,
                }
            });
            if let Some(found) = steps.max() {
                last = last.max(found);
                break;
            }
        }
        Ok(last)
    }
}

impl Check<'_> {
    fn found(&mut self, file: Option<String>, offset: Option<u64>, problem: String) {
        let finding = Finding { file, offset, lost_from: None, lost_to: None, problem };
        self.checked.findings.push(finding);
    }

    fn tell(&mut self) {
        let step = self.memory().map_or(0, |memory| memory.content().step);
        (self.progress)(VerificationProgress { bytes: self.bytes.min(self.of), of: self.of, step });
    }

    fn memory(&self) -> Option<&Memory> {
        let learnt = self.learner.as_ref().map(Learner::memory);
        learnt.or(self.replay.as_ref().map(|replay| &replay.memory))
    }

    /// Reads every snapshot.
    fn snapshots(&mut self) -> Result<(), PastError> {
        let storage = &*self.past.storage;
        let failed = |name: &str| StoreError::disk("read", storage.path(name));
        for number in snapshot::numbers(storage)? {
            let name = snapshot::name(number);
            match snapshot::sound(storage, number) {
                Ok(Some((whole, place))) => {
                    self.snapshots.push((place, whole.memory_digest, digest::claims(&whole.content)));
                }
                Ok(None) => {
                    let problem = "the snapshot is damaged: a block of it is not what was written".to_owned();
                    self.found(Some(storage.path(&name)), None, problem);
                }
                // A daemon removes snapshots that are no longer to be kept.
                Err(error) if error.kind() == std::io::ErrorKind::NotFound => continue,
                Err(error) => return Err(failed(&name)(error).into()),
            }
            self.bytes += storage.size(&name).unwrap_or(0);
            self.tell();
        }
        Ok(())
    }

    /// Follows the journal from its first segment to its end.
    fn journal(&mut self) -> Result<(), PastError> {
        let begins = self.past.begins()?;
        let firsts = self.past.segments()?;
        let from = match (begins.first(), firsts.first()) {
            (Some(head), Some(first)) if head.first == *first => head.after,
            (_, Some(first)) => {
                let file = self.past.storage.path(&segment_name(*first));
                self.found(Some(file), Some(0), "the head of the segment is damaged".to_owned());
                begins.first().map_or(Place::default(), |head| head.after)
            }
            // Without a snapshot the memory has only just begun; with one, the journal is missing.
            (_, None) => self.snapshots.last().map_or(Place::default(), |(place, ..)| *place),
        };
        if from.number == 0 {
            self.replay = Some(Replay::birth(&self.past.manifest)?);
        }
        self.passes(from)?;
        self.first_step();
        let read = journal::read::<PastError>(&*self.past.storage, from, |shown| {
            self.frame(&shown)?;
            Ok(ControlFlow::Continue(()))
        });
        match read {
            Ok(end) => {
                if let Some((file, offset)) = end.torn {
                    self.checked.tail = Tail::Torn { file, offset: offset as u64 };
                }
                Ok(())
            }
            Err(PastError::Store(error)) if self.last_try || !is_gone(&error) => self.damaged(error),
            Err(error) => Err(error),
        }
    }

    /// Notes the damage that ended the journal.
    fn damaged(&mut self, error: StoreError) -> Result<(), PastError> {
        let problem = damage_text(&error);
        let (file, offset) = match error {
            StoreError::Journal(JournalError::Damaged { file, offset, .. })
            | StoreError::Replay { file, offset, .. } => (Some(file), Some(offset as u64)),
            StoreError::Journal(JournalError::Missing { .. } | JournalError::Version { .. }) => (None, None),
            error => return Err(error.into()),
        };
        let step = self.memory().map(|memory| memory.content().step);
        let last = self.past.last_known_step()?;
        self.checked.tail = Tail::Damaged { problem: problem.clone() };
        let lost_from = step.map(|step| step + 1).filter(|from| *from <= last);
        let lost_to = lost_from.map(|_| last);
        self.checked.findings.push(Finding { file, offset, lost_from, lost_to, problem });
        Ok(())
    }

    fn frame(&mut self, shown: &JournalFrame<'_>) -> Result<(), PastError> {
        let record = self.past.record(shown)?;
        let length = (frame::HEAD_LEN + shown.payload.len()) as u64;
        self.checked.frames += 1;
        self.checked.journal_bytes += length;
        self.bytes += length;
        self.record(record, shown)?;
        self.passes(shown.place)?;
        if self.checked.frames.is_multiple_of(256) {
            self.tell();
        }
        Ok(())
    }

    fn record(&mut self, record: Record, shown: &JournalFrame<'_>) -> Result<(), PastError> {
        let Some(replay) = &mut self.replay else { return Ok(()) };
        let storage = &*self.past.storage;
        let wrong = |problem| PastError::Store(unplayable(storage, shown, problem));
        let batch = matches!(record, Record::Batch { .. });
        match record {
            Record::Batch { step, cause: Cause::Step(input), effects, .. } if self.relearn => {
                let learner = match &mut self.learner {
                    Some(learner) => learner,
                    None => self.learner.insert(relearn::lend(replay).map_err(wrong)?),
                };
                relearn::step(learner, input, &effects).map_err(wrong)?;
                if learner.memory().content().step != step {
                    return Err(wrong(format!(
                        "it was written after step {step}, and learning it again leads elsewhere"
                    )));
                }
                if let Some(relearnt) = &mut self.checked.relearnt {
                    *relearnt += 1;
                }
            }
            record => {
                if let Some(learner) = self.learner.take() {
                    replay.memory = learner.into_memory();
                }
                replay.apply(record, shown.place.number).map_err(wrong)?;
            }
        }
        self.checked.batches += u64::from(batch);
        Ok(())
    }

    /// Compares a snapshot that was made at this place with the replayed memory. When the journal does not reach back to the
    /// beginning of the memory, replaying begins with the first snapshot.
    fn passes(&mut self, place: Place) -> Result<(), PastError> {
        let here = self.snapshots.iter().find(|(there, ..)| there.number == place.number);
        let Some((there, written, claims)) = here.cloned() else { return Ok(()) };
        let crc = there.crc;
        let name = snapshot::name(place.number);
        let file = self.past.storage.path(&name);
        if crc != place.crc {
            self.found(Some(file), None, "the snapshot was made in another journal than this one".to_owned());
            return Ok(());
        }
        match self.memory() {
            None => {
                let found = snapshot::sound(&*self.past.storage, place.number);
                let found = found.map_err(StoreError::disk("read", file))?;
                if let Some((whole, _)) = found {
                    self.replay = Some(Replay::from_snapshot(whole)?);
                    self.first_step();
                    self.checked.snapshots += 1;
                }
            }
            Some(memory) => {
                let found = digest(memory.content());
                if found != written {
                    let problem =
                        format!("the snapshot has digest {written}, and the journal leads to {found}");
                    self.found(Some(file), None, problem);
                } else if digest::claims(memory.content()) != claims {
                    let problem = "the snapshot has other claims than those that the journal leads to";
                    self.found(Some(file), None, problem.to_owned());
                } else {
                    self.checked.snapshots += 1;
                }
            }
        }
        Ok(())
    }

    fn first_step(&mut self) {
        if self.checked.first_step.is_none() {
            self.checked.first_step = self.memory().map(|memory| memory.content().step);
        }
    }

    fn end(mut self) -> Verification {
        self.bytes = self.of;
        self.tell();
        let step = self.memory().map(|memory| memory.content().step);
        let found = self.memory().map(|memory| digest(memory.content()));
        if step.is_none() {
            let problem = "nothing can be replayed: the journal does not reach back to its beginning, and no snapshot in \
                           it is sound";
            self.found(None, None, problem.to_owned());
        }
        let mut checked = self.checked;
        (checked.last_step, checked.memory_digest) = (step, found);
        checked.digests = self.replay.map_or(0, |replay| replay.digests);
        checked.sound = checked.findings.is_empty();
        checked
    }
}
