//! A message that came over the wire is an allegation: a frame that is not allowed changes nothing but a counter.

#![allow(clippy::unwrap_used)] // A test panics to fail.

mod common;

use common::{Row, curriculum, free, setup};
use pschema_learner::Learner;
use pschema_learner::digest::digest;
use pschema_learner::effect::Effect;
use pschema_learner::progress::StageEffect;
use pschema_protocol::body::{Body, BodyLoop, Outcome};
use pschema_protocol::description::{ObservationType, Value};
use pschema_protocol::wire::message::{Introduction, OrderReport, RawFrame, Reply};
use pschema_protocol::wire::{FrameHeader, Record, decode, encode, kind};
use pschema_server::Setup;
use pschema_server::session::{FrameOutcome, Session};

const NUMBER: u64 = 7;
// The senses of a [`Row`], in the order it declares them.
const FINGER: u16 = 0;
const OBJECT: u16 = 1;
const TOUCH: u16 = 2;

fn learner(setup: Setup) -> Learner {
    setup.begin().unwrap()
}

fn hello(body: &Row) -> Introduction {
    Introduction { pid: 1, description: body.describe() }
}

fn observed(observation_type: u16, values: &[Value]) -> Record {
    encode::record(observation_type, values)
}

fn frame(sequence: u64, report: Option<OrderReport>, sensed: &[Record]) -> RawFrame {
    let observation_count = u32::try_from(sensed.len()).unwrap();
    let header = FrameHeader { session: NUMBER, sequence, observation_count, ..FrameHeader::default() };
    encode::frame(header, report.as_ref(), sensed.to_vec())
}

fn serve(session: &mut Session, learner: &mut Learner, raw: &RawFrame) -> FrameOutcome {
    session.frame(learner, raw, &mut Vec::new(), false)
}

/// A way to spoil a frame, and words of the refusal.
type Damage = (&'static str, fn(&mut RawFrame), &'static str);

#[test]
fn refused_frames_change_nothing_and_are_counted() {
    let damages: [Damage; 14] = [
        ("another protocol", |raw| raw.header.magic ^= 1, "not a pschema message"),
        ("a future version", |raw| raw.header.version += 1, "protocol version"),
        ("another session", |raw| raw.header.session += 1, "session 8 is not open"),
        ("a replayed sequence", |raw| raw.header.sequence -= 1, "out of order"),
        ("a skipped sequence", |raw| raw.header.sequence += 1, "out of order"),
        ("more observations than came", |raw| raw.header.observation_count += 1, "claims 4 observations"),
        ("a huge count", |raw| raw.header.observation_count = u32::MAX, "claims 4294967295"),
        ("an unknown purpose", |raw| raw.header.purpose = 9, "purpose 9"),
        ("an outcome of nothing", |raw| raw.header.outcome = 1, "answers"),
        ("an unknown type", |raw| raw.records[0].index = 3, "index 3 is unknown"),
        ("a wrong number of values", |raw| raw.records[1].count = 1, "1 values, 2 are declared"),
        ("an unknown symbol", |raw| raw.records[1].values[0] = 2, "symbol 2"),
        ("a value out of range", |raw| raw.records[0].values[0] = 8, "field = 8 is outside 0..=7"),
        (
            "a NaN for a number",
            |raw| {
                raw.records[0].kinds = kind::REAL;
                raw.records[0].values[0] = f64::NAN.to_bits();
            },
            "a real given where an integer is declared",
        ),
    ];
    let mut learner = learner(setup(1, free()));
    let (mut session, _) = Session::attach(NUMBER, &hello(&Row::new("row")), &mut learner).unwrap();
    let sensed = [
        observed(FINGER, &[Value::Integer(3)]),
        observed(OBJECT, &[Value::Symbol(1), Value::Integer(4)]),
        observed(TOUCH, &[]),
    ];
    let mut sequence = 1;
    let before = digest(learner.memory().content());
    for (count, (name, damage, complaint)) in damages.into_iter().enumerate() {
        let mut raw = frame(sequence, None, &sensed);
        damage(&mut raw);
        let served = serve(&mut session, &mut learner, &raw);
        let Reply::Refused { reason, code } = &served.reply else { panic!("{name} was taken") };
        assert!(reason.contains(complaint) && *code > 0, "{name}: {reason}");
        assert!(served.step.is_none(), "{name} led to a step");
        assert_eq!(digest(learner.memory().content()), before, "{name} changed memory");
        let status = session.status();
        assert_eq!((status.frames, status.frames_refused), (0, count as u64 + 1), "{name}");
        assert_eq!(status.last_refusal.as_deref(), Some(reason.as_str()), "{name}");
        // Content that is refused has used its number up; a frame out of order has not.
        sequence += u64::from(count >= 5);
    }
    let served = serve(&mut session, &mut learner, &frame(sequence, None, &sensed));
    assert!(served.step.is_some() && matches!(served.reply, Reply::Act(_)), "{:?}", served.reply);
    assert_eq!(session.status().frames, 1);
    assert_ne!(digest(learner.memory().content()), before);
}

#[test]
fn a_nan_where_a_real_is_declared_is_refused() {
    let mut description = Row::new("row").describe();
    let reach = description.actions[0].parameters[0].clone();
    let heat = description.observation(ObservationType::state("heat").property(reach)).index();
    let mut learner = learner(setup(1, free()));
    let hello = Introduction { pid: 1, description };
    let (mut session, _) = Session::attach(NUMBER, &hello, &mut learner).unwrap();
    let before = digest(learner.memory().content());
    for (sequence, value) in [(1, f64::NAN), (2, f64::INFINITY), (3, -0.5), (4, 1.5)] {
        let raw = frame(sequence, None, &[observed(heat, &[Value::Real(value)])]);
        let served = serve(&mut session, &mut learner, &raw);
        assert!(matches!(&served.reply, Reply::Refused { reason, .. } if reason.contains("outside 0..=1")));
        assert_eq!(digest(learner.memory().content()), before, "{value}");
    }
    let taken = serve(&mut session, &mut learner, &frame(5, None, &[observed(heat, &[Value::Real(0.5)])]));
    assert!(taken.step.is_some());
}

#[test]
fn an_order_that_is_never_answered_for_is_not_forgotten() {
    let mut learner = learner(setup(1, free()));
    let (mut session, _) = Session::attach(NUMBER, &hello(&Row::new("row")), &mut learner).unwrap();
    assert!(matches!(serve(&mut session, &mut learner, &frame(1, None, &[])).reply, Reply::Act(_)));
    let before = digest(learner.memory().content());
    let served = serve(&mut session, &mut learner, &frame(2, None, &[]));
    assert!(matches!(served.reply, Reply::Refused { .. }), "{:?}", served.reply);
    assert_eq!(digest(learner.memory().content()), before);
    let report = Some(OrderReport { outcome: Outcome::Done, answers: 1 });
    let finger = observed(FINGER, &[Value::Integer(2)]);
    let served = serve(&mut session, &mut learner, &frame(3, report, &[finger]));
    assert!(matches!(served.reply, Reply::Act(_)));
    assert_eq!(learner.memory().content().schemas.len(), 1);
}

#[test]
fn an_action_that_was_not_carried_out_teaches_nothing_about_its_effect() {
    let episodes = [Outcome::EpisodeEnded, Outcome::EpisodeCut];
    let failures = [Outcome::refused("why"), Outcome::failed("why"), Outcome::TimedOut];
    for outcome in failures.into_iter().chain(episodes) {
        let mut learner = learner(setup(1, free()));
        let (mut session, _) = Session::attach(NUMBER, &hello(&Row::new("row")), &mut learner).unwrap();
        serve(&mut session, &mut learner, &frame(1, None, &[]));
        let report = Some(OrderReport { outcome: outcome.clone(), answers: 1 });
        let finger = observed(FINGER, &[Value::Integer(2)]);
        serve(&mut session, &mut learner, &frame(2, report, &[finger]));
        assert_eq!(learner.memory().content().schemas.len(), 0, "{outcome:?}");
    }
}

/// The journal has a single step in this order, and learning it again expects it so.
#[test]
fn a_word_met_in_a_single_step_comes_after_the_release() {
    let mut learner = learner(setup(1, free()));
    let (mut session, _) = Session::attach(NUMBER, &hello(&Row::new("row")), &mut learner).unwrap();
    learner.set_held(true);
    let mut words = vec!["new".to_owned()];
    let served = session.frame(&mut learner, &frame(1, None, &[]), &mut words, true);
    let effects = served.step.unwrap().effects;
    let held = |held| Effect::Stage(StageEffect::Held(held));
    assert_eq!(effects[..2], [held(false), Effect::SymbolsMet(vec!["new".to_owned()])]);
    assert_eq!(effects.last(), Some(&held(true)));
    assert!(words.is_empty());
}

#[test]
fn an_arrangement_is_sent_command_by_command_and_a_failure_ends_it() {
    for failing in [None, Some(0), Some(1)] {
        let mut twice = curriculum();
        twice.stages.remove(0);
        let first = twice.stages[0].arrange[0].clone();
        twice.stages[0].arrange = vec![first.clone(), first];
        twice.stages[0].trials = 1;
        let mut learner = learner(setup(1, twice));
        let (mut session, _) = Session::attach(NUMBER, &hello(&Row::new("row")), &mut learner).unwrap();
        let mut served = serve(&mut session, &mut learner, &frame(1, None, &[]));
        for command in 0..2 {
            assert!(matches!(served.reply, Reply::Arrange(_)), "command {command}: {:?}", served.reply);
            let outcome = if failing == Some(command) { Outcome::failed("why") } else { Outcome::Done };
            let sequence = command + 2;
            let report = Some(OrderReport { outcome, answers: sequence - 1 });
            served = serve(&mut session, &mut learner, &frame(sequence, report, &[]));
            if failing == Some(command) {
                break;
            }
        }
        assert_eq!(learner.memory().content().progress.stuck.is_some(), failing.is_some(), "{failing:?}");
        assert_eq!(
            matches!(served.reply, Reply::Act(_)),
            failing.is_none(),
            "{failing:?}: {:?}",
            served.reply
        );
    }
}

#[test]
fn a_body_may_not_redefine_what_was_learnt_nor_the_sense_of_hearing() {
    let mut learner = learner(setup(1, free()));
    Session::attach(1, &hello(&Row::new("first")), &mut learner).unwrap();
    let before = digest(learner.memory().content());
    let mut other = hello(&Row::new("second"));
    other.description.observation_types[0].own = false;
    let error = Session::attach(2, &other, &mut learner).unwrap_err().to_string();
    assert!(error.contains("finger") && error.contains("already known"), "{error}");
    let mut hearing = hello(&Row::new("second"));
    hearing.description.observation_types[0].name = "word".to_owned();
    let error = Session::attach(2, &hearing, &mut learner).unwrap_err().to_string();
    assert!(error.contains("sense of hearing"), "{error}");
    assert_eq!(digest(learner.memory().content()), before);
    assert!(Session::attach(2, &hello(&Row::new("second")), &mut learner).is_ok());
}

#[test]
fn a_body_gets_its_own_values_back_though_another_declared_the_primitive_first() {
    // 0.1234 and 0.1241 are in one bin of 0.01, so they are one primitive to the learner.
    for reach in [0.1234, 0.1241] {
        let mut learner = learner(setup(1, free()));
        let mut first = hello(&Row::new("first"));
        first.description.repertoire.truncate(1);
        first.description.repertoire[0].parameters[0] = Value::Real(0.12);
        Session::attach(1, &first, &mut learner).unwrap();
        let mut second = hello(&Row::new("second"));
        second.description.repertoire.truncate(1);
        second.description.repertoire[0].parameters[0] = Value::Real(reach);
        let (mut session, _) = Session::attach(NUMBER, &second, &mut learner).unwrap();
        assert_eq!(learner.memory().content().vocabulary.primitives().len(), 1);
        let Reply::Act(action) = serve(&mut session, &mut learner, &frame(1, None, &[])).reply else {
            panic!()
        };
        assert_eq!(action.parameters, [Value::Real(reach)]);
    }
}

/// Drives a body for a number of frames through a session of its own.
fn drive(body: &mut BodyLoop<Row>, session: &mut Session, learner: &mut Learner, frames: u32) {
    for _ in 0..frames {
        let raw = body.next_frame();
        let served = session.frame(learner, raw, &mut Vec::new(), false);
        let wire = encode::reply(session.number(), raw.header.sequence, &served.reply);
        body.obey(&wire).unwrap();
    }
}

#[test]
fn a_body_that_comes_back_goes_on_where_it_left() {
    let mut learner = learner(setup(1, curriculum()));
    let mut body = BodyLoop::new(Row::new("row"));
    let introduction = decode::hello(&body.hello().unwrap()).unwrap();
    for number in 1..=20 {
        // Each session breaks off in the middle of an action.
        let (mut session, _) = Session::attach(number, &introduction, &mut learner).unwrap();
        body.attached(number);
        drive(&mut body, &mut session, &mut learner, 5);
    }
    let progress = &learner.memory().content().progress;
    assert!(progress.finished || progress.stage > 0, "{progress:?}");
    assert_eq!(learner.memory().content().vocabulary.bodies().len(), 1);
}
