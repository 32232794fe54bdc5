//! The journal: the changes of memory in order, in segments that are named by their first frame.
//!
//! Frames are numbered from 1 without a gap, and each has the crc of the frame before: a journal is a chain. Each frame also
//! says which frame was known to be durable when it was written. So a frame that was torn while it was being written can be told
//! from one that was damaged after it was acknowledged.

use std::io;
use std::ops::ControlFlow;
use std::sync::Arc;

use crate::format::VERSION;
use crate::frame::{self, Head, JOURNAL, SoundFrame};
use crate::storage::{OpenFile, Storage};

/// The directory of the segments.
pub(crate) const DIRECTORY: &str = "journal";
const SUFFIX: &str = ".journal";
/// `PSjs`: the magic number of the frame that begins a segment.
pub(crate) const SEGMENT: u32 = u32::from_le_bytes(*b"PSjs");

/// How long segments get, in bytes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sizes {
    /// Another segment is begun before one would get longer than this.
    pub(crate) segment_max: u64,
    /// So many zeros are written ahead at a time, so that a frame seldom makes its file longer.
    pub(crate) ahead: u64,
}

impl Default for Sizes {
    fn default() -> Self {
        Self { segment_max: 64 * 1024 * 1024, ahead: 1024 * 1024 }
    }
}

/// The file name of the segment that begins with frame `first`.
pub(crate) fn segment_name(first: u64) -> String {
    format!("{DIRECTORY}/{first:020}{SUFFIX}")
}

fn segment_first(name: &str) -> Option<u64> {
    let digits = name.strip_suffix(SUFFIX).filter(|digits| digits.len() == 20)?;
    digits.parse().ok()
}

/// The numbers of the first frames of all segments, in order.
pub(crate) fn segments(storage: &dyn Storage) -> io::Result<Vec<u64>> {
    Ok(storage.list(DIRECTORY)?.iter().filter_map(|name| segment_first(name)).collect())
}

/// A place in the chain: after frame `number`, whose crc is `crc`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Place {
    pub(crate) number: u64,
    pub(crate) crc: u32,
}

#[derive(Debug)]
struct Segment {
    first: u64,
    file: Box<dyn OpenFile>,
    end: u64,
    zeroed: u64,
}

/// A segment that nothing is written to any more.
#[derive(Debug)]
struct ClosedSegment {
    first: u64,
    bytes: u64,
}

/// The journal, to be written.
#[derive(Debug)]
pub(crate) struct Journal {
    storage: Arc<dyn Storage>,
    sizes: Sizes,
    last: Place,
    durable: u64,
    segment: Option<Segment>,
    /// The segments before it that the next start needs, and perhaps some that it no longer needs.
    closed: Vec<ClosedSegment>,
    /// Bytes that were appended since the journal was opened.
    written: u64,
}

impl Journal {
    /// Goes on after `last`, which is durable, in a segment of its own. The segment is made with its first frame.
    pub(crate) fn after(storage: Arc<dyn Storage>, last: Place, sizes: Sizes) -> Self {
        Self { storage, sizes, last, durable: last.number, segment: None, closed: Vec::new(), written: 0 }
    }

    /// Notes the segments that a start read, whose first frames are `firsts`: the next start reads them too, until a newer snapshot
    /// makes them unnecessary.
    ///
    /// # Errors
    /// When one of them isn't there.
    pub(crate) fn read_before(&mut self, firsts: &[u64]) -> io::Result<()> {
        for first in firsts.iter().copied() {
            self.closed.push(ClosedSegment { first, bytes: self.storage.size(&segment_name(first))? });
        }
        Ok(())
    }

    /// The place after the last frame that was appended.
    pub(crate) fn last(&self) -> Place {
        self.last
    }

    /// How the journal is called in messages.
    pub(crate) fn path(&self) -> String {
        self.storage.path(DIRECTORY)
    }

    /// Bytes that were appended since the journal was opened.
    pub(crate) fn written(&self) -> u64 {
        self.written
    }

    /// Appends a frame, which is durable after [`Journal::sync`]. `step` is how many steps had been taken before the change that
    /// the frame records.
    // Never inlined, so that `tests/counts` can count its instructions by its name.
    #[inline(never)]
    pub(crate) fn append(&mut self, payload: &[u8], step: u64) -> io::Result<Place> {
        let head = Head { number: self.last.number + 1, durable: self.durable, previous: self.last.crc };
        let (bytes, crc) = frame::written(JOURNAL, head, payload);
        let length = bytes.len() as u64;
        let full = self.segment.as_ref().is_none_or(|segment| segment.end + length > self.sizes.segment_max);
        if full {
            // A segment says that everything before it is durable.
            self.sync()?;
            self.begin_segment(step)?;
        }
        let Some(segment) = &mut self.segment else { return Err(io::Error::other("no segment")) };
        if segment.end + length > segment.zeroed {
            let to = segment.end + length + self.sizes.ahead;
            let zeros = vec![0; usize::try_from(to - segment.zeroed).unwrap_or(0)];
            segment.file.write_at(&zeros, segment.zeroed)?;
            segment.zeroed = to;
        }
        segment.file.write_at(&bytes, segment.end)?;
        segment.end += length;
        self.written += length;
        self.last = Place { number: head.number, crc };
        Ok(self.last)
    }

    /// Makes all appended frames durable. After an error nothing more may be appended.
    pub(crate) fn sync(&mut self) -> io::Result<()> {
        if let Some(segment) = &mut self.segment
            && self.durable < self.last.number
        {
            segment.file.sync()?;
        }
        self.durable = self.last.number;
        Ok(())
    }

    /// Whether all of the segments before the one that is being written are still there which the next start needs, as it begins
    /// from the snapshot made after frame `newest`.
    pub(crate) fn check_closed(&mut self, newest: Option<u64>) -> io::Result<()> {
        let wanted = newest.unwrap_or(0) + 1;
        let begun = self.closed.iter().map(|closed| closed.first);
        let begun = begun.chain(self.segment.as_ref().map(|segment| segment.first));
        let unnecessary = begun.filter(|first| *first <= wanted).count().saturating_sub(1);
        self.closed.drain(..unnecessary.min(self.closed.len()));
        self.closed
            .iter()
            .try_for_each(|closed| self.storage.is_whole(&segment_name(closed.first), closed.bytes))
    }

    /// Whether the segment that is being written is still where the next start looks for it, with all that was written.
    pub(crate) fn check(&self) -> io::Result<()> {
        self.segment.as_ref().map_or(Ok(()), |segment| segment.file.check())
    }

    /// Cuts off the zeros that were written ahead, for nothing is appended any more.
    pub(crate) fn end(&mut self) -> io::Result<()> {
        self.sync()?;
        self.end_segment()
    }

    fn end_segment(&mut self) -> io::Result<()> {
        let Some(Segment { first, end, zeroed, .. }) = self.segment.take() else { return Ok(()) };
        self.closed.push(ClosedSegment { first, bytes: end });
        if zeroed > end { self.storage.truncate(&segment_name(first), end) } else { Ok(()) }
    }

    fn begin_segment(&mut self, step: u64) -> io::Result<()> {
        self.end_segment()?;
        let first = self.last.number + 1;
        let head = Head { number: first, durable: self.last.number, previous: self.last.crc };
        let (mut bytes, _) = frame::written(SEGMENT, head, &file_head(step));
        let end = bytes.len() as u64;
        let zeroed = end + self.sizes.ahead;
        bytes.resize(usize::try_from(zeroed).unwrap_or(bytes.len()), 0);
        // One without a frame, of a daemon that was killed as it had begun it, is replaced.
        self.closed.retain(|closed| closed.first < first);
        let mut file = self.storage.create(&segment_name(first))?;
        file.write_at(&bytes, 0)?;
        file.sync()?;
        self.storage.sync_directory(DIRECTORY)?;
        self.segment = Some(Segment { first, file, end, zeroed });
        Ok(())
    }
}

/// Why a journal can't be read.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// There is no directory of the journal.
    #[error(
        "{directory} is missing, which holds every step since the last snapshot. Nothing was changed. Put it back from a \
         copy; if this memory never took a step, make an empty directory there"
    )]
    Gone {
        /// The directory of the journal.
        directory: String,
    },
    /// A frame that was acknowledged is damaged.
    #[error(
        "{file} is damaged at byte {offset}: frame {lost} and perhaps more after it can't be read, though frames up to \
         {claimed} were on disk and acted on. Nothing was changed. Put this data directory back from a copy; or `pschema repair \
         --dry-run` says what can be saved of it"
    )]
    Damaged {
        /// Which file.
        file: String,
        /// Where.
        offset: usize,
        /// The first frame that is lost.
        lost: u64,
        /// The last frame that is known to have been durable.
        claimed: u64,
    },
    /// A file is missing.
    #[error(
        "the journal of {directory} begins at frame {found}, and frame {wanted} is needed: a file is missing"
    )]
    Missing {
        /// Where.
        directory: String,
        /// The first frame there is; 0: there is none.
        found: u64,
        /// The first frame that is needed.
        wanted: u64,
    },
    /// A segment has a version that this release does not know.
    #[error("{file} has format {found}, and this release reads formats 1 to {VERSION}: use a newer release")]
    Version {
        /// Which file.
        file: String,
        /// The version that the segment has.
        found: u32,
    },
    /// The disk can't be read.
    #[error("cannot read {file}: {error}")]
    Read {
        /// Which file.
        file: String,
        /// Why.
        #[source]
        error: io::Error,
    },
}

/// Where a journal ends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct End {
    /// The last sound frame.
    pub(crate) last: Place,
    /// Where bytes follow that were never acknowledged: the file, and the place in it.
    pub(crate) torn: Option<(String, usize)>,
    /// The first frames of the segments that were read.
    pub(crate) segments: Vec<u64>,
    /// The length of the sound frames that were read, in bytes.
    pub(crate) bytes: u64,
    /// Where the last sound frame ends in the last segment.
    pub(crate) sound: u64,
}

/// A sound frame of the journal, and where it stands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JournalFrame<'a> {
    pub(crate) place: Place,
    pub(crate) payload: &'a [u8],
    pub(crate) segment: u64,
    pub(crate) offset: usize,
}

/// The length of the payload with which a segment and a snapshot begin, in bytes: the version, and how many steps had been
/// taken before the frames of the segment, or when the snapshot was made.
pub(crate) const FILE_HEAD_LEN: usize = 12;

pub(crate) fn file_head(step: u64) -> [u8; FILE_HEAD_LEN] {
    let mut head = [0; FILE_HEAD_LEN];
    let (version, steps) = head.split_at_mut(4);
    version.copy_from_slice(&VERSION.to_le_bytes());
    steps.copy_from_slice(&step.to_le_bytes());
    head
}

/// The version and the step; no step if this release does not know the version.
pub(crate) fn read_file_head(payload: &[u8]) -> Option<(u32, Option<u64>)> {
    let (version, rest) = payload.split_first_chunk()?;
    let version = u32::from_le_bytes(*version);
    if version != VERSION {
        return Some((version, None));
    }
    Some((version, Some(u64::from_le_bytes(rest.try_into().ok()?))))
}

/// Reads the frames after `from` in order, and hands each to `visit`, until `visit` has seen enough. Changes nothing.
///
/// Beside a daemon that writes, each segment is read as it was at that moment.
pub(crate) fn read<E: From<JournalError>>(
    storage: &dyn Storage,
    from: Place,
    mut visit: impl FnMut(JournalFrame<'_>) -> Result<ControlFlow<()>, E>,
) -> Result<End, E> {
    let failed = |name: &str| {
        let file = storage.path(name);
        |error| E::from(JournalError::Read { file, error })
    };
    let mut firsts = segments(storage).map_err(failed(DIRECTORY))?;
    if firsts.is_empty() && !storage.is_there(DIRECTORY) {
        return Err(JournalError::Gone { directory: storage.path(DIRECTORY) }.into());
    }
    let wanted = from.number + 1;
    let before = firsts.iter().rposition(|first| *first <= wanted);
    let begin = match before {
        Some(at) => at,
        None if firsts.is_empty() && from.number == 0 => 0,
        None => {
            let (directory, found) = (storage.path(DIRECTORY), firsts.first().copied().unwrap_or(0));
            // A first segment that was being made when power failed has no sound head, and nothing in it was acknowledged.
            return Err(JournalError::Missing { directory, found, wanted }.into());
        }
    };
    firsts.drain(..begin);
    let mut end = End { last: from, torn: None, segments: Vec::new(), bytes: 0, sound: 0 };
    let mut stopped: Option<(u64, usize)> = None;
    let mut claim: Option<u64> = None;
    for first in firsts {
        let name = segment_name(first);
        let mut bytes = storage.read(&name).map_err(failed(&name))?;
        let head = segment_head(&bytes, first);
        if let Some((_, version)) = head
            && version != VERSION
        {
            return Err(JournalError::Version { file: storage.path(&name), found: version }.into());
        }
        // A segment that was made after a torn end takes the place of that end, which then does not count.
        let goes_on = head.is_some_and(|(head, _)| {
            (end.segments.is_empty() && first <= end.last.number)
                || (first == end.last.number + 1 && head.previous == end.last.crc)
        });
        if goes_on && (claim.is_none() || claim.is_some_and(|claim| claim <= end.last.number)) {
            stopped = None;
            let at = head.map_or(0, |(head, _)| start(&bytes, head, &end, from));
            end.segments.push(first);
            let (mut at, mut enough) = chain(&bytes, at, first, &mut end, &mut visit)?;
            claim = claimed(bytes.get(at..).unwrap_or_default());
            while !enough && claim.is_some_and(|claim| claim > end.last.number) {
                // Beside a daemon that writes, later bytes may be read before earlier ones are there: look again.
                let again = storage.read(&name).map_err(failed(&name))?;
                if again == bytes {
                    break;
                }
                bytes = again;
                (at, enough) = chain(&bytes, at, first, &mut end, &mut visit)?;
                claim = claimed(bytes.get(at..).unwrap_or_default());
            }
            if enough {
                return Ok(end);
            }
            end.sound = at as u64;
            if bytes.get(at..).unwrap_or_default().iter().any(|byte| *byte != 0) {
                stopped = Some((first, at));
            }
        } else {
            stopped = stopped.or(Some((first, 0)));
            claim = claim.max(claimed(&bytes));
            if head.is_none() {
                // A head is durable before the first frame is written. So an unsound head before a sound frame was damaged
                // later.
                let frames = frame::scan(JOURNAL, &bytes).map(|(_, found)| found.head.number);
                claim = claim.max(frames.max());
            }
        }
    }
    if let Some((first, offset)) = stopped {
        let file = storage.path(&segment_name(first));
        if let Some(claimed) = claim.filter(|claim| *claim > end.last.number) {
            return Err(JournalError::Damaged { file, offset, lost: end.last.number + 1, claimed }.into());
        }
        end.torn = Some((file, offset));
    }
    Ok(end)
}

/// The head of a segment and the version it says, if it is sound and of this name.
fn segment_head(bytes: &[u8], first: u64) -> Option<(Head, u32)> {
    let found = frame::read(SEGMENT, bytes).filter(|found| found.head.number == first)?;
    Some((found.head, read_file_head(found.payload)?.0))
}

/// Where in a segment the chain goes on after `end`: right after the segment's head, or, in the first segment that is read,
/// after the frame that a snapshot was made at. Earlier frames are in the snapshot, whether they are sound here or not.
fn start(bytes: &[u8], head: Head, end: &End, from: Place) -> usize {
    let after_head = frame::HEAD_LEN + FILE_HEAD_LEN;
    if !end.segments.is_empty() || head.number == from.number + 1 {
        return after_head;
    }
    let follows =
        |found: &SoundFrame<'_>| found.head.number == from.number + 1 && found.head.previous == from.crc;
    let is_it = |found: &SoundFrame<'_>| found.head.number == from.number && found.crc == from.crc;
    for (at, found) in frame::scan(JOURNAL, bytes) {
        if follows(&found) {
            return at;
        }
        if is_it(&found) {
            return at + found.len();
        }
    }
    after_head
}

/// Follows the chain from `at`. Returns where it ends, and whether `visit` had seen enough.
fn chain<E>(
    bytes: &[u8],
    mut at: usize,
    segment: u64,
    end: &mut End,
    visit: &mut impl FnMut(JournalFrame<'_>) -> Result<ControlFlow<()>, E>,
) -> Result<(usize, bool), E> {
    while let Some(found) = bytes.get(at..).and_then(|rest| frame::read(JOURNAL, rest)) {
        if found.head.number != end.last.number + 1 || found.head.previous != end.last.crc {
            break;
        }
        let place = Place { number: found.head.number, crc: found.crc };
        if visit(JournalFrame { place, payload: found.payload, segment, offset: at })?.is_break() {
            return Ok((at, true));
        }
        end.last = place;
        end.bytes += found.len() as u64;
        at += found.len();
    }
    Ok((at, false))
}

/// The last frame of which a sound frame in `bytes` says that it was durable.
fn claimed(bytes: &[u8]) -> Option<u64> {
    let frames = frame::scan(JOURNAL, bytes).map(|(_, found)| found.head.durable);
    let heads = frame::scan(SEGMENT, bytes).map(|(_, found)| found.head.durable);
    frames.chain(heads).max()
}
