//! From disk to memory: the newest sound snapshot, and the journal after it through [`Memory::apply`].

use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};

use pschema_learner::digest::digest;
use pschema_learner::effect;
use pschema_learner::memory::{Content, Memory};
use pschema_learner::parameters::Parameters;

use crate::codec;
use crate::error::StoreError;
use crate::format::v1::{Bounds, Record};
use crate::journal::{self, DIRECTORY, End, Place, Shown, segment_name};
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

/// Memory as the disk has it, and where its journal ends. Changes nothing on disk.
pub(crate) fn recover(
    storage: &dyn Storage,
    seed: u64,
    parameters: &Parameters,
) -> Result<(Memory, End, Recovered), StoreError> {
    let newest = snapshot::newest(storage)?;
    let (mut memory, from, snapshot_step) = match newest {
        Some((content, place)) => {
            let step = content.step;
            (guarded("a snapshot", || Ok(Memory::restore(content, parameters.clone())))?, place, Some(step))
        }
        None => (Memory::new(seed, parameters.clone()), Place::default(), None),
    };
    let mut frames = 0;
    let end = journal::read::<StoreError>(storage, from, |shown| {
        frames += 1;
        replay(&mut memory, &shown).map_err(|problem| StoreError::Replay {
            file: storage.path(&segment_name(shown.segment)),
            offset: shown.offset,
            frame: shown.place.number,
            problem,
        })
    })?;
    let recovered = Recovered {
        step: memory.content().step,
        snapshot_step,
        frames,
        journal_bytes: end.bytes,
        torn: end.torn.clone(),
    };
    Ok((memory, end, recovered))
}

fn replay(memory: &mut Memory, shown: &Shown<'_>) -> Result<(), String> {
    match codec::decode(shown.payload).map_err(|error| error.to_string())? {
        Record::Batch { step, effects } => {
            for disk in effects {
                if !disk.fits(&Bounds::of(memory.content())) {
                    return Err("an effect speaks of an observation that memory has no words for".to_owned());
                }
                let live = effect::Effect::try_from(disk).map_err(|error| error.to_string())?;
                guarded("an effect", || memory.apply(&live).map_err(|error| error.to_string()))
                    .map_err(|error| error.to_string())?;
            }
            expect(step, memory.content())
        }
        Record::Digest { step, digest: written } => {
            expect(step, memory.content())?;
            let found = digest(memory.content());
            if found == written {
                return Ok(());
            }
            Err(format!(
                "memory has digest {found} after step {step}, and had {written} when this was written"
            ))
        }
    }
}

fn expect(step: u64, content: &Content) -> Result<(), String> {
    if content.step == step {
        return Ok(());
    }
    Err(format!("it was written after step {step}, and replaying it leads to step {}", content.step))
}

/// What a sound checksum stands before may still be forged; it must not end the process.
fn guarded<T>(what: &'static str, work: impl FnOnce() -> Result<T, String>) -> Result<T, StoreError> {
    let done = catch_unwind(AssertUnwindSafe(work));
    let done = done.unwrap_or_else(|_| Err(format!("{what} can't be taken into memory")));
    done.map_err(StoreError::Content)
}

/// Makes durable what was read, so that a new segment may say so of it. Changes nothing that can be read.
pub(crate) fn settle(storage: &dyn Storage, end: &End) -> io::Result<()> {
    for first in &end.segments {
        storage.sync(&segment_name(*first))?;
    }
    storage.sync_directory(DIRECTORY)
}
