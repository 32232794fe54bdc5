//! Superschemas: what no single schema achieves is achieved by several, in order and by different classes of actions.

// A test may stop at what cannot be; every number here is small.
#![allow(clippy::unwrap_used)]

mod common;

use std::collections::BTreeSet;

use common::free;
use pschema_learner::decision::{Decision, Subject};
use pschema_learner::mechanisms::Mechanisms;
use pschema_learner::memory::Memory;
use pschema_learner::observation::{Observation, PropertyId, TypeId, Value};
use pschema_learner::parameters::Parameters;
use pschema_learner::vocabulary::{
    BodyId, Declaration, DeclaredAction, DeclaredProperty, DeclaredType, Parameter, PrimitiveId, ValueKind,
};
use pschema_learner::{ActionOutcome, Frame, Learner, Output, why_not};

const FIELDS: i64 = 4;
/// A field that no hand comes to.
const FAR: i64 = 9;
/// The body of which the only action comes to a field with its hand and closes it there.
const TAKER: BodyId = BodyId(0);
/// The body that reaches for a field by one action, and opens or closes its hand by others.
const REACHER: BodyId = BodyId(1);

const HAND: TypeId = TypeId(0);
const GRIP: TypeId = TypeId(1);
const OBJECT: TypeId = TypeId(2);
const HELD: TypeId = TypeId(3);

fn property(name: &str) -> DeclaredProperty {
    let kind = if name == "closed" { ValueKind::Boolean } else { ValueKind::Integer };
    DeclaredProperty { name: name.into(), unit: String::new(), kind }
}

fn declaration(body: &str, actions: &[&str], repertoire: Vec<(usize, Vec<Parameter>)>) -> Declaration {
    let kind = |name: &str, own, transient, properties: &[&str]| DeclaredType {
        name: name.into(),
        own,
        transient,
        heard: false,
        value: false,
        properties: properties.iter().map(|name| property(name)).collect(),
    };
    let types = vec![
        kind("hand", true, false, &["field"]),
        kind("grip", true, false, &["closed"]),
        kind("object", false, false, &["field"]),
        kind("held", false, true, &[]),
    ];
    let action = |name: &&str| DeclaredAction {
        name: (*name).into(),
        parameters: if *name == "take" || *name == "reach" { vec![property("field")] } else { Vec::new() },
    };
    Declaration {
        body: body.into(),
        observation_types: types,
        actions: actions.iter().map(action).collect(),
        repertoire,
    }
}

/// A table with two bodies, of which one acts at a time.
struct Table {
    learner: Learner,
    hand: i64,
    closed: bool,
    object: Option<i64>,
    held: bool,
    outcome: Option<ActionOutcome>,
    /// How often the hand closed at the object.
    takes: u32,
}

impl Table {
    fn new(mechanisms: Mechanisms) -> Self {
        let mut learner = Learner::new(1, Parameters::default(), free()).unwrap();
        learner.set_mechanisms(mechanisms);
        let at = |action: usize| move |field: i64| (action, vec![Parameter::Integer(field)]);
        learner.declare(declaration("taker", &["take"], (0..FIELDS).map(at(0)).collect())).unwrap();
        let both = (0..FIELDS).map(at(0)).chain([(1, Vec::new()), (2, Vec::new())]).collect();
        learner.declare(declaration("reacher", &["reach", "close", "open"], both)).unwrap();
        Self { learner, hand: 0, closed: false, object: None, held: false, outcome: None, takes: 0 }
    }

    /// Shows how things are, and what the learner decides to do about it.
    fn show(&mut self, body: BodyId) -> (PrimitiveId, Decision) {
        let at = |kind: TypeId, field: i64| Observation::new(kind, [(PropertyId(0), Value::Integer(field))]);
        let grip = Observation::new(GRIP, [(PropertyId(1), Value::Boolean(self.closed))]);
        let mut observations = vec![at(HAND, self.hand), grip];
        observations.extend(self.object.map(|field| at(OBJECT, field)));
        observations.extend(self.held.then(|| Observation::new(HELD, [])));
        let step = self.learner.step(&Frame { body, outcome: self.outcome.take(), observations });
        let Output::Act(primitive) = step.output else { panic!("it acts") };
        (primitive, step.decision.unwrap())
    }

    fn step(&mut self, body: BodyId) -> Decision {
        let (PrimitiveId(primitive), decision) = self.show(body);
        let field = i64::from(primitive) % FIELDS;
        match i64::from(primitive) / FIELDS {
            0 => (self.hand, self.closed) = (field, true),
            1 => self.hand = field,
            _ => self.closed = field == 0,
        }
        self.held = self.closed && self.object == Some(self.hand);
        self.takes += u32::from(self.held && body == REACHER);
        self.outcome = Some(ActionOutcome::Done);
        decision
    }

    /// A body goes on, and its hand is opened and taken away after each action.
    fn live(&mut self, body: BodyId, object: Option<i64>, steps: usize) {
        self.object = object;
        for _ in 0..steps {
            self.begin();
            self.step(body);
            let _ = self.show(body);
        }
    }

    fn begin(&mut self) {
        (self.hand, self.closed, self.held, self.outcome) = (-1, false, false, None);
    }

    /// What the taker learns of taking, and the reacher of its hand while what is to be taken is out of its reach.
    fn learnt(mechanisms: Mechanisms) -> Self {
        let mut table = Self::new(mechanisms);
        table.live(TAKER, None, 40);
        table.live(TAKER, Some(0), 12);
        table.live(TAKER, Some(2), 12);
        table.live(REACHER, None, 40);
        table.live(REACHER, Some(FAR), 40);
        table.live(TAKER, Some(0), 40);
        table
    }
}

fn with_superschemas() -> Mechanisms {
    Mechanisms { superschemas: true, ..Mechanisms::PAPER }
}

#[test]
fn one_reaches_then_another_grasps() {
    let mut table = Table::learnt(with_superschemas());
    table.begin();
    table.object = Some(1);
    let decision = table.step(REACHER);
    let chosen = &decision.candidates[decision.chosen];
    let content = table.learner.memory().content();
    let together: Vec<_> = chosen.together.iter().map(|id| content.concrete(*id).unwrap().action.0).collect();
    assert_eq!(
        (BTreeSet::from_iter(together), chosen.distance),
        (BTreeSet::from([5, 8]), 2),
        "it reaches and closes, whichever comes first: {decision:?}"
    );
    let Subject::Schema(law) = chosen.subject else { panic!("a law") };
    assert!(content.generalised(law).is_some());
    table.step(REACHER);
    assert_eq!((table.hand, table.closed, table.takes), (1, true, 1));
    // What came of it counts for the law.
    let executions = |table: &Table| table.learner.memory().content().schema(law).unwrap().executions.trials;
    let before = executions(&table);
    let _ = table.show(REACHER);
    assert_eq!(executions(&table), before + 1);
}

#[test]
fn a_decision_that_several_are_for_is_weighed_once_more() {
    let mut table = Table::learnt(with_superschemas());
    table.begin();
    table.object = Some(1);
    let before = table.learner.memory().content().clone();
    let (_, decision) = table.show(REACHER);
    let Subject::Schema(law) = decision.candidates[decision.chosen].subject else { panic!("a law") };
    let memory = Memory::restore(before, Parameters::default());
    let again = why_not::weigh(&memory, table.learner.curriculum(), &decision, law).unwrap();
    assert_eq!(again.verdict, why_not::Verdict::Chosen);
    let first = decision.candidates[decision.chosen].together[0];
    let again = why_not::weigh(&memory, table.learner.curriculum(), &decision, first).unwrap();
    assert_eq!(again.verdict, why_not::Verdict::ExecutedFor(law));
}

/// The hand that is closed already need not be closed.
#[test]
fn what_is_there_already_is_not_done_again() {
    let mut table = Table::learnt(with_superschemas());
    table.begin();
    (table.object, table.closed) = (Some(1), true);
    let decision = table.step(REACHER);
    let chosen = &decision.candidates[decision.chosen];
    assert!(
        matches!(chosen.subject, Subject::Schema(_)) && chosen.together.is_empty() && chosen.distance == 1
    );
    assert_eq!((table.hand, table.closed, table.held), (1, true, true));
}

/// A law that was learnt without claims serves a learner with claims as long as these know nothing of its last action there.
#[test]
fn claims_let_it_be_tried_once() {
    let mut table = Table::learnt(with_superschemas());
    table.learner.set_mechanisms(Mechanisms::FULL);
    let is_tried = |table: &mut Table| {
        table.begin();
        table.object = Some(1);
        let (_, decision) = table.show(REACHER);
        table.outcome = None;
        decision.candidates.iter().any(|candidate| candidate.together.len() == 2)
    };
    assert!(is_tried(&mut table), "nothing is known of closing there");
    for _ in 0..60 {
        table.step(REACHER);
    }
    assert!(table.takes > 0 && !is_tried(&mut table), "it is known by now: {}", table.takes);
}

#[test]
fn without_the_mechanism_what_no_single_schema_achieves_is_out_of_reach() {
    let mut table = Table::learnt(Mechanisms::PAPER);
    table.begin();
    table.object = Some(1);
    for _ in 0..10 {
        let decision = table.step(REACHER);
        assert!(decision.candidates.iter().all(|candidate| candidate.together.is_empty()));
    }
}
