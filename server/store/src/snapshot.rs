//! Snapshots: memory whole, so that a start need not read the journal from its beginning.
//!
//! A snapshot is written beside its place, made durable, read back and compared, and only then takes its place. The two
//! newest are kept; what one says and the other does not, the journal between them does.

use std::io::{self, Read};

use pschema_learner::digest::digest;
use pschema_learner::memory::Content;

use crate::codec::{self, VALUE_BYTES_MAX};
use crate::error::StoreError;
use crate::format::VERSION;
use crate::format::v1::{Block, Reading, Setting, Whole, blocks};
use crate::frame::{self, Found, HEAD_LEN, Head, SNAPSHOT};
use crate::journal::{Place, file_head, read_file_head};
use crate::storage::Storage;

/// Where snapshots are.
pub(crate) const DIRECTORY: &str = "snapshot";
const SUFFIX: &str = ".snapshot";
/// Where one is while it is written.
pub(crate) const TEMPORARY: &str = "snapshot/writing.tmp";
/// `PSsn`: what begins a snapshot.
pub(crate) const BEGIN: u32 = u32::from_le_bytes(*b"PSsn");
/// So much is written at a time, and made durable, so that the journal never waits for more than that.
const PORTION_BYTES: usize = 512 * 1024;

/// The file name of the snapshot made after frame `number`.
pub(crate) fn name(number: u64) -> String {
    format!("{DIRECTORY}/{number:020}{SUFFIX}")
}

/// The frames after which there are snapshots, in order.
pub(crate) fn numbers(storage: &dyn Storage) -> io::Result<Vec<u64>> {
    let number = |name: &String| {
        let digits = name.strip_suffix(SUFFIX).filter(|digits| digits.len() == 20)?;
        digits.parse().ok()
    };
    Ok(storage.list(DIRECTORY)?.iter().filter_map(number).collect())
}

/// Writes `content`, which is memory as it is after frame `place`; that frame is durable. `expected` is its digest. Returns
/// how long the file is; nothing when it was given up, after which nothing was changed.
pub(crate) fn write(
    storage: &dyn Storage,
    content: &Content,
    setting: &Setting,
    place: Place,
    expected: &str,
    given_up: impl Fn() -> bool,
) -> Result<Option<u64>, StoreError> {
    let disk = |what| StoreError::disk(what, storage.path(TEMPORARY));
    let mut file = storage.create(TEMPORARY).map_err(disk("create"))?;
    let (mut at, mut portion) = (0, Vec::with_capacity(PORTION_BYTES));
    let mut previous = place.crc;
    let mut put = |magic, number, payload: &[u8], last| -> Result<(), StoreError> {
        let head = Head { number, durable: place.number, previous };
        let (bytes, crc) = frame::written(magic, head, payload);
        portion.extend_from_slice(&bytes);
        previous = crc;
        if last || portion.len() >= PORTION_BYTES {
            file.write_at(&portion, at).map_err(disk("write"))?;
            file.sync().map_err(disk("make durable"))?;
            at += portion.len() as u64;
            portion.clear();
        }
        Ok(())
    };
    put(BEGIN, place.number, &file_head(content.step), false)?;
    let end = std::iter::once(Block::End { digest: expected.to_owned() });
    for (number, block) in (1..).zip(blocks(content, setting).chain(end)) {
        if given_up() {
            return Ok(None);
        }
        put(SNAPSHOT, number, &codec::encode(&block)?, matches!(block, Block::End { .. }))?;
    }
    drop(file);
    let back = read(storage, TEMPORARY).map_err(disk("read back"))?;
    if !back.is_some_and(|(whole, found)| found == place && digest(&whole.content) == expected) {
        return Err(disk("read back")(io::Error::other("it is not what was written")));
    }
    storage.rename(TEMPORARY, &name(place.number)).map_err(disk("rename"))?;
    storage.sync_directory(DIRECTORY).map_err(disk("make durable"))?;
    Ok(Some(at))
}

/// The newest snapshot that is sound and not after step `until`, and the frame that it was made after; none when there
/// is none at all.
pub(crate) fn newest(
    storage: &dyn Storage,
    until: Option<u64>,
) -> Result<Option<(Whole, Place)>, StoreError> {
    Ok(search(storage, until)?.sound)
}

/// What a search for the newest sound snapshot found.
#[derive(Debug)]
pub(crate) struct Search {
    pub(crate) sound: Option<(Whole, Place)>,
    /// The numbers of newer ones that are damaged or can't be read.
    pub(crate) damaged: Vec<u64>,
}

/// As [`newest`], and what was passed over.
pub(crate) fn search(storage: &dyn Storage, until: Option<u64>) -> Result<Search, StoreError> {
    let numbers = numbers(storage).map_err(StoreError::disk("read", storage.path(DIRECTORY)))?;
    let mut damaged = Vec::new();
    for number in numbers.iter().rev() {
        let file = name(*number);
        let found = match (until, step(storage, *number)) {
            (Some(until), Ok(Some(step))) if step > until => continue,
            (_, Err(error)) => Err(error),
            _ => sound(storage, *number),
        };
        // A disk that can't read one snapshot may well read the one before.
        match found {
            Ok(Some(found)) => return Ok(Search { sound: Some(found), damaged }),
            Ok(None) => {
                tracing::error!(file = storage.path(&file), "the snapshot is damaged; an older one is used")
            }
            Err(error) => {
                tracing::error!(file = storage.path(&file), %error, "the snapshot can't be read; an older one is used")
            }
        }
        damaged.push(*number);
    }
    // Without any, the journal must begin at its beginning: it says so itself if it does not.
    Ok(Search { sound: None, damaged })
}

/// The step that a snapshot was made at, if its beginning is sound and its version ours.
pub(crate) fn step(storage: &dyn Storage, number: u64) -> io::Result<Option<u64>> {
    let mut frames = Frames { file: storage.open(&name(number))?, bytes: Vec::new() };
    Ok(frames.next(BEGIN)?.and_then(|begin| read_file_head(begin.payload)?.1))
}

/// The snapshot made after frame `number`, if all of it is sound and its content has the digest that it says.
pub(crate) fn sound(storage: &dyn Storage, number: u64) -> io::Result<Option<(Whole, Place)>> {
    let found = read(storage, &name(number))?;
    Ok(found.filter(|(_, place)| place.number == number))
}

/// Frames of a file, one at a time, so that a snapshot never is in memory whole.
struct Frames {
    file: Box<dyn Read>,
    bytes: Vec<u8>,
}

impl Frames {
    fn next(&mut self, magic: u32) -> io::Result<Option<Found<'_>>> {
        self.bytes.clear();
        let head = HEAD_LEN as u64;
        (&mut self.file).take(head).read_to_end(&mut self.bytes)?;
        let Some(length) = frame::length(&self.bytes).filter(|length| *length <= VALUE_BYTES_MAX) else {
            return Ok(None);
        };
        (&mut self.file).take(length as u64).read_to_end(&mut self.bytes)?;
        Ok(frame::read(magic, &self.bytes))
    }

    fn is_over(&mut self) -> io::Result<bool> {
        Ok(self.file.read(&mut [0])? == 0)
    }
}

fn read(storage: &dyn Storage, file: &str) -> io::Result<Option<(Whole, Place)>> {
    let mut frames = Frames { file: storage.open(file)?, bytes: Vec::new() };
    let Some(begin) = frames.next(BEGIN)? else { return Ok(None) };
    if read_file_head(begin.payload).is_none_or(|(version, _)| version != VERSION) {
        return Ok(None);
    }
    let place = Place { number: begin.head.number, crc: begin.head.previous };
    let mut previous = begin.crc;
    let mut reading: Option<Reading> = None;
    for number in 1.. {
        let Some(found) = frames.next(SNAPSHOT)? else { return Ok(None) };
        if found.head.number != number || found.head.previous != previous {
            return Ok(None);
        }
        previous = found.crc;
        let Ok(block) = codec::decode(found.payload) else { return Ok(None) };
        match (block, reading.take()) {
            (Block::Facts(facts), None) => reading = Some(Reading::begin(*facts)),
            (Block::End { digest: written }, Some(read)) => {
                let Ok(whole) = read.end() else { return Ok(None) };
                let sound = frames.is_over()? && digest(&whole.content) == written;
                return Ok(sound.then_some((whole, place)));
            }
            (block, Some(mut read)) => {
                if read.take(block).is_err() {
                    return Ok(None);
                }
                reading = Some(read);
            }
            (_, None) => return Ok(None),
        }
    }
    Ok(None)
}
