//! From disk to memory: the newest sound snapshot, and the journal after it through [`Memory::apply`].

use std::io;
use std::ops::ControlFlow;

use pschema_learner::digest::digest;
use pschema_learner::memory::{Content, Memory};

use crate::codec;
use crate::error::StoreError;
use crate::format::mirror::Mirror;
use crate::format::v1::{Cause, Input, Record, Setting, WholeMemory};
use crate::journal::{self, DIRECTORY, End, JournalFrame, Place, segment_name};
use crate::manifest::Manifest;
use crate::snapshot;
use crate::storage::Storage;

/// What was found on disk when a memory was found again.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RecoveryReport {
    /// Steps taken in the life of this memory.
    pub step: u64,
    /// The step of the snapshot that was read; none when there is none yet.
    pub snapshot_step: Option<u64>,
    /// Frames of the journal that were replayed after the snapshot.
    pub frames: u64,
    /// Bytes of the journal that were read.
    pub journal_bytes: u64,
    /// Where bytes were being written when the last daemon ended, which were never acknowledged: the file, and the place in it.
    pub torn: Option<(String, usize)>,
}

/// A memory that is found again, frame by frame.
#[derive(Debug)]
pub(crate) struct Replay {
    pub(crate) memory: Memory,
    /// The setting that is in force.
    pub(crate) setting: Setting,
    /// Memory at the last mark whose digest has not come yet, and the mark's frame.
    marked: Option<(u64, Box<Content>)>,
    /// How many digests came and were right.
    pub(crate) digests: u64,
    /// The last frame of a body among the replayed ones.
    pub(crate) seen: LastFrame,
}

/// The last frame of a body, which is in the journal and not in memory; and the time of the last change.
#[derive(Debug, Default)]
pub(crate) struct LastFrame {
    pub(crate) at_unix_ms: Option<u64>,
    pub(crate) input: Option<Input>,
}

impl Replay {
    /// A memory as it was begun.
    pub(crate) fn birth(manifest: &Manifest) -> Result<Self, StoreError> {
        let (parameters, _) = manifest.setting.checked()?;
        Ok(Self::of(Memory::new(manifest.seed, parameters), manifest.setting.clone()))
    }

    /// A memory as a snapshot has it.
    pub(crate) fn from_snapshot(snapshot: WholeMemory) -> Result<Self, StoreError> {
        let WholeMemory { content, setting, .. } = snapshot;
        let (parameters, _) = setting.checked()?;
        Ok(Self::of(Memory::restore(content, parameters), setting))
    }

    fn of(memory: Memory, setting: Setting) -> Self {
        Self { memory, setting, marked: None, digests: 0, seen: LastFrame::default() }
    }

    /// Takes in the record of frame `number`. The error says what is wrong with it.
    pub(crate) fn apply(&mut self, record: Record, number: u64) -> Result<(), String> {
        match record {
            Record::Batch { step, at_unix_ms, cause, effects } => {
                for effect in effects {
                    self.memory.apply(&effect.live()).map_err(|error| error.to_string())?;
                }
                self.seen.at_unix_ms = Some(at_unix_ms);
                match cause {
                    Cause::Changed(setting) => self.change(*setting)?,
                    Cause::Step(input) => self.seen.input = Some(input),
                    Cause::Declared(_) | Cause::Order(_) => (),
                }
                expect(step, self.memory.content())
            }
            Record::Mark { step } => {
                self.marked = Some((number, Box::new(self.memory.content().clone())));
                expect(step, self.memory.content())
            }
            Record::Digest { mark, step, digest: written } => {
                // Nothing is known of a mark before the snapshot that was read; the snapshot has a digest of its own.
                let Some((_, content)) = self.marked.take_if(|(number, _)| *number == mark) else {
                    return Ok(());
                };
                expect(step, &content)?;
                let found = digest(&content);
                if found != written {
                    return Err(format!(
                        "memory has digest {found} after step {step}, and had {written} when this was written"
                    ));
                }
                self.digests += 1;
                Ok(())
            }
        }
    }

    fn change(&mut self, setting: Setting) -> Result<(), String> {
        let (parameters, _) = setting.checked().map_err(|error| error.to_string())?;
        self.memory = Memory::restore(self.memory.content().clone(), parameters);
        self.setting = setting;
        Ok(())
    }
}

/// A memory that was found again, and the end of its journal.
#[derive(Debug)]
pub(crate) struct Recovery {
    pub(crate) replay: Replay,
    pub(crate) end: End,
    pub(crate) found: RecoveryReport,
    /// How many of the replayed frames changed memory.
    pub(crate) batches: u64,
    /// The batch that comes next in the journal, when replaying ended before it.
    pub(crate) next: Option<Record>,
    /// The numbers of damaged snapshots, which were passed over.
    pub(crate) damaged: Vec<u64>,
}

/// Where replaying begins.
#[derive(Debug)]
pub(crate) struct Base {
    replay: Replay,
    from: Place,
    /// The step of the snapshot; none at the beginning of the memory.
    pub(crate) snapshot_step: Option<u64>,
    damaged: Vec<u64>,
}

impl Base {
    /// The step of the snapshot, and the frame that it was made after.
    pub(crate) fn snapshot(&self) -> Option<(u64, u64)> {
        Some((self.snapshot_step?, self.from.number))
    }
}

/// The newest sound snapshot of step `until` or before, or else the beginning of the memory.
pub(crate) fn base(
    storage: &dyn Storage,
    manifest: &Manifest,
    until: Option<u64>,
) -> Result<Base, StoreError> {
    let snapshot::Search { sound, damaged } = snapshot::search(storage, until)?;
    let Some((whole, from)) = sound else {
        let replay = Replay::birth(manifest)?;
        return Ok(Base { replay, from: Place::default(), snapshot_step: None, damaged });
    };
    let snapshot_step = Some(whole.content.step);
    Ok(Base { replay: Replay::from_snapshot(whole)?, from, snapshot_step, damaged })
}

/// Memory as it is on disk, and where its journal ends; or memory as it was after step `until` and the orders that came before
/// the next step. Changes nothing on disk, and needs no lock.
pub(crate) fn recover(storage: &dyn Storage, base: Base, until: Option<u64>) -> Result<Recovery, StoreError> {
    let Base { mut replay, from, snapshot_step, damaged } = base;
    let (mut frames, mut batches, mut next) = (0, 0, None);
    let end = journal::read::<StoreError>(storage, from, |shown| {
        let wrong = |problem| unplayable(storage, &shown, problem);
        let record = codec::decode(shown.payload).map_err(|error| wrong(error.to_string()))?;
        if let (Record::Batch { step, .. }, Some(until)) = (&record, until)
            && *step > until
        {
            next = Some(record);
            return Ok(ControlFlow::Break(()));
        }
        frames += 1;
        batches += u64::from(matches!(record, Record::Batch { .. }));
        replay.apply(record, shown.place.number).map_err(wrong)?;
        Ok(ControlFlow::Continue(()))
    })?;
    let found = RecoveryReport {
        step: replay.memory.content().step,
        snapshot_step,
        frames,
        journal_bytes: end.bytes,
        torn: end.torn.clone(),
    };
    Ok(Recovery { replay, end, found, batches, next, damaged })
}

/// A frame that can't be replayed.
pub(crate) fn unplayable(storage: &dyn Storage, shown: &JournalFrame<'_>, problem: String) -> StoreError {
    StoreError::Replay {
        file: storage.path(&segment_name(shown.segment)),
        offset: shown.offset,
        frame: shown.place.number,
        problem,
    }
}

fn expect(step: u64, content: &Content) -> Result<(), String> {
    if content.step == step {
        return Ok(());
    }
    Err(format!("it was written after step {step}, and replaying it leads to step {}", content.step))
}

/// Makes the journal that was read durable, so that a new segment may say that it is, and cuts off the zeros behind it. Changes
/// nothing that can be read.
pub(crate) fn settle(storage: &dyn Storage, end: &End) -> io::Result<()> {
    if let Some((last, before)) = end.segments.split_last() {
        for first in before {
            storage.sync(&segment_name(*first))?;
        }
        // Every other segment was made durable before the one after it was begun.
        storage.confirm(&segment_name(*last), end.sound)?;
    }
    storage.sync_directory(DIRECTORY)?;
    match end.segments.last() {
        Some(last) if end.torn.is_none() => storage.truncate(&segment_name(*last), end.sound),
        _ => Ok(()),
    }
}
