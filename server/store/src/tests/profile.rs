//! A memory whose learner does more than the paper's: its evidence is found again, and its profile is kept.

use std::sync::Arc;

use pschema_learner::digest::digest;
use pschema_learner::effect::Effect;
use pschema_learner::experience::Experience;
use pschema_learner::item::{Event, Update};
use pschema_learner::mechanisms::Mechanisms;
use pschema_learner::memory::Memory;
use pschema_learner::observation::{Observation, Pattern, TypeId, Value as LearntValue};
use pschema_learner::parameters::Parameters;
use pschema_learner::policy::{Lead, Policy, PolicyRow, Yield};
use pschema_learner::pursuit::{Ending, Goal, PlanCause, PlanRecord, PursuitEffect};
use pschema_learner::random::Random;
use pschema_learner::vocabulary::{
    BodyId, Declaration, DeclaredProperty, DeclaredType, PrimitiveId, ValueKind,
};
use pschema_learner::{Frame, Learner};

use crate::error::StoreError;
use crate::format::mirror::Mirror;
use crate::past::{BatchCause, export};
use crate::storage::Storage;
use crate::tests::store::{World, attach, curriculum, opened_as, options, settled, step};
use crate::tests::twin::Twin;
use crate::{Options, RecoveryReport, Retention, Store, past};

/// Opens a memory; `change` alters what is asked for.
fn opened(
    twin: &Twin,
    change: impl FnOnce(&mut Options<'_>),
) -> Result<(Learner, Store, RecoveryReport), StoreError> {
    let (parameters, curriculum) = (Parameters::default(), curriculum());
    let retention = Retention { snapshot_bytes: 1_000_000, history_bytes: None };
    let mut options =
        Options { retention, mechanisms: Mechanisms::FULL, ..options(5, &parameters, &curriculum) };
    change(&mut options);
    opened_as(twin, options)
}

/// The next steps of a learner that is not changed by them, with what it foretold before each.
fn future(learner: &Learner, world: &World) -> Vec<impl PartialEq + std::fmt::Debug + use<>> {
    let (mut learner, mut world) = (learner.clone(), world.clone());
    let next = |_| {
        let Frame { observations, .. } = world.frame();
        let content = learner.memory().content();
        let foretell = |primitive| {
            content.evidence.foretell(
                &content.vocabulary,
                Some(BodyId(0)),
                PrimitiveId(primitive),
                &observations[..1],
            )
        };
        let foretold: Vec<_> = (0..12).map(foretell).collect();
        let taken = learner.step(&world.frame());
        world.follow(&taken.output);
        (foretold, taken)
    };
    (0..12).map(next).collect()
}

/// Several lives, ended as they should or by a loss of power; then the memory is what it would be without an end.
#[test]
fn evidence_is_found_again_and_foretells_alike() {
    let (twin, mut world, mut random) = (Twin::new(), World::new(5), Random::from_seed(5));
    let mut lived: Option<Learner> = None;
    for life in 0..4 {
        let (mut learner, mut store, recovered) = opened(&twin, |_| ()).unwrap();
        if let Some(lived) = &lived {
            let (now, then) = (learner.memory().content(), lived.memory().content());
            assert_eq!(digest(now), digest(then), "life {life}");
            assert_eq!(now.evidence, then.evidence, "life {life}");
            assert_eq!(now.items, then.items, "life {life}");
            assert_eq!((now.mechanisms, recovered.snapshot_step.is_some()), (Mechanisms::FULL, life > 0));
            assert_eq!(future(&learner, &world), future(lived, &world), "life {life}");
        }
        attach(&mut learner, &mut store).unwrap();
        for _ in 0..120 {
            let frame = world.frame();
            let taken = learner.step(&frame);
            let batch = store.append(&step(&frame, &taken), learner.memory().content()).unwrap();
            settled(&store, batch).unwrap();
            world.follow(&taken.output);
        }
        if life % 2 == 0 {
            store.finish(learner.memory()).unwrap();
        } else {
            drop(store);
            twin.lose_power(&mut random);
        }
        lived = Some(learner);
    }
    let lived = lived.unwrap();
    let content = lived.memory().content();
    assert!(content.evidence.kept().count() > 600 && content.generalised_count > 0);
    // The journal alone tells the same, each step can be learnt again, and an export brings the memory back.
    let past = past::tests::past(&twin);
    assert!(past.verify(true, &mut |_| ()).unwrap().sound);
    let (first, _) = past.batches(None, Some(0), 10, true).unwrap();
    assert_eq!(first[0].cause, BatchCause::Order { order: "profile full".to_owned() });
    assert_eq!(first[0].told[0].text, "the learner has the profile full");
    let mut bytes = Vec::new();
    past.export(&past.moment(None).unwrap(), &mut bytes, |_| ()).unwrap();
    let imported = export::read(&mut &*bytes, |_| ()).unwrap();
    assert_eq!((digest(&imported.content), &imported.content.evidence), (digest(content), &content.evidence));
    // A number out of range is refused, with the line that it is in.
    let text = String::from_utf8(bytes).unwrap();
    for (number, forged, says) in [
        ("{\"experience\":{\"pool\":0", "{\"experience\":{\"pool\":7", "that is not the one of its action"),
        (
            "{\"experience\":{\"pool\":0",
            "{\"experience\":{\"pool\":null",
            "that is not the one of its action",
        ),
        (
            "\"experience\":{\"body\":0,\"primitive\":",
            "\"experience\":{\"body\":0,\"primitive\":9",
            "that is not the one of its action",
        ),
        ("\"sensed\":[0,1,2]", "\"sensed\":[0,2,1]", "out of order"),
        ("\"sensed\":[0,1,2]", "\"sensed\":[0,1,9]", "it refers to observation type 9"),
        ("{\"line\":{\"body\":0", "{\"line\":{\"body\":5", "it refers to body 5"),
        ("{\"lived\":{\"body\":0", "{\"lived\":{\"body\":5", "it refers to line of a body 5"),
        ("\"before\":[{\"kind\":", "\"before\":[{\"kind\":9", "was never declared"),
        ("{\"mechanisms\":[\"claims\"", "{\"mechanisms\":[\"magic\"", "unknown variant `magic`"),
    ] {
        let forged = match text.split_once("{\"mechanisms\"") {
            Some((before, after)) => {
                format!("{before}{}", format!("{{\"mechanisms\"{after}").replacen(number, forged, 1))
            }
            None => panic!("the export does not tell the mechanisms"),
        };
        assert_ne!(forged, text, "{number}");
        let error = export::read(&mut forged.as_bytes(), |_| ()).unwrap_err().to_string();
        assert!(error.starts_with("line ") && error.contains(says), "{says}: {error}");
    }
}

/// Synthetic items are written as they are, and unsound ones are not read.
#[test]
fn synthetic_items_are_written_and_read() {
    let (twin, mut world) = (Twin::new(), World::new(5));
    let (mut learner, mut store, _) = opened(&twin, |_| ()).unwrap();
    attach(&mut learner, &mut store).unwrap();
    let mut memory = learner.into_memory();
    let mut after = world.frame().observations;
    after.retain(|o| o.kind() == TypeId(0));
    let event = |primitive| Event { primitive: PrimitiveId(primitive), after: after.clone().into() };
    for on in [true, false] {
        let updates = [(event(0), Update::Turn), (event(1), Update::On), (event(2), Update::Off)];
        let (body, primitive, kinds) = (BodyId(0), PrimitiveId(1), [TypeId(0)].into());
        memory.apply(&Effect::Supposed { body, on, primitive, kinds, updates: updates.into() }).unwrap();
    }
    memory.apply(&Effect::Dropped { item: 1 }).unwrap();
    let (content, curriculum) = (memory.content(), curriculum());
    let parameters = memory.parameters();
    let identity = export::Identity { learner: "it", seed: 5, parameters, curriculum: &curriculum };
    let mut bytes = Vec::new();
    export::write(content, identity, &mut bytes, |_| ()).unwrap();
    let read = export::read(&mut &*bytes, |_| ()).unwrap();
    assert_eq!((digest(&read.content), &read.content.items), (digest(content), &content.items));
    let text = String::from_utf8(bytes).unwrap();
    for (number, forged, says) in [
        ("\"primitive\":1,\"kinds\"", "\"primitive\":99,\"kinds\"", "it refers to primitive 99"),
        ("\"kinds\":[0]", "\"kinds\":[900]", "it refers to observation type 900"),
        ("\"kinds\":[0]", "\"kinds\":[0,0]", "out of order"),
        ("\"on\":[true,false]", "\"on\":[true,false,true]", "more than"),
    ] {
        let forged = text.replacen(number, forged, 1);
        assert_ne!(forged, text, "{number}");
        let error = export::read(&mut forged.as_bytes(), |_| ()).unwrap_err().to_string();
        assert!(error.starts_with("line ") && error.contains(says), "{says}: {error}");
    }
}

/// The policy of a goal is written as it is, in the journal and in an export, and an unsound one is not read.
#[test]
fn policies_are_written_and_read() {
    let (twin, mut world) = (Twin::new(), World::new(5));
    let (mut learner, mut store, _) = opened(&twin, |_| ()).unwrap();
    attach(&mut learner, &mut store).unwrap();
    let mut memory = learner.into_memory();
    let block: Vec<_> = world.frame().observations.into_iter().filter(|o| o.kind() == TypeId(1)).collect();
    let goal = vec![Pattern::new(TypeId(2), [])];
    let row = |context: Vec<Observation>, to| PolicyRow {
        context,
        action: PrimitiveId(3),
        probability: 0.75,
        leads: vec![Lead { to, probability: 0.5 }],
    };
    let policy = |after_actions| {
        Arc::new(Policy {
            kinds: vec![TypeId(1)],
            chance: vec![TypeId(2)],
            circumstances: Vec::new(),
            rows: vec![row(block.clone(), Some(1)), row(Vec::new(), None)],
            yields: Vec::new(),
            actions: 2.5,
            after_actions,
        })
    };
    let plan = PlanRecord {
        after_actions: 0,
        because: PlanCause::First,
        chain: Vec::new(),
        policy: Some(policy(0)),
        probability: 0.75,
        truncated: false,
    };
    let begun = PursuitEffect::Begun { body: BodyId(0), goal: goal.into(), actions_max: 9 };
    for effect in [begun, PursuitEffect::Planned(plan), PursuitEffect::Revised(policy(4))] {
        let effect = Effect::Pursuit(effect);
        let kept: crate::format::v1::Effect = Mirror::of(&effect);
        assert_eq!(kept.live(), effect);
        memory.apply(&effect).unwrap();
    }
    let (content, curriculum) = (memory.content(), curriculum());
    let parameters = memory.parameters();
    let identity = export::Identity { learner: "it", seed: 5, parameters, curriculum: &curriculum };
    let mut bytes = Vec::new();
    export::write(content, identity, &mut bytes, |_| ()).unwrap();
    let read = export::read(&mut &*bytes, |_| ()).unwrap();
    assert_eq!((digest(&read.content), &read.content.pursuit), (digest(content), &content.pursuit));
    assert_eq!(read.content.pursuit.unwrap().plans[0].policy, Some(policy(4)));
    let text = String::from_utf8(bytes).unwrap();
    for (number, forged, says) in [
        ("{\"plan\":0,", "{\"plan\":1,", "no goal before has such a plan"),
        ("\"to\":1", "\"to\":2", "do not fit together"),
        ("\"chance\":[2]", "\"chance\":[900]", "it refers to observation type 900"),
        (
            "\"action\":3,\"probability\":0.75",
            "\"action\":99,\"probability\":0.75",
            "it refers to primitive 99",
        ),
        ("\"probability\":0.75,\"leads\"", "\"probability\":1.75,\"leads\"", "do not fit together"),
    ] {
        let forged = text.replacen(number, forged, 1);
        assert_ne!(forged, text, "{number}");
        let error = export::read(&mut forged.as_bytes(), |_| ()).unwrap_err().to_string();
        assert!(error.starts_with("line ") && error.contains(says), "{says}: {error}");
    }
}

/// A body with a value, experiences in which it came, the end of an episode, and a goal for most of it: all comes back.
#[test]
fn values_and_goals_for_most_of_them_are_written_and_read() {
    let (twin, mut world) = (Twin::new(), World::new(5));
    let (mut learner, mut store, _) = opened(&twin, |_| ()).unwrap();
    attach(&mut learner, &mut store).unwrap();
    let mut memory = learner.into_memory();
    let points = DeclaredProperty { name: "points".into(), unit: String::new(), kind: ValueKind::Integer };
    let score = DeclaredType {
        transient: true,
        value: true,
        properties: vec![points],
        ..DeclaredType::state("score")
    };
    let declared =
        Declaration { body: "judge".into(), observation_types: vec![score], ..Declaration::default() };
    let mut journalled = Vec::new();
    let mut apply = |memory: &mut Memory, effect: Effect| {
        let kept: crate::format::v1::Effect = Mirror::of(&effect);
        assert_eq!(kept.clone().live(), effect);
        memory.apply(&effect).unwrap();
        journalled.push(kept);
    };
    apply(&mut memory, Effect::Declared(Box::new(declared)));
    let vocabulary = memory.content().vocabulary.clone();
    let score = vocabulary.type_named("score").unwrap();
    let property = vocabulary.property_named("points").unwrap();
    let lasting: Vec<_> = world.frame().observations.into_iter().filter(|o| o.kind() == TypeId(1)).collect();
    for number in 0..40_i64 {
        let came = Observation::new(score, [(property, LearntValue::Integer(number % 2))]);
        let after = [&lasting[..], &[came]].concat();
        let experience = Experience {
            body: BodyId(0),
            primitive: PrimitiveId((number % 4) as u32),
            parameters: vec![Some(LearntValue::Integer(number % 4))].into(),
            before: lasting.clone().into(),
            after: after.into(),
            sensed: vec![TypeId(1), score].into(),
            recalled: None,
        };
        apply(&mut memory, Effect::Experienced(Box::new(experience)));
    }
    apply(&mut memory, Effect::Experienced(Box::new(Experience::beginning(BodyId(0)))));
    let policy = |worth: f64| {
        let leads = vec![Lead { to: Some(0), probability: 0.5 }];
        let row = PolicyRow { context: lasting.clone(), action: PrimitiveId(1), probability: 0.0, leads };
        let yields = vec![Yield { worth, brings: 1.0 }];
        Arc::new(Policy {
            kinds: vec![TypeId(1)],
            rows: vec![row],
            yields,
            actions: 32.0,
            ..Policy::default()
        })
    };
    let plan = PlanRecord {
        after_actions: 0,
        because: PlanCause::First,
        chain: Vec::new(),
        policy: Some(policy(1.0)),
        probability: 0.0,
        truncated: false,
    };
    let again = Goal::Again(vec![Pattern::new(TypeId(1), [])]);
    for effect in [
        PursuitEffect::Begun { body: BodyId(0), goal: again.clone(), actions_max: 9 },
        PursuitEffect::Ended(Ending::Cancelled),
        PursuitEffect::Begun { body: BodyId(0), goal: Goal::Most(score), actions_max: 9 },
        PursuitEffect::Planned(plan),
        PursuitEffect::Acted,
        PursuitEffect::Came(-2.5),
        PursuitEffect::Revised(policy(1.5)),
    ] {
        apply(&mut memory, Effect::Pursuit(effect));
    }
    let (content, curriculum) = (memory.content(), curriculum());
    let parameters = memory.parameters();
    let identity = export::Identity { learner: "it", seed: 5, parameters, curriculum: &curriculum };
    let mut bytes = Vec::new();
    export::write(content, identity, &mut bytes, |_| ()).unwrap();
    let read = export::read(&mut &*bytes, |_| ()).unwrap().content;
    assert_eq!((digest(&read), &read.pursuit), (digest(content), &content.pursuit));
    assert_eq!(read.vocabulary.types(), content.vocabulary.types());
    assert_eq!(read.evidence, content.evidence);
    assert_eq!(
        (read.pursuit.as_ref().unwrap().came, &read.pursuit.unwrap().goal),
        (-2.5, &Goal::Most(score))
    );
    let text = String::from_utf8(bytes).unwrap();
    let number = score.0;
    for (before, forged, says) in [
        (format!("{{\"values\":[{number}]}}"), "{\"values\":[1]}".to_owned(), "an event with one number"),
        (
            format!("{{\"values\":[{number}]}}"),
            "{\"values\":[900]}".to_owned(),
            "it refers to observation type 900",
        ),
        (format!("{{\"most\":{number}}}"), "{\"most\":1}".to_owned(), "never declared"),
        ("\"yields\":[{".to_owned(), "\"yields\":[{\"worth\":1.0,\"brings\":1.0},{".to_owned(), "row by row"),
    ] {
        let forged = text.replacen(&before, &forged, 1);
        assert_ne!(forged, text, "{before}");
        let error = export::read(&mut forged.as_bytes(), |_| ()).unwrap_err().to_string();
        assert!(error.starts_with("line ") && error.contains(says), "{says}: {error}");
    }
}

/// A memory goes on under its own profile; another one that is asked for is refused, or journalled.
#[test]
fn a_profile_is_kept_until_another_is_asked_for() {
    let twin = Twin::new();
    let paper = |options: &mut Options<'_>| options.mechanisms = Mechanisms::PAPER;
    // The first start was killed before its profile was durable: the next one says it again.
    let (_, store, _) = opened(&twin, paper).unwrap();
    drop(store);
    let (mut learner, mut store, _) = opened(&twin, |_| ()).unwrap();
    attach(&mut learner, &mut store).unwrap();
    store.finish(learner.memory()).unwrap();
    let error = opened(&twin, paper).unwrap_err().to_string();
    assert!(error.contains("\n  profile: full there, paper given\n"), "{error}");
    let unasked = |options: &mut Options<'_>| {
        paper(options);
        options.setting_given = false;
    };
    let (learner, store, _) = opened(&twin, unasked).unwrap();
    assert_eq!(learner.memory().content().mechanisms, Mechanisms::FULL);
    store.finish(learner.memory()).unwrap();
    let changing = |options: &mut Options<'_>| {
        paper(options);
        options.change = true;
    };
    let (learner, store, _) = opened(&twin, changing).unwrap();
    assert_eq!(learner.memory().content().mechanisms, Mechanisms::PAPER);
    drop(store);
    // A start that was killed before the profile was in the journal has it in the manifest.
    let killed = Twin::new();
    drop(opened(&killed, |_| ()).unwrap());
    for segment in killed.list("journal").unwrap() {
        killed.remove(&format!("journal/{segment}")).unwrap();
    }
    assert_eq!(opened(&killed, unasked).unwrap().0.memory().content().mechanisms, Mechanisms::FULL);
    // It is in the journal, and from there in the snapshots.
    for _ in 0..2 {
        let (learner, store, _) = opened(&twin, paper).unwrap();
        assert_eq!(learner.memory().content().mechanisms, Mechanisms::PAPER);
        store.finish(learner.memory()).unwrap();
    }
    assert_eq!(twin.list("snapshot").unwrap().len(), 2);
}
