//! How far back a memory can be returned to: which snapshots and which segments of the journal are kept.
//!
//! The two newest snapshots and the journal from the older of them on are always kept. Of older journal, as much is kept as
//! was asked for, in whole segments. Of older snapshots, some are kept, well spaced, to return to quickly; the oldest of them
//! is the one that the kept journal goes on from.

use crate::error::StoreError;
use crate::journal::{self, segment_name};
use crate::snapshot;
use crate::storage::Storage;

/// Snapshots that are always kept.
const NEWEST: usize = 2;
/// Older snapshots are at least this part of the kept journal apart.
const SPACED: u64 = 8;
/// Segments kept at most, however short they are: a daemon that is killed again and again makes one each time.
const SEGMENTS_MAX: usize = 4_096;

/// The snapshots and segments that are to be removed.
#[derive(Debug, Default, PartialEq, Eq)]
struct Removal {
    snapshots: Vec<u64>,
    segments: Vec<u64>,
}

/// Which of `segments` (first frame and bytes) and `snapshots` (frames) are to go, so that at most `history` bytes of
/// journal are kept where that is possible; without `history`, all of the journal is kept.
fn plan(segments: &[(u64, u64)], snapshots: &[u64], history: Option<u64>) -> Removal {
    let Some(older) = snapshots.len().checked_sub(NEWEST).and_then(|at| snapshots.get(at)) else {
        return Removal::default();
    };
    // The segment in which the journal goes on after a snapshot; none when the journal does not reach back so far.
    let goes_on =
        |snapshot: u64| segments.iter().rposition(|(first, _)| *first <= snapshot.saturating_add(1));
    let Some(needed) = goes_on(*older) else { return Removal::default() };
    let bytes = |from: usize| segments.iter().skip(from).map(|(_, bytes)| bytes).sum::<u64>();
    let fits = |from: &usize| {
        history.is_none_or(|history| bytes(*from) <= history && segments.len() - from <= SEGMENTS_MAX)
    };
    let wanted = (0..needed).find(fits).unwrap_or(needed);
    let from_birth = wanted == 0 && segments.first().is_some_and(|(first, _)| *first == 1);
    let base = if from_birth {
        0
    } else {
        snapshots.iter().filter_map(|at| goes_on(*at)).find(|at| *at >= wanted).unwrap_or(needed)
    };
    let spacing = (bytes(base) / SPACED).max(1);
    // The beginning of the memory is a place to return to as well.
    let mut last = from_birth.then(|| bytes(0));
    let mut plan = Removal::default();
    for snapshot in snapshots {
        let left = goes_on(*snapshot).filter(|at| *at >= base).map(bytes);
        let spaced = left.is_some_and(|left| last.is_none_or(|last| last.saturating_sub(left) >= spacing));
        if snapshot >= older || spaced {
            last = left;
        } else {
            plan.snapshots.push(*snapshot);
        }
    }
    plan.segments = segments.iter().take(base).map(|(first, _)| *first).collect();
    plan
}

/// How much of a memory's past is kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct History {
    /// The length of the journal.
    pub(crate) bytes: u64,
    /// The first step that can be returned to.
    pub(crate) oldest_step: u64,
}

/// Removes the snapshots and segments that are to be kept no longer. Returns how many bytes of journal were removed. Snapshots
/// that are known to be `damaged` do not count, and go when they are older than those that are always kept.
pub(crate) fn tidy(storage: &dyn Storage, history: Option<u64>, damaged: &[u64]) -> Result<u64, StoreError> {
    let disk = |name: &str| StoreError::disk("remove", storage.path(name));
    let segments = segments(storage)?;
    let snapshots = snapshot::numbers(storage)?;
    let (sound, unsound): (Vec<u64>, Vec<u64>) =
        snapshots.into_iter().partition(|number| !damaged.contains(number));
    let mut plan = plan(&segments, &sound, history);
    if let Some(older) = sound.len().checked_sub(NEWEST).and_then(|at| sound.get(at)) {
        plan.snapshots.extend(unsound.iter().filter(|number| *number < older));
    }
    for number in &plan.snapshots {
        let name = snapshot::name(*number);
        storage.remove(&name).map_err(disk(&name))?;
    }
    let mut removed = 0;
    for (first, bytes) in segments.iter().filter(|(first, _)| plan.segments.contains(first)) {
        let name = segment_name(*first);
        storage.remove(&name).map_err(disk(&name))?;
        removed += bytes;
    }
    Ok(removed)
}

/// How much is kept now.
pub(crate) fn kept(storage: &dyn Storage) -> Result<History, StoreError> {
    let disk = |name: &str| StoreError::disk("read", storage.path(name));
    let segments = segments(storage)?;
    let bytes = segments.iter().map(|(_, bytes)| bytes).sum();
    let mut oldest_step = 0;
    if let Some((first, _)) = segments.first().filter(|(first, _)| *first > 1) {
        let snapshots = snapshot::numbers(storage)?;
        for number in snapshots.iter().filter(|number| **number + 1 >= *first) {
            if let Some(step) = snapshot::step(storage, *number).map_err(disk(&snapshot::name(*number)))? {
                oldest_step = step;
                break;
            }
        }
    }
    Ok(History { bytes, oldest_step })
}

fn segments(storage: &dyn Storage) -> Result<Vec<(u64, u64)>, StoreError> {
    let disk = |name: &str| StoreError::disk("read", storage.path(name));
    let firsts = journal::segments(storage).map_err(disk(journal::DIRECTORY))?;
    let sized = |first: u64| {
        let name = segment_name(first);
        Ok((first, storage.size(&name).map_err(disk(&name))?))
    };
    firsts.into_iter().map(sized).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SEGMENTS: [(u64, u64); 6] = [(1, 100), (11, 100), (21, 100), (31, 100), (41, 100), (51, 100)];
    const SNAPSHOTS: [u64; 6] = [5, 15, 25, 35, 45, 55];

    fn kept(history: Option<u64>, snapshots: &[u64]) -> (Vec<u64>, Vec<u64>) {
        let plan = plan(&SEGMENTS, snapshots, history);
        let segments = SEGMENTS.iter().map(|(first, _)| *first).filter(|at| !plan.segments.contains(at));
        let snapshots = snapshots.iter().copied().filter(|at| !plan.snapshots.contains(at));
        (segments.collect(), snapshots.collect())
    }

    #[test]
    fn the_newest_two_and_what_they_need_are_always_kept() {
        assert_eq!(kept(Some(0), &SNAPSHOTS), (vec![41, 51], vec![45, 55]));
        assert_eq!(kept(Some(0), &[55]), (vec![1, 11, 21, 31, 41, 51], vec![55]));
        assert_eq!(kept(Some(0), &[]), (vec![1, 11, 21, 31, 41, 51], vec![]));
        // A snapshot at the end of a segment goes on in the next.
        assert_eq!(kept(Some(0), &[40, 55]), (vec![41, 51], vec![40, 55]));
    }

    #[test]
    fn older_journal_is_kept_up_to_its_bytes_and_has_a_snapshot_to_go_on_from() {
        assert_eq!(kept(Some(400), &SNAPSHOTS), (vec![21, 31, 41, 51], vec![25, 35, 45, 55]));
        assert_eq!(kept(Some(499), &SNAPSHOTS), (vec![21, 31, 41, 51], vec![25, 35, 45, 55]));
        // 400 bytes would reach back to frame 21, and nothing there can be gone on from before 35.
        assert_eq!(kept(Some(400), &[5, 35, 45, 55]), (vec![31, 41, 51], vec![35, 45, 55]));
        // Birth needs no snapshot.
        let (segments, snapshots) = kept(Some(600), &SNAPSHOTS);
        assert_eq!((segments.len(), snapshots), (6, vec![15, 25, 35, 45, 55]));
        assert_eq!(kept(None, &SNAPSHOTS).0.len(), 6);
    }

    #[test]
    fn there_are_not_too_many_segments_unless_all_are_asked_for() {
        let segments: Vec<(u64, u64)> = (0..5_000).map(|at| (at * 10 + 1, 1)).collect();
        let snapshots: Vec<u64> = (0..5_000).map(|at| at * 10 + 5).collect();
        assert_eq!(plan(&segments, &snapshots, Some(u64::MAX)).segments.len(), 5_000 - SEGMENTS_MAX);
        assert!(plan(&segments, &snapshots, None).segments.is_empty());
    }

    #[test]
    fn there_are_few_snapshots_however_long_the_journal_is() {
        let segments: Vec<(u64, u64)> = (0..1_000).map(|at| (at * 10 + 1, 100)).collect();
        let mut snapshots: Vec<u64> = Vec::new();
        for at in 0..1_000 {
            snapshots.push(at * 10 + 5);
            let there = &segments[..=usize::try_from(at).unwrap()];
            let plan = plan(there, &snapshots, None);
            assert!(plan.segments.is_empty());
            snapshots.retain(|at| !plan.snapshots.contains(at));
            assert!(snapshots.len() <= 2 + 16, "{snapshots:?}");
        }
        assert!(snapshots.len() >= 6, "{snapshots:?}");
    }
}
