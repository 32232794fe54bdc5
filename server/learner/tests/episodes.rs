//! Episodes: a frame that begins a new one came of nothing that was done before.

// A test may stop at what cannot be; every number here is small.
#![allow(clippy::unwrap_used)]

mod common;

use std::collections::BTreeSet;
use std::sync::Arc;

use common::free;
use pschema_learner::decision::Reason;
use pschema_learner::effect::Effect;
use pschema_learner::execution::ChainLink;
use pschema_learner::mechanisms::Mechanisms;
use pschema_learner::memory::Memory;
use pschema_learner::observation::{Observation, Pattern, PropertyId, Substitution, Term, TypeId, Value};
use pschema_learner::parameters::Parameters;
use pschema_learner::plan::plan;
use pschema_learner::pursuit::{Ending, Pursuit};
use pschema_learner::random::Random;
use pschema_learner::schema::SchemaId;
use pschema_learner::vocabulary::{
    BodyId, Declaration, DeclaredAction, DeclaredProperty, DeclaredType, PrimitiveId, ValueKind,
};
use pschema_learner::world_state::WorldState;
use pschema_learner::{ActionOutcome, Frame, Learner, Output, Step};

const BODY: BodyId = BodyId(0);

/// Fields in a row between two walls; an action goes to the next one on the left or on the right.
#[derive(Clone)]
struct Row {
    learner: Learner,
    walls: (i64, i64),
    at: i64,
    outcome: Option<ActionOutcome>,
}

impl Row {
    fn new(mechanisms: Mechanisms, walls: (i64, i64)) -> Self {
        let mut learner = Learner::new(7, Parameters::default(), free()).unwrap();
        learner.set_mechanisms(mechanisms);
        let field = DeclaredProperty { name: "field".into(), unit: String::new(), kind: ValueKind::Integer };
        let at = DeclaredType {
            name: "at".into(),
            own: false,
            transient: false,
            heard: false,
            value: false,
            properties: vec![field],
        };
        let action = |name: &str| DeclaredAction { name: name.into(), parameters: Vec::new() };
        let declaration = Declaration {
            body: "row".into(),
            observation_types: vec![at],
            actions: ["left", "right"].map(action).into(),
            repertoire: vec![(0, Vec::new()), (1, Vec::new())],
        };
        learner.declare(declaration).unwrap();
        Self { learner, walls, at: walls.0, outcome: None }
    }

    fn world(at: i64) -> WorldState {
        WorldState::new([Observation::new(TypeId(0), [(PropertyId(0), Value::Integer(at))])])
    }

    fn goal(at: i64) -> Vec<Pattern> {
        vec![Pattern::new(TypeId(0), [(PropertyId(0), Term::Constant(Value::Integer(at)))])]
    }

    /// The learner sees where the body is, and the body does what it says.
    fn step(&mut self) -> Step {
        let observations = Self::world(self.at).observations().to_vec();
        let step = self.learner.step(&Frame { body: BODY, outcome: self.outcome.take(), observations });
        if let Output::Act(PrimitiveId(action)) = step.output {
            self.at = (self.at + [-1, 1][action as usize]).clamp(self.walls.0, self.walls.1);
            self.outcome = Some(ActionOutcome::Done);
        }
        step
    }

    fn live(mut self, steps: usize) -> Self {
        (0..steps).for_each(|_| drop(self.step()));
        self
    }

    /// What was asked is not carried out: a new episode begins at a field.
    fn begin(&mut self, at: i64, outcome: ActionOutcome) -> Step {
        (self.at, self.outcome) = (at, Some(outcome));
        self.step()
    }

    fn leads(&self, from: i64, to: i64) -> bool {
        plan(self.learner.memory(), BODY, &Self::world(from), &Self::goal(to).into()).plan.is_some()
    }

    fn pursuit(&self) -> Pursuit {
        self.learner.memory().content().pursuit.as_deref().unwrap().clone()
    }
}

#[test]
fn nothing_is_learnt_across_the_begin_of_an_episode() {
    for mechanisms in [Mechanisms::PAPER, Mechanisms::FULL] {
        for outcome in [ActionOutcome::EpisodeEnded, ActionOutcome::EpisodeCut] {
            let mut row = Row::new(mechanisms, (0, 4)).live(61);
            let before = row.learner.memory().content().clone();
            let step = row.begin(4 - row.at, outcome);
            for effect in &step.effects {
                match effect {
                    Effect::StepEnded { .. } => (),
                    Effect::Followed { .. } if mechanisms.supposes() => (),
                    Effect::Experienced(one) if one.is_beginning() => assert!(mechanisms.claims),
                    // That nothing leads on from the last frame is no change.
                    Effect::Experienced(one) => {
                        assert!(mechanisms.claims && outcome == ActionOutcome::EpisodeEnded);
                        assert!(one.is_end() && one.before == one.after, "{one:?}");
                    }
                    other => panic!("{outcome:?} {other:?}"),
                }
            }
            let after = row.learner.memory().content();
            assert!(after.attempts.iter().eq(before.attempts.iter()), "it is no refusal");
            assert!(after.schemas.iter().eq(before.schemas.iter()));
            assert!(after.attention.iter().eq(before.attention.iter()));
            if outcome == ActionOutcome::EpisodeCut {
                assert!(after.evidence.kept().eq(before.evidence.kept()));
            }
        }
    }
}

/// It knows how it moves, so that it expects to move on from a field where it never was.
#[test]
fn after_one_episode_that_ended_it_is_known_that_nothing_leads_on_from_there() {
    let mut row = Row::new(Mechanisms::FULL, (3, 7)).live(80);
    row.walls = (0, 7);
    while row.at != 2 {
        row.step();
    }
    row.step();
    assert!(row.leads(2, 7));
    let mut cut = row.clone();
    cut.begin(5, ActionOutcome::EpisodeCut);
    assert!(cut.leads(2, 7));
    let step = row.begin(5, ActionOutcome::EpisodeEnded);
    let ends = step.effects.iter().filter(|e| matches!(e, Effect::Experienced(one) if one.is_end()));
    assert_eq!(ends.count(), 1);
    assert!(!row.leads(2, 7), "whatever is done there");
    assert!(row.leads(3, 7));
}

#[test]
fn what_is_known_of_an_end_is_not_learnt_for_ever() {
    let mut row = Row::new(Mechanisms::FULL, (0, 4)).live(20);
    let mut learnt = 0;
    for _ in 0..50 {
        let end = row.begin(2, ActionOutcome::EpisodeEnded).effects;
        learnt += end.iter().filter(|e| matches!(e, Effect::Experienced(one) if one.is_end())).count();
        row.outcome = None;
        row.at = 2;
        row.step();
    }
    assert!((16..=40).contains(&learnt), "{learnt}");
}

#[test]
fn a_chain_ends_with_its_episode() {
    let chained = |outcome| {
        let mut row = Row::new(Mechanisms::PAPER, (0, 4)).live(40);
        let content = row.learner.memory().content();
        let mut execution = content.pending[0].as_deref().unwrap().clone();
        // Something that can be done where the body is next.
        let here = Row::world(row.at);
        let holds = |id: &SchemaId| {
            let pre = &content.concrete(*id).unwrap().pre;
            here.satisfies(pre.iter().map(|id| content.observation(*id)))
        };
        let schema = (0..content.schemas.len() as u32).map(SchemaId).find(holds).unwrap();
        execution.chain = vec![ChainLink { schema, binding: Substitution::new(), carrier: None }];
        let random = content.random.state();
        let (curriculum, mut memory): (_, Memory) =
            (row.learner.curriculum().clone(), row.learner.into_memory());
        let pending = Some(Arc::new(execution));
        memory.apply(&Effect::StepEnded { body: BODY, random, pending }).unwrap();
        row.learner = Learner::resume(memory, curriculum).unwrap();
        row.outcome = Some(outcome);
        row.step().decision.unwrap().reason
    };
    assert_eq!(chained(ActionOutcome::Done), Reason::Chain);
    for outcome in [ActionOutcome::EpisodeEnded, ActionOutcome::EpisodeCut] {
        assert_ne!(chained(outcome), Reason::Chain, "{outcome:?}");
    }
}

#[test]
fn a_goal_goes_on_in_the_next_episode_by_the_same_policy() {
    let mut row = Row::new(Mechanisms::FULL, (0, 9)).live(200);
    row.begin(1, ActionOutcome::EpisodeCut);
    row.learner.pursue(BODY, Row::goal(8), 40).unwrap();
    row.step();
    row.step();
    let before = row.pursuit();
    row.begin(2, ActionOutcome::EpisodeCut);
    let after = row.pursuit();
    assert_eq!((after.plans_made, after.ended), (1, None));
    assert!(Arc::ptr_eq(&before.plans[0], &after.plans[0]), "what was to be done is as good as it was");
    while row.pursuit().ended.is_none() {
        row.step();
    }
    assert_eq!(row.pursuit().ended, Some(Ending::Achieved));
}

/// Nothing leads on from where an episode ends, and so nothing leads to the goal: but the next episode is yet to come.
#[test]
fn a_goal_is_not_given_up_where_an_episode_ends_and_reached_in_the_next() {
    let mut row = Row::new(Mechanisms::FULL, (0, 9)).live(200);
    row.walls = (0, 12);
    // Where it was put and never was before, all episodes ended.
    for _ in 0..3 {
        row.begin(12, ActionOutcome::EpisodeCut);
        row.begin(4, ActionOutcome::EpisodeEnded);
    }
    row.learner.pursue(BODY, Row::goal(8), 40).unwrap();
    row.step();
    let put = row.begin(12, ActionOutcome::EpisodeCut);
    assert!(matches!(put.output, Output::Act(_)), "something is asked");
    assert_eq!(row.pursuit().ended, None);
    row.begin(4, ActionOutcome::EpisodeEnded);
    assert!(row.pursuit().ended.is_none());
    while row.pursuit().ended.is_none() {
        row.step();
    }
    assert_eq!(row.pursuit().ended, Some(Ending::Achieved));
}

/// That episodes end beyond a field is told of fields where it never was.
#[test]
fn an_end_is_foretold_where_nobody_was_yet() {
    let mut row = Row::new(Mechanisms::FULL, (0, 6)).live(120);
    row.walls = (0, 12);
    let arrives = |row: &Row, from: i64| {
        let found = plan(row.learner.memory(), BODY, &Row::world(from), &Row::goal(2).into());
        found.plan.map_or(0.0, |plan| plan.probability)
    };
    row.begin(3, ActionOutcome::EpisodeCut);
    assert!(arrives(&row, 11) > 0.5, "{}", arrives(&row, 11));
    for at in [7, 8, 9, 7, 8, 9, 7, 8, 9] {
        row.begin(at, ActionOutcome::EpisodeCut);
        row.begin(3, ActionOutcome::EpisodeEnded);
    }
    assert!(arrives(&row, 11) < 0.2, "{}", arrives(&row, 11));
    assert!(arrives(&row, 6) > 0.8, "{}", arrives(&row, 6));
}

/// Rooms in a row of fields each, which lead nowhere; where the last field is reached the episode ends, and the next begins in another room.
fn rooms_seen(rooms: u64, seed: u64) -> (usize, usize) {
    let mut learner = Learner::new(seed, Parameters::default(), free()).unwrap();
    learner.set_mechanisms(Mechanisms::FULL);
    let kind = |name: &str, property: &str| DeclaredType {
        name: name.into(),
        own: false,
        transient: false,
        heard: false,
        value: false,
        properties: vec![DeclaredProperty {
            name: property.into(),
            unit: String::new(),
            kind: ValueKind::Integer,
        }],
    };
    let action = |name: &str| DeclaredAction { name: name.into(), parameters: Vec::new() };
    let declaration = Declaration {
        body: "rooms".into(),
        observation_types: vec![kind("room", "number"), kind("at", "field")],
        actions: ["left", "right"].map(action).into(),
        repertoire: vec![(0, Vec::new()), (1, Vec::new())],
    };
    learner.declare(declaration).unwrap();
    let mut random = Random::from_seed(seed ^ 0x517);
    let (mut room, mut field, mut outcome, mut ends) = (0, 0_i64, None, 0);
    let mut seen = BTreeSet::from([room]);
    for _ in 0..400 {
        let integer = |value: i64| Value::Integer(value);
        let observations = vec![
            Observation::new(TypeId(0), [(PropertyId(0), integer(room))]),
            Observation::new(TypeId(1), [(PropertyId(1), integer(field))]),
        ];
        let step = learner.step(&Frame { body: BODY, outcome, observations });
        let Output::Act(PrimitiveId(action)) = step.output else { panic!("it holds still") };
        if field == 5 {
            (room, field, ends) = (random.below(rooms as usize) as i64, 0, ends + 1);
            outcome = Some(ActionOutcome::EpisodeEnded);
            seen.insert(room);
        } else {
            field = (field + [-1, 1][action as usize]).max(0);
            outcome = Some(ActionOutcome::Done);
        }
    }
    (seen.len(), ends)
}

/// What is new where an episode begins can be seen by ending one.
#[test]
fn it_ends_episodes_as_long_as_they_begin_where_it_never_was() {
    for seed in 1..=6 {
        let ((rooms, ends), (_, of_one)) = (rooms_seen(12, seed), rooms_seen(1, seed));
        assert!(rooms >= 8 && ends >= 2 * of_one, "seed {seed}: {rooms} rooms, {ends} ends; {of_one} of one");
    }
}
