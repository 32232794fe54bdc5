//! Things that are told one by one, and things out of sight that are recalled.

// A test may stop at what cannot be; every number here is small.
#![allow(clippy::unwrap_used)]

mod common;

use common::free;
use pschema_learner::Learner;
use pschema_learner::digest::digest;
use pschema_learner::effect::Effect;
use pschema_learner::evidence::{About, Foretold};
use pschema_learner::experience::Experience;
use pschema_learner::mechanisms::Mechanisms;
use pschema_learner::memory::Memory;
use pschema_learner::observation::{Observation, PropertyId, TypeId, Value};
use pschema_learner::parameters::Parameters;
use pschema_learner::random::Random;
use pschema_learner::vocabulary::{
    BodyId, Declaration, DeclaredAction, DeclaredProperty, DeclaredType, PrimitiveId, ValueKind,
};
use pschema_learner::world_state::WorldState;

const GAZE: TypeId = TypeId(0);
const STONE: TypeId = TypeId(1);
/// Places of the row.
const ROW: usize = 13;

/// A gaze over a row of places, on some of which a stone lies. It sees the stones up to two places to each side, by how far they
/// are from where it looks. One action moves it to the left, one to the right; chance chooses. Now and then a stone is moved.
struct Row {
    memory: Memory,
    effects: Vec<Effect>,
    stones: [bool; ROW],
    gaze: usize,
    random: Random,
    /// The world before the last action.
    earlier: Option<WorldState>,
    /// When the gaze went back to where it was before the last action: with what probability a stone was expected at the place that came
    /// into sight, and how often that was asked; where one had been, and where none had been.
    gone_back: [(f64, u32); 2],
}

impl Row {
    fn new(seed: u64, mechanisms: Mechanisms) -> Self {
        println!("seed {seed}");
        let mut learner = Learner::new(seed, Parameters::default(), free()).unwrap();
        let mut effects = learner.set_mechanisms(mechanisms);
        let sense = |name: &str, property: &str| DeclaredType {
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
            body: "row".into(),
            observation_types: vec![sense("gaze", "place"), sense("stone", "away")],
            actions: ["left", "right"].map(action).into(),
            repertoire: (0..2).map(|number| (number, Vec::new())).collect(),
        };
        effects.extend(learner.declare(declaration).unwrap().1);
        let mut random = Random::from_seed(seed ^ 0x51);
        let stones = std::array::from_fn(|_| random.below(2) == 0);
        let (earlier, gone_back) = (None, [(0.0, 0); 2]);
        let memory = learner.into_memory();
        Self { memory, effects, stones, gaze: ROW / 2, random, earlier, gone_back }
    }

    fn stone(away: i64) -> Observation {
        Observation::new(STONE, [(PropertyId(1), Value::Integer(away))])
    }

    fn world(&self) -> WorldState {
        let place = i64::try_from(self.gaze).unwrap();
        let gaze = Observation::new(GAZE, [(PropertyId(0), Value::Integer(place))]);
        let lies = |away: &i64| {
            let at = usize::try_from(place + away).ok();
            at.and_then(|at| self.stones.get(at)).is_some_and(|lies| *lies)
        };
        WorldState::new([gaze].into_iter().chain((-2..=2).filter(lies).map(Self::stone)))
    }

    fn act(&mut self, action: PrimitiveId) {
        self.gaze = match action {
            PrimitiveId(0) => self.gaze.saturating_sub(1),
            _ => (self.gaze + 1).min(ROW - 1),
        };
    }

    /// Takes in what came of an action.
    fn learn(&mut self, primitive: PrimitiveId, before: &WorldState) {
        let (content, after) = (self.memory.content(), self.world());
        let recalled = content.mechanisms.recalls().then(|| {
            content.evidence.recalled(&content.vocabulary, BodyId(0), primitive, after.observations())
        });
        let experience = Effect::Experienced(Box::new(Experience {
            body: BodyId(0),
            primitive,
            parameters: [].into(),
            before: before.observations().into(),
            after: after.observations().into(),
            sensed: [GAZE, STONE].into(),
            recalled: recalled.flatten(),
        }));
        self.memory.apply(&experience).unwrap();
        self.effects.push(experience);
    }

    fn live(mut self, actions: usize) -> Self {
        for _ in 0..actions {
            let action = PrimitiveId(u32::try_from(self.random.below(2)).unwrap());
            let (before, away) = (self.world(), if action == PrimitiveId(0) { -2 } else { 2 });
            let expected = self.expected(action, away);
            self.act(action);
            let shows = |world: &WorldState| world.filter(|o| o.kind() == GAZE);
            let now = self.world();
            if let Some(earlier) = &self.earlier
                && shows(earlier) == shows(&now)
                && shows(&before) != shows(&now)
            {
                let sum = &mut self.gone_back[usize::from(!earlier.contains(&Self::stone(away)))];
                sum.0 += expected;
                sum.1 += 1;
            }
            self.learn(action, &before);
            self.earlier = Some(before);
            if self.random.below(8) == 0 {
                let (one, other) = (self.random.below(ROW), self.random.below(ROW));
                self.stones.swap(one, other);
            }
        }
        self
    }

    fn foretold(&self, action: PrimitiveId) -> Vec<Foretold> {
        let content = self.memory.content();
        content.evidence.foretell(&content.vocabulary, Some(BodyId(0)), action, self.world().observations())
    }

    /// The means of what was expected at each return, from now on.
    fn going_back(mut self, actions: usize) -> [f64; 2] {
        self.gone_back = [(0.0, 0); 2];
        let lived = self.live(actions);
        lived.gone_back.map(|(sum, count)| {
            assert!(count > 0, "the gaze never went back");
            sum / f64::from(count)
        })
    }

    /// The probability with which a stone is expected so far away after an action.
    fn expected(&self, action: PrimitiveId, away: i64) -> f64 {
        let facets = self.foretold(action);
        let Some(facet) = facets.iter().find(|facet| facet.kinds == [STONE]) else { return 0.0 };
        let with = facet.outcomes.iter().filter(|(after, _)| after.contains(&Self::stone(away)));
        let with: u32 = with.map(|(_, count)| count).sum();
        f64::from(with) / f64::from(facet.trials)
    }
}

#[test]
fn stones_are_told_one_by_one_from_where_the_others_were() {
    for seed in 1..=3 {
        let row = Row::new(seed, Mechanisms::FULL).live(600);
        let content = row.memory.content();
        let claims = content.evidence.claims(&content.vocabulary, About::Action(0));
        let (_, claim) = claims.iter().find(|(kinds, _)| *kinds == [STONE]).unwrap();
        assert!(claim.is_of_each(), "seed {seed}");
        // The gaze goes to the left: each stone is one place more to the right from it.
        let mut inner = row;
        inner.gaze = 4;
        inner.stones = std::array::from_fn(|place| place == 3);
        assert!(inner.expected(PrimitiveId(0), 0) > 0.9, "seed {seed}");
        assert!(inner.expected(PrimitiveId(0), 1) < 0.1 && inner.expected(PrimitiveId(0), -1) < 0.1);
    }
}

#[test]
fn what_is_out_of_sight_is_expected_where_it_was() {
    for seed in 1..=3 {
        let [there, elsewhere] = Row::new(seed, Mechanisms::FULL).live(600).going_back(400);
        println!("{there:.3} {elsewhere:.3}");
        assert!(there > 0.8 && elsewhere < 0.3, "seed {seed}: {there} {elsewhere}");
    }
}

#[test]
fn without_recall_nothing_out_of_sight_is_known() {
    let forgetful = Mechanisms { recall: false, ..Mechanisms::FULL };
    let row = Row::new(1, forgetful).live(300);
    assert_eq!(row.memory.content().evidence.recollections().count(), 0);
    // What was noted before it was switched off is old when it is on again.
    let mut memory = Row::new(1, Mechanisms::FULL).live(100).memory;
    assert_eq!(memory.content().evidence.recollections().count(), 1);
    memory.apply(&Effect::Mechanisms(forgetful)).unwrap();
    assert_eq!(memory.content().evidence.recollections().count(), 0);
    let [there, elsewhere] = row.going_back(400);
    assert!(there - elsewhere < 0.5, "{there} {elsewhere}");
}

#[test]
fn effects_alone_make_the_same_memory() {
    let row = Row::new(4, Mechanisms::FULL).live(300);
    let mut replayed = Memory::new(4, Parameters::default());
    for effect in &row.effects {
        replayed.apply(effect).unwrap();
    }
    let lived = row.memory.content();
    assert_eq!(digest(replayed.content()), digest(lived));
    assert!(replayed.content().evidence == lived.evidence);
}
