//! A disk that takes its time.

use std::time::Duration;

use pschema_learner::parameters::Parameters;

use crate::error::StoreError;
use crate::store::Ending;
use crate::tests::store::{World, attach, curriculum, opened, opened_as, options, settled, step};
use crate::tests::twin::Twin;
use crate::writer::WAITING_MAX;
use crate::{Durability, Options};

#[test]
fn under_relaxed_durability_a_disk_that_does_not_confirm_holds_messages_back_and_nothing_else() {
    let (twin, mut world) = (Twin::new(), World::new(3));
    let (parameters, curriculum) = (Parameters::default(), curriculum());
    let relaxed = Options { durability: Durability::Relaxed, ..options(3, &parameters, &curriculum) };
    let (mut learner, mut store, _) = opened_as(&twin, relaxed).unwrap();
    attach(&mut learner, &mut store).unwrap();
    twin.hold_syncs(true);
    let mut held_back = None;
    for _ in 0..3 * WAITING_MAX {
        let frame = world.frame();
        let taken = learner.step(&frame);
        // This returned only when the disk had written an earlier batch.
        let batch = store.append(&step(&frame, &taken), learner.memory().content()).unwrap();
        if !store.may_leave(batch) {
            held_back = held_back.or(Some(batch));
        }
        world.follow(&taken.output);
    }
    let held_back = held_back.expect("messages are held back when too many batches wait");
    assert!(held_back > WAITING_MAX, "{held_back} of them waited for the disk");
    twin.hold_syncs(false);
    while !store.may_leave(3 * WAITING_MAX) {
        assert!(store.failure().is_none());
        std::thread::yield_now();
    }
    let last = learner.memory().content().step;
    store.finish(learner.memory()).unwrap();
    let (_, _, found) = opened(&twin, 3, 1_000_000).unwrap();
    assert_eq!(found.step, last);
}

#[test]
fn the_end_waits_for_a_slow_disk_no_longer_than_it_was_told() {
    for (snapshot_only, patience) in [(false, Duration::ZERO), (true, Duration::ZERO), (false, Duration::MAX)]
    {
        let (twin, mut world) = (Twin::new(), World::new(3));
        let (mut learner, mut store, _) = opened(&twin, 3, 1_000_000).unwrap();
        attach(&mut learner, &mut store).unwrap();
        let frame = world.frame();
        let taken = learner.step(&frame);
        let batch = store.append(&step(&frame, &taken), learner.memory().content()).unwrap();
        settled(&store, batch).unwrap();
        if patience > Duration::ZERO {
            assert_eq!(store.finish_within(learner.memory(), patience).unwrap(), Ending::Whole);
        } else if snapshot_only {
            twin.hold_snapshots(true);
            // The journal is not held up; how long it takes is the machine's.
            let ended = loop {
                match store.finish_within(learner.memory(), Duration::from_millis(200)) {
                    Err(StoreError::Slow { .. }) => {
                        (learner, store, _) = opened(&twin.copy(), 3, 1_000_000).unwrap();
                    }
                    ended => break ended.unwrap(),
                }
            };
            assert_eq!(ended, Ending::WithoutSnapshot);
        } else {
            twin.hold_syncs(true);
            let ended = store.finish_within(learner.memory(), patience).unwrap_err();
            assert!(matches!(ended, StoreError::Slow { changes: 1, .. }), "{ended}");
        }
        // The threads that were left to themselves come to their end.
        twin.hold_syncs(false);
        twin.hold_snapshots(false);
    }
}
