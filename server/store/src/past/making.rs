//! Making data directories: of an export, or of a memory as it was at an earlier step.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use pschema_process::no_directory;

use super::cut::{self, Cut};
use super::error::PastError;
use super::export::Import;
use super::moment::Past;
use crate::durable;
use crate::error::StoreError;
use crate::format::v1::{Record, Setting};
use crate::frame::HEAD_LEN;
use crate::journal::{self, Journal, Place, Sizes};
use crate::manifest::{self, Manifest};
use crate::snapshot;
use crate::storage::{Directory, Storage};

/// A data directory that was made.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DataDirectory {
    /// Where it is.
    pub directory: String,
    /// The step that a daemon goes on from.
    pub step: u64,
    /// The digest of memory at that step.
    pub memory_digest: String,
}

/// Makes a data directory of an export. A daemon can go on from it; it has no past of its own.
///
/// # Errors
/// When `to` is not empty, or the disk fails.
pub fn import(imported: &Import, to: &Path) -> Result<DataDirectory, PastError> {
    let target = new_directory(to)?;
    let setting = Setting::new(&imported.parameters, &imported.curriculum);
    let (learner, mechanisms) = (imported.learner.clone(), Some(imported.content.mechanisms));
    let manifest = Manifest { learner, seed: imported.seed, mechanisms, setting: setting.clone() };
    durable::create_all(&target, &snapshot::DIRECTORIES)?;
    // Frame 1 is never written, so that nobody takes this for the journal of a memory from its beginning.
    let base = Place { number: 1, crc: 0 };
    let digest = &imported.lines.memory_digest;
    let step = imported.content.step;
    snapshot::write(&target, &imported.content, &setting, base, digest, || false)?;
    let mut journal = Journal::after(Arc::new(target.clone()), base, Sizes::default());
    let record = crate::codec::encode(&Record::Mark { step }).map_err(StoreError::from)?;
    let written = journal.append(&record, step).and_then(|_| journal.end());
    written.map_err(StoreError::disk("write", target.path(journal::DIRECTORY)))?;
    durable::sync_all(&target, &snapshot::DIRECTORIES_AND_ROOT)?;
    manifest::write(&target, &manifest)?;
    sync_parent(to)?;
    Ok(DataDirectory { directory: to.display().to_string(), step, memory_digest: digest.clone() })
}

impl Past {
    /// Makes a data directory of the memory as it was after step `until`, with its past: the life of another learner can branch
    /// off there.
    ///
    /// # Errors
    /// When `to` is not empty, the step can't be returned to, or the disk fails.
    pub fn branch(&self, until: Option<u64>, to: &Path) -> Result<DataDirectory, PastError> {
        let moment = self.moment(until)?;
        let target = new_directory(to)?;
        let after = self.begins()?.first().map_or(Place::default(), |head| head.after);
        let mut end = None;
        journal::read::<PastError>(&*self.storage, after, |shown| {
            if shown.place.number > moment.frame {
                return Ok(ControlFlow::Break(()));
            }
            end = Some((shown.segment, (shown.offset + HEAD_LEN + shown.payload.len()) as u64));
            Ok(ControlFlow::Continue(()))
        })?;
        if end.is_none() {
            end = self.head_after(after)?;
        }
        let (segment, bytes) = end.map_or((None, 0), |(segment, bytes)| (Some(segment), bytes));
        let cut = Cut { frame: moment.frame, segment, bytes };
        cut::copy(&*self.storage, &target, &self.manifest, cut, |_| true)?;
        sync_parent(to)?;
        let (step, memory_digest) = (moment.step(), moment.memory_digest());
        Ok(DataDirectory { directory: to.display().to_string(), step, memory_digest })
    }
}

/// An empty directory, which is made if it isn't there.
pub(super) fn new_directory(path: &Path) -> Result<Directory, PastError> {
    let shown = path.display().to_string();
    let made = std::fs::create_dir_all(path).map_err(|error| no_directory(path, error));
    made.map_err(StoreError::disk("create", shown.clone()))?;
    let mut inside = std::fs::read_dir(path).map_err(StoreError::disk("read", shown.clone()))?;
    if inside.next().is_some() {
        return Err(PastError::Taken { path: shown });
    }
    Ok(Directory::new(path))
}

/// Makes the name of a directory durable.
pub(super) fn sync_parent(path: &Path) -> Result<(), PastError> {
    let path = path.canonicalize().map_err(StoreError::disk("find", path.display().to_string()))?;
    let Some(parent) = path.parent() else { return Ok(()) };
    let synced = Directory::new(parent).sync_directory("");
    Ok(synced.map_err(StoreError::disk("make durable", parent.display().to_string()))?)
}
