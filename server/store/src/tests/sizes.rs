//! The size of a snapshot, by the number of conditions of its schemas: the figures in `docs/PERFORMANCE.md`.

use pschema_learner::Learner;
use pschema_learner::effect::Effect;
use pschema_learner::observation::{Observation, PropertyId, TypeId, Value};
use pschema_learner::parameters::Parameters;
use pschema_learner::vocabulary::PrimitiveId;

use crate::format::v1::Setting;
use crate::journal::Place;
use crate::snapshot;
use crate::storage::Storage;
use crate::tests::store::{curriculum, declaration};
use crate::tests::twin::Twin;

const SCHEMAS: i64 = 2_000;

/// Bytes for each schema, of a memory whose every schema has so many readings before its action and as many after it. None of
/// them comes twice, as of a noisy sensor at full resolution.
fn bytes_a_schema(readings: i64) -> u64 {
    let (parameters, curriculum) = (Parameters::default(), curriculum());
    let mut learner = Learner::new(1, parameters.clone(), curriculum.clone()).unwrap();
    learner.declare(declaration()).unwrap();
    let mut memory = learner.into_memory();
    let reading = |number: i64| Observation::new(TypeId(0), [(PropertyId(0), Value::Integer(number))]);
    for at in 0..SCHEMAS {
        let all =
            |from: i64| (0..readings).map(|n| reading((at * 2 + from) * readings + n)).collect::<Vec<_>>();
        let (pre, seen) = (all(0), all(1));
        let gone = pre.iter().map(|o| (o.clone(), true));
        let mut post: Vec<_> = seen.iter().map(|o| (o.clone(), false)).chain(gone).collect();
        post.sort_unstable();
        let action = PrimitiveId(u32::try_from(at % 12).unwrap());
        memory.apply(&Effect::Created { pre, action, post, parent: None, contradicts: None }).unwrap();
    }
    let twin = Twin::new();
    let digest = pschema_learner::digest::digest(memory.content());
    let setting = Setting::new(&parameters, &curriculum);
    let place = Place { number: 1, crc: 0 };
    let written = snapshot::write(&twin, memory.content(), &setting, place, &digest, || false).unwrap();
    assert!(twin.size(&format!("snapshot/{:020}.snapshot", 1)).unwrap() >= written.unwrap());
    written.unwrap() / SCHEMAS.unsigned_abs()
}

#[test]
fn a_snapshot_grows_with_the_conditions_of_its_schemas() {
    let found = [1, 3, 10, 30].map(|readings| (readings, bytes_a_schema(readings)));
    for (readings, bytes) in found {
        println!("{readings} readings before and after: {bytes} bytes a schema");
    }
    // What the pages say.
    assert!(found.iter().all(|(readings, bytes)| *bytes < 40 + 45 * readings.unsigned_abs()), "{found:?}");
    assert!((700..1_500).contains(&found[3].1), "{found:?}");
}
