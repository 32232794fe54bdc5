//! Snapshots: the whole memory, so that a start need not read the journal from its beginning.
//!
//! A snapshot is written to a temporary file, made durable, read back and compared, and only then renamed. The two newest
//! snapshots are kept; should the newer one be damaged, the journal leads from the older one to the same memory.

use std::io::{self, Read};

use pschema_learner::digest::digest;
use pschema_learner::memory::Content;

use crate::codec::{self, VALUE_BYTES_MAX};
use crate::error::StoreError;
use crate::format::VERSION;
use crate::format::v1::{Assembly, End, Item, Setting, WholeMemory, items};
use crate::frame::{self, HEAD_LEN, Head, SNAPSHOT, SoundFrame};
use crate::journal::{self, Place, file_head, read_file_head};
use crate::storage::{OpenFile, Storage};

/// The directory of the snapshots.
pub(crate) const DIRECTORY: &str = "snapshot";
/// The directories in a data directory.
pub(crate) const DIRECTORIES: [&str; 2] = [journal::DIRECTORY, DIRECTORY];
/// The same and the data directory itself: all in which files come and go.
pub(crate) const DIRECTORIES_AND_ROOT: [&str; 3] = [journal::DIRECTORY, DIRECTORY, ""];
const SUFFIX: &str = ".snapshot";
/// The file of a snapshot that is being written.
pub(crate) const TEMPORARY: &str = "snapshot/writing.tmp";
/// `PSsn`: the magic number of the frame that begins a snapshot.
pub(crate) const BEGIN: u32 = u32::from_le_bytes(*b"PSsn");
/// A block has as many items as fit into so many bytes, and at least one.
const BLOCK_BYTES: usize = 16 * 1024;
/// So many bytes are written and made durable at a time, so that the journal never waits longer for the disk.
const PORTION_BYTES: usize = 512 * 1024;

/// The file name of the snapshot made after frame `number`.
pub(crate) fn name(number: u64) -> String {
    format!("{DIRECTORY}/{number:020}{SUFFIX}")
}

/// The numbers of all snapshots, which are those of the frames that they were made after, in order.
pub(crate) fn numbers(storage: &dyn Storage) -> Result<Vec<u64>, StoreError> {
    let number = |name: &String| {
        let digits = name.strip_suffix(SUFFIX).filter(|digits| digits.len() == 20)?;
        digits.parse().ok()
    };
    let names = storage.list(DIRECTORY).map_err(StoreError::disk("read", storage.path(DIRECTORY)))?;
    Ok(names.iter().filter_map(number).collect())
}

/// Makes sure that the snapshot made after frame `newest` is still where the next start looks for it, for the journal before it may
/// be gone. Where there is none yet, nothing was lost with the directory, which is made again.
pub(crate) fn check(storage: &dyn Storage, newest: Option<u64>) -> io::Result<()> {
    let Some(number) = newest else {
        if storage.is_there(DIRECTORY) {
            return Ok(());
        }
        tracing::warn!(
            directory = storage.path(DIRECTORY),
            "the empty directory was removed, and is made again"
        );
        return storage.directory(DIRECTORY);
    };
    storage.is_whole(&name(number), 0)
}

/// Writes `content`, which is memory as it is after frame `place`; that frame is durable. `expected` is the digest of
/// `content`. Returns the length of the file in bytes; none when `given_up` said so, and then nothing was changed.
pub(crate) fn write(
    storage: &dyn Storage,
    content: &Content,
    setting: &Setting,
    place: Place,
    expected: &str,
    given_up: impl Fn() -> bool,
) -> Result<Option<u64>, StoreError> {
    let disk = |what| StoreError::disk(what, storage.path(TEMPORARY));
    let mut blocks = BlockWriter {
        file: storage.create(TEMPORARY).map_err(disk("create"))?,
        path: storage.path(TEMPORARY),
        durable: place.number,
        previous: place.crc,
        blocks: 0,
        block: Vec::with_capacity(BLOCK_BYTES),
        portion: Vec::with_capacity(PORTION_BYTES),
        written: 0,
    };
    blocks.frame(BEGIN, place.number, &file_head(content.step));
    let mut count = 0;
    for item in items(content, setting) {
        if given_up() {
            return Ok(None);
        }
        blocks.item(&item)?;
        count += 1;
    }
    blocks.item(&Item::End(End { items: count, memory_digest: expected.to_owned() }))?;
    let bytes = blocks.end()?;
    let back = read(storage, TEMPORARY).map_err(disk("read back"))?;
    if !back.is_some_and(|(whole, found)| found == place && whole.memory_digest == expected) {
        return Err(disk("read back")(io::Error::other("it is not what was written")));
    }
    storage.rename(TEMPORARY, &name(place.number)).map_err(disk("rename"))?;
    storage.sync_directory(DIRECTORY).map_err(disk("make durable"))?;
    Ok(Some(bytes))
}

/// A snapshot that is being written.
struct BlockWriter {
    file: Box<dyn OpenFile>,
    /// How the file is called in messages.
    path: String,
    /// The last frame of the journal that is known to be durable.
    durable: u64,
    /// The crc of the frame before.
    previous: u32,
    blocks: u64,
    /// Items that are not in a block yet.
    block: Vec<u8>,
    /// Frames that are not in the file yet.
    portion: Vec<u8>,
    /// Bytes in the file.
    written: u64,
}

impl BlockWriter {
    fn item(&mut self, item: &Item) -> Result<(), StoreError> {
        let before = self.block.len();
        codec::encode_onto(item, &mut self.block)?;
        if before > 0 && self.block.len() > BLOCK_BYTES {
            let item = self.block.split_off(before);
            self.end_block()?;
            self.block = item;
        }
        Ok(())
    }

    fn end_block(&mut self) -> Result<(), StoreError> {
        let block = std::mem::take(&mut self.block);
        self.blocks += 1;
        self.frame(SNAPSHOT, self.blocks, &block);
        if self.portion.len() >= PORTION_BYTES { self.end_portion() } else { Ok(()) }
    }

    fn frame(&mut self, magic: u32, number: u64, payload: &[u8]) {
        let head = Head { number, durable: self.durable, previous: self.previous };
        let (bytes, crc) = frame::written(magic, head, payload);
        self.portion.extend_from_slice(&bytes);
        self.previous = crc;
    }

    fn end_portion(&mut self) -> Result<(), StoreError> {
        let disk = |what| StoreError::disk(what, self.path.clone());
        self.file.write_at(&self.portion, self.written).map_err(disk("write"))?;
        self.file.sync().map_err(disk("make durable"))?;
        self.written += self.portion.len() as u64;
        self.portion.clear();
        Ok(())
    }

    /// Writes everything that is left. Returns the length of the file in bytes.
    fn end(mut self) -> Result<u64, StoreError> {
        self.end_block()?;
        self.end_portion()?;
        Ok(self.written)
    }
}

/// What a search for the newest sound snapshot found: the snapshot, and the frame that it was made after.
#[derive(Debug)]
pub(crate) struct Search {
    pub(crate) sound: Option<(WholeMemory, Place)>,
    /// The numbers of newer snapshots, which are damaged or can't be read.
    pub(crate) damaged: Vec<u64>,
}

/// Searches for the newest sound snapshot that was made at step `until` or before.
pub(crate) fn search(storage: &dyn Storage, until: Option<u64>) -> Result<Search, StoreError> {
    let mut damaged = Vec::new();
    for number in numbers(storage)?.iter().rev() {
        let file = name(*number);
        let found = match (until, step(storage, *number)) {
            (Some(until), Ok(Some(step))) if step > until => continue,
            (_, Err(error)) => Err(error),
            _ => sound(storage, *number),
        };
        // A disk that can't read one snapshot may well read another.
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
    // Without a snapshot the journal must reach back to the beginning; whoever reads it says so if it does not.
    Ok(Search { sound: None, damaged })
}

/// The step that a snapshot was made at, if its first frame is sound and this release knows its version.
pub(crate) fn step(storage: &dyn Storage, number: u64) -> io::Result<Option<u64>> {
    let mut frames = Frames { file: storage.open(&name(number))?, bytes: Vec::new() };
    Ok(frames.next(BEGIN)?.and_then(|begin| read_file_head(begin.payload)?.1))
}

/// The snapshot made after frame `number`, if all of it is sound and its content has the digest that it says.
pub(crate) fn sound(storage: &dyn Storage, number: u64) -> io::Result<Option<(WholeMemory, Place)>> {
    let found = read(storage, &name(number))?;
    Ok(found.filter(|(_, place)| place.number == number))
}

/// Frames of a file, one at a time, so that the bytes of a snapshot are never all in memory.
struct Frames {
    file: Box<dyn Read>,
    bytes: Vec<u8>,
}

impl Frames {
    fn next(&mut self, magic: u32) -> io::Result<Option<SoundFrame<'_>>> {
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

fn read(storage: &dyn Storage, file: &str) -> io::Result<Option<(WholeMemory, Place)>> {
    let mut frames = Frames { file: storage.open(file)?, bytes: Vec::new() };
    let Some(begin) = frames.next(BEGIN)? else { return Ok(None) };
    if read_file_head(begin.payload).is_none_or(|(version, _)| version != VERSION) {
        return Ok(None);
    }
    let place = Place { number: begin.head.number, crc: begin.head.previous };
    let mut previous = begin.crc;
    let mut assembly: Option<Assembly> = None;
    for number in 1.. {
        let Some(block) = frames.next(SNAPSHOT)? else { return Ok(None) };
        if block.head.number != number || block.head.previous != previous {
            return Ok(None);
        }
        previous = block.crc;
        let Ok(end) = take_items(block.payload, &mut assembly) else { return Ok(None) };
        if let Some(end) = end {
            let whole = assembly.and_then(|assembly| assembly.end(end).ok());
            let over = frames.is_over()?;
            let whole = whole.filter(|whole| over && digest(&whole.content) == whole.memory_digest);
            return Ok(whole.map(|whole| (whole, place)));
        }
    }
    Ok(None)
}

/// Takes the items of a block. Returns the end of the memory if it is in the block.
fn take_items(mut items: &[u8], assembly: &mut Option<Assembly>) -> Result<Option<End>, StoreError> {
    while !items.is_empty() {
        let (item, rest) = codec::decode_first(items)?;
        items = rest;
        match (item, assembly.as_mut()) {
            (Item::End(end), _) if items.is_empty() => return Ok(Some(end)),
            (item, Some(assembly)) => assembly.take(item)?,
            (item, None) => *assembly = Some(Assembly::begin(item)?),
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use pschema_learner::effect::Effect;
    use pschema_learner::memory::Memory;
    use pschema_learner::parameters::Parameters;

    use super::*;
    use crate::tests::store::curriculum;
    use crate::tests::twin::Twin;

    /// Blocks are filled, none is longer than the limit but for one item that is, and what they hold comes back.
    #[test]
    fn items_are_divided_into_blocks() {
        let mut memory = Memory::new(1, Parameters::default());
        let mut symbols: Vec<String> = (0..9_000).map(|number| format!("symbol {number}")).collect();
        symbols.insert(4_000, "long".repeat(BLOCK_BYTES));
        memory.apply(&Effect::SymbolsMet(symbols)).unwrap();
        let (twin, content) = (Twin::new(), memory.content());
        let (setting, expected) = (Setting::new(memory.parameters(), &curriculum()), digest(content));
        let place = Place { number: 7, crc: 8 };
        let bytes = write(&twin, content, &setting, place, &expected, || false).unwrap().unwrap();
        let mut frames = Frames { file: twin.open(&name(7)).unwrap(), bytes: Vec::new() };
        let mut lengths = vec![frames.next(BEGIN).unwrap().unwrap().len()];
        while let Some(block) = frames.next(SNAPSHOT).unwrap() {
            lengths.push(block.len());
        }
        assert_eq!(lengths.iter().sum::<usize>() as u64, bytes);
        assert_eq!(
            lengths.iter().filter(|length| **length > BLOCK_BYTES + HEAD_LEN).count(),
            1,
            "{lengths:?}"
        );
        assert!(lengths.len() > 6, "{lengths:?}");
        let (whole, found) = sound(&twin, 7).unwrap().unwrap();
        assert_eq!((digest(&whole.content), found, whole.setting), (expected, place, setting));
    }
}
