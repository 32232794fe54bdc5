//! Mending a damaged data directory: finding the longest sound part of it, and cutting away the rest. Nothing is cut before
//! the whole directory has been copied aside.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use super::cut::{self, Cut};
use super::error::{PastError, READ_AGAIN_MAX, beside, damage_text};
use super::making::{new_directory, sync_parent};
use super::moment::Past;
use crate::durable;
use crate::error::StoreError;
use crate::frame::{self, HEAD_LEN, Head};
use crate::journal::{self, FILE_HEAD_LEN, Place, SEGMENT, file_head, segment_name};
use crate::lock;
use crate::recovery::{Replay, unplayable};
use crate::snapshot;
use crate::storage::{Directory, Storage};

/// What is damaged in a directory, and what can be saved of it.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RepairPlan {
    /// The directory.
    pub directory: String,
    /// Each damage; nothing is to be done when there is none.
    pub damage: Vec<String>,
    /// The last step that can be saved.
    pub saved_step: u64,
    /// The digest of memory after that step.
    pub memory_digest: String,
    /// The last step that is known to have been taken; above `saved_step` when steps are lost.
    pub last_step: u64,
    /// The first step that could be returned to if nothing were damaged.
    pub first_step: u64,
    /// The first step that can be returned to after the repair.
    pub saved_first_step: u64,
    #[serde(skip)]
    plan: Remainder,
}

/// What a repair has done.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RepairOutcome {
    /// The directory that holds the saved part.
    pub directory: String,
    /// The copy of the directory as it was before; none when the directory itself was left as it was.
    pub aside: Option<String>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Remainder {
    cut: Cut,
    /// The numbers of the sound snapshots.
    sound: Vec<u64>,
    /// Where the saved part begins, when the journal before it does not lead to it.
    base: Option<Base>,
}

/// A snapshot after which the journal begins anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Base {
    place: Place,
    step: u64,
    /// The segment in which the journal goes on after it, and the place there; none when it does not go on.
    rest: Option<(u64, u64)>,
}

impl Remainder {
    fn usable(&self, snapshot: u64) -> bool {
        self.sound.contains(&snapshot) && self.base.is_none_or(|base| snapshot >= base.place.number)
    }
}

/// How far a journal can be followed.
struct Trail {
    last: Place,
    /// The segment of the last frame, and where it ends there.
    end: Option<(u64, u64)>,
    damage: Option<String>,
}

impl Past {
    /// Finds out what is damaged and what can be saved. Changes nothing.
    ///
    /// # Errors
    /// When the directory can't be read, or nothing in it can be saved.
    pub fn plan_repair(&self) -> Result<RepairPlan, PastError> {
        for _ in 0..READ_AGAIN_MAX {
            let before = self.names()?;
            let repair = beside(|| self.plan_repair_once())?;
            // Files that a daemon removes meanwhile look damaged.
            if repair.damage.is_empty() || self.names()? == before {
                return Ok(repair);
            }
        }
        self.plan_repair_once()
    }

    /// The numbers of all segments and of all snapshots.
    pub(super) fn names(&self) -> Result<(Vec<u64>, Vec<u64>), PastError> {
        Ok((self.segments()?, snapshot::numbers(&*self.storage)?))
    }

    fn plan_repair_once(&self) -> Result<RepairPlan, PastError> {
        let storage = &*self.storage;
        let mut damage = Vec::new();
        let sound = self.sound_snapshots(&mut damage)?;
        let (replay, from, reached) = self.farthest(&sound)?;
        damage.extend(reached.damage.clone());
        let content = replay.memory.content();
        let saved_step = content.step;
        let memory_digest = pschema_learner::digest::digest(content);
        let first_step = crate::retention::kept(storage)?.oldest_step;
        let base = self.oldest_base(&sound, from, reached.last, &mut damage)?;
        let cut = self.cut_at(&reached, from)?;
        let base = base.map(|(place, step)| self.goes_on(place, step)).transpose()?;
        let saved_first_step = base.map_or(first_step, |base| base.step);
        let last_step = if damage.is_empty() { saved_step } else { self.last_known_step()?.max(saved_step) };
        Ok(RepairPlan {
            directory: self.path(),
            damage,
            saved_step,
            memory_digest,
            last_step,
            first_step,
            saved_first_step,
            plan: Remainder { cut, sound: sound.iter().map(|(place, _)| place.number).collect(), base },
        })
    }

    /// Copies everything into a directory beside it, and then cuts what can't be saved.
    ///
    /// # Errors
    /// When a daemon has the directory, or the disk fails. Every file is then still there, or in the copy beside it.
    pub fn repair(&self, repair: &RepairPlan) -> Result<RepairOutcome, PastError> {
        let _lock = lock::take(&self.directory, "repair")?;
        let aside = copy_aside(&*self.storage, &self.directory)?;
        apply(&*self.storage, &repair.plan)?;
        let directory = self.path();
        Ok(RepairOutcome { directory, aside: Some(aside.display().to_string()) })
    }

    /// Leaves the directory as it is, and copies what can be saved to `to`.
    ///
    /// # Errors
    /// When `to` is not empty, or the disk fails.
    pub fn repair_to(&self, repair: &RepairPlan, to: &Path) -> Result<RepairOutcome, PastError> {
        let target = new_directory(to)?;
        let plan = &repair.plan;
        cut::copy(&*self.storage, &target, &self.manifest, plan.cut, |number| plan.usable(number))?;
        apply(&target, plan)?;
        Ok(RepairOutcome { directory: to.display().to_string(), aside: None })
    }

    /// The sound snapshots in order, each with its step. The others are noted as damage.
    fn sound_snapshots(&self, damage: &mut Vec<String>) -> Result<Vec<(Place, u64)>, PastError> {
        let storage = &*self.storage;
        let mut sound = Vec::new();
        for number in snapshot::numbers(storage)? {
            let name = snapshot::name(number);
            match snapshot::sound(storage, number) {
                Ok(Some((whole, place))) => sound.push((place, whole.content.step)),
                Ok(None) => damage.push(format!("{}: the snapshot is damaged", storage.path(&name))),
                Err(error) => {
                    damage.push(format!("{}: the snapshot can't be read: {error}", storage.path(&name)))
                }
            }
        }
        Ok(sound)
    }

    /// Memory as far as the journal can be replayed: from the newest snapshot from which it leads farthest, or the beginning.
    fn farthest(&self, sound: &[(Place, u64)]) -> Result<(Replay, Place, Trail), PastError> {
        let mut best: Option<(Replay, Place, Trail)> = None;
        for (place, _) in sound.iter().rev() {
            let (replay, reached) = self.follow(*place)?;
            if best.as_ref().is_none_or(|(_, _, best)| reached.last.number > best.last.number) {
                best = Some((replay, *place, reached));
            }
            // A snapshot that the journal goes on from leads as far as any.
            if best.as_ref().is_some_and(|(_, from, best)| best.last != *from || best.damage.is_none()) {
                break;
            }
        }
        let from_birth = self.segments()?.first().is_none_or(|first| *first == 1);
        if best.is_none() && from_birth {
            let (replay, reached) = self.follow(Place::default())?;
            best = Some((replay, Place::default(), reached));
        }
        best.ok_or_else(|| PastError::Lost { path: self.path() })
    }

    /// Follows the journal from a snapshot, or the beginning, as far as it is sound and can be replayed.
    fn follow(&self, from: Place) -> Result<(Replay, Trail), PastError> {
        let mut replay = self.base_at(from)?;
        let mut reached = Trail { last: from, end: None, damage: None };
        let error = match self.follow_to(&mut replay, &mut reached, None) {
            Ok(()) => return Ok((replay, reached)),
            Err(PastError::Store(error)) if error.is_damage() => error,
            Err(error) => return Err(error),
        };
        if matches!(error, StoreError::Replay { .. }) {
            // Some effects of that frame are in memory already.
            let last = reached.last.number;
            replay = self.base_at(from)?;
            reached = Trail { last: from, end: None, damage: None };
            self.follow_to(&mut replay, &mut reached, Some(last))?;
        }
        reached.damage = Some(damage_text(&error));
        Ok((replay, reached))
    }

    fn base_at(&self, from: Place) -> Result<Replay, PastError> {
        if from.number == 0 {
            return Ok(Replay::birth(&self.manifest)?);
        }
        let path = self.storage.path(&snapshot::name(from.number));
        let found = snapshot::sound(&*self.storage, from.number).map_err(StoreError::disk("read", path))?;
        let (whole, _) = found.ok_or_else(|| PastError::Lost { path: self.path() })?;
        Ok(Replay::from_snapshot(whole)?)
    }

    fn follow_to(
        &self,
        replay: &mut Replay,
        reached: &mut Trail,
        last: Option<u64>,
    ) -> Result<(), PastError> {
        journal::read::<PastError>(&*self.storage, reached.last, |shown| {
            if last.is_some_and(|last| shown.place.number > last) {
                return Ok(ControlFlow::Break(()));
            }
            let record = self.record(&shown)?;
            let applied = replay.apply(record, shown.place.number);
            applied.map_err(|problem| unplayable(&*self.storage, &shown, problem))?;
            reached.last = shown.place;
            reached.end = Some((shown.segment, (shown.offset + HEAD_LEN + shown.payload.len()) as u64));
            Ok(ControlFlow::Continue(()))
        })?;
        Ok(())
    }

    /// The snapshot with which the saved part begins, when the journal does not lead from its first segment to the end.
    fn oldest_base(
        &self,
        sound: &[(Place, u64)],
        from: Place,
        last: Place,
        damage: &mut Vec<String>,
    ) -> Result<Option<(Place, u64)>, PastError> {
        let begins = self.begins()?;
        let first = self.segments()?.first().copied();
        let whole = begins.first().filter(|head| Some(head.first) == first);
        if first.is_none_or(|first| first > last.number.saturating_add(1)) && last.number == 0 {
            return Ok(None);
        }
        match whole {
            Some(head) => match self.chain(head.after, last)? {
                None => return Ok(None),
                Some(problem) => note(damage, problem),
            },
            None => note(damage, "the head of the oldest segment of the journal is damaged".to_owned()),
        }
        for (place, step) in sound.iter().filter(|(place, _)| place.number <= from.number.max(last.number)) {
            if self.chain(*place, last)?.is_none() {
                return Ok(Some((*place, *step)));
            }
        }
        let step = sound.iter().find(|(place, _)| *place == from).map_or(0, |(_, step)| *step);
        Ok((from.number > 0).then_some((from, step)))
    }

    /// Why the journal does not lead from one place to another; none when it does.
    fn chain(&self, from: Place, to: Place) -> Result<Option<String>, PastError> {
        if from.number >= to.number {
            return Ok((from != to).then(|| "a snapshot is of another journal".to_owned()));
        }
        let mut last = from;
        let read = journal::read::<PastError>(&*self.storage, from, |shown| {
            last = shown.place;
            Ok(if last.number >= to.number { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
        });
        match read {
            _ if last == to => Ok(None),
            Ok(_) => Ok(Some(format!("the journal ends after frame {}", last.number))),
            Err(PastError::Store(error)) if error.is_damage() => Ok(Some(damage_text(&error))),
            Err(error) => Err(error),
        }
    }

    /// Where the journal is to end.
    fn cut_at(&self, reached: &Trail, from: Place) -> Result<Cut, PastError> {
        let frame = reached.last.number;
        if let Some((segment, bytes)) = reached.end {
            return Ok(Cut { frame, segment: Some(segment), bytes });
        }
        // Nothing follows the snapshot. The journal ends where the snapshot was made, if that frame is still there, or with
        // the head of the next segment.
        let there = match self.head_after(from)? {
            Some(head) => Some(head),
            None => self.frame_end(from)?,
        };
        let (segment, bytes) = there.map_or((None, 0), |(segment, bytes)| (Some(segment), bytes));
        Ok(Cut { frame, segment, bytes })
    }

    /// The segment that begins right after a frame, and where its head ends.
    pub(super) fn head_after(&self, place: Place) -> Result<Option<(u64, u64)>, PastError> {
        let begins = self.begins()?;
        let next = begins.iter().find(|head| head.after == place);
        Ok(next.map(|head| (head.first, (HEAD_LEN + FILE_HEAD_LEN) as u64)))
    }

    /// The segment that a frame is in, and where the frame ends in it.
    fn frame_end(&self, place: Place) -> Result<Option<(u64, u64)>, PastError> {
        let firsts = self.segments()?;
        let Some(segment) = firsts.iter().rfind(|first| **first <= place.number).copied() else {
            return Ok(None);
        };
        let name = segment_name(segment);
        let bytes = self.storage.read(&name);
        let bytes = bytes.map_err(StoreError::disk("read", self.storage.path(&name)))?;
        let found = frame::scan(frame::JOURNAL, &bytes)
            .find(|(_, found)| found.head.number == place.number && found.crc == place.crc);
        Ok(found.map(|(at, found)| (segment, (at + found.len()) as u64)))
    }

    /// Where the journal goes on after a snapshot.
    fn goes_on(&self, place: Place, step: u64) -> Result<Base, PastError> {
        let mut rest = None;
        let read = journal::read::<PastError>(&*self.storage, place, |shown| {
            rest = Some((shown.segment, shown.offset as u64));
            Ok(ControlFlow::Break(()))
        });
        match read {
            Ok(_) | Err(PastError::Store(StoreError::Journal(_))) => Ok(Base { place, step, rest }),
            Err(error) => Err(error),
        }
    }
}

fn note(damage: &mut Vec<String>, problem: String) {
    if !damage.contains(&problem) {
        damage.push(problem);
    }
}

/// Leaves in `storage` only the part that is to remain. Done again after an interruption, it does the rest.
fn apply(storage: &dyn Storage, plan: &Remainder) -> Result<(), PastError> {
    if let Some(base) = plan.base {
        begin_at(storage, &base, plan.cut)?;
    }
    let mut end = plan.cut;
    if let Some(base) = plan.base {
        // The segment in which the journal goes on is now one that begins there.
        let moved = base.rest.filter(|(segment, _)| plan.cut.segment == Some(*segment));
        let fresh = base.place.number + 1;
        match moved {
            Some((segment, at)) if segment != fresh => {
                let head = (HEAD_LEN + FILE_HEAD_LEN) as u64;
                end = Cut {
                    segment: Some(fresh),
                    bytes: head + (plan.cut.bytes - at.min(plan.cut.bytes)),
                    ..end
                };
            }
            None if base.rest.is_none() => {
                end = Cut { segment: Some(fresh), bytes: (HEAD_LEN + FILE_HEAD_LEN) as u64, ..end };
            }
            _ => (),
        }
    }
    cut::cut(storage, end, |number| plan.usable(number))?;
    let Some(base) = plan.base else { return Ok(()) };
    // The segments before the base go last: until then they are as they were, damaged or not.
    for first in cut::segments(storage)? {
        if first <= base.place.number {
            let name = segment_name(first);
            storage.remove(&name).map_err(StoreError::disk("remove", storage.path(&name)))?;
        }
    }
    let synced = storage.sync_directory(journal::DIRECTORY);
    Ok(synced.map_err(StoreError::disk("make durable", storage.path(journal::DIRECTORY)))?)
}

/// Makes a segment that begins right after the base, of the frames that follow the base in their old segment. The frames stay
/// as they are, byte for byte.
fn begin_at(storage: &dyn Storage, base: &Base, cut: Cut) -> Result<(), PastError> {
    let first = base.place.number + 1;
    let name = segment_name(first);
    let (source, at) = match base.rest {
        Some((segment, _)) if segment == first => return Ok(()),
        Some((segment, at)) => (Some(segment), at),
        None => (None, 0),
    };
    let head = Head { number: first, durable: base.place.number, previous: base.place.crc };
    let (mut bytes, _) = frame::written(SEGMENT, head, &file_head(base.step));
    if let Some(source) = source {
        let from = segment_name(source);
        let read = match storage.read(&from) {
            // It was made before an interruption, and the old segment is gone.
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(()),
            read => read.map_err(StoreError::disk("read", storage.path(&from)))?,
        };
        let to = if cut.segment == Some(source) { cut.bytes } else { read.len() as u64 };
        let part = usize::try_from(at).ok().zip(usize::try_from(to).ok());
        bytes.extend(part.and_then(|(at, to)| read.get(at..to)).unwrap_or_default());
    }
    Ok(durable::replace(storage, &name, &format!("{}/mending.tmp", journal::DIRECTORY), &bytes)?)
}

/// Copies everything in `directory` to a directory beside it. The copy gets its name when it is whole and durable.
fn copy_aside(storage: &dyn Storage, directory: &Path) -> Result<PathBuf, PastError> {
    let numbered = |number: u32, suffix: &str| {
        let mut name = directory.as_os_str().to_owned();
        name.push(format!(".before-repair-{number}{suffix}"));
        PathBuf::from(name)
    };
    let free = (1..=u32::MAX).map(|number| (numbered(number, ""), numbered(number, ".tmp")));
    let (aside, temporary) = free
        .into_iter()
        .find(|(aside, _)| !aside.exists())
        .ok_or_else(|| PastError::Lost { path: directory.display().to_string() })?;
    let shown = temporary.display().to_string();
    if temporary.exists() {
        // A copy that was interrupted; everything in it is still in the directory.
        std::fs::remove_dir_all(&temporary).map_err(StoreError::disk("remove", shown.clone()))?;
    }
    std::fs::create_dir(&temporary).map_err(StoreError::disk("create", shown.clone()))?;
    let target = Directory::new(&temporary);
    cut::copy_all(storage, &target, &cut::files(storage)?)?;
    std::fs::rename(&temporary, &aside).map_err(StoreError::disk("rename", shown))?;
    sync_parent(&aside)?;
    Ok(aside)
}

#[cfg(test)]
mod tests;
