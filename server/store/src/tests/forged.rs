//! Files that somebody forged, with every checksum right: they are refused, or a learner can live with what they say.

use std::sync::Arc;

use pschema_learner::Learner;
use pschema_learner::digest::digest;
use pschema_learner::mechanisms::Mechanisms;
use pschema_learner::memory::Memory;
use pschema_learner::observation::{Pattern, PropertyId, Term, TypeId, Value};
use pschema_learner::parameters::Parameters;
use pschema_learner::random::Random;
use pschema_learner::vocabulary::BodyId;

use crate::format::v1;
use crate::journal::segment_name;
use crate::storage::Storage;
use crate::tests::store::{SIZES, World, attach, curriculum, opened, recovered, step};
use crate::tests::twin::Twin;
use crate::{codec, frame, manifest, snapshot};

/// Sound checksums before anything at all: refused or read, but the process lives.
#[test]
fn forged_frames_end_nothing() {
    let mut random = Random::from_seed(11);
    let (twin, mut world) = (Twin::new(), World::new(1));
    let (mut learner, mut store, _) = opened(&twin, 1, 1_000_000).unwrap();
    attach(&mut learner, &mut store).unwrap();
    let mut payloads = Vec::new();
    for _ in 0..60 {
        let frame = world.frame();
        let taken = learner.step(&frame);
        store.append(&step(&frame, &taken), learner.memory().content()).unwrap();
        let next = learner.memory().content().step + 1;
        payloads.push(codec::encode(&step(&frame, &taken).record(next)).unwrap());
        world.follow(&taken.output);
    }
    drop(store);
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
        let end = recovered(&*storage, &manifest, None).unwrap().end;
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
    let (mut learner, mut store, _) = opened(&twin, 1, 1_000_000).unwrap();
    attach(&mut learner, &mut store).unwrap();
    for _ in 0..400 {
        let frame = world.frame();
        let taken = learner.step(&frame);
        store.append(&step(&frame, &taken), learner.memory().content()).unwrap();
        world.follow(&taken.output);
    }
    store.finish(learner.memory()).unwrap();
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
    assert!(rest.is_empty() && blocks.len() > 1);
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
        match snapshot::search(&twin, None).unwrap().sound {
            Some((whole, _)) => assert_eq!(digest(&whole.content), digest(learner.memory().content())),
            None => refused += 1,
        }
    }
    assert!(refused > 3_000, "{refused}");
}

/// As forged snapshots, by somebody who sets the digest right as well: what is said of a memory is changed, number by number.
/// It is refused, or a learner can live with it.
#[test]
fn no_learner_is_ended_by_what_is_said_of_its_memory() {
    let (refused, lived) = forged_memories(Mechanisms::PAPER, 300, 6_000);
    assert!(refused > 1_000 && lived > 1_000, "{refused} refused, {lived} lived");
    let (refused, lived) = forged_memories(Mechanisms::FULL, 60, 1_000);
    assert!(refused > 200 && lived > 200, "{refused} refused, {lived} lived");
}

/// How many of `cases` forged memories, of a life of `steps`, are refused, and with how many a learner can live.
fn forged_memories(mechanisms: Mechanisms, steps: u32, cases: u32) -> (u32, u32) {
    let twin = Twin::new();
    let (mut learner, mut store, _) = opened(&twin, 3, 1_000_000).unwrap();
    attach(&mut learner, &mut store).unwrap();
    learner.set_mechanisms(mechanisms);
    let (mut world, mut random) = (World::new(3), Random::from_seed(3));
    for number in 0..steps {
        if number == steps - 50 {
            let goal = Pattern::new(TypeId(0), [(PropertyId(0), Term::Constant(Value::Integer(3)))]);
            learner.pursue(BodyId(0), vec![goal], 90).unwrap();
        }
        let taken = learner.step(&world.frame());
        world.follow(&taken.output);
    }
    let setting = v1::Setting::new(&Parameters::default(), &curriculum());
    let items: Vec<_> = v1::items(learner.memory().content(), &setting).collect();
    let json: Vec<_> = items.iter().map(|item| serde_json::to_value(item).unwrap()).collect();
    let (mut refused, mut lived) = (0, 0);
    for _ in 0..cases {
        let mut items = items.clone();
        for _ in 0..=random.below(2) {
            let at = random.below(items.len());
            let mut forged = json[at].clone();
            let numbers = numbers(&forged);
            if let Some(pointer) = numbers.get(random.below(numbers.len().max(1))) {
                let number = [0, 1, 2, 5, 90, 70_000, u64::from(u32::MAX), u64::MAX][random.below(8)];
                *forged.pointer_mut(pointer).unwrap() = number.into();
            }
            if let Ok(forged) = serde_json::from_value(forged) {
                items[at] = forged;
            }
        }
        if random.below(4) == 0 {
            let (one, other) = (random.below(items.len()), random.below(items.len()));
            items.swap(one, other);
        }
        let end = v1::End { items: items.len() as u64, memory_digest: String::new() };
        let mut items = items.into_iter();
        let whole = v1::Assembly::begin(items.next().unwrap()).and_then(|mut assembly| {
            items.try_for_each(|item| assembly.take(item))?;
            assembly.end(end)
        });
        let Ok(whole) = whole else {
            refused += 1;
            continue;
        };
        assert_eq!(digest(&whole.content).len(), 64);
        let (parameters, curriculum) = whole.setting.checked().unwrap();
        let memory = Memory::restore(whole.content, parameters);
        let Ok(mut learner) = Learner::resume(memory, curriculum) else { continue };
        for _ in 0..4 {
            let taken = learner.step(&world.frame());
            world.follow(&taken.output);
        }
        assert_eq!(digest(learner.memory().content()).len(), 64);
        lived += 1;
    }
    (refused, lived)
}

/// Where there are numbers in a value of JSON.
fn numbers(value: &serde_json::Value) -> Vec<String> {
    let below = |key: String, value: &serde_json::Value| {
        numbers(value).into_iter().map(move |rest| format!("/{key}{rest}")).collect::<Vec<_>>()
    };
    match value {
        serde_json::Value::Number(_) => vec![String::new()],
        serde_json::Value::Array(list) => {
            list.iter().enumerate().flat_map(|(at, value)| below(at.to_string(), value)).collect()
        }
        serde_json::Value::Object(map) => {
            map.iter().flat_map(|(key, value)| below(key.clone(), value)).collect()
        }
        _ => Vec::new(),
    }
}
