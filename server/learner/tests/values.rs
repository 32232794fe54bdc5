//! Values: numbers that come with frames. The learner does not live by them, and brings most of one if it is asked to.

// A test may stop at what cannot be; every number here is small.
#![allow(clippy::unwrap_used)]

mod common;

use common::free;
use pschema_learner::decision::Reason;
use pschema_learner::digest::digest;
use pschema_learner::evidence::About;
use pschema_learner::mechanisms::Mechanisms;
use pschema_learner::notation;
use pschema_learner::observation::{Observation, Pattern, PropertyId, Term, TypeId, Value};
use pschema_learner::parameters::{Parameters, TypeOverride};
use pschema_learner::plan::plan;
use pschema_learner::policy::Policy;
use pschema_learner::pursuit::{Ending, Goal, PursueError, Pursuit};
use pschema_learner::random::Random;
use pschema_learner::vocabulary::{
    BodyId, Declaration, DeclarationError, DeclaredAction, DeclaredProperty, DeclaredType, PrimitiveId,
    ValueKind, Vocabulary,
};
use pschema_learner::world_state::WorldState;
use pschema_learner::{ActionOutcome, Frame, Learner, Output, Step};

const BODY: BodyId = BodyId(0);
const STEPS: [(i64, i64); 4] = [(0, -1), (1, 0), (0, 1), (-1, 0)];
/// The width of a bin of the reward.
const RESOLUTION: f64 = 0.5;
/// What comes an action later counts so much (docs/LEARNING.md, "Most of something").
const DISCOUNT: f64 = 0.99;

fn numbers(name: &str, properties: &[&str]) -> DeclaredType {
    let number = |name: &&str| DeclaredProperty {
        name: (*name).into(),
        unit: String::new(),
        kind: ValueKind::Integer,
    };
    DeclaredType { properties: properties.iter().map(number).collect(), ..DeclaredType::state(name) }
}

fn reward() -> DeclaredType {
    let kind = ValueKind::Real { resolution: RESOLUTION };
    let amount = DeclaredProperty { name: "amount".into(), unit: String::new(), kind };
    DeclaredType { transient: true, value: true, properties: vec![amount], ..DeclaredType::state("reward") }
}

/// What comes of an action: where the body is then, and what is rewarded.
type Rewards = fn(&mut Random, from: (i64, i64), to: (i64, i64)) -> f64;

/// Fields in rows and columns with walls around, and lamps that blink. An action moves by a field.
struct Grid {
    learner: Learner,
    size: i64,
    at: (i64, i64),
    /// Where it was before the last action.
    before: (i64, i64),
    lamp: bool,
    /// Where an episode ends.
    end: Option<(i64, i64)>,
    /// None of a body that declares no reward.
    rewards: Option<Rewards>,
    comes: Option<f64>,
    outcome: Option<ActionOutcome>,
    random: Random,
    luck: Random,
    /// What came in all.
    came: f64,
}

impl Grid {
    fn new(mechanisms: Mechanisms, size: i64, rewards: Option<Rewards>) -> Self {
        Self::under(Parameters::default(), mechanisms, size, rewards)
    }

    fn under(parameters: Parameters, mechanisms: Mechanisms, size: i64, rewards: Option<Rewards>) -> Self {
        let mut learner = Learner::new(3, parameters, free()).unwrap();
        learner.set_mechanisms(mechanisms);
        let action = |name: &str| DeclaredAction { name: name.into(), parameters: Vec::new() };
        // The reward comes first, so that all other types and properties have other numbers without it.
        let first = rewards.map(|_| reward()).into_iter();
        let declaration = Declaration {
            body: "grid".into(),
            observation_types: first.chain([numbers("at", &["x", "y"]), numbers("lamp", &["lit"])]).collect(),
            actions: ["north", "east", "south", "west"].map(action).into(),
            repertoire: (0..4).map(|number| (number, Vec::new())).collect(),
        };
        learner.declare(declaration).unwrap();
        Self {
            learner,
            size,
            at: (0, 0),
            before: (0, 0),
            lamp: false,
            end: None,
            rewards,
            comes: None,
            outcome: None,
            random: Random::from_seed(17),
            luck: Random::from_seed(29),
            came: 0.0,
        }
    }

    fn vocabulary(&self) -> &Vocabulary {
        &self.learner.memory().content().vocabulary
    }

    fn one(&self, kind: &str, values: &[Value]) -> Observation {
        let id = self.vocabulary().type_named(kind).unwrap();
        let properties = self.vocabulary().types()[usize::from(id.0)].properties.iter().copied();
        Observation::new(id, properties.zip(values.iter().copied()))
    }

    fn place(&self, at: (i64, i64)) -> Observation {
        self.one("at", &[Value::Integer(at.0), Value::Integer(at.1)])
    }

    fn reward(&self) -> TypeId {
        self.vocabulary().type_named("reward").unwrap()
    }

    fn observations(&self) -> Vec<Observation> {
        let lamp = self.one("lamp", &[Value::Integer(i64::from(self.lamp))]);
        let comes = self.comes.map(|comes| self.one("reward", &[Value::Bin((comes / RESOLUTION) as i64)]));
        [self.place(self.at), lamp].into_iter().chain(comes).collect()
    }

    fn step(&mut self) -> Step {
        let observations = self.observations();
        let frame = Frame { body: BODY, outcome: self.outcome.take(), observations };
        let step = self.learner.step(&frame);
        let Output::Act(PrimitiveId(action)) = step.output else { return step };
        self.outcome = Some(ActionOutcome::Done);
        self.comes = None;
        if self.end == Some(self.at) {
            // It is not carried out: the episode had ended.
            (self.at, self.outcome) = ((0, 0), Some(ActionOutcome::EpisodeEnded));
            return step;
        }
        let to = self.led(self.at, action as usize);
        let from = std::mem::replace(&mut self.at, to);
        self.before = from;
        self.lamp = self.random.below(2) == 1;
        let comes = self.rewards.map_or(0.0, |rewards| rewards(&mut self.luck, from, to));
        self.comes = Some(comes).filter(|comes| *comes != 0.0);
        self.came += comes;
        step
    }

    fn led(&self, from: (i64, i64), action: usize) -> (i64, i64) {
        let inside = |n: i64| n.clamp(0, self.size - 1);
        (inside(from.0 + STEPS[action].0), inside(from.1 + STEPS[action].1))
    }

    fn live(mut self, steps: usize) -> Self {
        (0..steps).for_each(|_| drop(self.step()));
        self
    }

    fn pursuit(&self) -> Pursuit {
        self.learner.memory().content().pursuit.as_deref().unwrap().clone()
    }

    fn policy(&self) -> Policy {
        self.pursuit().plans.last().unwrap().policy.as_deref().unwrap().clone()
    }

    /// What each field is worth, and each action in it, by the world as it is.
    fn truth(&self) -> Vec<(f64, [f64; 4])> {
        let fields = (0..self.size * self.size).map(|n| (n % self.size, n / self.size));
        let number = |at: (i64, i64)| (at.1 * self.size + at.0) as usize;
        let mut none = Random::from_seed(0);
        let mut worth: Vec<(f64, [f64; 4])> = fields.clone().map(|_| (0.0, [0.0; 4])).collect();
        for _ in 0..3_000 {
            for from in fields.clone().filter(|from| Some(*from) != self.end) {
                let mut of = |action: usize| {
                    let to = self.led(from, action);
                    self.rewards.unwrap()(&mut none, from, to) + DISCOUNT * worth[number(to)].0
                };
                let of = [of(0), of(1), of(2), of(3)];
                worth[number(from)] = (of.into_iter().fold(f64::NEG_INFINITY, f64::max), of);
            }
        }
        worth
    }

    /// Compares the policy with the best one there is, in each context that it tells of; how many there are.
    fn assert_best(&self, policy: &Policy) -> usize {
        let (at, truth) = (self.vocabulary().type_named("at").unwrap(), self.truth());
        for (row, told) in policy.rows.iter().zip(&policy.yields) {
            let field = row.context.iter().find(|o| o.kind() == at).unwrap();
            let [(_, Value::Integer(x)), (_, Value::Integer(y))] = field.properties() else { panic!() };
            let (best, of) = truth[(y * self.size + x) as usize];
            let by = of[row.action.0 as usize];
            assert!(best - by <= best.abs() * 1e-3, "at {x}, {y}: {row:?} is worth {by} and not {best}");
            let off = (told.worth - best).abs() / best.abs().max(1.0);
            assert!(off < 0.1, "at {x}, {y}: {} is told, and it is {best}", told.worth);
        }
        policy.rows.len()
    }

    fn most(&mut self, actions: u32) {
        let goal = Goal::Most(self.reward());
        self.learner.pursue(BODY, goal, actions).unwrap();
    }

    fn until_ended(&mut self) -> Pursuit {
        while self.pursuit().under_way() {
            self.step();
        }
        self.pursuit()
    }
}

/// A small reward near, and a large one far away.
fn near_and_far(_: &mut Random, _: (i64, i64), to: (i64, i64)) -> f64 {
    match to {
        (1, 0) => 0.5,
        (3, 3) => 5.0,
        _ => 0.0,
    }
}

fn toll(_: &mut Random, _: (i64, i64), _: (i64, i64)) -> f64 {
    -1.0
}

fn at_random(luck: &mut Random, _: (i64, i64), _: (i64, i64)) -> f64 {
    luck.below(7) as f64 - 3.0
}

/// The same life with a reward, and without one: whatever comes, all choices are the same, and so are their reasons.
#[test]
fn the_learner_does_not_live_by_rewards() {
    for mechanisms in [Mechanisms::PAPER, Mechanisms::FULL] {
        let rewards: [Rewards; 3] = [at_random, toll, near_and_far];
        for (steps, end, rewards) in
            rewards.iter().map(|one| (700, None, *one)).chain([(1_200, Some((2, 2)), at_random as Rewards)])
        {
            let [mut with, mut without] = [Some(rewards), None].map(|rewards| {
                let mut grid = Grid::new(mechanisms, 3, rewards);
                grid.end = end;
                grid
            });
            for at in 0..steps {
                if at == 500 {
                    // A goal that has nothing to do with it changes nothing either.
                    for grid in [&mut with, &mut without] {
                        let kind = grid.vocabulary().type_named("at").unwrap();
                        let x = grid.vocabulary().property_named("x").unwrap();
                        let there = Pattern::new(kind, [(x, Term::Constant(Value::Integer(1)))]);
                        grid.learner.pursue(BODY, Goal::Again(vec![there]), 50).unwrap();
                    }
                }
                let [one, other] = [with.step(), without.step()].map(|step| {
                    let decision = step.decision.unwrap();
                    let chosen = &decision.candidates[decision.chosen];
                    let of = (chosen.excitation, chosen.distance, decision.candidates_total, decision.ties);
                    (step.output, decision.reason, of)
                });
                assert_eq!(one, other, "{rewards:?}, step {at}");
            }
            let told = |grid: &Grid| {
                let content = grid.learner.memory().content();
                let schemas = content.schemas.iter();
                schemas.map(|schema| notation::schema(content, schema).to_string()).collect::<Vec<_>>()
            };
            assert_eq!(told(&with), told(&without));
        }
    }
}

#[test]
fn claims_tell_what_comes() {
    let grid = Grid::new(Mechanisms::FULL, 4, Some(near_and_far)).live(600);
    let content = grid.learner.memory().content();
    let told = (0..4).flat_map(|action| content.evidence.claims(&content.vocabulary, About::Action(action)));
    let told = told.filter(|(kinds, _)| *kinds == [grid.reward()]);
    assert!(told.into_iter().any(|(_, claim)| !claim.exceptions.is_empty()), "a facet of its own");
    let context = [grid.place((2, 3)), grid.one("lamp", &[Value::Integer(0)])];
    let foretold = content.evidence.foretell(&content.vocabulary, None, PrimitiveId(1), &context);
    let comes = foretold.iter().find(|facet| facet.kinds == [grid.reward()]).unwrap();
    assert_eq!(comes.outcomes[0].0, [grid.one("reward", &[Value::Bin(10)])]);
    assert!(comes.attributed);
}

#[test]
fn the_best_policy_is_found() {
    let mut grid = Grid::new(Mechanisms::FULL, 4, Some(near_and_far)).live(900);
    let reward = grid.reward();
    // From where it is far.
    for _ in 0..300 {
        if grid.at.0 + grid.at.1 <= 2 {
            break;
        }
        grid.step();
    }
    grid.most(60);
    grid.step();
    let policy = grid.policy();
    assert!(grid.assert_best(&policy) >= 4, "{policy:?}");
    let wanted = grid.learner.memory();
    let world = WorldState::new(grid.observations());
    let found = plan(wanted, BODY, &world, &Goal::Most(reward)).plan.unwrap();
    assert!(found.policy.unwrap().worth().unwrap() > 100.0, "and it plans the same");
    let ended = grid.until_ended();
    assert_eq!((ended.ended, ended.actions), (Some(Ending::ActionsUsedUp), 60));
    // Seven fields away at most, and then 5 with each action at the wall.
    assert!(ended.came >= 5.0 * 52.0, "{}", ended.came);
    assert_eq!(ended.plans_made, 1, "what comes about as expected needs no other");
    let mut decision = None;
    grid.most(3);
    while grid.pursuit().under_way() {
        decision = grid.step().decision.filter(|decision| decision.reason == Reason::Goal).or(decision);
    }
    let goal = decision.unwrap().goal.unwrap();
    assert_eq!((goal.goal, goal.probability), (Goal::Most(reward), 0.0));
    assert!(goal.worth.unwrap() > 100.0);
}

/// Each action costs something: the end of the episode is near in each of them, and there is another after it.
#[test]
fn what_costs_is_kept_short_and_each_episode_counts() {
    let mut grid = Grid::new(Mechanisms::FULL, 4, Some(toll));
    grid.end = Some((2, 3));
    let mut grid = grid.live(1_500);
    while grid.at != (0, 0) {
        grid.step();
    }
    grid.most(60);
    grid.step();
    let policy = grid.policy();
    assert!(grid.assert_best(&policy) >= 5, "{policy:?}");
    let (before, mut episodes) = (grid.came, 0);
    while grid.pursuit().under_way() {
        grid.step();
        episodes += usize::from(grid.outcome == Some(ActionOutcome::EpisodeEnded));
    }
    let ended = grid.pursuit();
    assert_eq!(ended.ended, Some(Ending::ActionsUsedUp));
    // Five actions from the beginning to the end, and one in which the next begins.
    assert!(episodes >= 9, "{episodes}");
    assert!(ended.came <= -45.0 && (ended.came - (grid.came - before)).abs() <= 2.0, "{}", ended.came);
}

/// Of a place where a reward came and comes no more, it is learnt.
#[test]
fn a_policy_is_made_anew_when_less_comes_than_expected() {
    let twice: Rewards = |_, _, to| match to {
        (1, 0) => 0.5,
        (3, 3) => 1.0,
        _ => 0.0,
    };
    let mut grid = Grid::new(Mechanisms::FULL, 4, Some(twice)).live(600);
    grid.rewards = Some(|_, _, to| if to == (1, 0) { 0.5 } else { 0.0 });
    grid.most(1_000);
    grid.until_ended();
    let near = (grid.at.0 - 1).abs() + grid.at.1;
    assert!(near <= 1 && grid.pursuit().came > 50.0, "{:?}: {}", grid.at, grid.pursuit().came);
}

/// Numbers without measure end no life: they count as the greatest that there is.
#[test]
fn rewards_beyond_measure_are_taken() {
    let mut grid =
        Grid::new(Mechanisms::FULL, 3, Some(|_, _, to| if to == (2, 2) { f64::MAX } else { f64::MIN }));
    grid = grid.live(200);
    grid.most(60);
    let ended = grid.until_ended();
    assert_eq!(ended.ended, Some(Ending::ActionsUsedUp));
    assert!(ended.came.is_finite() && ended.plans.iter().all(|plan| plan.policy.is_some()));
    let vocabulary = grid.vocabulary();
    let one = |bin| grid.one("reward", &[Value::Bin(bin)]);
    let all = [one(i64::MAX), one(i64::MAX - 1), one(i64::MIN)];
    assert!(vocabulary.sum_of(grid.reward(), &all).is_finite());
}

/// The same where a bin is as wide as numbers go: some add up to more than there is.
#[test]
fn numbers_that_are_added_up_stay_finite() {
    let mut learner = Learner::new(1, Parameters::default(), free()).unwrap();
    let mut wide = reward();
    wide.properties[0].kind = ValueKind::Real { resolution: f64::MAX };
    let declaration = Declaration {
        body: "wide".into(),
        observation_types: vec![wide],
        actions: vec![DeclaredAction { name: "wait".into(), parameters: Vec::new() }],
        repertoire: vec![(0, Vec::new())],
    };
    learner.declare(declaration).unwrap();
    let vocabulary = &learner.memory().content().vocabulary;
    let kind = vocabulary.type_named("reward").unwrap();
    let one = |bin| Observation::new(kind, [(PropertyId(0), Value::Bin(bin))]);
    assert_eq!(vocabulary.sum_of(kind, &[one(1), one(2), one(3)]), 1e100);
    assert_eq!(vocabulary.sum_of(kind, &[one(-1), one(i64::MIN)]), -1e100);
    assert_eq!(vocabulary.sum_of(kind, &[one(1), one(-1)]), 0.0);
}

#[test]
fn a_pattern_may_name_a_value() {
    let mut grid = Grid::new(Mechanisms::FULL, 4, Some(near_and_far)).live(900);
    let goal = Pattern::new(grid.reward(), [(PropertyId(0), Term::Constant(Value::Bin(10)))]);
    grid.learner.pursue(BODY, vec![goal], 20).unwrap();
    assert_eq!(grid.until_ended().ended, Some(Ending::Achieved));
    // It goes on as it likes when it sees that the goal holds.
    assert_eq!((grid.before, grid.pursuit().came), ((3, 3), 0.0));
}

#[test]
fn where_nothing_brings_any_there_is_nothing_to_do() {
    let mut grid = Grid::new(Mechanisms::FULL, 3, Some(|_, _, _| 0.0)).live(200);
    grid.most(10);
    assert_eq!(grid.until_ended().ended, Some(Ending::NothingBringsAny));
    assert_eq!(grid.pursuit().actions, 0);
    let at = grid.vocabulary().type_named("at").unwrap();
    let refused = grid.learner.pursue(BODY, Goal::Most(at), 10).unwrap_err();
    assert_eq!(refused, PursueError::NoValue { kind: "at".into(), values: vec!["reward".into()] });
    let mut paper = Grid::new(Mechanisms::PAPER, 3, Some(toll)).live(20);
    let refused = paper.learner.pursue(BODY, Goal::Most(paper.reward()), 10).unwrap_err();
    assert_eq!(refused, PursueError::NoPolicies);
    assert!(refused.to_string().contains("profile `full`"), "{refused}");
}

/// `learner.toml` may give a value a part in learning, as it may to every other type.
#[test]
fn a_parameter_makes_it_a_condition() {
    for mechanisms in [Mechanisms::PAPER, Mechanisms::FULL] {
        let part = TypeOverride { name: "reward".into(), precondition: None, postcondition: Some(true) };
        let parameters = Parameters { type_overrides: vec![part], ..Parameters::default() };
        let told = |parameters: Parameters| {
            let grid = Grid::under(parameters, mechanisms, 3, Some(near_and_far)).live(400);
            let content = grid.learner.memory().content().clone();
            let mut schemas = content.schemas.iter().filter_map(|schema| schema.concrete());
            schemas
                .any(|one| one.post.iter().any(|post| content.observation(post.what).kind() == grid.reward()))
        };
        assert!(told(parameters), "{mechanisms:?}");
        assert!(!told(Parameters::default()), "{mechanisms:?}");
    }
}

#[test]
fn a_value_is_one_number_that_comes_with_a_frame() {
    let refused = |kind: DeclaredType| {
        let declaration = Declaration {
            body: "odd".into(),
            observation_types: vec![kind],
            actions: Vec::new(),
            repertoire: Vec::new(),
        };
        Vocabulary::default().check(&declaration)
    };
    assert_eq!(refused(reward()), Ok(()));
    let two = [reward().properties, numbers("", &["n"]).properties].concat();
    let lit = DeclaredProperty { kind: ValueKind::Boolean, ..two[0].clone() };
    for odd in [
        DeclaredType { transient: false, ..reward() },
        DeclaredType { heard: true, ..reward() },
        DeclaredType { properties: Vec::new(), ..reward() },
        DeclaredType { properties: two, ..reward() },
        DeclaredType { properties: vec![lit], ..reward() },
    ] {
        assert_eq!(refused(odd), Err(DeclarationError::Value { name: "reward".into() }));
    }
    let mut known = Vocabulary::default();
    let declaration =
        |kind| Declaration { body: "b".into(), observation_types: vec![kind], ..Declaration::default() };
    known.declare(&declaration(DeclaredType { value: false, ..reward() })).unwrap();
    let differs = known.check(&declaration(reward())).unwrap_err().to_string();
    assert!(differs.contains("an event {amount"), "{differs}");
}

/// The effects bring the same memory back, what is expected and what came included.
#[test]
fn effects_tell_all_of_it() {
    let mut grid = Grid::new(Mechanisms::FULL, 3, Some(toll));
    grid.end = Some((2, 2));
    let mut copy = grid.learner.memory().clone();
    let take = |copy: &mut pschema_learner::memory::Memory, effects: &[pschema_learner::effect::Effect]| {
        effects.iter().for_each(|effect| copy.apply(effect).unwrap());
    };
    for at in 0..400 {
        if at == 300 {
            let effects = grid.learner.pursue(BODY, Goal::Most(grid.reward()), 1_000).unwrap();
            take(&mut copy, &effects);
        }
        let step = grid.step();
        take(&mut copy, &step.effects);
    }
    assert_eq!(digest(&copy.content().clone()), digest(grid.learner.memory().content()));
    assert_eq!(copy.content().pursuit, grid.learner.memory().content().pursuit);
    assert!(grid.pursuit().came < -50.0);
}
