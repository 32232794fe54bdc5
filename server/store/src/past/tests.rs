//! The past of small lives, each step of which is known.

use std::path::PathBuf;
use std::sync::Arc;

use pschema_learner::decision::Decision;
use pschema_learner::digest::digest;
use pschema_learner::parameters::Parameters;
use pschema_learner::progress::StageCommand;
use pschema_learner::random::Random;
use pschema_learner::{Frame, Learner};

use super::*;
use crate::Store;
use crate::journal::{Sizes, segment_name};
use crate::storage::{Directory, Storage};
use crate::tests::store::{World, curriculum, declaration};
use crate::tests::twin::Twin;
use crate::{Change, Durability, Options, Retention};

pub(super) const SIZES: Sizes = Sizes { segment_max: 30_000, ahead: 3_000 };

/// A life on disk, and what it was after each step, up to the next.
pub(super) struct Life {
    pub(super) twin: Twin,
    /// By step, from 0.
    pub(super) digests: Vec<String>,
    frames: Vec<Option<Frame>>,
    decisions: Vec<Option<Decision>>,
}

impl Life {
    pub(super) fn past(&self) -> Past {
        past(&self.twin)
    }

    pub(super) fn last(&self) -> u64 {
        self.digests.len() as u64 - 1
    }
}

pub(crate) fn past(twin: &Twin) -> Past {
    Past::of(Arc::new(twin.clone()), PathBuf::from("twin")).unwrap()
}

pub(super) fn opened(twin: &Twin, seed: u64, retention: Retention) -> (Learner, Store) {
    let (parameters, curriculum) = (Parameters::default(), curriculum());
    let mut options = Options::new("test", seed, &parameters, &curriculum);
    options.durability = Durability::Strict;
    options.retention = retention;
    let found = crate::open::open_in(Arc::new(twin.clone()), options, SIZES, Arc::new(|| ())).unwrap();
    (found.learner, found.store)
}

/// Some lives of `steps` steps each, of one memory. The last one ends as it should, or is cut off.
pub(super) fn lived(seed: u64, lives: u32, steps: u64, retention: Retention, clean: bool) -> Life {
    let (twin, mut world) = (Twin::new(), World::new(seed));
    let mut lived = Life { twin, digests: vec![String::new()], frames: vec![None], decisions: vec![None] };
    for life in 0..lives {
        let (mut learner, mut store) = opened(&lived.twin, seed, retention);
        let (_, mut effects) = learner.declare(declaration()).unwrap();
        for symbol in ["red", "blue"] {
            effects.extend(learner.symbol(symbol).1);
        }
        append(&mut store, &learner, crate::Cause::Declared("row"), &effects);
        *lived.digests.last_mut().unwrap() = digest(learner.memory().content());
        for step in 0..steps {
            let frame = world.frame();
            let ordered = |learner: &mut Learner, command| learner.stage(&command).unwrap();
            // Now and then an operator holds it and asks for this one step, which is one batch.
            let single = step % 89 == 40;
            let taken = if single {
                let held = ordered(&mut learner, StageCommand::Hold);
                append(&mut store, &learner, crate::Cause::Order("stage step"), &held);
                *lived.digests.last_mut().unwrap() = digest(learner.memory().content());
                learner.single_step(&frame)
            } else {
                learner.step(&frame)
            };
            append(&mut store, &learner, crate::Cause::Step(&frame), &taken.effects);
            world.follow(&taken.output);
            if single {
                let resumed = ordered(&mut learner, StageCommand::Resume);
                append(&mut store, &learner, crate::Cause::Order("stage resume"), &resumed);
            }
            if step % 97 == 50 {
                for command in [StageCommand::Hold, StageCommand::Resume] {
                    let effects = learner.stage(&command).unwrap();
                    append(&mut store, &learner, crate::Cause::Order("an order"), &effects);
                }
            }
            lived.digests.push(digest(learner.memory().content()));
            lived.frames.push(Some(frame));
            lived.decisions.push(taken.decision);
        }
        if clean || life + 1 < lives {
            store.finish(learner.memory()).unwrap();
        }
    }
    lived
}

fn append(
    store: &mut Store,
    learner: &Learner,
    cause: crate::Cause<'_>,
    effects: &[pschema_learner::effect::Effect],
) {
    let change = Change { cause, at_unix_ms: 1_795_330_800_000, effects };
    let batch = store.append(&change, learner.memory().content()).unwrap();
    while !store.is_durable(batch) {
        assert!(store.failure().is_none(), "{:?}", store.failure());
        std::thread::yield_now();
    }
    // A snapshot is made beside the steps; a test wants to know which.
    while store.is_archiving() {
        std::thread::yield_now();
    }
}

pub(super) fn all() -> Retention {
    Retention { snapshot_bytes: 50_000, history_bytes: None }
}

#[test]
fn memory_is_what_it_was_after_any_step() {
    for (seed, retention) in [(1, all()), (2, Retention { snapshot_bytes: u64::MAX, history_bytes: None })] {
        let lived = lived(seed, 3, 250, retention, seed == 1);
        let past = lived.past();
        let mut random = Random::from_seed(seed);
        let sampled = (0..40).map(|_| random.below(lived.digests.len()));
        for step in sampled.chain([0, 1, 250, 251, 499, 500, 501, 749, 750]) {
            let moment = past.moment(Some(step as u64)).unwrap();
            assert_eq!(moment.memory_digest(), lived.digests[step], "seed {seed}, step {step}");
            let perceived = moment.perceived.map(|(_, observations)| observations);
            let frame = lived.frames[step].as_ref();
            assert_eq!(
                perceived.as_ref(),
                frame.map(|frame| &frame.observations),
                "seed {seed}, step {step}"
            );
            match &lived.decisions[step] {
                Some(decided) => {
                    let moment = past.decision(Some(step as u64), None).unwrap();
                    assert_eq!(moment.decision.as_ref(), Some(decided), "seed {seed}, step {step}");
                    assert_eq!(decided.step, step as u64, "the step that is asked for");
                }
                None => assert!(past.decision(Some(step as u64), None).is_err(), "seed {seed}, step {step}"),
            }
        }
        let now = past.moment(None).unwrap();
        assert_eq!((now.step(), now.memory_digest()), (lived.last(), lived.digests.last().unwrap().clone()));
        let last = (0..lived.decisions.len()).rfind(|at| lived.decisions[*at].is_some()).unwrap();
        assert_eq!(past.moment_with_decision(None).unwrap().decision, lived.decisions[last]);
        assert_eq!(past.decision(None, Some(300)).unwrap().decision, lived.decisions[300]);
    }
}

#[test]
fn steps_that_are_not_there_are_answered_with_those_that_are() {
    let lived = lived(3, 2, 600, Retention { snapshot_bytes: 30_000, history_bytes: Some(0) }, true);
    let past = lived.past();
    let oldest = past.files().unwrap().oldest_step;
    assert!((1..1_200).contains(&oldest), "{oldest}");
    assert_eq!(past.moment(Some(oldest)).unwrap().memory_digest(), lived.digests[oldest as usize]);
    let error = past.moment(Some(oldest - 1)).unwrap_err();
    assert!(matches!(error, PastError::Before { first, .. } if first == oldest), "{error}");
    // The journal goes back a little further, to the beginning of a segment.
    let listed = past.batches(Some(0), None, 1, false).unwrap().0[0].step;
    assert!((2..=oldest).contains(&listed), "{listed}");
    let error = past.batches(None, Some(listed - 2), 9, false).unwrap_err();
    assert!(matches!(error, PastError::Before { asked, .. } if asked == listed - 2), "{error}");
    let error = past.moment(Some(1_201)).unwrap_err();
    assert!(matches!(error, PastError::Beyond { last: 1_200, .. }), "{error}");
    assert!(matches!(past.decision(Some(1_201), None), Err(PastError::Beyond { .. })));
    assert!(matches!(past.decision(Some(0), None), Err(PastError::Undecided { .. })));
    let nothing = Past::of(Arc::new(Twin::new()), PathBuf::from("twin"));
    assert!(matches!(nothing, Err(PastError::Nothing { .. })));
}

#[test]
fn the_journal_is_listed_from_either_end() {
    let lived = lived(4, 2, 300, all(), true);
    let past = lived.past();
    let steps = |from, to, limit| {
        let (batches, tail) = past.batches(from, to, limit, false).unwrap();
        assert_eq!(tail, Tail::Whole);
        batches.iter().map(|batch| batch.step).collect::<Vec<_>>()
    };
    assert_eq!(steps(None, None, 3), [598, 599, 600]);
    assert_eq!(steps(Some(100), None, 3), [100, 101, 102]);
    assert_eq!(steps(Some(100), Some(101), 30), [100, 101]);
    assert_eq!(
        steps(None, Some(300), 2),
        [299, 300, 300][1..].to_vec(),
        "with what came before the next step"
    );
    assert_eq!(steps(Some(0), Some(0), 9), [0], "the body attached");
    let error = past.batches(Some(601), None, 9, false).unwrap_err();
    assert!(matches!(error, PastError::Beyond { asked: 601, last: 600, .. }), "{error}");
    // Each life is declared, and three times given two orders, and three times one before a step and one after it.
    assert_eq!(steps(Some(0), None, 5_000).len(), 600 + 2 + 2 * 2 * 3 + 2 * 2 * 3);

    let (batches, _) = past.batches(Some(1), Some(600), 5_000, true).unwrap();
    assert!(
        batches
            .iter()
            .all(|batch| batch.told.len() as u32 == batch.effects.iter().map(|e| e.count).sum::<u32>())
    );
    let told: Vec<_> = batches.iter().flat_map(|batch| &batch.told).map(|told| told.text.as_str()).collect();
    for wanted in
        ["a schema is made: ", " / move(reach=0.29) / ", "finger{field=", "an operator holds the learner"]
    {
        assert!(told.iter().any(|text| text.contains(wanted)), "{wanted}");
    }
    assert!(
        !told.iter().any(|text| text.contains('?') || text.contains("primitive")),
        "everything has a name"
    );
}

#[test]
fn what_is_sound_is_found_sound_and_can_be_learnt_again() {
    for (seed, clean) in [(5, true), (6, false)] {
        let lived = lived(seed, 3, 400, all(), clean);
        let mut last = 0;
        let checked = lived.past().verify(true, &mut |progress| {
            assert!(progress.bytes <= progress.of && progress.bytes >= last);
            last = progress.bytes;
        });
        let checked = checked.unwrap();
        assert!(checked.sound, "{:?}", checked.findings);
        assert_eq!((checked.first_step, checked.last_step), (Some(0), Some(1_200)));
        assert_eq!(checked.memory_digest.as_ref(), lived.digests.last());
        assert_eq!(checked.relearnt, Some(1_200));
        assert!(checked.snapshots >= 3 && checked.digests >= checked.snapshots, "{checked:?}");
        assert!(checked.batches > 1_200 && checked.frames > checked.batches);
    }
}

/// Whatever bit is flipped of what says something, it is noticed, and the steps that it costs are named.
#[test]
fn no_damage_goes_unnoticed() {
    let lived = lived(7, 2, 150, all(), true);
    let past = lived.past();
    let (_, tail) = past.batches(None, None, 1, false).unwrap();
    assert_eq!(tail, Tail::Whole);
    let files = past.files().unwrap();
    let mut random = Random::from_seed(7);
    let last = files.segments.last().unwrap().file.clone();
    for case in 0..120 {
        let names =
            files.segments.iter().map(|one| &one.file).chain(files.snapshots.iter().map(|one| &one.file));
        let names: Vec<_> = names.collect();
        let name = names[random.below(names.len())];
        let twin = lived.twin.copy();
        // The end of the last file can't be told from one that was torn.
        let bytes = twin.read(name).unwrap().len() - if *name == last { 200 } else { 0 };
        let bit = random.below(bytes * 8);
        twin.flip(name, bit);
        let checked = super::tests::past(&twin).verify(false, &mut |_| ()).unwrap();
        assert!(!checked.sound, "case {case}: bit {bit} of {name}");
        for finding in checked.findings {
            if let (Some(from), Some(to)) = (finding.lost_from, finding.lost_to) {
                assert!(from <= to && to <= lived.last() && from >= 1, "{finding:?}");
                assert_eq!(checked.last_step, Some(from - 1));
            }
        }
    }
}

#[test]
fn a_life_branches_off() {
    let lived = lived(8, 2, 300, all(), true);
    let directory = tempfile::tempdir().unwrap();
    // The twin's files as real ones, for a branch is made on a disk.
    let real = directory.path().join("life");
    for name in super::cut::files(&lived.twin).unwrap() {
        let path = real.join(&name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, lived.twin.read(&name).unwrap()).unwrap();
    }
    let past = Past::open(&real).unwrap();
    let out = directory.path().join("branch");
    let made = past.branch(Some(123), &out).unwrap();
    assert_eq!((made.step, &made.memory_digest), (123, &lived.digests[123]));
    let branch = Past::open(&out).unwrap();
    assert_eq!(branch.moment(None).unwrap().memory_digest(), lived.digests[123]);
    assert_eq!(branch.moment(Some(60)).unwrap().memory_digest(), lived.digests[60], "it has its past");
    assert!(branch.verify(true, &mut |_| ()).unwrap().sound);
    assert!(matches!(past.branch(Some(5), &out), Err(PastError::Taken { .. })));
    let (parameters, curriculum) = (Parameters::default(), curriculum());
    let opened = crate::open(&out, Options::new("other", 8, &parameters, &curriculum), || ()).unwrap();
    assert_eq!(digest(opened.learner.memory().content()), lived.digests[123], "a daemon goes on from it");
    assert_eq!(
        past.moment(None).unwrap().memory_digest(),
        *lived.digests.last().unwrap(),
        "the life is as it was"
    );
    assert!(segment_name(1).contains("journal"));
}

/// A daemon that writes, makes snapshots and drops what it keeps no longer, and somebody who looks all the while.
#[test]
fn beside_a_daemon_nothing_sound_is_taken_for_damaged() {
    let directory = tempfile::tempdir().unwrap();
    let storage: Arc<dyn Storage> = Arc::new(Directory::new(directory.path()));
    let (parameters, curriculum) = (Parameters::default(), curriculum());
    let mut options = Options::new("test", 9, &parameters, &curriculum);
    options.durability = Durability::Relaxed;
    options.retention = Retention { snapshot_bytes: 40_000, history_bytes: Some(100_000) };
    let found = crate::open::open_in(storage, options, SIZES, Arc::new(|| ())).unwrap();
    let (mut learner, mut store) = (found.learner, found.store);
    let (_, mut effects) = learner.declare(declaration()).unwrap();
    for symbol in ["red", "blue"] {
        effects.extend(learner.symbol(symbol).1);
    }
    append(&mut store, &learner, crate::Cause::Declared("row"), &effects);
    let done = std::sync::atomic::AtomicBool::new(false);
    let looked = std::thread::scope(|scope| {
        let looking = scope.spawn(|| {
            let past = Past::open(directory.path()).unwrap();
            let (mut looked, mut last) = (0, 0);
            while !done.load(std::sync::atomic::Ordering::Relaxed) || looked < 3 {
                let moment = past.moment(None).unwrap();
                assert!(moment.step() >= last, "it goes on: {} after {last}", moment.step());
                last = moment.step();
                let (_, tail) = past.batches(None, None, 10, false).unwrap();
                assert!(!matches!(tail, Tail::Damaged { .. }), "{tail:?}");
                let checked = past.verify(false, &mut |_| ()).unwrap();
                assert!(checked.sound, "{:?}", checked.findings);
                let repair = past.plan_repair().unwrap();
                assert!(repair.damage.is_empty(), "{:?}", repair.damage);
                looked += 1;
            }
            looked
        });
        let mut world = World::new(9);
        for _ in 0..6_000 {
            let frame = world.frame();
            let step = learner.step(&frame);
            let cause = crate::Cause::Step(&frame);
            let change = Change { cause, at_unix_ms: 0, effects: &step.effects };
            store.append(&change, learner.memory().content()).unwrap();
            world.follow(&step.output);
        }
        done.store(true, std::sync::atomic::Ordering::Relaxed);
        looking.join().unwrap()
    });
    assert!(looked >= 3, "{looked}");
}
