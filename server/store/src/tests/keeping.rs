//! What is kept beyond the last step: the way back to earlier ones, and what steps were taken on.

use std::ops::ControlFlow;
use std::sync::Arc;

use pschema_learner::Learner;
use pschema_learner::digest::digest;
use pschema_learner::effect::Effect;
use pschema_learner::observation::{Pattern, PropertyId, Term, TypeId, Value};
use pschema_learner::parameters::Parameters;
use pschema_learner::progress::StageCommand;
use pschema_learner::random::Random;
use pschema_learner::vocabulary::BodyId;

use crate::Store;
use crate::error::StoreError;
use crate::format::mirror::Mirror;
use crate::format::v1::{self, Record};
use crate::journal::{self, Place, segments};
use crate::open::open_in;
use crate::tests::store::{SIZES, World, attach, curriculum, opened_as, options, recovered, settled, step};
use crate::tests::twin::Twin;
use crate::{Cause, Change, Options, Retention, codec, manifest, retention};

/// A memory that lived through several daemons, with its digest after every step.
fn lived(history_bytes: Option<u64>) -> (Twin, Vec<String>) {
    let (twin, mut world) = (Twin::new(), World::new(4));
    let (parameters, curriculum) = (Parameters::default(), curriculum());
    let retention = Retention { snapshot_bytes: 30_000, history_bytes };
    let options = Options { retention, ..options(4, &parameters, &curriculum) };
    let mut digests = vec![String::new()];
    for life in 0..5 {
        let (mut learner, mut store, _) = opened_as(&twin, options).unwrap();
        attach(&mut learner, &mut store).unwrap();
        for _ in 0..600 {
            let frame = world.frame();
            let taken = learner.step(&frame);
            let batch = store.append(&step(&frame, &taken), learner.memory().content()).unwrap();
            settled(&store, batch).unwrap();
            world.follow(&taken.output);
            digests.push(digest(learner.memory().content()));
        }
        if life % 2 == 0 {
            store.finish(learner.memory()).unwrap();
        }
    }
    (twin, digests)
}

#[test]
fn every_step_in_the_history_that_is_kept_can_be_returned_to() {
    for history in [None, Some(400_000)] {
        let (twin, digests) = lived(history);
        let kept = retention::kept(&twin).unwrap();
        let manifest = manifest::read(&twin).unwrap().unwrap();
        let until = |step: usize| recovered(&twin, &manifest, Some(step as u64));
        let oldest = usize::try_from(kept.oldest_step).unwrap();
        match history {
            None => assert_eq!(oldest, 0),
            Some(history) => {
                assert!(oldest > 0 && oldest < 2_400, "{oldest}");
                assert!(kept.bytes <= history + 2 * SIZES.segment_max, "{kept:?}");
                let error = until(oldest - 1).unwrap_err().to_string();
                assert!(error.contains("is missing"), "{error}");
            }
        }
        let mut random = Random::from_seed(1);
        let somewhere = (0..30).map(|_| oldest.max(1) + random.below(3_001 - oldest.max(1)));
        for step in somewhere.chain([oldest.max(1), 3_000]) {
            let found = until(step).unwrap();
            let content = found.replay.memory.content();
            assert_eq!((content.step, &digest(content)), (step as u64, &digests[step]));
            // From no further off than snapshots are apart.
            assert!(found.found.frames < 1_500, "{:?}", found.found);
        }
    }
}

#[test]
fn steps_become_durable_while_a_snapshot_is_made() {
    let (twin, mut world) = (Twin::new(), World::new(6));
    let (parameters, curriculum) = (Parameters::default(), curriculum());
    let retention = Retention { snapshot_bytes: 5_000, history_bytes: Some(0) };
    let (mut learner, mut store, _) =
        opened_as(&twin, Options { retention, ..options(6, &parameters, &curriculum) }).unwrap();
    attach(&mut learner, &mut store).unwrap();
    twin.hold_snapshots(true);
    for _ in 0..500 {
        let frame = world.frame();
        let taken = learner.step(&frame);
        let batch = store.append(&step(&frame, &taken), learner.memory().content()).unwrap();
        settled(&store, batch).unwrap();
        world.follow(&taken.output);
    }
    assert!(store.is_archiving() && store.snapshot_step().is_none());
    assert_eq!(store.durable_step(), 500);
    twin.hold_snapshots(false);
    store.finish(learner.memory()).unwrap();
    // The one that was held back, and the last: the frames between are not lost for either.
    let numbers = crate::snapshot::numbers(&twin).unwrap();
    assert_eq!(numbers.len(), 2);
    for number in numbers {
        assert!(crate::snapshot::sound(&twin, number).unwrap().is_some());
    }
}

fn put(store: &mut Store, learner: &Learner, cause: Cause<'_>, effects: &[Effect]) {
    let change = Change { cause, at_unix_ms: 0, effects };
    store.append(&change, learner.memory().content()).unwrap();
}

/// Steps, words, orders, a goal and another curriculum.
fn eventful(twin: &Twin, steps: u64) -> Learner {
    let (mut world, mut random) = (World::new(8), Random::from_seed(8));
    let (parameters, curriculum) = (Parameters::default(), curriculum());
    let retention = Retention { snapshot_bytes: 1_000_000, history_bytes: None };
    let options = Options { retention, ..options(8, &parameters, &curriculum) };
    let (mut learner, mut store, _) = opened_as(twin, options).unwrap();
    attach(&mut learner, &mut store).unwrap();
    for number in 0..steps {
        if number == steps / 2 {
            drop(store);
            let parameters = Parameters { association_weight: 0.6, ..Parameters::default() };
            let options = Options { change: true, parameters: &parameters, ..options };
            let found = open_in(Arc::new(twin.clone()), options, SIZES, Arc::new(|| ())).unwrap();
            assert!(found.changed);
            (learner, store) = (found.learner, found.store);
        }
        match random.below(200) {
            0 => {
                for command in [StageCommand::Hold, StageCommand::Resume] {
                    let effects = learner.stage(&command).unwrap();
                    put(&mut store, &learner, Cause::Order("stage"), &effects);
                }
            }
            1 => {
                let field = Term::Constant(Value::Integer(random.below(12) as i64));
                let goal = Pattern::new(TypeId(0), [(PropertyId(0), field)]);
                // Mostly there is a goal under way, which is as well.
                if let Ok(effects) = learner.pursue(BodyId(0), vec![goal], 20) {
                    put(&mut store, &learner, Cause::Order("achieve"), &effects);
                }
            }
            _ => (),
        }
        let mut effects = Vec::new();
        if random.below(100) == 0 {
            effects.extend(learner.symbol(&format!("word{number}")).1);
        }
        let frame = world.frame();
        let taken = learner.step(&frame);
        effects.extend(taken.effects);
        put(&mut store, &learner, Cause::Step(&frame), &effects);
        world.follow(&taken.output);
    }
    store.finish(learner.memory()).unwrap();
    learner
}

/// What was perceived, put through a new learner, gives the effects that are in the journal. `PSCHEMA_RELEARN_STEPS` says
/// how many steps.
#[test]
fn replay_equals_live() {
    let steps = std::env::var("PSCHEMA_RELEARN_STEPS").map_or(10_000, |steps| steps.parse().unwrap());
    let twin = Twin::new();
    let live = eventful(&twin, steps);
    let mut learner = Learner::new(8, Parameters::default(), curriculum()).unwrap();
    let mut digests = 0;
    journal::read::<StoreError>(&twin, Place::default(), |shown| {
        let record = codec::decode(shown.payload)?;
        digests += u32::from(matches!(record, Record::Digest { .. }));
        let Record::Batch { step, cause, effects, .. } = record else { return Ok(ControlFlow::Continue(())) };
        let journalled: Vec<Effect> = effects.live();
        match cause {
            v1::Cause::Step(input) => {
                let mut again = Vec::new();
                for effect in &journalled {
                    let Effect::SymbolsMet(symbols) = effect else { break };
                    symbols.iter().for_each(|symbol| again.extend(learner.symbol(symbol).1));
                }
                again.extend(learner.step(&input.live()).effects);
                assert_eq!(again, journalled, "step {step}");
            }
            v1::Cause::Changed(setting) => {
                let (parameters, curriculum) = setting.checked()?;
                assert_eq!(learner.change(parameters, curriculum).unwrap(), journalled);
            }
            v1::Cause::Declared(_) | v1::Cause::Order(_) => {
                let mut memory = learner.clone().into_memory();
                journalled.iter().for_each(|effect| memory.apply(effect).unwrap());
                learner = Learner::resume(memory, learner.curriculum().clone()).unwrap();
            }
        }
        Ok(ControlFlow::Continue(()))
    })
    .unwrap();
    assert_eq!(digest(learner.memory().content()), digest(live.memory().content()));
    // Each was compared when it was read back.
    let manifest = manifest::read(&twin).unwrap().unwrap();
    let found = recovered(&twin, &manifest, None).unwrap();
    assert_eq!(digest(found.replay.memory.content()), digest(live.memory().content()));
    assert!(digests >= 3 && segments(&twin).unwrap()[0] == 1, "{digests} digests");
}
