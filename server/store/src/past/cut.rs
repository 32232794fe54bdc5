//! Cutting a data directory, and copying a part of it into a directory of its own. Files are copied and cut; the frames in
//! them stay as they are.

use std::io::{self, Read};

use super::error::PastError;
use crate::durable;
use crate::error::StoreError;
use crate::journal::{self, segment_name};
use crate::manifest::{self, Manifest};
use crate::snapshot::{self, DIRECTORIES, DIRECTORIES_AND_ROOT};
use crate::storage::Storage;

/// So many bytes are copied at a time.
const PIECE_BYTES: usize = 1024 * 1024;

/// Where a journal is to end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Cut {
    /// The last frame that stays.
    pub(super) frame: u64,
    /// The segment that this frame is in; none when no segment stays.
    pub(super) segment: Option<u64>,
    /// So many bytes of that segment stay.
    pub(super) bytes: u64,
}

impl Cut {
    fn keeps(&self, segment: u64) -> bool {
        self.segment.is_some_and(|last| segment <= last)
    }

    /// How many bytes of a segment stay; none when all of it stays.
    fn length(&self, segment: u64) -> Option<u64> {
        (self.segment == Some(segment)).then_some(self.bytes)
    }
}

/// Copies the part of `from` that ends with `cut` into `to`, which is empty. `usable` says which snapshots go with it. The
/// manifest is written last: a directory without a manifest is no memory, so neither is a copy that was not finished.
pub(super) fn copy(
    from: &dyn Storage,
    to: &dyn Storage,
    manifest: &Manifest,
    cut: Cut,
    usable: impl Fn(u64) -> bool,
) -> Result<(), PastError> {
    durable::create_all(to, &DIRECTORIES)?;
    for first in segments(from)?.into_iter().filter(|first| cut.keeps(*first)) {
        copy_file(from, to, &segment_name(first), cut.length(first))?;
    }
    for number in
        snapshot::numbers(from)?.into_iter().filter(|number| *number <= cut.frame && usable(*number))
    {
        copy_file(from, to, &snapshot::name(number), None)?;
    }
    durable::sync_all(to, &DIRECTORIES_AND_ROOT)?;
    Ok(manifest::write(to, manifest)?)
}

/// Cuts `storage` so that it ends with `cut`. Done again after an interruption, it does the rest. At no moment does the
/// directory say more than before, and no file that stays is ever missing.
pub(super) fn cut(storage: &dyn Storage, cut: Cut, usable: impl Fn(u64) -> bool) -> Result<(), PastError> {
    let failed = |what, name: &str| StoreError::disk(what, storage.path(name));
    // From the end back, so that the segments that are left are always a journal that ends early.
    for first in segments(storage)?.into_iter().rev().filter(|first| !cut.keeps(*first)) {
        let name = segment_name(first);
        storage.remove(&name).map_err(failed("remove", &name))?;
        storage.sync_directory(journal::DIRECTORY).map_err(failed("make durable", journal::DIRECTORY))?;
    }
    if let Some(first) = cut.segment {
        let name = segment_name(first);
        if storage.size(&name).map_err(failed("read", &name))? > cut.bytes {
            storage.truncate(&name, cut.bytes).map_err(failed("cut", &name))?;
            storage.sync(&name).map_err(failed("make durable", &name))?;
        }
    }
    for number in
        snapshot::numbers(storage)?.into_iter().filter(|number| *number > cut.frame || !usable(*number))
    {
        let name = snapshot::name(number);
        storage.remove(&name).map_err(failed("remove", &name))?;
    }
    Ok(storage.sync_directory(snapshot::DIRECTORY).map_err(failed("make durable", snapshot::DIRECTORY))?)
}

/// Copies every file of the directory, and makes the copies durable.
pub(super) fn copy_all(from: &dyn Storage, to: &dyn Storage, files: &[String]) -> Result<(), PastError> {
    durable::create_all(to, &DIRECTORIES)?;
    for name in files {
        copy_file(from, to, name, None)?;
    }
    Ok(durable::sync_all(to, &DIRECTORIES_AND_ROOT)?)
}

/// The names of all files of a data directory, but for the lock and temporary files.
pub(super) fn files(storage: &dyn Storage) -> Result<Vec<String>, PastError> {
    let mut files = Vec::new();
    if storage.size(manifest::FILE).is_ok() {
        files.push(manifest::FILE.to_owned());
    }
    for directory in DIRECTORIES {
        let listed = storage.list(directory).map_err(StoreError::disk("read", storage.path(directory)))?;
        files.extend(listed.into_iter().map(|name| format!("{directory}/{name}")));
    }
    Ok(files)
}

fn copy_file(
    from: &dyn Storage,
    to: &dyn Storage,
    name: &str,
    length: Option<u64>,
) -> Result<(), StoreError> {
    let reading = |error| StoreError::disk("read", from.path(name))(error);
    let writing = |error| StoreError::disk("write", to.path(name))(error);
    let mut source = from.open(name).map_err(reading)?.take(length.unwrap_or(u64::MAX));
    let mut target = to.create(name).map_err(writing)?;
    let (mut at, mut piece) = (0, vec![0; PIECE_BYTES]);
    loop {
        let read = match source.read(&mut piece) {
            Ok(0) => break,
            Ok(read) => read,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(error) => return Err(reading(error)),
        };
        target.write_at(piece.get(..read).unwrap_or_default(), at).map_err(writing)?;
        at += read as u64;
    }
    target.sync().map_err(|error| StoreError::disk("make durable", to.path(name))(error))
}

/// The first frames of all segments, in order.
pub(super) fn segments(storage: &dyn Storage) -> Result<Vec<u64>, StoreError> {
    journal::segments(storage).map_err(StoreError::disk("read", storage.path(journal::DIRECTORY)))
}
