//! Curiosity: what drives a learner that keeps claims, where a few schemas cover all that it can do.

// A test may stop at what cannot be; every number here is small.
#![allow(clippy::unwrap_used)]

mod common;

use std::collections::BTreeMap;

use common::free;
use pschema_learner::decision::Role;
use pschema_learner::effect::Effect;
use pschema_learner::mechanisms::Mechanisms;
use pschema_learner::observation::{Observation, PropertyId, SymbolId, TypeId, Value};
use pschema_learner::parameters::Parameters;
use pschema_learner::random::Random;
use pschema_learner::vocabulary::{
    Declaration, DeclaredAction, DeclaredProperty, DeclaredType, Parameter, PrimitiveId, ValueKind,
};
use pschema_learner::{ActionOutcome, Frame, Learner, Output, why_not};

const PLACES: usize = 12;
/// One step on, one step back, a jump to the place across, and a look at a picture.
const ACTIONS: u32 = 4;
const PICTURES: usize = 8;

fn property(name: &str) -> DeclaredProperty {
    DeclaredProperty { name: name.into(), unit: String::new(), kind: ValueKind::Symbol }
}

/// A ring of places with opaque names, and pictures that come at random.
struct Ring {
    learner: Learner,
    names: Vec<SymbolId>,
    place: usize,
    picture: usize,
    random: Random,
    /// How often each action was carried out at each place.
    tried: BTreeMap<(usize, u32), u32>,
}

impl Ring {
    fn new(seed: u64, mechanisms: Mechanisms) -> Self {
        let mut learner = Learner::new(seed, Parameters::default(), free()).unwrap();
        learner.set_mechanisms(mechanisms);
        let kind = |name: &str, property_name: &str| DeclaredType {
            name: name.into(),
            own: false,
            transient: false,
            heard: false,
            value: false,
            properties: vec![property(property_name)],
        };
        let action = |name: &str| DeclaredAction { name: name.into(), parameters: vec![property("of")] };
        let declaration = Declaration {
            body: "ring".into(),
            observation_types: vec![kind("at", "place"), kind("picture", "shows")],
            actions: ["on", "back", "across", "look"].map(action).into(),
            repertoire: (0..4).map(|number| (number, vec![Parameter::Symbol("it".into())])).collect(),
        };
        learner.declare(declaration).unwrap();
        let names = (0..PLACES.max(PICTURES)).map(|i| learner.symbol(&format!("s{i}")).0).collect();
        let random = Random::from_seed(seed ^ 0x51);
        Self { learner, names, place: 0, picture: 0, random, tried: BTreeMap::new() }
    }

    fn frame(&self, outcome: Option<ActionOutcome>) -> Frame {
        let shown = |kind: u16, property: u16, number: usize| {
            // The names do not tell which place is beside which.
            let name = self.names[number * 5 % PLACES % self.names.len()];
            Observation::new(TypeId(kind), [(PropertyId(property), Value::Symbol(name))])
        };
        let observations = vec![shown(0, 0, self.place), shown(1, 1, self.picture)];
        Frame { body: pschema_learner::vocabulary::BodyId(0), outcome, observations }
    }

    fn live(mut self, actions: usize) -> Self {
        let mut outcome = None;
        for _ in 0..actions {
            let frame = self.frame(outcome);
            let step = self.learner.step(&frame);
            let Output::Act(PrimitiveId(action)) = step.output else { panic!("nothing was chosen") };
            *self.tried.entry((self.place, action)).or_default() += 1;
            match action {
                0 => self.place = (self.place + 1) % PLACES,
                1 => self.place = (self.place + PLACES - 1) % PLACES,
                2 => self.place = (self.place + PLACES / 2) % PLACES,
                _ => self.picture = self.random.below(PICTURES),
            }
            outcome = Some(ActionOutcome::Done);
        }
        self
    }

    /// The share of what can be done at each place that was done.
    fn covered(&self) -> f64 {
        self.tried.len() as f64 / (PLACES * ACTIONS as usize) as f64
    }

    /// How often each action was carried out.
    fn by_action(&self) -> Vec<u32> {
        let of = |action| self.tried.iter().filter(|((_, tried), _)| *tried == action).map(|(_, n)| n).sum();
        (0..ACTIONS).map(of).collect()
    }

    /// The share of its actions in which it looked at pictures.
    fn looked(&self) -> f64 {
        let all: u32 = self.tried.values().sum();
        let looked: u32 = self.tried.iter().filter(|((_, action), _)| *action == 3).map(|(_, n)| n).sum();
        f64::from(looked) / f64::from(all)
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[test]
fn whatever_can_be_done_anywhere_is_tried_and_noise_holds_nobody() {
    let lives =
        |mechanisms| -> Vec<Ring> { (1..=9).map(|seed| Ring::new(seed, mechanisms).live(300)).collect() };
    let covered = |lives: &[Ring]| median(lives.iter().map(Ring::covered).collect());
    let without = lives(Mechanisms { curiosity: false, ..Mechanisms::FULL });
    let curious = lives(Mechanisms::FULL);
    let looked = median(curious.iter().map(Ring::looked).collect());
    let found = (covered(&without), covered(&curious), looked);
    assert!(found.1 >= 0.95 && found.1 > found.0 && looked < 0.5, "seeds 1 to 9: {found:?}");
}

/// What can't be foretold, and matters to nothing else, does not hold a learner when all the rest is known; and it does not repeat one
/// action for ever either.
#[test]
fn when_all_is_known_noise_is_dull_and_the_other_actions_take_turns() {
    let shares = |seed: u64| -> Vec<f64> {
        let ring = Ring::new(seed, Mechanisms::FULL).live(1_500);
        let before = ring.by_action();
        let after = ring.live(500).by_action();
        before.iter().zip(after).map(|(before, after)| f64::from(after - before) / 500.0).collect()
    };
    let lives: Vec<_> = (1..=5).map(shares).collect();
    let of = |action: usize| median(lives.iter().map(|shares| shares[action]).collect());
    println!("seeds 1 to 5: {lives:.2?}");
    assert!(of(3) <= 0.1, "the share of pictures: {lives:.2?}");
    assert!((0..3).all(|action| (0.1..=0.7).contains(&of(action))), "the others: {lives:.2?}");
}

#[test]
fn a_decision_tells_of_curiosity_and_can_be_weighed_once_more() {
    let mut ring = Ring::new(3, Mechanisms::FULL).live(40);
    let decision = loop {
        let frame = ring.frame(Some(ActionOutcome::Done));
        let decision = ring.learner.step(&frame).decision.unwrap();
        if decision.candidates.iter().any(|c| c.terms.iter().any(|term| term.role == Role::Curiosity)) {
            break decision;
        }
    };
    for candidate in &decision.candidates {
        let sum: f64 = candidate.terms.iter().map(|term| term.value).sum();
        let excitation = candidate.excitation * f64::from(candidate.distance);
        assert!((sum - excitation).abs() < 1e-9, "{sum} {excitation}");
    }
    let (memory, curriculum) = (ring.learner.memory(), ring.learner.curriculum());
    let schemas = decision.candidates.iter().filter_map(|candidate| match candidate.subject {
        pschema_learner::decision::Subject::Schema(id) => Some(id),
        pschema_learner::decision::Subject::Primitive(_) => None,
    });
    assert!(schemas.map(|id| why_not::weigh(memory, curriculum, &decision, id)).all(|told| told.is_ok()));
}

/// A body that refused an action some times and carries it out again: it was held to be unreliable for good.
#[test]
fn refusals_weigh_only_until_it_works_again() {
    let attempts = |mechanisms, outcomes: &[bool]| {
        let mut memory = Ring::new(1, mechanisms).learner.into_memory();
        for carried_out in outcomes {
            let attempted = Effect::Attempted { primitive: PrimitiveId(0), carried_out: *carried_out };
            memory.apply(&attempted).unwrap();
        }
        let count = memory.content().attempts.iter().next().copied().unwrap();
        (count.occurrences, count.trials)
    };
    let refused = [false; 8];
    let again = [&refused[..], &[true; 4]].concat();
    assert_eq!(attempts(Mechanisms::FULL, &refused), (0, 8), "what never works falls off");
    assert_eq!(attempts(Mechanisms::FULL, &again), (4, 4));
    assert_eq!(attempts(Mechanisms::PAPER, &again), (4, 12));
    assert_eq!(attempts(Mechanisms { curiosity: false, ..Mechanisms::FULL }, &again), (4, 12));
}

/// Switches that turn on in one order only, which nothing shows; a wrong one turns all off. What comes of one depends on all that are on. A lamp
/// blinks beside them.
#[test]
fn what_only_a_whole_series_leads_to_is_come_to() {
    const ORDER: [usize; 6] = [3, 0, 4, 1, 5, 2];
    const ACTIONS_MAX: usize = 1_000;
    let kind = |name: &str, property_name: &str| DeclaredType {
        name: name.into(),
        own: false,
        transient: false,
        heard: false,
        value: false,
        properties: vec![DeclaredProperty {
            name: property_name.into(),
            unit: String::new(),
            kind: ValueKind::Integer,
        }],
    };
    let solved = |seed: u64| {
        let mut learner = Learner::new(seed, Parameters::default(), free()).unwrap();
        learner.set_mechanisms(Mechanisms::FULL);
        let declaration = Declaration {
            body: "box".into(),
            observation_types: vec![kind("on", "switch"), kind("lamp", "lit")],
            actions: vec![DeclaredAction {
                name: "press".into(),
                parameters: kind("on", "switch").properties,
            }],
            repertoire: (0..6).map(|switch| (0, vec![Parameter::Integer(switch)])).collect(),
        };
        learner.declare(declaration).unwrap();
        let mut random = Random::from_seed(seed ^ 0x51);
        let (mut on, mut outcome) = (0, None);
        for taken in 0..ACTIONS_MAX {
            let sensed = |kind: u16, property: u16, number: usize| {
                let number = Value::Integer(i64::try_from(number).unwrap());
                Observation::new(TypeId(kind), [(PropertyId(property), number)])
            };
            let lamp = sensed(1, 1, random.below(2));
            let observations = ORDER[..on].iter().map(|switch| sensed(0, 0, *switch)).chain([lamp]).collect();
            let body = pschema_learner::vocabulary::BodyId(0);
            let step = learner.step(&Frame { body, outcome, observations });
            let Output::Act(PrimitiveId(switch)) = step.output else { panic!("nothing was chosen") };
            on = if ORDER[on] == switch as usize { on + 1 } else { 0 };
            if on == ORDER.len() {
                return taken as f64;
            }
            outcome = Some(ActionOutcome::Done);
        }
        ACTIONS_MAX as f64
    };
    let taken: Vec<_> = (1..=7).map(solved).collect();
    println!("seeds 1 to 7: {taken:?}");
    assert!(median(taken.clone()) < 250.0, "{taken:?}");
}
