//! The files of a data directory, and looking back through its journal without rebuilding memory.

use std::collections::VecDeque;
use std::io;
use std::ops::ControlFlow;
use std::sync::Arc;

use super::cut;
use super::entry::{Batch, Wording};
use super::error::{PastError, beside, damage_text};
use super::moment::Past;
use crate::error::StoreError;
use crate::format::mirror::Mirror;
use crate::format::v1::{Cause, Effect, Record};
use crate::frame::{self, HEAD_LEN};
use crate::journal::{self, FILE_HEAD_LEN, Place, SEGMENT, read_file_head, segment_name};
use crate::recovery::LastFrame;
use crate::retention;
use crate::snapshot;
use crate::storage::Storage;

/// The files that a memory is kept in.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Files {
    /// The segments of the journal, in order.
    pub segments: Vec<SegmentFile>,
    /// The snapshots, in order.
    pub snapshots: Vec<SnapshotFile>,
    /// The first step that can be returned to.
    pub oldest_step: u64,
}

/// A segment of the journal.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SegmentFile {
    /// Its path.
    pub file: String,
    /// The number of the first frame in it.
    pub first_frame: u64,
    /// How many steps had been taken before it; none when its head is damaged.
    pub step: Option<u64>,
    /// The length of the file in bytes, with the zeros that were written ahead.
    pub bytes: u64,
}

/// A snapshot.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SnapshotFile {
    /// Its path.
    pub file: String,
    /// The frame that it was made after.
    pub frame: u64,
    /// The step that it was made at; none when its head is damaged.
    pub step: Option<u64>,
    /// The length of the file in bytes.
    pub bytes: u64,
}

/// How a journal ends.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "state", rename_all = "snake_case")]
pub enum Tail {
    /// With its last frame.
    #[default]
    Whole,
    /// With bytes that were being written when the daemon ended, or are being written now; nobody acted on them.
    Torn {
        /// Which file.
        file: String,
        /// Where these bytes begin.
        offset: u64,
    },
    /// With damage to a frame that was acknowledged, or with a frame that can't be read.
    Damaged {
        /// What is damaged, and where.
        problem: String,
    },
}

/// The head of a segment.
#[derive(Clone, Copy, Debug)]
pub(super) struct SegmentHead {
    pub(super) first: u64,
    /// The place after the frame before the segment.
    pub(super) after: Place,
    /// How many steps had been taken before the segment.
    pub(super) step: u64,
}

impl Past {
    pub(super) fn segments(&self) -> Result<Vec<u64>, StoreError> {
        cut::segments(&*self.storage)
    }

    /// The first step that can be returned to; none when there is no journal at all.
    pub(super) fn first_step(&self) -> Result<Option<u64>, StoreError> {
        if self.segments()?.is_empty() {
            return Ok(None);
        }
        retention::kept(&*self.storage).map(|kept| Some(kept.oldest_step))
    }

    /// The heads of the segments that are sound.
    pub(super) fn begins(&self) -> Result<Vec<SegmentHead>, StoreError> {
        let mut begins = Vec::new();
        for first in self.segments()? {
            let name = segment_name(first);
            match beginning(&*self.storage, first) {
                Ok(found) => begins.extend(found),
                // A daemon removes segments that are no longer to be kept.
                Err(error) if error.kind() == io::ErrorKind::NotFound => (),
                Err(error) => return Err(StoreError::disk("read", self.storage.path(&name))(error)),
            }
        }
        Ok(begins)
    }

    /// The files that the memory is kept in.
    ///
    /// # Errors
    /// When the directory can't be read.
    pub fn files(&self) -> Result<Files, PastError> {
        beside(|| self.files_once())
    }

    fn files_once(&self) -> Result<Files, PastError> {
        let begins = self.begins()?;
        let failed = |name: &str| StoreError::disk("read", self.storage.path(name));
        let mut segments = Vec::new();
        for first in self.segments()? {
            let name = segment_name(first);
            let step = begins.iter().find(|head| head.first == first).map(|head| head.step);
            let bytes = self.storage.size(&name).map_err(failed(&name))?;
            segments.push(SegmentFile { file: self.storage.path(&name), first_frame: first, step, bytes });
        }
        let mut snapshots = Vec::new();
        for frame in snapshot::numbers(&*self.storage)? {
            let name = snapshot::name(frame);
            let step = snapshot::step(&*self.storage, frame).map_err(failed(&name))?;
            let bytes = self.storage.size(&name).map_err(failed(&name))?;
            snapshots.push(SnapshotFile { file: self.storage.path(&name), frame, step, bytes });
        }
        let oldest_step = retention::kept(&*self.storage)?.oldest_step;
        Ok(Files { segments, snapshots, oldest_step })
    }

    /// The last record of the journal, up to and with step `until`, for which `found` has an answer, and that answer. The segments
    /// are looked through from the last one back.
    fn look_back<T>(
        &self,
        until: u64,
        mut found: impl FnMut(&Record) -> Option<T>,
    ) -> Result<Option<T>, PastError> {
        let mut beyond = u64::MAX;
        for head in self.begins()?.iter().rev().filter(|head| head.step <= until) {
            let mut last = None;
            journal::read::<PastError>(&*self.storage, head.after, |shown| {
                let record = self.record(&shown)?;
                let over = matches!(&record, Record::Batch { step, .. } if *step > until);
                if over || shown.place.number >= beyond {
                    return Ok(ControlFlow::Break(()));
                }
                last = found(&record).or(last.take());
                Ok(ControlFlow::Continue(()))
            })?;
            if last.is_some() {
                return Ok(last);
            }
            beyond = head.first;
        }
        Ok(None)
    }

    /// The last frame of a body, up to and with step `until`.
    pub(super) fn last_input(&self, until: u64) -> Result<LastFrame, PastError> {
        let found = self.look_back(until, |record| match record {
            Record::Batch { at_unix_ms, cause: Cause::Step(input), .. } => {
                Some(LastFrame { at_unix_ms: Some(*at_unix_ms), input: Some(input.clone()) })
            }
            _ => None,
        })?;
        Ok(found.unwrap_or_default())
    }

    /// The last step up to and with step `until` that chose an action.
    pub(super) fn last_decided(&self, until: u64) -> Result<Option<u64>, PastError> {
        self.look_back(until, |record| match record {
            Record::Batch { step, cause: Cause::Step(_), effects, .. } => {
                let chose = |effect: &Effect| matches!(effect, Effect::StepEnded { pending: Some(_), .. });
                effects.iter().any(chose).then_some(*step)
            }
            _ => None,
        })
    }

    /// Batches of the journal in order: those of the steps `from` to `to`, at most `limit` of them; the last ones when
    /// `from` is not given. With `in_words`, effects are put into words as well.
    ///
    /// A damaged journal is read up to the damage, which the tail then names.
    ///
    /// # Errors
    /// When the directory can't be read, or none of these steps is in it: they are still to come, or are no longer kept.
    pub fn batches(
        &self,
        from: Option<u64>,
        to: Option<u64>,
        limit: usize,
        in_words: bool,
    ) -> Result<(Vec<Batch>, Tail), PastError> {
        beside(|| self.batches_once(from, to, limit, in_words))
    }

    fn batches_once(
        &self,
        from: Option<u64>,
        to: Option<u64>,
        limit: usize,
        in_words: bool,
    ) -> Result<(Vec<Batch>, Tail), PastError> {
        let words = self.words()?;
        let mut last = None;
        let mut begins = self.begins()?;
        let mut tail = Tail::Whole;
        let mut batches = VecDeque::new();
        // From the segment with the first batch on; or from the last segment back, until there are enough batches.
        if let (Some(asked), Some(SegmentHead { step: first, .. })) = (to, begins.first().copied())
            && asked < first
        {
            return Err(PastError::Before { path: self.path(), asked, first });
        }
        let to = to.unwrap_or(u64::MAX);
        begins.retain(|head| head.step <= to);
        let wanted = from.map(|from| begins.iter().rposition(|head| head.step < from.max(1)).unwrap_or(0));
        let mut at = wanted.unwrap_or(begins.len().saturating_sub(1));
        while let Some(head) = begins.get(at) {
            batches.clear();
            tail = self.read_batches(
                head.after,
                |batch| {
                    last = Some(batch.step);
                    let beyond = batch.step > to || (from.is_some() && batches.len() >= limit);
                    if beyond {
                        return ControlFlow::Break(());
                    }
                    if from.is_none_or(|from| batch.step >= from) {
                        batches.push_back(batch);
                        if batches.len() > limit {
                            batches.pop_front();
                        }
                    }
                    ControlFlow::Continue(())
                },
                &words,
                in_words,
            )?;
            if from.is_some() || batches.len() >= limit || at == 0 {
                break;
            }
            at -= 1;
        }
        // Beyond damage there may be what was asked for.
        if let (Some(asked), Some(last)) = (from, last.or(begins.last().map(|head| head.step)))
            && asked > last
            && !matches!(tail, Tail::Damaged { .. })
        {
            return Err(PastError::Beyond { path: self.path(), asked, last });
        }
        Ok((batches.into(), tail))
    }

    fn read_batches(
        &self,
        after: Place,
        mut take: impl FnMut(Batch) -> ControlFlow<()>,
        words: &Wording,
        in_words: bool,
    ) -> Result<Tail, PastError> {
        let end = journal::read::<PastError>(&*self.storage, after, |shown| {
            let record = self.record(&shown)?;
            Ok(match Batch::of(&*self.storage, &shown, record, words, in_words) {
                Some(batch) => take(batch),
                None => ControlFlow::Continue(()),
            })
        });
        match end {
            Ok(end) => Ok(match end.torn {
                None => Tail::Whole,
                Some((file, offset)) => Tail::Torn { file, offset: offset as u64 },
            }),
            Err(PastError::Store(error)) if error.is_damage() => {
                Ok(Tail::Damaged { problem: damage_text(&error) })
            }
            Err(error) => Err(error),
        }
    }

    /// The newest vocabulary that can be found. The name of a number never changes, so the newest vocabulary is right for all of
    /// the past.
    fn words(&self) -> Result<Wording, PastError> {
        let newest = snapshot::search(&*self.storage, None)?.sound;
        let newest = newest.map(|(whole, place)| (whole.content.vocabulary, place));
        let (mut vocabulary, from) = newest.unwrap_or_default();
        let known = Arc::make_mut(&mut vocabulary);
        let read = journal::read::<PastError>(&*self.storage, from, |shown| {
            let Record::Batch { effects, .. } = self.record(&shown)? else {
                return Ok(ControlFlow::Continue(()));
            };
            for effect in effects {
                match effect {
                    // A declaration that is refused is not in the memory either.
                    Effect::Declared(declaration) => drop(known.declare(&(*declaration).live())),
                    Effect::DeclaredValues(declaration) => drop(known.declare(&(*declaration).live())),
                    Effect::SymbolsMet(symbols) => known.meet(&symbols),
                    _ => (),
                }
            }
            Ok(ControlFlow::Continue(()))
        });
        if let Err(error) = read {
            tracing::debug!(%error, "names are known only up to the damage");
        }
        Ok(Wording(vocabulary))
    }
}

/// The head of the segment that begins with frame `first`, if it is sound.
fn beginning(storage: &dyn Storage, first: u64) -> io::Result<Option<SegmentHead>> {
    let mut bytes = Vec::new();
    let length = (HEAD_LEN + FILE_HEAD_LEN) as u64;
    io::Read::read_to_end(&mut io::Read::take(storage.open(&segment_name(first))?, length), &mut bytes)?;
    let Some(found) = frame::read(SEGMENT, &bytes).filter(|found| found.head.number == first) else {
        return Ok(None);
    };
    let step = read_file_head(found.payload).and_then(|(_, step)| step);
    let after = Place { number: first.saturating_sub(1), crc: found.head.previous };
    Ok(step.map(|step| SegmentHead { first, after, step }))
}
