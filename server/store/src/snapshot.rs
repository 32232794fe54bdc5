//! Snapshots: memory whole, so that a start need not read the journal from its beginning.
//!
//! A snapshot is written beside its place, made durable, read back and compared, and only then takes its place. The two
//! newest are kept; what one says and the other does not, the journal between them does.

use std::io;

use pschema_learner::digest::digest;
use pschema_learner::memory::Content;

use crate::codec;
use crate::error::StoreError;
use crate::format::VERSION;
use crate::format::v1::{Block, Reading, blocks};
use crate::frame::{self, Head, SNAPSHOT};
use crate::journal::{self, Place, segment_name};
use crate::storage::Storage;

/// Where snapshots are.
pub(crate) const DIRECTORY: &str = "snapshot";
const SUFFIX: &str = ".snapshot";
/// `PSsn`: what begins a snapshot.
const BEGIN: u32 = u32::from_le_bytes(*b"PSsn");
/// Snapshots kept.
const KEPT: usize = 2;

fn name(number: u64) -> String {
    format!("{DIRECTORY}/{number:020}{SUFFIX}")
}

/// The frames after which there are snapshots, in order.
fn numbers(storage: &dyn Storage) -> io::Result<Vec<u64>> {
    let number = |name: &String| name.strip_suffix(SUFFIX)?.parse().ok();
    Ok(storage.list(DIRECTORY)?.iter().filter_map(number).collect())
}

/// Writes `content`, which is memory as it is after frame `place`; that frame is durable.
pub(crate) fn write(storage: &dyn Storage, content: &Content, place: Place) -> Result<(), StoreError> {
    let (kept, temporary) = (name(place.number), format!("{DIRECTORY}/writing.tmp"));
    let disk = |what| StoreError::disk(what, storage.path(&temporary));
    let expected = digest(content);
    let mut file = storage.create(&temporary).map_err(disk("create"))?;
    let mut at = 0;
    let mut previous = place.crc;
    let mut put = |magic, number, payload: &[u8]| -> Result<(), StoreError> {
        let head = Head { number, durable: place.number, previous };
        let (bytes, crc) = frame::written(magic, head, payload);
        file.write_at(&bytes, at).map_err(disk("write"))?;
        at += bytes.len() as u64;
        previous = crc;
        Ok(())
    };
    put(BEGIN, place.number, &VERSION.to_le_bytes())?;
    let end = std::iter::once(Block::End { digest: expected.clone() });
    for (number, block) in (1..).zip(blocks(content).chain(end)) {
        put(SNAPSHOT, number, &codec::encode(&block)?)?;
    }
    file.sync().map_err(disk("make durable"))?;
    drop(file);
    let bytes = storage.read(&temporary).map_err(disk("read back"))?;
    let back = read(&bytes).filter(|(content, found)| *found == place && digest(content) == expected);
    if back.is_none() {
        return Err(disk("read back")(io::Error::other("it is not what was written")));
    }
    storage.rename(&temporary, &kept).map_err(disk("rename"))?;
    storage.sync_directory(DIRECTORY).map_err(disk("make durable"))?;
    tidy(storage)
}

/// Removes all but the newest snapshots, and of the journal what only the others needed.
fn tidy(storage: &dyn Storage) -> Result<(), StoreError> {
    let disk = |name: &str| StoreError::disk("remove", storage.path(name));
    let numbers = numbers(storage).map_err(disk(DIRECTORY))?;
    let Some(first_kept) = numbers.len().checked_sub(KEPT) else { return Ok(()) };
    for number in numbers.iter().take(first_kept) {
        storage.remove(&name(*number)).map_err(disk(&name(*number)))?;
    }
    let oldest = numbers.get(first_kept).copied().unwrap_or(0);
    let firsts = journal::segments(storage).map_err(disk(journal::DIRECTORY))?;
    for pair in firsts.windows(2) {
        // The one before is needed no more when the next begins at or before what the oldest snapshot goes on with.
        if let [first, next] = pair
            && *next <= oldest
        {
            storage.remove(&segment_name(*first)).map_err(disk(&segment_name(*first)))?;
        }
    }
    Ok(())
}

/// The newest snapshot that is sound, and the frame that it was made after; none when there is none at all.
pub(crate) fn newest(storage: &dyn Storage) -> Result<Option<(Content, Place)>, StoreError> {
    let numbers = numbers(storage).map_err(StoreError::disk("read", storage.path(DIRECTORY)))?;
    for number in numbers.iter().rev() {
        let file = name(*number);
        let bytes = storage.read(&file).map_err(StoreError::disk("read", storage.path(&file)))?;
        match read(&bytes) {
            Some((content, place)) if place.number == *number => return Ok(Some((content, place))),
            _ => tracing::error!(file = storage.path(&file), "the snapshot is damaged; an older one is used"),
        }
    }
    // Without any, the journal must begin at its beginning: it says so itself if it does not.
    Ok(None)
}

/// What a snapshot says, if all of it is sound.
fn read(bytes: &[u8]) -> Option<(Content, Place)> {
    let begin = frame::read(BEGIN, bytes)?;
    if begin.payload != VERSION.to_le_bytes() {
        return None;
    }
    let place = Place { number: begin.head.number, crc: begin.head.previous };
    let (mut at, mut previous) = (begin.len(), begin.crc);
    let mut reading: Option<Reading> = None;
    for number in 1.. {
        let found = frame::read(SNAPSHOT, bytes.get(at..)?)?;
        if found.head.number != number || found.head.previous != previous {
            return None;
        }
        (at, previous) = (at + found.len(), found.crc);
        match (codec::decode(found.payload).ok()?, &mut reading) {
            (Block::Facts(facts), None) => reading = Some(Reading::begin(*facts).ok()?),
            (Block::Observations(remembered), Some(reading)) => reading.observations(remembered).ok()?,
            (Block::Schemas(schemas), Some(reading)) => reading.schemas(schemas).ok()?,
            (Block::End { digest: written }, Some(_)) => {
                let content = reading.take()?.end().ok()?;
                return (at == bytes.len() && digest(&content) == written).then_some((content, place));
            }
            _ => return None,
        }
    }
    None
}
