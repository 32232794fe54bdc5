//! A memory that lives, ends and is found again: the same by digest, and deciding alike.

use std::sync::Arc;

use pschema_learner::curriculum::Curriculum;
use pschema_learner::digest::digest;
use pschema_learner::effect::Effect;
use pschema_learner::mechanisms::Mechanisms;
use pschema_learner::observation::{Observation, PropertyId, SymbolId, TypeId, Value};
use pschema_learner::parameters::Parameters;
use pschema_learner::random::Random;
use pschema_learner::vocabulary::{
    BodyId, Declaration, DeclaredAction, DeclaredProperty, DeclaredType, Parameter, ValueKind,
};
use pschema_learner::{ActionOutcome, Frame, Learner, Output, Step};

use crate::error::StoreError;
use crate::format::mirror::Mirror;
use crate::format::v1;
use crate::journal::{Sizes, segments};
use crate::manifest::Manifest;
use crate::open::open_in;
use crate::recovery::{self, Recovery};
use crate::storage::Storage;
use crate::tests::twin::{Fault, Twin};
use crate::{Cause, Change, Durability, Options, RecoveryReport, Retention, Store, codec};

const FIELDS: i64 = 12;
pub(crate) const SIZES: Sizes = Sizes { segment_max: 40_000, ahead: 4_000 };

/// A curriculum that asks nothing.
pub(crate) fn curriculum() -> Curriculum {
    Curriculum::free("free")
}

pub(crate) fn declaration() -> Declaration {
    let property = |name: &str, kind| DeclaredProperty { name: name.to_owned(), unit: String::new(), kind };
    let sense = |name: &str, own, transient, properties| DeclaredType {
        name: name.to_owned(),
        own,
        transient,
        heard: false,
        value: false,
        properties,
    };
    let field = || property("field", ValueKind::Integer);
    let reach = property("reach", ValueKind::Real { resolution: 0.01 });
    Declaration {
        body: "row".to_owned(),
        observation_types: vec![
            sense("finger", true, false, vec![field()]),
            sense("object", false, false, vec![property("colour", ValueKind::Symbol), field()]),
            sense("touch", false, true, vec![]),
        ],
        actions: vec![DeclaredAction { name: "move".to_owned(), parameters: vec![reach] }],
        repertoire: (0..FIELDS).map(|at| (0, vec![Parameter::Real(at as f64 / 7.0)])).collect(),
    }
}

/// A finger over a row of fields, and a block that somebody moves now and then.
#[derive(Clone)]
pub(crate) struct World {
    random: Random,
    finger: Option<i64>,
    block: (u32, i64),
    outcome: Option<ActionOutcome>,
}

impl World {
    pub(crate) fn new(seed: u64) -> Self {
        Self { random: Random::from_seed(seed ^ 0x5151), finger: None, block: (0, 3), outcome: None }
    }

    pub(crate) fn frame(&mut self) -> Frame {
        if self.random.below(5) == 0 {
            let (colour, field) = (self.random.below(2) as u32, self.random.below(FIELDS as usize) as i64);
            self.block = (colour, field);
        }
        let field = |at| (PropertyId(0), Value::Integer(at));
        let (colour, at) = self.block;
        let mut observations =
            vec![Observation::new(TypeId(1), [(PropertyId(1), Value::Symbol(SymbolId(colour))), field(at)])];
        observations.extend(self.finger.map(|at| Observation::new(TypeId(0), [field(at)])));
        if self.finger == Some(at) && self.outcome.is_some() {
            observations.push(Observation::new(TypeId(2), []));
        }
        Frame { body: BodyId(0), outcome: self.outcome, observations }
    }

    pub(crate) fn follow(&mut self, output: &Output) {
        self.outcome = None;
        if let Output::Act(primitive) = output {
            let failed = self.random.below(20) == 0;
            self.outcome = Some(if failed { ActionOutcome::Failed } else { ActionOutcome::Done });
            self.finger = if failed { self.finger } else { Some(i64::from(primitive.0)) };
        }
    }
}

pub(crate) fn options<'a>(seed: u64, parameters: &'a Parameters, curriculum: &'a Curriculum) -> Options<'a> {
    Options {
        learner: "test",
        seed,
        parameters,
        mechanisms: Mechanisms::PAPER,
        curriculum,
        seed_given: true,
        setting_given: true,
        change: false,
        at_unix_ms: 0,
        durability: Durability::Strict,
        retention: Retention { snapshot_bytes: 1_000_000, history_bytes: Some(0) },
    }
}

/// Memory as it is in `storage`, or as it was after step `until`.
pub(crate) fn recovered(
    storage: &dyn Storage,
    manifest: &Manifest,
    until: Option<u64>,
) -> Result<Recovery, StoreError> {
    recovery::recover(storage, recovery::base(storage, manifest, until)?, until)
}

pub(crate) fn opened_as(
    twin: &Twin,
    options: Options<'_>,
) -> Result<(Learner, Store, RecoveryReport), StoreError> {
    let found = open_in(Arc::new(twin.clone()), options, SIZES, Arc::new(|| ()))?;
    let recovered = found.store.recovered().clone();
    Ok((found.learner, found.store, recovered))
}

pub(crate) fn opened(
    twin: &Twin,
    seed: u64,
    snapshot_bytes: u64,
) -> Result<(Learner, Store, RecoveryReport), StoreError> {
    let (parameters, curriculum) = (Parameters::default(), curriculum());
    let retention = Retention { snapshot_bytes, history_bytes: Some(0) };
    opened_as(twin, Options { retention, ..options(seed, &parameters, &curriculum) })
}

/// A change at a time that jumps about.
pub(crate) fn step<'a>(frame: &'a Frame, step: &'a Step) -> Change<'a> {
    let at_unix_ms = frame.observations.len() as u64 * 0x1234_5678_9ABC_DEF1;
    Change { cause: Cause::Step(frame), at_unix_ms, effects: &step.effects }
}

pub(crate) fn settled(store: &Store, batch: u64) -> Result<(), StoreError> {
    while !store.is_durable(batch) {
        if let Some(failure) = store.failure() {
            return Err(failure);
        }
        std::thread::yield_now();
    }
    Ok(())
}

/// Has the body declared, which a body does whenever it attaches.
pub(crate) fn attach(learner: &mut Learner, store: &mut Store) -> Result<(), StoreError> {
    let (_, mut effects) = learner.declare(declaration()).unwrap();
    for symbol in ["red", "blue"] {
        effects.extend(learner.symbol(symbol).1);
    }
    let change = Change { cause: Cause::Declared("row"), at_unix_ms: u64::MAX, effects: &effects };
    store.append(&change, learner.memory().content()).map(drop)
}

#[test]
fn a_memory_found_again_is_the_same_and_decides_alike() {
    for seed in 0..6 {
        let (twin, mut world) = (Twin::new(), World::new(seed));
        let mut never_ended = Learner::new(seed, Parameters::default(), curriculum()).unwrap();
        never_ended.declare(declaration()).unwrap();
        for symbol in ["red", "blue"] {
            never_ended.symbol(symbol);
        }
        let mut random = Random::from_seed(seed);
        let (mut snapshots, mut taken) = (0, 0);
        for life in 0..8 {
            let (mut learner, mut store, recovered) = opened(&twin, seed, 60_000).unwrap();
            assert_eq!(recovered.step, taken, "seed {seed}, life {life}");
            snapshots += u32::from(recovered.snapshot_step.is_some());
            attach(&mut learner, &mut store).unwrap();
            assert_eq!(digest(learner.memory().content()), digest(never_ended.memory().content()));
            for _ in 0..400 {
                let frame = world.frame();
                let (live, resumed) = (never_ended.step(&frame), learner.step(&frame));
                assert_eq!(live, resumed, "seed {seed}, life {life}, step {taken}");
                let batch = store.append(&step(&frame, &resumed), learner.memory().content()).unwrap();
                settled(&store, batch).unwrap();
                world.follow(&resumed.output);
                taken += 1;
            }
            if life % 2 == 0 {
                store.finish(learner.memory()).unwrap();
            } else {
                drop(store);
            }
            if life % 3 == 0 {
                twin.lose_power(&mut random);
            }
        }
        // A loss of power may have brought back what was removed; the next end removes it again.
        let (learner, store, _) = opened(&twin, seed, 60_000).unwrap();
        store.finish(learner.memory()).unwrap();
        twin.sync_directory("").unwrap();
        let kept = || -> Vec<String> {
            twin.list("snapshot").unwrap().into_iter().filter(|name| name.ends_with(".snapshot")).collect()
        };
        assert!(snapshots > 4 && never_ended.memory().content().schemas.len() > 100, "seed {seed}");
        assert!(segments(&twin).unwrap()[0] > 1, "old segments are dropped");
        assert_eq!(kept().len(), 2);
        // The newest snapshot damaged: the older one and the journal give the same.
        let newest = format!("snapshot/{}", kept()[1]);
        let damaged = twin.copy();
        damaged.flip(&newest, 4_000);
        let (learner, _, recovered) = opened(&damaged, seed, 60_000).unwrap();
        assert!(recovered.frames > 0);
        assert_eq!(digest(learner.memory().content()), digest(never_ended.memory().content()));
        // It counts for nothing where two are to be kept: should the next one be damaged as well, the older one is there.
        let mended = damaged.copy();
        let (learner, store, _) = opened(&mended, seed, 60_000).unwrap();
        store.finish(learner.memory()).unwrap();
        let next =
            mended.list("snapshot").unwrap().into_iter().filter(|name| name.ends_with(".snapshot")).max();
        let next = format!("snapshot/{}", next.unwrap());
        assert_ne!(next, newest);
        mended.flip(&next, 4_000);
        let (learner, _, _) = opened(&mended, seed, 60_000).unwrap();
        assert_eq!(digest(learner.memory().content()), digest(never_ended.memory().content()));
        // Both damaged: the journal does not reach back far enough, and says so.
        damaged.flip(&format!("snapshot/{}", kept()[0]), 4_000);
        let error = opened(&damaged, seed, 60_000).unwrap_err();
        assert!(error.to_string().contains("is missing"), "{error}");
    }
}

#[test]
fn after_a_failure_of_the_disk_nothing_is_durable_that_is_not_on_it() {
    for seed in 0..60 {
        let (twin, mut world) = (Twin::new(), World::new(seed));
        let mut random = Random::from_seed(seed);
        let (mut learner, mut store, _) = opened(&twin, seed, 20_000).unwrap();
        twin.fail(match seed % 2 {
            0 => Fault::Full(random.below(40_000) as u64),
            _ => Fault::Sync(random.below(40) as u32),
        });
        let mut acknowledged = Vec::new();
        let mut live = || -> Result<(), StoreError> {
            attach(&mut learner, &mut store)?;
            for _ in 0..3_000 {
                let frame = world.frame();
                let taken = learner.step(&frame);
                let batch = store.append(&step(&frame, &taken), learner.memory().content())?;
                settled(&store, batch)?;
                acknowledged.push(digest(learner.memory().content()));
                world.follow(&taken.output);
            }
            Ok(())
        };
        let error = live().unwrap_err();
        assert!(error.to_string().contains("ends before anything more"), "{error}");
        drop(store);
        twin.fail(Fault::None);
        twin.lose_power(&mut random);
        let (learner, _, recovered) = opened(&twin, seed, 20_000).unwrap();
        let at = usize::try_from(recovered.step).unwrap();
        assert!(at == acknowledged.len() || at == acknowledged.len() + 1, "seed {seed}: {at}");
        if let Some(expected) = acknowledged.last().filter(|_| at == acknowledged.len()) {
            assert_eq!(digest(learner.memory().content()), *expected, "seed {seed}");
        }
    }
}

#[test]
fn a_memory_begun_with_something_else_is_refused() {
    let twin = Twin::new();
    drop(opened(&twin, 1, 1_000_000).unwrap());
    let error = opened(&twin, 2, 1_000_000).unwrap_err().to_string();
    assert!(error.contains("begun with seed = 1, and 2 was given"), "{error}");
    let parameters = Parameters { association_weight: 0.5, ..Parameters::default() };
    let error = opened_as(&twin, options(1, &parameters, &curriculum())).unwrap_err().to_string();
    assert!(error.contains("parameters.association_weight: 0.8 there, 0.5 given"), "{error}");
}

/// Effects survive the disk as they are.
/// A body that declares names which no pattern can name is refused when it attaches. A memory that knows such names from
/// before is found again.
#[test]
fn names_that_are_refused_today_are_found_again() {
    let twin = Twin::new();
    let (mut learner, mut store, _) = opened(&twin, 1, 1 << 20).unwrap();
    let mut odd = declaration();
    "a{b=c}".clone_into(&mut odd.observation_types[1].name);
    "$x, y".clone_into(&mut odd.observation_types[1].properties[0].name);
    let (_, mut effects) = learner.declare(odd).unwrap();
    effects.extend(learner.symbol("\u{202e}red").1);
    let change = Change { cause: Cause::Declared("row"), at_unix_ms: 0, effects: &effects };
    store.append(&change, learner.memory().content()).unwrap();
    store.finish(learner.memory()).unwrap();
    let (again, ..) = opened(&twin, 1, 1 << 20).unwrap();
    assert_eq!(digest(again.memory().content()), digest(learner.memory().content()));
}

#[test]
fn effects_come_back_as_they_were() {
    let mut world = World::new(9);
    let mut learner = Learner::new(9, Parameters::default(), curriculum()).unwrap();
    let (_, mut effects) = learner.declare(declaration()).unwrap();
    effects.extend(learner.set_mechanisms(Mechanisms::FULL));
    let mut last = world.frame();
    for _ in 0..500 {
        last = world.frame();
        let step = learner.step(&last);
        world.follow(&step.output);
        effects.extend(step.effects);
    }
    let change = Change { cause: Cause::Step(&last), at_unix_ms: 7, effects: &effects };
    let bytes = codec::encode(&change.record(500)).unwrap();
    let v1::Record::Batch { step, at_unix_ms, cause: v1::Cause::Step(input), effects: back } =
        codec::decode(&bytes).unwrap()
    else {
        panic!("another record came back")
    };
    let back: Vec<Effect> = back.live();
    assert_eq!((step, at_unix_ms, input.live(), back), (500, 7, last, effects));
    assert!(bytes.len() > 5_000);
}
