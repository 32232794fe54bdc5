//! Damage of every kind, mended; and a repair that is killed at any instant.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};

use pschema_learner::random::Random;

use super::*;
use crate::Retention;
use crate::past::tests::{Life, all, lived, opened, past};
use crate::storage::OpenFile;
use crate::tests::twin::Twin;

/// A process that is killed after so many operations that change something: all of them fail from then on.
#[derive(Clone, Debug)]
struct Mortal {
    twin: Twin,
    left: Arc<AtomicI64>,
}

impl Mortal {
    fn new(twin: &Twin, left: i64) -> Self {
        Self { twin: twin.clone(), left: Arc::new(AtomicI64::new(left)) }
    }

    fn beside(&self, twin: &Twin) -> Self {
        Self { twin: twin.clone(), left: self.left.clone() }
    }

    fn lives(&self) -> io::Result<()> {
        if self.left.fetch_sub(1, Ordering::Relaxed) > 0 { Ok(()) } else { Err(io::Error::other("killed")) }
    }
}

#[derive(Debug)]
struct MortalFile(Box<dyn OpenFile>, Mortal);

impl OpenFile for MortalFile {
    fn write_at(&mut self, bytes: &[u8], offset: u64) -> io::Result<()> {
        self.1.lives()?;
        self.0.write_at(bytes, offset)
    }
    fn sync(&mut self) -> io::Result<()> {
        self.1.lives()?;
        self.0.sync()
    }
}

impl Storage for Mortal {
    fn list(&self, directory: &str) -> io::Result<Vec<String>> {
        self.twin.list(directory)
    }
    fn is_there(&self, directory: &str) -> bool {
        self.twin.is_there(directory)
    }
    fn open(&self, name: &str) -> io::Result<Box<dyn io::Read>> {
        self.twin.open(name)
    }
    fn size(&self, name: &str) -> io::Result<u64> {
        self.twin.size(name)
    }
    fn truncate(&self, name: &str, to: u64) -> io::Result<()> {
        self.lives()?;
        self.twin.truncate(name, to)
    }
    fn create(&self, name: &str) -> io::Result<Box<dyn OpenFile>> {
        self.lives()?;
        Ok(Box::new(MortalFile(self.twin.create(name)?, self.clone())))
    }
    fn sync(&self, name: &str) -> io::Result<()> {
        self.lives()?;
        self.twin.sync(name)
    }
    fn confirm(&self, name: &str, to: u64) -> io::Result<()> {
        self.lives()?;
        self.twin.confirm(name, to)
    }
    fn rename(&self, from: &str, to: &str) -> io::Result<()> {
        self.lives()?;
        self.twin.rename(from, to)
    }
    fn remove(&self, name: &str) -> io::Result<()> {
        self.lives()?;
        self.twin.remove(name)
    }
    fn directory(&self, name: &str) -> io::Result<()> {
        self.twin.directory(name)
    }
    fn sync_directory(&self, name: &str) -> io::Result<()> {
        self.lives()?;
        self.twin.sync_directory(name)
    }
    fn path(&self, name: &str) -> String {
        self.twin.path(name)
    }
}

/// What was damaged, and where it ended up.
struct Case {
    name: String,
    twin: Twin,
    /// The step that must be saved at least.
    saves: u64,
}

fn flip(twin: &Twin, file: &str, random: &mut Random) {
    // In the middle, where there is something.
    let bytes = twin.read(file).unwrap().len();
    twin.flip(file, (bytes / 4 + random.below(bytes / 4)) * 8 + random.below(8));
}

/// A life with some segments and snapshots, damaged in every way.
fn cases(lived: &Life, random: &mut Random) -> Vec<Case> {
    let files = lived.past().files().unwrap();
    let (last, snapshots) = (lived.last(), &files.snapshots);
    let newest = snapshots.last().unwrap();
    let mut cases = Vec::new();
    let mut case = |name: &str, saves: u64, damage: &mut dyn FnMut(&Twin)| {
        let twin = lived.twin.copy();
        damage(&twin);
        cases.push(Case { name: name.to_owned(), twin, saves });
    };
    for segment in &files.segments {
        let after_newest = segment.first_frame > newest.frame;
        let saves = if after_newest { segment.step.unwrap() } else { newest.step.unwrap() };
        case(&format!("a bit of {}", segment.file), saves, &mut |twin| flip(twin, &segment.file, random));
        case(&format!("the head of {}", segment.file), saves, &mut |twin| twin.flip(&segment.file, 77));
        case(&format!("{} is missing", segment.file), saves, &mut |twin| twin.remove(&segment.file).unwrap());
    }
    for snapshot in snapshots {
        case(&format!("a bit of {}", snapshot.file), last, &mut |twin| flip(twin, &snapshot.file, random));
    }
    case("all snapshots", last, &mut |twin| snapshots.iter().for_each(|one| flip(twin, &one.file, random)));
    cases
}

/// Everything that a mended directory must be.
fn assert_mended(twin: &Twin, lived: &Life, seed: u64, repair: &RepairPlan, what: &str) {
    let past = past(twin);
    let checked = past.verify(true, &mut |_| ()).unwrap();
    assert!(checked.sound, "{what}: {:?}", checked.findings);
    assert_eq!(checked.last_step, Some(repair.saved_step), "{what}");
    assert_eq!(checked.memory_digest.as_deref(), Some(repair.memory_digest.as_str()), "{what}");
    assert_eq!(
        repair.memory_digest, lived.digests[repair.saved_step as usize],
        "{what}: memory as it was there"
    );
    assert_eq!(checked.first_step, Some(repair.saved_first_step), "{what}");
    assert!(past.plan_repair().unwrap().damage.is_empty(), "{what}: nothing more is to be done");
    let again = twin.copy();
    let (learner, _writer) = opened(&again, seed, all());
    assert_eq!(learner.memory().content().step, repair.saved_step, "{what}: a daemon starts");
}

#[test]
fn whatever_is_damaged_the_longest_sound_part_is_saved() {
    for seed in [11, 12] {
        let lived = lived(seed, 3, 200, all(), seed == 11);
        let mut random = Random::from_seed(seed);
        for Case { name, twin, saves } in cases(&lived, &mut random) {
            let what = format!("seed {seed}: {name}");
            let repair = past(&twin).plan_repair().unwrap();
            assert!(repair.saved_step >= saves, "{what}: {repair:?}");
            assert!(repair.last_step <= lived.last() && repair.last_step >= repair.saved_step, "{what}");
            assert!(!repair.damage.is_empty() || twin_is_whole(&twin), "{what}: {repair:?}");
            apply(&twin, &repair.plan).unwrap();
            assert_mended(&twin, &lived, seed, &repair, &what);
        }
    }
}

fn twin_is_whole(twin: &Twin) -> bool {
    past(twin).verify(false, &mut |_| ()).unwrap().sound
}

#[test]
fn what_is_sound_is_left_alone() {
    let lived = lived(13, 2, 200, all(), false);
    let before = contents(&lived.twin);
    let repair = lived.past().plan_repair().unwrap();
    assert_eq!((repair.damage.as_slice(), repair.saved_step), (&[][..], 400));
    assert_eq!(contents(&lived.twin), before);
}

/// A directory that lost its journal says so, and goes on from its snapshot.
#[test]
fn a_journal_that_is_gone_is_missed() {
    let lived = lived(16, 2, 200, all(), true);
    for segment in lived.past().files().unwrap().segments {
        lived.twin.remove(&segment.file).unwrap();
    }
    let checked = lived.past().verify(false, &mut |_| ()).unwrap();
    assert!(
        !checked.sound && checked.findings.iter().any(|found| found.problem.contains("a file is missing"))
    );
    let repair = lived.past().plan_repair().unwrap();
    assert_eq!((repair.saved_step, repair.saved_first_step), (400, 400));
    apply(&lived.twin, &repair.plan).unwrap();
    assert_mended(&lived.twin, &lived, 16, &repair, "no journal");
    // Mended once more it stays what it is.
    let again = lived.past().plan_repair().unwrap();
    apply(&lived.twin, &again.plan).unwrap();
    assert_mended(&lived.twin, &lived, 16, &again, "no journal, twice");
}

#[test]
fn nothing_to_begin_with_is_said() {
    let lived = lived(14, 2, 600, Retention { snapshot_bytes: 30_000, history_bytes: Some(0) }, true);
    for snapshot in lived.past().files().unwrap().snapshots {
        lived.twin.flip(&snapshot.file, 800);
    }
    assert!(matches!(lived.past().plan_repair(), Err(PastError::Lost { .. })));
    let checked = lived.past().verify(false, &mut |_| ()).unwrap();
    assert!(!checked.sound && checked.memory_digest.is_none(), "{checked:?}");
}

fn contents(twin: &Twin) -> Vec<(String, Vec<u8>)> {
    let read = |name: String| {
        let bytes = twin.read(&name).unwrap();
        (name, bytes)
    };
    cut::files(twin).unwrap().into_iter().map(read).collect()
}

/// A repair as it is done: all of it aside, and only then the cut.
fn repaired(main: &dyn Storage, aside: &dyn Storage, plan: &Remainder) -> Result<(), PastError> {
    cut::copy_all(main, aside, &cut::files(main)?)?;
    apply(main, plan)
}

#[test]
fn killed_at_any_instant_it_loses_nothing_and_can_be_done_again() {
    let lived = lived(15, 3, 120, all(), true);
    let mut random = Random::from_seed(15);
    for case in cases(&lived, &mut random) {
        let planned = past(&case.twin).plan_repair().unwrap();
        if planned.damage.is_empty() {
            continue;
        }
        for name in cut::files(&case.twin).unwrap() {
            case.twin.sync(&name).unwrap();
        }
        case.twin.sync_directory("").unwrap();
        let before = contents(&case.twin);
        for kill in 0.. {
            let (main, aside) = (case.twin.copy(), Twin::new());
            let mortal = Mortal::new(&main, kill);
            let done = repaired(&mortal, &mortal.beside(&aside), &planned.plan);
            let what = format!("{}, killed after {kill} operations", case.name);
            if kill % 3 == 0 && done.is_err() {
                // The machine goes with it.
                main.lose_power(&mut random);
                aside.lose_power(&mut random);
            }
            let whole = contents(&aside) == before;
            assert!(whole || contents(&main) == before, "{what}: what was there is there, or beside it");
            let again = past(&main).plan_repair().unwrap();
            assert_eq!(again.saved_step, planned.saved_step, "{what}");
            repaired(&main, &Twin::new(), &again.plan).unwrap();
            let expected = RepairPlan { saved_first_step: again.saved_first_step, ..planned.clone() };
            assert_mended(&main, &lived, 15, &expected, &what);
            if done.is_ok() {
                assert!(kill > 10, "{what}: it takes some operations");
                break;
            }
        }
    }
}
