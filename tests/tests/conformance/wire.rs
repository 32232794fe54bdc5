//! A body on the wire, with a daemon that only checks: every message goes through the encoding and the checks of a real
//! session.

use std::collections::BTreeSet;

use pschema_arm::SplitMix;
use pschema_protocol::body::{Body, BodyLoop, Directive, Outcome};
use pschema_protocol::description::{Action, ActionId, ActionType, Description, Value, ValueKind};
use pschema_protocol::wire::decode::{self, SessionChecks};
use pschema_protocol::wire::message::{OrderReport, RawFrame, Reply};
use pschema_protocol::wire::{Record, encode};

use super::{Any, Subject};

/// The session's number.
const SESSION: u64 = 7;
/// How many actions a body is asked for in tests of its messages in the long run.
const ACTIONS: usize = 1_000;

/// A frame that passed every check.
#[derive(Clone, Debug, PartialEq)]
struct Frame {
    sequence: u64,
    report: Option<OrderReport>,
    observations: Vec<Record>,
}

impl Frame {
    fn check(checks: &mut SessionChecks, raw: &RawFrame) -> Self {
        let checked = checks.check(raw).unwrap_or_else(|refusal| panic!("a frame is refused: {refusal}"));
        Self { sequence: checked.sequence, report: checked.report, observations: raw.records.clone() }
    }
}

/// A body and the checks of its session.
struct Wire {
    body: BodyLoop<Any>,
    checks: SessionChecks,
}

impl Wire {
    fn new(subject: &dyn Subject, seed: u64) -> Self {
        println!("{}, seed {seed}", subject.name());
        let mut body = BodyLoop::new(subject.body(seed));
        let hello = decode::hello(&body.hello().expect("a description that is allowed")).expect("a hello");
        assert_eq!(hello.description, *body.description());
        body.attached(SESSION);
        Self { body, checks: SessionChecks::new(SESSION, hello.description) }
    }

    fn description(&self) -> &Description {
        self.checks.description()
    }

    fn frame(&mut self) -> Frame {
        Frame::check(&mut self.checks, self.body.next_frame())
    }

    /// Replies to the frame, and lets the body obey.
    fn reply(&mut self, frame: &Frame, reply: &Reply) -> Directive {
        self.checks.replied(reply);
        let wire = encode::reply(SESSION, frame.sequence, reply);
        self.body.obey(&wire).unwrap_or_else(|refusal| panic!("{reply:?} is refused: {refusal}"))
    }

    /// One order, and the frame that reports on it.
    fn order(&mut self, frame: &Frame, reply: &Reply) -> Frame {
        assert_eq!(self.reply(frame, reply), Directive::Continue);
        let next = self.frame();
        assert_eq!(next.sequence, frame.sequence + 1, "one order, one frame");
        assert_eq!(
            next.report.as_ref().map(|report| report.answers),
            Some(frame.sequence),
            "an order is reported on"
        );
        next
    }
}

/// A value that `kind` allows.
fn any(kind: &ValueKind, random: &mut SplitMix) -> Value {
    let mut share = || (random.within_one() + 1.0) / 2.0;
    match kind {
        ValueKind::Integer { min, max } => {
            let span = (max - min) as f64 + 1.0;
            Value::Integer((min + (share() * span) as i64).min(*max))
        }
        ValueKind::Symbol { symbols } => Value::Symbol((share() * symbols.len() as f64) as u32),
        ValueKind::Boolean => Value::Boolean(share() < 0.5),
        ValueKind::Real { min, max, .. } => Value::Real(min + (max - min) * share()),
    }
}

fn any_of(declared: &[ActionType], random: &mut SplitMix) -> Option<Action> {
    let all: Vec<usize> = (0..declared.len()).collect();
    let index = random.one_of(&all)?;
    let parameters =
        declared[index].parameters.iter().map(|parameter| any(&parameter.kind, random)).collect();
    Some(Action { id: ActionId::from_index(u16::try_from(index).unwrap()), parameters })
}

/// Something to do: mostly of the repertoire, sometimes any action that is declared, sometimes a change of the scene.
fn anything(description: &Description, random: &mut SplitMix) -> Reply {
    if random.happens(0.05)
        && let Some(command) = any_of(&description.scene_commands, random)
    {
        return Reply::Arrange(command);
    }
    let all: Vec<usize> = (0..description.repertoire.len()).collect();
    match random.one_of(&all).filter(|_| random.happens(0.9)) {
        Some(index) => Reply::Act(description.repertoire[index].clone()),
        None => Reply::Act(any_of(&description.actions, random).expect("a body with actions")),
    }
}

/// A body describes itself in the same way whenever it is asked, and offers only actions that it can carry out.
pub(crate) fn it_describes_itself(subject: &dyn Subject) {
    let one = subject.body(1);
    assert_eq!(one.describe(), one.describe());
    drop(one);
    let described = subject.body(2).describe();
    assert_eq!(described, Wire::new(subject, 1).description().clone(), "whatever the seed");
    assert!(!described.repertoire.is_empty(), "a learner has something to babble with");
    let distinct: BTreeSet<String> =
        described.repertoire.iter().map(|action| format!("{action:?}")).collect();
    assert_eq!(distinct.len(), described.repertoire.len(), "every primitive is there once");
    assert!(described.observation_types.iter().any(|kind| !kind.own || !kind.transient), "it senses states");
}

/// Orders that were never declared are not carried out, whatever the daemon says.
pub(crate) fn it_refuses_what_it_never_declared(subject: &dyn Subject) {
    let mut wire = Wire::new(subject, 3);
    let before = wire.frame();
    let description = wire.description().clone();
    let sound = description.repertoire[0].clone();
    let with = |parameters: Vec<Value>| Action { id: sound.id, parameters };
    let count = u16::try_from(description.actions.len()).unwrap();
    let mut longer = sound.parameters.clone();
    longer.push(Value::Integer(0));
    let hostile = [
        Action { id: ActionId::from_index(count), ..sound.clone() },
        Action { id: ActionId::from_index(u16::MAX), ..sound.clone() },
        with(Vec::new()),
        with(longer),
        with(vec![Value::Real(f64::NAN); sound.parameters.len()]),
        with(vec![Value::Real(1e300); sound.parameters.len()]),
        with(vec![Value::Integer(i64::MIN); sound.parameters.len()]),
        with(vec![Value::Symbol(u32::MAX); sound.parameters.len()]),
    ];
    for action in hostile {
        for reply in [Reply::Act(action.clone()), Reply::Arrange(action)] {
            let is_a_command = matches!(&reply, Reply::Arrange(command)
                if usize::from(command.id.index()) < description.scene_commands.len());
            let wire_reply = encode::reply(SESSION, before.sequence, &reply);
            let obeyed = wire.body.obey(&wire_reply);
            assert!(obeyed.is_err() || is_a_command, "{reply:?} led to {obeyed:?}");
        }
    }
    for (session, sequence) in [(SESSION + 1, before.sequence), (SESSION, before.sequence + 1), (SESSION, 0)]
    {
        let stale = encode::reply(session, sequence, &Reply::Act(sound.clone()));
        assert!(wire.body.obey(&stale).is_err(), "a reply to another frame is not obeyed");
    }
    assert_eq!(wire.body.orders(), 0, "nothing was done");
    let after = wire.frame();
    assert_eq!((after.report, after.sequence), (None, before.sequence + 1));
    assert_eq!(after.observations, before.observations, "nothing has moved");
}

/// Frames are numbered one after the other; an order is reported on once, in the next; a rest is not.
pub(crate) fn one_action_one_frame_one_report(subject: &dyn Subject) {
    let mut wire = Wire::new(subject, 4);
    let mut frame = wire.frame();
    assert_eq!((frame.sequence, &frame.report), (1, &None));
    let repertoire = wire.description().repertoire.clone();
    for action in repertoire.iter().cycle().take(10) {
        frame = wire.order(&frame, &Reply::Act(action.clone()));
        assert_eq!(frame.report.as_ref().map(|report| &report.outcome), Some(&Outcome::Done), "{action:?}");
        assert_eq!(wire.reply(&frame, &Reply::Wait { ms: 0 }), Directive::Wait(std::time::Duration::ZERO));
        let rested = wire.frame();
        assert_eq!(
            (&rested.report, &rested.observations),
            (&None, &frame.observations),
            "a rest changes nothing"
        );
        frame = rested;
    }
    // The outcome in a refused frame is reported again, with the next frame.
    assert_eq!(wire.reply(&frame, &Reply::Act(repertoire[0].clone())), Directive::Continue);
    let lost = wire.body.next_frame().clone();
    let refused =
        encode::reply(SESSION, lost.header.sequence, &Reply::Refused { code: 1, reason: "lost".into() });
    assert!(matches!(wire.body.obey(&refused), Ok(Directive::Refused { .. })));
    let again = wire.body.next_frame();
    assert_eq!((again.header.answers, again.header.outcome), (lost.header.answers, lost.header.outcome));
}

/// In a new session nothing is reported that was ordered in an earlier one.
pub(crate) fn a_new_session_begins_anew(subject: &dyn Subject) {
    let mut wire = Wire::new(subject, 5);
    let frame = wire.frame();
    let action = wire.description().repertoire[0].clone();
    assert_eq!(wire.reply(&frame, &Reply::Act(action)), Directive::Continue);
    wire.body.attached(SESSION + 1);
    let description = wire.description().clone();
    let mut checks = SessionChecks::new(SESSION + 1, description);
    let first = Frame::check(&mut checks, wire.body.next_frame());
    assert_eq!((first.sequence, first.report), (1, None));
    let farewell = encode::reply(SESSION + 1, first.sequence, &Reply::Detach);
    assert_eq!(wire.body.obey(&farewell), Ok(Directive::Detach));
}

/// Whatever the body does, it senses only declared types, with values in their declared ranges.
pub(crate) fn values_stay_within_what_is_declared(subject: &dyn Subject) {
    let mut wire = Wire::new(subject, 6);
    let mut random = SplitMix::new(6);
    let mut frame = wire.frame();
    let mut outcomes = [0_usize; 5];
    for _ in 0..ACTIONS {
        let order = anything(wire.checks.description(), &mut random);
        frame = wire.order(&frame, &order);
        let Some(OrderReport { outcome, .. }) = &frame.report else { panic!("an order is reported on") };
        let index = match outcome {
            Outcome::Done => 0,
            Outcome::Refused(_) => 1,
            Outcome::Failed(_) => 2,
            Outcome::TimedOut => 3,
            Outcome::EpisodeEnded | Outcome::EpisodeCut => 4,
        };
        outcomes[index] += 1;
        let again = format!("{:?}", frame.observations);
        let distinct: BTreeSet<String> = frame.observations.iter().map(|one| format!("{one:?}")).collect();
        assert_eq!(distinct.len(), frame.observations.len(), "each observation once: {again}");
    }
    println!(
        "done {}, refused {}, failed {}, timed out {}, episodes {}",
        outcomes[0], outcomes[1], outcomes[2], outcomes[3], outcomes[4]
    );
    assert!(outcomes[0] * 10 > ACTIONS * 8, "most of it is carried out: {outcomes:?}");
    // An arm may be stopped by its watchdog on a machine under load; anything more is a fault.
    assert!(
        (outcomes[2] + outcomes[3]) * 200 <= ACTIONS,
        "hardly anything fails in a sound body: {outcomes:?}"
    );
}

/// The surroundings are arranged as asked, or it is said that they were not.
pub(crate) fn scene_commands_are_obeyed_or_refused(subject: &dyn Subject) {
    let mut wire = Wire::new(subject, 7);
    let mut random = SplitMix::new(7);
    let commands = wire.description().scene_commands.clone();
    let mut frame = wire.frame();
    for (index, command) in commands.iter().enumerate().flat_map(|one| std::iter::repeat_n(one, 5)) {
        let parameters = command.parameters.iter().map(|one| any(&one.kind, &mut random)).collect();
        let order =
            Reply::Arrange(Action { id: ActionId::from_index(u16::try_from(index).unwrap()), parameters });
        frame = wire.order(&frame, &order);
        let outcome = frame.report.as_ref().map(|report| &report.outcome);
        assert!(matches!(outcome, Some(Outcome::Done | Outcome::Refused(_))), "{order:?}: {outcome:?}");
    }
    if commands.is_empty() {
        let order = encode::reply(SESSION, 1, &Reply::Arrange(Action::new(ActionId::from_index(0), ())));
        assert!(wire.body.obey(&order).is_err());
    }
}

/// Equal seeds and orders give equal frames and outcomes.
pub(crate) fn the_same_seed_gives_the_same_life(subject: &dyn Subject) {
    let life = || {
        let mut wire = Wire::new(subject, 8);
        let mut random = SplitMix::new(8);
        let mut frame = wire.frame();
        let mut lived = vec![frame.clone()];
        for _ in 0..60 {
            let order = anything(wire.checks.description(), &mut random);
            frame = wire.order(&frame, &order);
            lived.push(frame.clone());
        }
        lived
    };
    let (one, other) = (life(), life());
    for (one, other) in one.iter().zip(&other) {
        assert_eq!(one, other);
    }
}
