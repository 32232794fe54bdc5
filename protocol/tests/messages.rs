//! Every encoded message decodes to itself; a message with a wrong claim is refused, and never causes a panic.
#![allow(clippy::unwrap_used)] // A test panics to fail.

mod support;

use proptest::prelude::*;
use proptest::sample::Index;
use pschema_protocol::body::{BodyLoop, Directive};
use pschema_protocol::description::{ActionId, ValueKind};
use pschema_protocol::limits::{OBSERVATIONS_MAX, REASON_BYTES_MAX};
use pschema_protocol::prelude::*;
use pschema_protocol::refusal::{Refusal, codes};
use pschema_protocol::wire::decode::{self, SessionChecks};
use pschema_protocol::wire::encode;
use pschema_protocol::wire::message::{Admission, OrderReport, RawFrame, RawHello, Reply};
use pschema_protocol::wire::{FrameHeader, ObservationRecord, Record, VERSION, purpose};
use support::{ADD, COUNT, Counter, counter_description};

fn kind() -> impl Strategy<Value = ValueKind> {
    prop_oneof![
        (any::<i64>(), any::<i64>())
            .prop_map(|(one, other)| ValueKind::Integer { min: one.min(other), max: one.max(other) }),
        (1..20_usize).prop_map(|count| ValueKind::Symbol {
            symbols: (0..count).map(|number| format!("ß{number}")).collect()
        }),
        Just(ValueKind::Boolean),
        (-1e6..1e6_f64, 0.0..1e6_f64, 1e-3..10.0_f64).prop_map(|(min, range, resolution)| ValueKind::Real {
            min,
            max: min + range,
            resolution
        }),
    ]
}

fn properties() -> impl Strategy<Value = Vec<Property>> {
    proptest::collection::vec((kind(), "[a-zé]{0,8}"), 0..=8).prop_map(|kinds| {
        let named = kinds.into_iter().enumerate();
        named.map(|(number, (kind, unit))| Property::new(format!("p{number}"), kind).unit(unit)).collect()
    })
}

fn action_types(most: usize) -> impl Strategy<Value = Vec<ActionType>> {
    proptest::collection::vec(properties(), 0..=most).prop_map(|all| {
        let named = all.into_iter().enumerate();
        let action = |(number, parameters): (usize, Vec<_>)| {
            parameters.into_iter().fold(ActionType::new(format!("a{number}")), ActionType::parameter)
        };
        named.map(action).collect()
    })
}

/// A value allowed for `property`, chosen by `random`.
fn value(property: &Property, random: u64) -> Value {
    match &property.kind {
        ValueKind::Integer { min, max } => {
            let range = i128::from(*max) - i128::from(*min) + 1;
            Value::Integer((i128::from(*min) + i128::from(random) % range) as i64)
        }
        ValueKind::Symbol { symbols } => Value::Symbol((random % symbols.len() as u64) as u32),
        ValueKind::Boolean => Value::Boolean(random % 2 == 1),
        ValueKind::Real { min, max, .. } => {
            Value::Real((min + (max - min) * (random as f64 / u64::MAX as f64)).clamp(*min, *max))
        }
    }
}

fn values(declared: &[Property], random: &[u64; 8]) -> Vec<Value> {
    declared.iter().zip(random).map(|(property, random)| value(property, *random)).collect()
}

fn description() -> impl Strategy<Value = Description> {
    let types = proptest::collection::vec((any::<bool>(), any::<bool>(), properties()), 1..=6);
    let primitives = proptest::collection::vec((any::<Index>(), any::<[u64; 8]>()), 0..=20);
    ("[a-z]{1,32}", types, action_types(4), action_types(3), primitives).prop_map(
        |(name, types, actions, scene_commands, primitives)| {
            let mut description = Description::new(name, "any");
            for (number, (own, transient, properties)) in types.into_iter().enumerate() {
                let mut declared = ObservationType::state(format!("t{number}"));
                (declared.own, declared.transient, declared.properties) = (own, transient, properties);
                let is_number =
                    |one: &Property| matches!(one.kind, ValueKind::Integer { .. } | ValueKind::Real { .. });
                declared.value =
                    own && transient && matches!(&declared.properties[..], [one] if is_number(one));
                assert_eq!(usize::from(description.observation(declared).index()), number);
            }
            for (which, random) in primitives.iter().filter(|_| !actions.is_empty()) {
                let action = which.index(actions.len());
                let id = ActionId::from_index(action as u16);
                description.primitive(id, values(&actions[action].parameters, random).as_slice());
            }
            (description.actions, description.scene_commands) = (actions, scene_commands);
            description
        },
    )
}

fn observations(of: &Description, chosen: &[(Index, [u64; 8])]) -> Vec<Record> {
    let one = |(which, random): &(Index, [u64; 8])| {
        let kind = which.index(of.observation_types.len());
        encode::record(kind as u16, &values(&of.observation_types[kind].properties, random))
    };
    chosen.iter().map(one).collect()
}

fn frame(session: u64, sequence: u64, report: Option<OrderReport>, sensed: &[Record]) -> RawFrame {
    let observation_count = sensed.len() as u32;
    let header = FrameHeader { session, sequence, observation_count, ..FrameHeader::default() };
    encode::frame(header, report.as_ref(), sensed.to_vec())
}

/// A number likely to be wrong in an interesting way.
fn odd() -> impl Strategy<Value = u64> {
    prop_oneof![
        0..20_u64,
        any::<u64>(),
        Just(u64::MAX),
        Just(f64::NAN.to_bits()),
        Just(f64::INFINITY.to_bits())
    ]
}

/// Sets one of a record's fields to something else.
fn spoil_record(record: &mut Record, field: usize, to: u64) {
    match field % 4 {
        0 => record.index = to as u16,
        1 => record.count = to as u16,
        2 => record.kinds = to as u32,
        _ => record.values[(to % 8) as usize] = to,
    }
}

fn spoil_header(header: &mut FrameHeader, field: usize, to: u64) {
    match field % 8 {
        0 => header.magic = to as u32,
        1 => header.version = to as u32,
        2 => header.session = to,
        3 => header.sequence = to,
        4 => header.answers = to,
        5 => header.outcome = to as u32,
        6 => header.purpose = to as u32,
        _ => header.observation_count = to as u32,
    }
}

fn spoil_hello(hello: &mut RawHello, field: usize, place: usize, to: u64) {
    let head = &mut hello.head;
    let kind = &mut head.observation_types[place % 6];
    let property = &mut kind.properties[place % 8];
    match field % 20 {
        0 => head.magic = to as u32,
        1 => head.version = to as u32,
        2 => head.observation_type_count = to as u32,
        3 => head.action_count = to as u32,
        4 => head.scene_command_count = to as u32,
        5 => head.symbol_count = to as u32,
        6 => head.primitive_count = to as u32,
        7 => head.name.length = to as u32,
        8 => head.name.bytes[place % 32] = to as u8,
        9 => kind.flags = to as u32,
        10 => kind.property_count = to as u32,
        11 => kind.name.bytes[place % 2] = to as u8,
        12 => property.kind = to as u32,
        13 => property.first_symbol = to as u32,
        14 => property.symbol_count = to as u32,
        15 => property.min = to,
        16 => property.max = to,
        17 => property.resolution = to,
        18 => head.actions[place % 4].parameter_count = to as u32,
        _ => {
            if let Some(record) = hello.primitives.first_mut() {
                spoil_record(record, place, to);
            }
        }
    }
}

proptest! {
    #[test]
    fn a_description_arrives_as_it_was(description in description(), pid: u32) {
        let hello = encode::hello(&description, pid, 7).unwrap();
        let checked = decode::hello(&hello).unwrap();
        prop_assert_eq!(checked.description, description);
        prop_assert_eq!(checked.pid, pid);
    }

    #[test]
    fn a_frame_arrives_as_it_was(
        description in description(),
        chosen in proptest::collection::vec((any::<Index>(), any::<[u64; 8]>()), 0..=40),
        session in 1..u64::MAX,
    ) {
        let sensed = observations(&description, &chosen);
        let mut daemon = SessionChecks::new(session, description);
        let raw = frame(session, 1, None, &sensed);
        let checked = daemon.check(&raw).unwrap();
        prop_assert_eq!((checked.session, checked.sequence, checked.report), (session, 1, None));
        let arrived = checked.observations.iter().map(|one| encode::record(one.sense().index(), &values_of(one)));
        prop_assert_eq!(arrived.collect::<Vec<_>>(), sensed);
    }

    #[test]
    fn a_reply_arrives_as_it_was(
        description in description(),
        random: [u64; 8],
        which: Index,
        wait in 0..=10_000_u32,
        reason in ".{0,60}",
        session: u64,
        sequence: u64,
    ) {
        let order = |declared: &[ActionType]| (!declared.is_empty()).then(|| {
            let action = which.index(declared.len());
            Action { id: ActionId::from_index(action as u16), parameters: values(&declared[action].parameters, &random) }
        });
        let mut replies = vec![Reply::Wait { ms: wait }, Reply::Detach, Reply::Refused { code: 4, reason }];
        replies.extend(order(&description.actions).map(Reply::Act));
        replies.extend(order(&description.scene_commands).map(Reply::Arrange));
        for reply in replies {
            let sent = encode::reply(session, sequence, &reply);
            prop_assert_eq!(decode::reply(&sent, &description, session, sequence), Ok(reply));
            prop_assert!(decode::reply(&sent, &description, session, sequence.wrapping_add(1)).is_err());
            prop_assert!(decode::reply(&sent, &description, session.wrapping_add(1), sequence).is_err());
        }
    }

    #[test]
    fn a_spoilt_frame_is_refused_or_means_something_allowed(
        description in description(),
        chosen in proptest::collection::vec((any::<Index>(), any::<[u64; 8]>()), 1..=8),
        spoils in proptest::collection::vec((any::<bool>(), 0..8_usize, any::<Index>(), odd()), 1..=4),
    ) {
        let mut raw = frame(9, 1, None, &observations(&description, &chosen));
        for (in_header, field, which, to) in spoils {
            if in_header {
                spoil_header(&mut raw.header, field, to);
            } else {
                let which = which.index(raw.records.len());
                spoil_record(&mut raw.records[which], field, to);
            }
        }
        let mut daemon = SessionChecks::new(9, description.clone());
        let Ok(checked) = daemon.check(&raw) else { return Ok(()) };
        prop_assert!(checked.observations.len() <= OBSERVATIONS_MAX);
        for one in checked.observations.iter() {
            let declared = &description.observation_types[usize::from(one.sense().index())].properties;
            let values = values_of(one);
            prop_assert_eq!(values.len(), declared.len());
            for (value, property) in values.iter().zip(declared) {
                prop_assert!(allowed(*value, &property.kind), "{value:?} for {property:?}");
            }
        }
    }

    #[test]
    fn a_spoilt_hello_is_refused_or_means_something_allowed(
        description in description(),
        spoils in proptest::collection::vec((0..20_usize, any::<usize>(), odd()), 1..=4),
    ) {
        let mut hello = encode::hello(&description, 1, 1).unwrap();
        for (field, place, to) in spoils {
            spoil_hello(&mut hello, field, place, to);
        }
        if let Ok(checked) = decode::hello(&hello) {
            prop_assert_eq!(checked.description.check(), Ok(()));
            // And it can be sent on.
            let again = encode::hello(&checked.description, 1, 1).unwrap();
            prop_assert_eq!(decode::hello(&again).unwrap().description, checked.description);
        }
    }
}

/// Written apart from the code under test.
fn allowed(value: Value, kind: &ValueKind) -> bool {
    match (value, kind) {
        (Value::Integer(number), ValueKind::Integer { min, max }) => *min <= number && number <= *max,
        (Value::Symbol(index), ValueKind::Symbol { symbols }) => (index as usize) < symbols.len(),
        (Value::Boolean(_), ValueKind::Boolean) => true,
        (Value::Real(number), ValueKind::Real { min, max, .. }) => {
            number.is_finite() && *min <= number && number <= *max
        }
        _ => false,
    }
}

fn values_of(observation: ObservationRecord<'_>) -> Vec<Value> {
    observation.values().collect()
}

fn sensed(number: i64) -> Vec<Record> {
    vec![encode::record(0, &[Value::Integer(number), Value::Real(0.5)])]
}

#[test]
fn refusals_name_the_place_and_the_figures() {
    let mut daemon = SessionChecks::new(5, counter_description());
    let mut sequence = 0;
    let mut refused = |values: Vec<Value>, kind: u16| {
        sequence += 1;
        let wrong = [sensed(1), vec![encode::record(kind, &values)]].concat();
        daemon.check(&frame(5, sequence, None, &wrong)).unwrap_err().to_string()
    };
    let half = Value::Real(0.5);
    let one = Value::Integer(1);
    let place = "observation 1 (count): property";
    assert_eq!(
        refused(vec![Value::Integer(-3), half], 0),
        format!("{place} number = -3 is outside 0..=1000000")
    );
    assert_eq!(
        refused(vec![one, Value::Real(f64::NAN)], 0),
        format!("{place} half = NaN is outside 0..=500000")
    );
    assert_eq!(
        refused(vec![one, one], 0),
        format!("{place} half: an integer given where a real is declared")
    );
    assert_eq!(
        refused(vec![one, Value::Real(-1e300)], 0),
        format!("{place} half = -1e300 is outside 0..=500000")
    );
    assert_eq!(refused(vec![one], 0), "observation 1 (count): 1 values, 2 are declared");
    assert_eq!(refused(vec![one; 9], 0), "observation 1 (count): 9 values, 2 are declared");
    assert_eq!(refused(vec![], 3), "observation 1: index 3 is unknown, 1 are declared");
}

#[test]
fn frames_come_in_order_of_one_session_and_version() {
    let mut daemon = SessionChecks::new(5, counter_description());
    let first = frame(5, 1, None, &sensed(1));
    daemon.check(&first).unwrap();
    let replayed = daemon.check(&first).unwrap_err();
    assert_eq!(replayed, Refusal::Sequence { found: 1, expected: 2 });
    assert_eq!(replayed.code(), codes::SEQUENCE);
    let skipped = daemon.check(&frame(5, 3, None, &sensed(1))).unwrap_err();
    assert_eq!(skipped, Refusal::Sequence { found: 3, expected: 2 });
    let foreign = daemon.check(&frame(6, 2, None, &sensed(1))).unwrap_err();
    assert_eq!(foreign, Refusal::Session { found: 6, expected: 5 });
    let mut future = frame(5, 2, None, &sensed(1));
    future.header.version = VERSION + 1;
    let future = daemon.check(&future).unwrap_err();
    assert_eq!(future, Refusal::Version { theirs: VERSION + 1, ours: VERSION });
    let mut leaving = frame(5, 2, None, &sensed(1));
    leaving.header.purpose = purpose::DETACH + 1;
    assert_eq!(daemon.check(&leaving).unwrap_err(), Refusal::Purpose { found: 3 });
    // Nothing of that but the last, which was in order, used a number up.
    assert_eq!(daemon.check(&frame(5, 3, None, &sensed(1))).unwrap().sequence, 3);
}

#[test]
fn an_order_is_answered_once_and_by_its_number() {
    let mut daemon = SessionChecks::new(5, counter_description());
    let report = |answers| Some(OrderReport { outcome: Outcome::Done, answers });
    let unasked = daemon.check(&frame(5, 1, report(1), &sensed(1))).unwrap_err();
    assert_eq!(unasked, Refusal::Answers { found: 1, expected: 0 });
    daemon.check(&frame(5, 2, None, &sensed(1))).unwrap();
    daemon.replied(&Reply::Act(Action::new(ADD, [1])));
    let silent = daemon.check(&frame(5, 3, None, &sensed(1))).unwrap_err();
    assert_eq!(silent, Refusal::Answers { found: 0, expected: 2 });
    let refused = daemon.check(&frame(5, 4, report(2), &sensed(-1))).unwrap_err();
    assert!(matches!(refused, Refusal::ValueRange { .. }), "{refused}");
    assert_eq!(daemon.check(&frame(5, 5, report(2), &sensed(1))).unwrap().report, report(2));
    let twice = daemon.check(&frame(5, 6, report(2), &sensed(1))).unwrap_err();
    assert_eq!(twice, Refusal::Answers { found: 2, expected: 0 });
}

#[test]
fn the_reason_of_an_outcome_arrives_cut_to_its_limit_and_only_as_text() {
    let reported = |outcome: Outcome, spoil: fn(&mut RawFrame)| {
        let mut daemon = SessionChecks::new(5, counter_description());
        daemon.check(&frame(5, 1, None, &sensed(1))).unwrap();
        daemon.replied(&Reply::Act(Action::new(ADD, [1])));
        let mut raw = frame(5, 2, Some(OrderReport { outcome, answers: 1 }), &sensed(1));
        spoil(&mut raw);
        daemon.check(&raw).map(|frame| frame.report.unwrap().outcome)
    };
    let whole = |_: &mut RawFrame| ();
    let without_reason = [Outcome::Done, Outcome::TimedOut, Outcome::EpisodeEnded, Outcome::EpisodeCut];
    for outcome in
        [Outcome::refused("the lid is shut"), Outcome::failed("")].into_iter().chain(without_reason)
    {
        assert_eq!(reported(outcome.clone(), whole), Ok(outcome));
    }
    let unknown = reported(Outcome::Done, |raw| raw.header.outcome = 7);
    assert_eq!(unknown, Err(Refusal::UnknownOutcome { found: 7 }));
    let cut = Outcome::failed("é".repeat(REASON_BYTES_MAX / 2));
    assert_eq!(reported(Outcome::failed("é".repeat(200)), whole), Ok(cut));
    let too_long = reported(Outcome::refused("why"), |raw| raw.reason.length = 257).unwrap_err();
    assert_eq!(too_long.to_string(), "reason of the outcome: it claims 257 bytes of 256");
    let no_text = reported(Outcome::refused("why"), |raw| raw.reason.bytes[1] = 0xff).unwrap_err();
    assert!(no_text.to_string().contains("not UTF-8"), "{no_text}");
    // An order that was carried out has no reason: the bytes of the reason are not read.
    assert_eq!(reported(Outcome::Done, |raw| raw.reason.length = 257), Ok(Outcome::Done));
}

#[test]
fn more_observations_than_a_frame_holds_are_refused_not_cut() {
    struct Crowd(usize);
    impl Body for Crowd {
        fn describe(&self) -> Description {
            counter_description()
        }
        fn sense(&mut self, frame: &mut Senses) {
            for _ in 0..self.0 {
                frame.observe(COUNT, (1, 0.5));
            }
            assert_eq!(frame.observations().len(), OBSERVATIONS_MAX);
        }
        fn act(&mut self, _: &Action) -> Outcome {
            Outcome::Done
        }
    }
    let checked = |count| {
        let mut body = BodyLoop::new(Crowd(count));
        body.attached(5);
        let mut daemon = SessionChecks::new(5, counter_description());
        daemon.check(body.next_frame()).map(|frame| frame.observations.len())
    };
    assert_eq!(checked(OBSERVATIONS_MAX), Ok(OBSERVATIONS_MAX));
    assert_eq!(checked(OBSERVATIONS_MAX + 1), Err(Refusal::ObservationCount { found: 4097, held: 4096 }));
}

#[test]
fn declarations_that_contradict_themselves_are_refused() {
    type Spoil = fn(&mut Description);
    let cases: [(Spoil, &str); 21] = [
        (|one| one.name = String::new(), "the body's name: it is empty"),
        (|one| one.name = "x".repeat(33), "33 bytes, at most 32 are allowed"),
        (|one| one.kind = "a\nb".to_owned(), "control character"),
        (|one| one.kind = "a\u{202e}b".to_owned(), "holds U+202E, which can't be seen"),
        (|one| one.name = "\u{3164}".to_owned(), "holds U+3164, which can't be seen"),
        (|one| one.observation_types[0].name = "\u{2800}".to_owned(), "holds U+2800, which can't be seen"),
        (|one| one.actions[0].name = "go\u{fe0f}".to_owned(), "holds U+FE0F, which can't be seen"),
        (|one| one.observation_types[0].name = "a{b=c}".to_owned(), "holds '{'"),
        (|one| one.observation_types[0].properties[0].name = "a,b".to_owned(), "holds ','"),
        (|one| kind_of(one, ValueKind::Symbol { symbols: vec!["$x".to_owned()] }), "a dollar sign"),
        (|one| kind_of(one, ValueKind::Symbol { symbols: vec!["a\u{a0}b".to_owned()] }), "holds U+00A0"),
        (|one| one.actions[0].name = "go(".to_owned(), "holds '('"),
        (|one| one.observation_types = vec![one.observation_types[0].clone(); 2], "\"count\" is used twice"),
        (
            |one| one.observation_types = vec![one.observation_types[0].clone(); 33],
            "33, at most 32 are allowed",
        ),
        (|one| kind_of(one, ValueKind::Integer { min: 3, max: 2 }), "minimum 3 is above its maximum 2"),
        (|one| kind_of(one, ValueKind::Real { min: 0.0, max: 1.0, resolution: 0.0 }), "not above zero"),
        (|one| kind_of(one, ValueKind::Real { min: f64::NAN, max: 1.0, resolution: 1.0 }), "not finite"),
        // Numbers of hundreds of digits were told.
        (
            |one| kind_of(one, ValueKind::Real { min: -1e300, max: 1e300, resolution: 1e-300 }),
            "its resolution 1e-300 is too fine for -1e300..=1e300",
        ),
        (|one| kind_of(one, ValueKind::Symbol { symbols: vec![] }), "no symbols"),
        (|one| one.repertoire[0].parameters = vec![Value::Integer(4)], "amount = 4 is outside 1..=3"),
        (
            |one| one.repertoire[0].id = ActionId::from_index(1),
            "primitive 0: index 1 is unknown, 1 are declared",
        ),
    ];
    for (spoil, complaint) in cases {
        let mut description = counter_description();
        spoil(&mut description);
        let error = encode::hello(&description, 1, 1).unwrap_err();
        assert!(error.to_string().contains(complaint), "{error}");
    }
}

fn kind_of(description: &mut Description, kind: ValueKind) {
    description.observation_types[0].properties[0].kind = kind;
}

#[test]
fn a_welcome_opens_a_session_or_says_why_not_whatever_the_version() {
    let opened = decode::welcome(&encode::welcome(3, "demo")).unwrap();
    assert_eq!(opened, Admission::Accepted { session: 3, learner: "demo".to_owned() });
    let refusal = Refusal::Version { theirs: 1, ours: 2 };
    let mut refused = encode::unwelcome(&refusal, "demo");
    refused.version = 2;
    let expected = Admission::Refused { code: refusal.code(), reason: refusal.to_string() };
    assert_eq!(decode::welcome(&refused).unwrap(), expected);
    let long = Refusal::Unwilling { reason: "é".repeat(200) };
    let Admission::Refused { reason, .. } = decode::welcome(&encode::unwelcome(&long, "demo")).unwrap()
    else {
        panic!("accepted")
    };
    assert_eq!(reason, "é".repeat(REASON_BYTES_MAX / 2));
}

#[test]
fn a_body_is_driven_without_any_transport() {
    let mut body = BodyLoop::new(Counter::new());
    let hello = decode::hello(&body.hello().unwrap()).unwrap();
    let mut daemon = SessionChecks::new(1, hello.description);
    body.attached(1);
    for number in 0..10 {
        let checked = daemon.check(body.next_frame()).unwrap();
        assert_eq!(checked.report.is_some(), number > 0);
        assert_eq!(checked.observations.iter().next().map(values_of).unwrap()[0], Value::Integer(3 * number));
        let order = Reply::Act(Action::new(ADD, [3]));
        daemon.replied(&order);
        let sequence = checked.sequence;
        let directive = body.obey(&encode::reply(1, sequence, &order)).unwrap();
        assert_eq!(directive, Directive::Continue);
    }
    // An order outside the declaration is not carried out.
    let wrong = Reply::Act(Action::new(ADD, [4]));
    let sequence = daemon.check(body.next_frame()).unwrap().sequence;
    let error = body.obey(&encode::reply(1, sequence, &wrong)).unwrap_err();
    assert_eq!(error.to_string(), "the action (add): parameter amount = 4 is outside 1..=3");
    assert_eq!((body.orders(), body.body().acted), (10, 30));
}

/// The page says that reserved fields are not checked, as is everything beyond a count or a length.
#[test]
fn reserved_fields_are_ignored() {
    let description = counter_description();
    let mut hello = encode::hello(&description, 1, 2).unwrap();
    let plain = decode::hello(&hello).unwrap();
    for one in &mut hello.head.observation_types {
        one.reserved = u32::MAX;
        one.properties.iter_mut().for_each(|property| property.reserved = u32::MAX);
    }
    for one in hello.head.actions.iter_mut().chain(&mut hello.head.scene_commands) {
        one.reserved = [u32::MAX; 2];
        one.parameters.iter_mut().for_each(|parameter| parameter.reserved = u32::MAX);
    }
    let beyond = hello.head.name.length as usize;
    hello.head.name.bytes[beyond..].fill(0xff);
    assert_eq!(decode::hello(&hello).unwrap(), plain);
    let mut frame =
        encode::frame(FrameHeader { session: 7, sequence: 1, ..FrameHeader::default() }, None, Vec::new());
    frame.header.reserved = u32::MAX;
    SessionChecks::new(7, description.clone()).check(&frame).unwrap();
    let mut welcome = encode::welcome(7, "demo");
    welcome.reserved = u32::MAX;
    assert!(matches!(decode::welcome(&welcome).unwrap(), Admission::Accepted { session: 7, .. }));
    let mut reply = encode::reply(7, 1, &Reply::Wait { ms: 5 });
    (reply.reserved, reply.reserved_end) = (u32::MAX, u32::MAX);
    assert_eq!(decode::reply(&reply, &description, 7, 1).unwrap(), Reply::Wait { ms: 5 });
}

#[test]
fn a_value_is_one_number_that_comes_with_a_frame() {
    let refused = |declared: ObservationType| {
        let mut description = Description::new("body", "any");
        let _sense = description.observation(declared);
        description.check().map_err(|refusal| refusal.to_string())
    };
    let score = || ObservationType::value("score", Property::integer("points", -5..=5));
    assert_eq!(refused(score()), Ok(()));
    assert_eq!(refused(score().own()), Ok(()));
    let mut state = score();
    state.transient = false;
    let mut none = score();
    none.properties.clear();
    for (odd, told) in [
        (state, "a value is an event"),
        (none, "one integer or real"),
        (score().property(Property::real("more", 0.0..=1.0, 0.1)), "not just one property"),
        (ObservationType::value("score", Property::boolean("won")), "won is no number"),
    ] {
        let problem = refused(odd).unwrap_err();
        assert!(problem.contains("observation type score") && problem.contains(told), "{problem}");
    }
}
