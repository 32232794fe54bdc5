//! The journal on a disk that fails: cut anywhere, flipped anywhere, without power at any time.

use std::ops::ControlFlow;
use std::sync::Arc;

use pschema_learner::random::Random;

use crate::frame;
use crate::journal::{End, FILE_HEAD_LEN, Journal, JournalError, Place, Sizes, read, segment_name};
use crate::storage::Storage;
use crate::tests::twin::{Fault, Twin};

/// One segment for all.
const ONE: Sizes = Sizes { segment_max: 1 << 30, ahead: 700 };
const SMALL: Sizes = Sizes { segment_max: 3_000, ahead: 700 };

fn payload(number: u64, random: &mut Random) -> Vec<u8> {
    let length = random.below(200);
    let mut payload = number.to_le_bytes().to_vec();
    payload.extend((0..length).map(|_| random.next_u64() as u8));
    payload
}

fn frames(storage: &dyn Storage) -> Result<(Vec<Vec<u8>>, End), JournalError> {
    let mut seen = Vec::new();
    let end = read::<JournalError>(storage, Place::default(), |shown| {
        seen.push(shown.payload.to_vec());
        Ok(ControlFlow::Continue(()))
    })?;
    Ok((seen, end))
}

/// A journal of `count` frames in one segment, each synced by itself, and where each of them ends.
fn written(count: u64) -> (Twin, Vec<Vec<u8>>, Vec<usize>) {
    let (twin, mut random) = (Twin::new(), Random::from_seed(count));
    let mut journal = Journal::after(Arc::new(twin.clone()), Place::default(), ONE);
    let (mut payloads, mut ends) = (Vec::new(), vec![frame::HEAD_LEN + FILE_HEAD_LEN]);
    for number in 1..=count {
        let payload = payload(number, &mut random);
        journal.append(&payload, 0).unwrap();
        journal.sync().unwrap();
        ends.push(ends.last().unwrap() + frame::HEAD_LEN + payload.len());
        payloads.push(payload);
    }
    (twin, payloads, ends)
}

#[test]
fn cut_at_every_byte_it_gives_the_frames_before_the_cut() {
    let (twin, payloads, ends) = written(12);
    let name = segment_name(1);
    let whole = twin.read(&name).unwrap();
    let mut random = Random::from_seed(7);
    for cut in 0..=*ends.last().unwrap() {
        let intact = ends.iter().filter(|end| **end <= cut).count().saturating_sub(1);
        let garbage: Vec<u8> = (0..300).map(|_| random.next_u64() as u8).collect();
        for tail in [&[][..], &[0; 300], &garbage] {
            let damaged = twin.copy();
            damaged.edit(&name, |bytes| *bytes = [&whole[..cut], tail].concat());
            let (seen, end) = frames(&damaged).unwrap();
            assert_eq!(seen, payloads[..intact], "cut at {cut}");
            // And it goes on from there.
            let mut journal = Journal::after(Arc::new(damaged.clone()), end.last, SMALL);
            journal.append(b"new", 0).unwrap();
            journal.sync().unwrap();
            let (seen, _) = frames(&damaged).unwrap();
            assert_eq!(seen.len(), intact + 1, "cut at {cut}");
            assert_eq!(seen.last().unwrap(), b"new");
        }
    }
}

#[test]
fn every_bit_flip_below_the_last_frame_is_refused() {
    let (twin, _, ends) = written(100);
    let name = segment_name(1);
    let below = ends[ends.len() - 2];
    for bit in 0..below * 8 {
        let damaged = twin.copy();
        damaged.flip(&name, bit);
        let Err(error) = frames(&damaged) else { panic!("bit {bit} of byte {} went unseen", bit / 8) };
        let JournalError::Damaged { offset, lost, .. } = error else { panic!("bit {bit}: {error}") };
        let frame = ends.iter().filter(|end| **end <= bit / 8).count();
        let (at, number) = if frame == 0 { (0, 1) } else { (ends[frame - 1], frame as u64) };
        assert_eq!((offset, lost), (at, number), "bit {bit}");
    }
    // The last frame may have been torn: nothing says that it was acknowledged.
    twin.flip(&name, below * 8 + 3);
    assert_eq!(frames(&twin).unwrap().0.len(), 99);
}

/// A long journal: no flip of any bit leaves its frame sound, so that the chain ends before it; and what is read then is
/// refused. `PSCHEMA_DAMAGE_MIB` says how long.
#[test]
fn no_bit_of_a_long_journal_can_flip_unseen() {
    let mebibytes: usize = std::env::var("PSCHEMA_DAMAGE_MIB").map_or(1, |length| length.parse().unwrap());
    let count = mebibytes * (1 << 20) / 140;
    let (twin, _, ends) = written(count as u64);
    let name = segment_name(1);
    let mut bytes = twin.read(&name).unwrap();
    for (at, frame) in ends.windows(2).enumerate() {
        let frame = &mut bytes[frame[0]..frame[1]];
        for bit in 0..frame.len() * 8 {
            frame[bit / 8] ^= 1 << (bit % 8);
            assert!(frame::read(frame::JOURNAL, frame).is_none(), "bit {bit} of frame {}", at + 1);
            frame[bit / 8] ^= 1 << (bit % 8);
        }
    }
    let mut random = Random::from_seed(5);
    let below = ends[ends.len() - 2];
    for _ in 0..30 {
        let (damaged, bit) = (twin.copy(), random.below(below * 8));
        damaged.flip(&name, bit);
        let error = frames(&damaged).unwrap_err();
        assert!(matches!(error, JournalError::Damaged { .. }), "bit {bit}: {error}");
    }
    assert_eq!(frames(&twin).unwrap().0.len(), count);
}

#[test]
fn a_missing_segment_is_refused() {
    let (twin, mut random) = (Twin::new(), Random::from_seed(3));
    let mut journal = Journal::after(Arc::new(twin.clone()), Place::default(), SMALL);
    for number in 1..=60 {
        journal.append(&payload(number, &mut random), 0).unwrap();
        journal.sync().unwrap();
    }
    let firsts = crate::journal::segments(&twin).unwrap();
    assert!(firsts.len() > 2, "{firsts:?}");
    assert_eq!(frames(&twin).unwrap().0.len(), 60);
    for first in &firsts[..firsts.len() - 1] {
        let damaged = twin.copy();
        damaged.remove(&segment_name(*first)).unwrap();
        let error = frames(&damaged).unwrap_err();
        assert!(matches!(error, JournalError::Damaged { .. } | JournalError::Missing { .. }), "{error}");
    }
}

/// Appends, syncs, dies and loses power in any order, and whatever was synced is there again, in order and without a
/// hole; and nothing that was never appended is. `PSCHEMA_POWER_LOSS_SEEDS` says how often.
#[test]
fn what_was_synced_survives_any_loss_of_power() {
    let seeds: u64 = std::env::var("PSCHEMA_POWER_LOSS_SEEDS").map_or(10_000, |seeds| seeds.parse().unwrap());
    for seed in 0..seeds {
        let mut random = Random::from_seed(seed);
        let twin = Twin::new();
        let mut appended: Vec<Vec<u8>> = Vec::new();
        let mut synced = 0;
        for _ in 0..4 {
            let (seen, end) = frames(&twin).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
            assert!(seen.len() >= synced, "seed {seed}: {} of {synced} synced frames", seen.len());
            assert_eq!(seen, appended[..seen.len()], "seed {seed}");
            appended.truncate(seen.len());
            let resumed = crate::recovery::settle(&twin, &end);
            resumed.unwrap();
            synced = seen.len();
            let mut journal = Journal::after(Arc::new(twin.clone()), end.last, SMALL);
            for _ in 0..random.below(12) {
                let payload = payload(appended.len() as u64, &mut random);
                journal.append(&payload, 0).unwrap();
                // To begin a segment, all before it is synced.
                appended.push(payload);
                if random.below(3) == 0 {
                    journal.sync().unwrap();
                    synced = appended.len();
                }
            }
            // A process that is killed loses nothing that it wrote; power takes what was not synced.
            if random.below(3) > 0 {
                twin.lose_power(&mut random);
            }
        }
    }
}

#[test]
fn a_full_disk_and_a_failed_sync_lose_nothing_that_was_synced() {
    for seed in 0..500 {
        let mut random = Random::from_seed(seed);
        let twin = Twin::new();
        let fault = if seed % 2 == 0 {
            Fault::Full(random.below(6_000) as u64)
        } else {
            Fault::Sync(u32::try_from(random.below(20)).unwrap())
        };
        twin.fail(fault);
        let mut journal = Journal::after(Arc::new(twin.clone()), Place::default(), SMALL);
        let mut appended: Vec<Vec<u8>> = Vec::new();
        let mut synced = 0;
        loop {
            let payload = payload(appended.len() as u64, &mut random);
            appended.push(payload.clone());
            if journal.append(&payload, 0).and_then(|_| journal.sync()).is_err() {
                break;
            }
            synced = appended.len();
        }
        twin.fail(Fault::None);
        twin.lose_power(&mut random);
        let (seen, _) = frames(&twin).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        assert!(seen.len() >= synced, "seed {seed}");
        assert_eq!(seen, appended[..seen.len()], "seed {seed}");
    }
}
