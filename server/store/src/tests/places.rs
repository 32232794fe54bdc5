//! Data directories of the file system: moved, replaced, taken by another, or with files of others in them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use pschema_learner::Learner;
use pschema_learner::parameters::Parameters;

use crate::error::StoreError;
use crate::tests::store::{World, attach, curriculum, options, settled, step};
use crate::{Opened, Options, Retention, Store, open};

fn opened(directory: &Path) -> Result<(Learner, Store, bool), StoreError> {
    let (parameters, curriculum) = (Parameters::default(), curriculum());
    // With a snapshot that is taken by itself, within the second in which nobody looks, a start no longer needs what was removed.
    let retention = Retention { snapshot_bytes: u64::MAX, history_bytes: None };
    let options = Options { retention, ..options(6, &parameters, &curriculum) };
    let Opened { learner, store, begun, .. } = open(directory, options, || ())?;
    Ok((learner, store, begun))
}

/// A memory that was begun in `directory` and has taken some steps.
fn living(directory: &Path) -> (Learner, Store, World) {
    let (mut learner, mut store, begun) = opened(directory).unwrap();
    assert!(begun);
    let mut world = World::new(6);
    attach(&mut learner, &mut store).unwrap();
    for _ in 0..20 {
        lived(&mut learner, &mut store, &mut world).unwrap();
    }
    (learner, store, world)
}

/// One step that is acknowledged, or why it can't be.
fn lived(learner: &mut Learner, store: &mut Store, world: &mut World) -> Result<(), StoreError> {
    let frame = world.frame();
    let taken = learner.step(&frame);
    let batch = store.append(&step(&frame, &taken), learner.memory().content())?;
    world.follow(&taken.output);
    settled(store, batch)
}

#[test]
fn no_step_is_acknowledged_in_a_directory_that_was_moved_or_that_another_may_take() {
    type Mishap = fn(&Path, &Path);
    let mishaps: [(&str, Mishap); 6] = [
        ("life was moved or removed", |life, away| fs::rename(life, away).unwrap()),
        ("life was moved or removed, and another is in its place", |life, away| {
            fs::rename(life, away).unwrap();
            let copied = Command::new("cp").arg("-a").args([away, life]).status().unwrap();
            assert!(copied.success());
        }),
        ("LOCK was moved or removed", |life, _| fs::remove_file(life.join("LOCK")).unwrap()),
        ("LOCK was moved or removed, and another", |life, _| {
            fs::remove_file(life.join("LOCK")).unwrap();
            fs::write(life.join("LOCK"), "").unwrap();
        }),
        ("journal was moved or removed", |life, away| fs::rename(life.join("journal"), away).unwrap()),
        ("life was moved or removed", |life, _| fs::remove_dir_all(life).unwrap()),
    ];
    for (why, mishap) in mishaps {
        for idle in [false, true] {
            let above = tempfile::tempdir().unwrap();
            let (life, away) = (above.path().join("life"), above.path().join("away"));
            let (mut learner, mut store, mut world) = living(&life);
            mishap(&life, &away);
            let error = if idle {
                let start = Instant::now();
                loop {
                    if let Some(error) = store.failure() {
                        break error;
                    }
                    assert!(start.elapsed() < Duration::from_secs(60), "{why}: not noticed");
                    std::thread::yield_now();
                }
            } else {
                lived(&mut learner, &mut store, &mut world).unwrap_err()
            };
            let error = error.to_string();
            assert!(error.contains(why), "wanted {why:?}, idle {idle}: {error}");
        }
    }
}

#[test]
fn who_took_the_lock_that_was_removed_goes_on_alone() {
    let above = tempfile::tempdir().unwrap();
    let life = above.path().join("life");
    let (mut learner, mut store, mut world) = living(&life);
    let acknowledged = learner.memory().content().step;
    assert!(matches!(opened(&life), Err(StoreError::Locked { .. })));
    fs::remove_file(life.join("LOCK")).unwrap();
    let (mut other, mut others, begun) = opened(&life).unwrap();
    assert!(!begun && other.memory().content().step >= acknowledged);
    attach(&mut other, &mut others).unwrap();
    let mut elsewhere = world.clone();
    lived(&mut learner, &mut store, &mut world).unwrap_err();
    for _ in 0..20 {
        lived(&mut other, &mut others, &mut elsewhere).unwrap();
    }
    store.finish(learner.memory()).unwrap_err();
    others.finish(other.memory()).unwrap();
    assert_eq!(opened(&life).unwrap().0.memory().content().step, other.memory().content().step);
}

#[test]
fn an_empty_directory_that_did_not_come_along_is_made_and_a_journal_that_did_not_is_missed() {
    let above = tempfile::tempdir().unwrap();
    let life = above.path().join("life");
    let (mut learner, store, mut world) = living(&life);
    let taken = learner.memory().content().step;
    // Killed before the first snapshot.
    drop(store);
    fs::remove_dir(life.join("snapshot")).unwrap();
    let (found, mut store, _) = opened(&life).unwrap();
    assert_eq!(found.memory().content().step, taken);
    lived(&mut learner, &mut store, &mut world).unwrap();
    store.finish(learner.memory()).unwrap();
    assert_eq!(fs::read_dir(life.join("snapshot")).unwrap().count(), 1);

    fs::rename(life.join("journal"), above.path().join("journal")).unwrap();
    let error = opened(&life).unwrap_err().to_string();
    assert!(error.contains("journal is missing") && !life.join("journal").exists(), "{error}");
    fs::rename(above.path().join("journal"), life.join("journal")).unwrap();
    opened(&life).unwrap();
}

/// The removal was told at the next snapshot only, as a file that could not be created; until then steps were acknowledged that
/// the next start could not have found.
#[test]
fn a_removed_directory_of_snapshots_is_made_again_while_it_is_empty_and_missed_when_it_is_not() {
    let above = tempfile::tempdir().unwrap();
    let life = above.path().join("life");
    let (snapshots, away) = (life.join("snapshot"), above.path().join("away"));
    let (mut learner, mut store, mut world) = living(&life);
    fs::remove_dir(&snapshots).unwrap();
    lived(&mut learner, &mut store, &mut world).unwrap();
    assert!(snapshots.is_dir(), "made again");
    store.finish(learner.memory()).unwrap();
    let taken = learner.memory().content().step;
    for in_its_place in [false, true] {
        for idle in [false, true] {
            let (mut learner, mut store, _) = opened(&life).unwrap();
            fs::rename(&snapshots, &away).unwrap();
            if in_its_place {
                fs::create_dir(&snapshots).unwrap();
            }
            let error = if idle {
                let start = Instant::now();
                loop {
                    if let Some(error) = store.failure() {
                        break error;
                    }
                    assert!(start.elapsed() < Duration::from_secs(60), "not noticed");
                    std::thread::yield_now();
                }
            } else {
                lived(&mut learner, &mut store, &mut world.clone()).unwrap_err()
            };
            let error = error.to_string();
            assert!(error.contains(".snapshot was moved or removed. Every step"), "{error}");
            drop(store);
            drop(fs::remove_dir_all(&snapshots));
            fs::rename(&away, &snapshots).unwrap();
            assert!(opened(&life).unwrap().0.memory().content().step >= taken);
        }
    }
}

/// Until the next start nobody noticed: steps were acknowledged that it could not have found.
#[test]
fn files_that_a_start_needs_and_that_are_removed_replaced_or_cut_short_under_a_daemon_end_it() {
    type Mishap = fn(&Path);
    fn segment(life: &Path, newest: bool) -> PathBuf {
        let found = fs::read_dir(life.join("journal")).unwrap().map(|found| found.unwrap().path());
        if newest { found.max().unwrap() } else { found.min().unwrap() }
    }
    fn cut(path: &Path) {
        fs::OpenOptions::new().write(true).open(path).unwrap().set_len(0).unwrap();
    }
    let mishaps: [(&str, Mishap); 6] = [
        ("manifest was moved or removed. Every step", |life| fs::remove_file(life.join("manifest")).unwrap()),
        ("manifest was changed, or another", |life| {
            fs::rename(life.join("LOCK"), life.join("manifest")).unwrap();
            fs::hard_link(life.join("manifest"), life.join("LOCK")).unwrap();
        }),
        (".journal was moved or removed. Every step", |life| fs::remove_file(segment(life, false)).unwrap()),
        (".journal was cut short by another program", |life| cut(&segment(life, false))),
        (".journal was moved or removed. Every step", |life| fs::remove_file(segment(life, true)).unwrap()),
        (".journal was cut short by another program", |life| cut(&segment(life, true))),
    ];
    for (why, mishap) in mishaps {
        for idle in [false, true] {
            let above = tempfile::tempdir().unwrap();
            let life = above.path().join("life");
            let (_, store, mut world) = living(&life);
            // Killed before the first snapshot; the next start begins another segment.
            drop(store);
            let (mut learner, mut store, _) = opened(&life).unwrap();
            lived(&mut learner, &mut store, &mut world).unwrap();
            mishap(&life);
            let start = Instant::now();
            let error = loop {
                let lived = if idle { Ok(()) } else { lived(&mut learner, &mut store, &mut world) };
                if let Some(error) = lived.err().or_else(|| store.failure()) {
                    break error.to_string();
                }
                assert!(start.elapsed() < Duration::from_secs(60), "{why}, idle {idle}: not noticed");
                std::thread::yield_now();
            };
            assert!(error.contains(why), "wanted {why:?}, idle {idle}: {error}");
        }
    }
}

#[test]
fn a_memory_is_not_begun_among_files_of_others() {
    let above = tempfile::tempdir().unwrap();
    for name in ["thesis.tex", "a", "b", "c", "d"] {
        fs::write(above.path().join(name), "mine").unwrap();
    }
    let error = opened(above.path()).unwrap_err().to_string();
    assert!(error.contains(r#"("a", "b", "c", …)"#), "{error}");
    assert!(!above.path().join("LOCK").exists(), "it is left as it was");
    // The root of a file system of its own is as good as empty; and a memory may have files of others beside it.
    let own = above.path().join("own");
    fs::create_dir_all(own.join("lost+found")).unwrap();
    let (learner, store, begun) = opened(&own).unwrap();
    assert!(begun);
    store.finish(learner.memory()).unwrap();
    fs::write(own.join("notes.txt"), "mine").unwrap();
    assert!(!opened(&own).unwrap().2);
}
