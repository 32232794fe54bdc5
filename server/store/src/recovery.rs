//! From disk to memory: the newest sound snapshot, and the journal after it through [`Memory::apply`].

use std::io;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};

use pschema_learner::digest::digest;
use pschema_learner::effect;
use pschema_learner::memory::{Content, Memory};

use crate::codec;
use crate::error::StoreError;
use crate::format::v1::{Bounds, Cause, Effect, Record, Setting, Whole};
use crate::journal::{self, DIRECTORY, End, Place, Shown, segment_name};
use crate::manifest::Manifest;
use crate::snapshot;
use crate::storage::Storage;

/// What was found on disk.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Recovered {
    /// Steps taken in the life of this memory.
    pub step: u64,
    /// The step of the snapshot that was read; none when there is none yet.
    pub snapshot_step: Option<u64>,
    /// Frames of the journal replayed after it.
    pub frames: u64,
    /// Bytes of the journal read.
    pub journal_bytes: u64,
    /// What was being written when the last daemon ended, and never acknowledged: the file, and where in it.
    pub torn: Option<(String, usize)>,
}

/// A memory as it is found again, frame by frame.
#[derive(Debug)]
pub(crate) struct Replay {
    pub(crate) memory: Memory,
    /// What it lives under.
    pub(crate) setting: Setting,
    /// How many stages its curriculum has.
    stages: usize,
    /// Memory at the last mark whose digest has not come yet, and the mark's frame.
    marked: Option<(u64, Box<Content>)>,
    /// Digests that came and were right.
    pub(crate) digests: u64,
}

impl Replay {
    /// A memory as it was begun.
    pub(crate) fn birth(manifest: &Manifest) -> Result<Self, StoreError> {
        let (parameters, _) = manifest.setting.clone().live()?;
        Ok(Self::of(Memory::new(manifest.seed, parameters), manifest.setting.clone()))
    }

    /// A memory as a snapshot has it.
    pub(crate) fn from_snapshot(Whole { content, setting }: Whole) -> Result<Self, StoreError> {
        let (parameters, _) = setting.clone().live()?;
        let memory = guarded("a snapshot", || Ok(Memory::restore(content, parameters)));
        Ok(Self::of(memory.map_err(StoreError::Content)?, setting))
    }

    fn of(memory: Memory, setting: Setting) -> Self {
        let stages = setting.curriculum.stages();
        Self { memory, setting, stages, marked: None, digests: 0 }
    }

    /// Takes in what frame `number` says. The error says what is wrong with it.
    pub(crate) fn apply(&mut self, record: Record, number: u64) -> Result<(), String> {
        match record {
            Record::Batch { step, cause, effects, .. } => {
                for disk in effects {
                    self.effect(disk)?;
                }
                if let Cause::Changed(setting) = cause {
                    self.change(*setting)?;
                }
                expect(step, self.memory.content())
            }
            Record::Mark { step } => {
                self.marked = Some((number, Box::new(self.memory.content().clone())));
                expect(step, self.memory.content())
            }
            Record::Digest { mark, step, digest: written } => {
                // Of a mark before what was read from, nothing is known; a snapshot has a digest of its own.
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

    fn effect(&mut self, disk: Effect) -> Result<(), String> {
        if !disk.fits(&Bounds::of(self.memory.content(), self.stages)) {
            return Err("an effect speaks of what memory does not have".to_owned());
        }
        let live = effect::Effect::try_from(disk).map_err(|error| error.to_string())?;
        guarded("an effect", || self.memory.apply(&live).map_err(|error| error.to_string()))
    }

    fn change(&mut self, setting: Setting) -> Result<(), String> {
        let (parameters, _) = setting.clone().live().map_err(|error| error.to_string())?;
        let content = self.memory.content().clone();
        self.memory = guarded("a change of settings", || Ok(Memory::restore(content, parameters)))?;
        self.stages = setting.curriculum.stages();
        self.setting = setting;
        Ok(())
    }
}

/// What is there, found again.
#[derive(Debug)]
pub(crate) struct Recovery {
    pub(crate) replay: Replay,
    pub(crate) end: End,
    pub(crate) found: Recovered,
    /// Frames among those replayed that changed memory.
    pub(crate) batches: u64,
    /// Snapshots that were passed over.
    pub(crate) damaged: Vec<u64>,
}

/// Memory as the disk has it, and where its journal ends; or as it was after step `until`, orders that came before the
/// next step included. Changes nothing on disk, and needs no lock.
pub(crate) fn recover(
    storage: &dyn Storage,
    manifest: &Manifest,
    until: Option<u64>,
) -> Result<Recovery, StoreError> {
    let snapshot::Search { sound, damaged } = snapshot::search(storage, until)?;
    let (mut replay, from, snapshot_step) = match sound {
        Some((whole, place)) => {
            let step = whole.content.step;
            (Replay::from_snapshot(whole)?, place, Some(step))
        }
        None => (Replay::birth(manifest)?, Place::default(), None),
    };
    let (mut frames, mut batches) = (0, 0);
    let end = journal::read::<StoreError>(storage, from, |shown| {
        let wrong = |problem| unplayable(storage, &shown, problem);
        let record = codec::decode(shown.payload).map_err(|error| wrong(error.to_string()))?;
        if let (Record::Batch { step, .. }, Some(until)) = (&record, until)
            && *step > until
        {
            return Ok(ControlFlow::Break(()));
        }
        frames += 1;
        batches += u64::from(matches!(record, Record::Batch { .. }));
        replay.apply(record, shown.place.number).map_err(wrong)?;
        Ok(ControlFlow::Continue(()))
    })?;
    let found = Recovered {
        step: replay.memory.content().step,
        snapshot_step,
        frames,
        journal_bytes: end.bytes,
        torn: end.torn.clone(),
    };
    Ok(Recovery { replay, end, found, batches, damaged })
}

/// A frame that can't be replayed.
pub(crate) fn unplayable(storage: &dyn Storage, shown: &Shown<'_>, problem: String) -> StoreError {
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

/// What a sound checksum stands before may still be forged; it must not end the process.
fn guarded<T>(what: &'static str, work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    let done = catch_unwind(AssertUnwindSafe(work));
    done.unwrap_or_else(|_| Err(format!("{what} can't be taken into memory")))
}

/// Makes durable what was read, so that a new segment may say so of it, and cuts off the zeros behind it. Changes nothing
/// that can be read.
pub(crate) fn settle(storage: &dyn Storage, end: &End) -> io::Result<()> {
    if let Some((last, before)) = end.segments.split_last() {
        for first in before {
            storage.sync(&segment_name(*first))?;
        }
        // All others were made durable before the one after them was begun.
        storage.confirm(&segment_name(*last), end.sound)?;
    }
    storage.sync_directory(DIRECTORY)?;
    match end.segments.last() {
        Some(last) if end.torn.is_none() => storage.truncate(&segment_name(*last), end.sound),
        _ => Ok(()),
    }
}
