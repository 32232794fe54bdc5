//! A data directory as version 1 has it, kept byte by byte in `tests/golden/v1`: every release reads it to the same memory,
//! and writes what it says in the same bytes.
//!
//! A released format is never changed, so these files are written once. `PSCHEMA_GOLDEN=write cargo test -p pschema-store
//! golden` made them.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use pschema_learner::Learner;
use pschema_learner::curriculum::{
    Absence, Afterwards, Argument, Curriculum, Habituation, Lift, NamedObservation, Pool, Saturation,
    SceneCommand, Stage, Utterance,
};
use pschema_learner::digest::digest;
use pschema_learner::effect::Effect;
use pschema_learner::observation::{Pattern, PropertyId, Term, TypeId, Value};
use pschema_learner::parameters::{Parameters, TypeOverride};
use pschema_learner::progress::StageCommand;
use pschema_learner::vocabulary::BodyId;

use crate::error::StoreError;
use crate::format::mirror::list;
use crate::format::v1::{self, Record, Setting};
use crate::journal::{self, Journal, Place, Sizes, segment_name, segments};
use crate::manifest::{self, Manifest};
use crate::storage::{Directory, Storage};
use crate::tests::store::{World, curriculum, declaration, recovered};
use crate::tests::twin::Twin;
use crate::{Cause, Change, codec, snapshot};

const SIZES: Sizes = Sizes { segment_max: 120_000, ahead: 0 };
const SEED: u64 = 1_980;

fn golden() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/v1")
}

fn expected() -> String {
    std::fs::read_to_string(golden().join("digest")).unwrap().trim().to_owned()
}

/// A curriculum that uses everything there is.
fn rich() -> Curriculum {
    let named = |name: &str, value| (name.to_owned(), value);
    let symbol = |name: &str| Argument::Symbol(name.to_owned());
    let touch = NamedObservation { kind: "touch".to_owned(), properties: Vec::new() };
    let finger = NamedObservation {
        kind: "finger".to_owned(),
        properties: vec![named("field", Argument::Integer(3))],
    };
    let red =
        NamedObservation { kind: "object".to_owned(), properties: vec![named("colour", symbol("red"))] };
    let draw = Argument::Draw("fields".to_owned());
    let place = SceneCommand {
        command: "place".to_owned(),
        arguments: vec![named("object", symbol("red-block")), named("position", draw)],
    };
    let babbling = Stage {
        name: "babbling".to_owned(),
        lift: Lift::Types(vec!["finger".to_owned(), "touch".to_owned()]),
        saturation: Some(Saturation { excitation_below: 1.0, actions: 3 }),
        habituation: Some(Habituation { executions_min: 2, interval_max: 0.5 }),
        ..crate::tests::store::curriculum().stages.remove(0)
    };
    let speaking = Stage {
        name: "speaking".to_owned(),
        lift: Lift::All,
        trials: 2,
        arrange: vec![place],
        until: Some(touch.clone()),
        until_absent: Some(Absence { observation: red.clone(), actions: 4 }),
        trial_actions_max: 6,
        saturation: None,
        habituation: None,
        say: vec![Utterance {
            heard: vec![finger, touch],
            when: Some(red.clone()),
            unless: None,
            probability: 0.75,
            times_max: 2,
        }],
        ..babbling.clone()
    };
    Curriculum {
        name: "rich".to_owned(),
        pools: vec![Pool { name: "fields".to_owned(), from: -2, to: 9 }],
        stages: vec![babbling, speaking, crate::tests::store::curriculum().stages.remove(0)],
        afterwards: Afterwards::Hold,
    }
}

/// A life in which everything happens that the format has words for.
struct Life {
    storage: Arc<dyn Storage>,
    journal: Journal,
    learner: Learner,
    world: World,
    /// Steps taken before what is put next.
    before: u64,
}

impl Life {
    fn put(&mut self, record: &Record) {
        self.journal.append(&codec::encode(record).unwrap(), self.before).unwrap();
        self.journal.sync().unwrap();
        self.before = self.learner.memory().content().step;
    }

    fn change(&mut self, cause: Cause<'_>, effects: &[Effect]) {
        let step = self.learner.memory().content().step;
        let change = Change { cause, at_unix_ms: 1_300_000_000_000 + step * 20, effects };
        self.put(&change.record(step));
    }

    fn steps(&mut self, count: usize) {
        for _ in 0..count {
            let frame = self.world.frame();
            let step = self.learner.step(&frame);
            self.world.follow(&step.output);
            self.change(Cause::Step(&frame), &step.effects);
        }
    }

    fn mark(&mut self, setting: Option<&Setting>) {
        let step = self.learner.memory().content().step;
        self.put(&Record::Mark { step });
        let (mark, content) = (self.journal.last(), self.learner.memory().content());
        let digest = digest(content);
        if let Some(setting) = setting {
            snapshot::write(&*self.storage, content, setting, mark, &digest, || false).unwrap();
        }
        self.put(&Record::Digest { mark: mark.number, step, digest });
    }
}

fn write(directory: &Path) {
    let storage: Arc<dyn Storage> = Arc::new(Directory::new(directory));
    storage.directory(journal::DIRECTORY).unwrap();
    storage.directory(snapshot::DIRECTORY).unwrap();
    let (parameters, first) = (Parameters::default(), rich());
    let setting = Setting::new(&parameters, &first);
    let manifest = Manifest { learner: "golden".to_owned(), seed: SEED, mechanisms: None, setting };
    manifest::write(&*storage, &manifest).unwrap();
    let journal = Journal::after(storage.clone(), Place::default(), SIZES);
    let learner = Learner::new(SEED, parameters.clone(), first).unwrap();
    let mut life = Life { storage, journal, learner, world: World::new(SEED), before: 0 };
    let (_, mut effects) = life.learner.declare(declaration()).unwrap();
    for symbol in ["red", "blue"] {
        effects.extend(life.learner.symbol(symbol).1);
    }
    life.change(Cause::Declared("row"), &effects);
    life.steps(30);
    let effects = life.learner.stage(&StageCommand::Set("speaking".to_owned())).unwrap();
    life.change(Cause::Order("stage set speaking"), &effects);
    life.steps(10);
    let effects = life.learner.stage(&StageCommand::Hold).unwrap();
    life.change(Cause::Order("stage hold"), &effects);
    let effects = life.learner.stage(&StageCommand::Resume).unwrap();
    life.change(Cause::Order("stage resume"), &effects);
    life.steps(360);
    life.mark(Some(&manifest.setting));
    let rule = TypeOverride { name: "touch".to_owned(), precondition: Some(false), postcondition: None };
    let parameters = Parameters { association_weight: 0.5, type_overrides: vec![rule], ..parameters };
    let effects = life.learner.change(parameters.clone(), curriculum()).unwrap();
    let setting = Box::new(Setting::new(&parameters, &curriculum()));
    let step = life.learner.memory().content().step;
    let effects = list(&effects);
    let cause = v1::Cause::Changed(setting);
    life.put(&Record::Batch { step, at_unix_ms: 1_400_000_000_000, cause, effects });
    life.steps(580);
    let goal = Pattern::new(TypeId(0), [(PropertyId(0), Term::Constant(Value::Integer(3)))]);
    let effects = life.learner.pursue(BodyId(0), vec![goal], 5).unwrap();
    life.change(Cause::Order("achieve finger{field=3} with at most 5 actions"), &effects);
    life.steps(20);
    life.mark(None);
    life.journal.end().unwrap();
    std::fs::write(directory.join("digest"), format!("{}\n", digest(life.learner.memory().content())))
        .unwrap();
}

#[test]
fn a_directory_of_version_1_is_read_to_the_memory_it_was() {
    if std::env::var("PSCHEMA_GOLDEN").is_ok_and(|how| how == "write") {
        std::fs::create_dir_all(golden()).unwrap();
        write(&golden());
    }
    let storage = Directory::new(&golden());
    let manifest = manifest::read(&storage).unwrap().unwrap();
    let found = recovered(&storage, &manifest, None).unwrap();
    assert_eq!((found.found.step, found.found.snapshot_step), (1_000, Some(400)));
    let content = found.replay.memory.content();
    assert_eq!(digest(content), expected());
    let (schemas, generalised) = (content.schemas.len(), content.generalised_count);
    assert!(generalised > 0 && content.pursuit.is_some() && schemas > 30, "{generalised} of {schemas}");
    assert!(content.schemas.iter().any(|schema| !schema.associations.is_empty()));
    assert_eq!(found.replay.digests, 1);
    // Without the snapshot, from the beginning.
    let twin = copied();
    let snapshot = twin.list(snapshot::DIRECTORY).unwrap().remove(0);
    twin.remove(&format!("{}/{snapshot}", snapshot::DIRECTORY)).unwrap();
    let found = recovered(&twin, &manifest, None).unwrap();
    assert_eq!((found.found.snapshot_step, found.replay.digests), (None, 2));
    assert_eq!(digest(found.replay.memory.content()), expected());
}

/// The golden directory in memory.
fn copied() -> Twin {
    let (twin, from) = (Twin::new(), Directory::new(&golden()));
    let mut files = vec!["manifest".to_owned()];
    for directory in [journal::DIRECTORY, snapshot::DIRECTORY] {
        files.extend(from.list(directory).unwrap().iter().map(|name| format!("{directory}/{name}")));
    }
    for name in files {
        twin.create(&name).unwrap().write_at(&from.read(&name).unwrap(), 0).unwrap();
    }
    twin
}

#[test]
fn what_it_says_is_written_in_the_same_bytes() {
    let golden = copied();
    let again = Twin::new();
    let manifest = manifest::read(&golden).unwrap().unwrap();
    manifest::write(&again, &manifest).unwrap();
    let mut journal = Journal::after(Arc::new(again.clone()), Place::default(), SIZES);
    let mut step = 0;
    journal::read::<StoreError>(&golden, Place::default(), |shown| {
        let record: Record = codec::decode(shown.payload)?;
        journal.append(&codec::encode(&record)?, step).unwrap();
        journal.sync().unwrap();
        let (Record::Batch { step: after, .. }
        | Record::Mark { step: after }
        | Record::Digest { step: after, .. }) = record;
        step = after;
        Ok(ControlFlow::Continue(()))
    })
    .unwrap();
    journal.end().unwrap();
    let (whole, place) = snapshot::search(&golden, None).unwrap().sound.unwrap();
    let said = digest(&whole.content);
    snapshot::write(&again, &whole.content, &whole.setting, place, &said, || false).unwrap();
    let snapshot = snapshot::name(place.number);
    let firsts = segments(&golden).unwrap();
    assert_eq!(firsts.len(), 2);
    let names = firsts.into_iter().map(segment_name).chain(["manifest".to_owned(), snapshot]);
    for name in names {
        assert!(golden.read(&name).unwrap() == again.read(&name).unwrap(), "{name} is written otherwise");
    }
}
