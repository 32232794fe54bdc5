//! A memory that lives, ends and is found again: the same by digest, and deciding alike.

use std::sync::Arc;

use pschema_learner::curriculum::{Afterwards, Curriculum, Lift, Stage};
use pschema_learner::digest::digest;
use pschema_learner::effect::Effect;
use pschema_learner::observation::{Observation, PropertyId, SymbolId, TypeId, Value};
use pschema_learner::parameters::Parameters;
use pschema_learner::random::Random;
use pschema_learner::vocabulary::{
    BodyId, Declaration, DeclaredAction, DeclaredProperty, DeclaredType, Parameter, ValueKind,
};
use pschema_learner::{ActionOutcome, Frame, Learner, Output, Step};

use crate::error::StoreError;
use crate::format::v1;
use crate::journal::{Sizes, segment_name, segments};
use crate::storage::Storage;
use crate::store::open_in;
use crate::twin::{Fault, Twin};
use crate::writer::Writer;
use crate::{
    Cause, Change, Durability, Options, Recovered, Retention, codec, frame, manifest, recovery, snapshot,
};

const FIELDS: i64 = 12;
pub(crate) const SIZES: Sizes = Sizes { segment_max: 40_000, ahead: 4_000 };

/// A curriculum that asks nothing.
pub(crate) fn curriculum() -> Curriculum {
    let stage = Stage {
        name: "free".to_owned(),
        lift: Lift::All,
        learning: true,
        trials: 0,
        arrange: Vec::new(),
        until: None,
        until_absent: None,
        trial_actions_max: 0,
        saturation: None,
        habituation: None,
        say: Vec::new(),
    };
    Curriculum {
        name: "free".to_owned(),
        pools: Vec::new(),
        stages: vec![stage],
        afterwards: Afterwards::Continue,
    }
}

pub(crate) fn declaration() -> Declaration {
    let property = |name: &str, kind| DeclaredProperty { name: name.to_owned(), unit: String::new(), kind };
    let sense = |name: &str, own, transient, properties| DeclaredType {
        name: name.to_owned(),
        own,
        transient,
        heard: false,
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
        curriculum,
        seed_given: true,
        setting_given: true,
        change: false,
        at_unix_ms: 0,
        durability: Durability::Strict,
        retention: Retention { snapshot_bytes: 1_000_000, history_bytes: Some(0) },
    }
}

pub(crate) fn opened_as(
    twin: &Twin,
    options: Options<'_>,
) -> Result<(Learner, Writer, Recovered), StoreError> {
    let found = open_in(Arc::new(twin.clone()), options, SIZES, Arc::new(|| ()))?;
    let recovered = found.store.recovered().clone();
    Ok((found.learner, found.store.writer, recovered))
}

fn opened(twin: &Twin, seed: u64, snapshot_bytes: u64) -> Result<(Learner, Writer, Recovered), StoreError> {
    let (parameters, curriculum) = (Parameters::default(), curriculum());
    let retention = Retention { snapshot_bytes, history_bytes: Some(0) };
    opened_as(twin, Options { retention, ..options(seed, &parameters, &curriculum) })
}

/// A change at a time that jumps about.
pub(crate) fn step<'a>(frame: &'a Frame, step: &'a Step) -> Change<'a> {
    let at_unix_ms = frame.observations.len() as u64 * 0x1234_5678_9ABC_DEF1;
    Change { cause: Cause::Step(frame), at_unix_ms, effects: &step.effects }
}

pub(crate) fn settled(writer: &Writer, batch: u64) -> Result<(), StoreError> {
    while !writer.is_durable(batch) {
        if let Some(failure) = writer.failure() {
            return Err(failure);
        }
        std::thread::yield_now();
    }
    Ok(())
}

/// Has the body declared, which a body does whenever it attaches.
pub(crate) fn attach(learner: &mut Learner, writer: &mut Writer) -> Result<(), StoreError> {
    let (_, mut effects) = learner.declare(declaration()).unwrap();
    for symbol in ["red", "blue"] {
        effects.extend(learner.symbol(symbol).1);
    }
    let change = Change { cause: Cause::Declared("row"), at_unix_ms: u64::MAX, effects: &effects };
    writer.append(&change, learner.memory().content()).map(drop)
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
            let (mut learner, mut writer, recovered) = opened(&twin, seed, 60_000).unwrap();
            assert_eq!(recovered.step, taken, "seed {seed}, life {life}");
            snapshots += u32::from(recovered.snapshot_step.is_some());
            attach(&mut learner, &mut writer).unwrap();
            assert_eq!(digest(learner.memory().content()), digest(never_ended.memory().content()));
            for _ in 0..400 {
                let frame = world.frame();
                let (live, resumed) = (never_ended.step(&frame), learner.step(&frame));
                assert_eq!(live, resumed, "seed {seed}, life {life}, step {taken}");
                let batch = writer.append(&step(&frame, &resumed), learner.memory().content()).unwrap();
                settled(&writer, batch).unwrap();
                world.follow(&resumed.output);
                taken += 1;
            }
            if life % 2 == 0 {
                writer.finish(learner.memory().content()).unwrap();
            } else {
                drop(writer);
            }
            if life % 3 == 0 {
                twin.lose_power(&mut random);
            }
        }
        // A loss of power may have brought back what was removed; the next end removes it again.
        let (learner, writer, _) = opened(&twin, seed, 60_000).unwrap();
        writer.finish(learner.memory().content()).unwrap();
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
        let (learner, writer, _) = opened(&mended, seed, 60_000).unwrap();
        writer.finish(learner.memory().content()).unwrap();
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
        let (mut learner, mut writer, _) = opened(&twin, seed, 20_000).unwrap();
        twin.fail(match seed % 2 {
            0 => Fault::Full(random.below(40_000) as u64),
            _ => Fault::Sync(random.below(40) as u32),
        });
        let mut acknowledged = Vec::new();
        let mut live = || -> Result<(), StoreError> {
            attach(&mut learner, &mut writer)?;
            for _ in 0..3_000 {
                let frame = world.frame();
                let taken = learner.step(&frame);
                let batch = writer.append(&step(&frame, &taken), learner.memory().content())?;
                settled(&writer, batch)?;
                acknowledged.push(digest(learner.memory().content()));
                world.follow(&taken.output);
            }
            Ok(())
        };
        let error = live().unwrap_err();
        assert!(error.to_string().contains("ends before anything more"), "{error}");
        drop(writer);
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

/// Sound checksums before anything at all: refused or read, but the process lives.
#[test]
fn forged_frames_end_nothing() {
    let mut random = Random::from_seed(11);
    let (twin, mut world) = (Twin::new(), World::new(1));
    let (mut learner, mut writer, _) = opened(&twin, 1, 1_000_000).unwrap();
    attach(&mut learner, &mut writer).unwrap();
    let mut payloads = Vec::new();
    for _ in 0..60 {
        let frame = world.frame();
        let taken = learner.step(&frame);
        writer.append(&step(&frame, &taken), learner.memory().content()).unwrap();
        let next = learner.memory().content().step + 1;
        payloads.push(codec::encode(&step(&frame, &taken).record(next)).unwrap());
        world.follow(&taken.output);
    }
    drop(writer);
    let mut refused = 0;
    for _ in 0..3_000 {
        let mut payload = payloads[random.below(payloads.len())].clone();
        for _ in 0..=random.below(3) {
            let at = random.below(payload.len());
            payload[at] = random.next_u64() as u8;
        }
        let forged = twin.copy();
        let storage: Arc<dyn Storage> = Arc::new(forged.clone());
        let manifest = manifest::read(&*storage).unwrap().unwrap();
        let end = recovery::recover(&*storage, &manifest, None).unwrap().end;
        let mut journal = crate::journal::Journal::after(storage, end.last, SIZES);
        journal.append(&payload, 60).unwrap();
        journal.sync().unwrap();
        refused += u32::from(opened(&forged, 1, 1_000_000).is_err());
    }
    assert!(refused > 1_000, "{refused}");
    assert!(twin.read(&segment_name(1)).is_ok());
}

/// As forged frames: a snapshot whose every checksum is right.
#[test]
fn forged_snapshots_end_nothing() {
    let mut random = Random::from_seed(12);
    let (twin, mut world) = (Twin::new(), World::new(2));
    let (mut learner, mut writer, _) = opened(&twin, 1, 1_000_000).unwrap();
    attach(&mut learner, &mut writer).unwrap();
    for _ in 0..400 {
        let frame = world.frame();
        let taken = learner.step(&frame);
        writer.append(&step(&frame, &taken), learner.memory().content()).unwrap();
        world.follow(&taken.output);
    }
    writer.finish(learner.memory().content()).unwrap();
    let name = snapshot::name(snapshot::numbers(&twin).unwrap()[0]);
    let sound = twin.read(&name).unwrap();
    let mut rest = &sound[..];
    let mut blocks = Vec::new();
    while let Some(found) =
        frame::read(if blocks.is_empty() { snapshot::BEGIN } else { frame::SNAPSHOT }, rest)
    {
        blocks.push((found.head, found.payload.to_vec()));
        rest = &rest[found.len()..];
    }
    assert!(rest.is_empty() && blocks.len() > 4);
    let mut refused = 0;
    for _ in 0..5_000 {
        let mut blocks = blocks.clone();
        let at = random.below(blocks.len());
        for _ in 0..=random.below(3) {
            let payload = &mut blocks[at].1;
            let byte = random.below(payload.len());
            payload[byte] = random.next_u64() as u8;
        }
        let mut forged = Vec::new();
        let mut previous = blocks[0].0.previous;
        for (head, payload) in &blocks {
            let magic = if forged.is_empty() { snapshot::BEGIN } else { frame::SNAPSHOT };
            let (bytes, crc) = frame::written(magic, frame::Head { previous, ..*head }, payload);
            forged.extend(bytes);
            previous = crc;
        }
        let twin = twin.copy();
        twin.edit(&name, |bytes| *bytes = forged);
        // The digest of memory at the end sees what no checksum does.
        match snapshot::newest(&twin, None).unwrap() {
            Some((whole, _)) => assert_eq!(digest(&whole.content), digest(learner.memory().content())),
            None => refused += 1,
        }
    }
    assert!(refused > 3_000, "{refused}");
}

/// Effects survive the disk as they are.
#[test]
fn effects_come_back_as_they_were() {
    let mut world = World::new(9);
    let mut learner = Learner::new(9, Parameters::default(), curriculum()).unwrap();
    let (_, mut effects) = learner.declare(declaration()).unwrap();
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
    let back: Result<Vec<Effect>, _> = back.into_iter().map(Effect::try_from).collect();
    assert_eq!((step, at_unix_ms, Frame::from(input), back.unwrap()), (500, 7, last, effects));
    assert!(bytes.len() > 5_000);
}
