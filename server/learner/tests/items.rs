//! Synthetic items: what the learner supposes where no sense tells why an action's outcomes differ.

// A test may stop at what cannot be; every number here is small.
#![allow(clippy::unwrap_used)]

mod common;

use common::free;
use pschema_learner::digest::digest;
use pschema_learner::effect::Effect;
use pschema_learner::item::Item;
use pschema_learner::mechanisms::Mechanisms;
use pschema_learner::memory::Memory;
use pschema_learner::observation::{Observation, PropertyId, TypeId, Value};
use pschema_learner::parameters::Parameters;
use pschema_learner::random::Random;
use pschema_learner::vocabulary::{
    BodyId, Declaration, DeclaredAction, DeclaredProperty, DeclaredType, PrimitiveId, ValueKind,
};
use pschema_learner::world_state::WorldState;
use pschema_learner::{ActionOutcome, Frame, Learner};

/// Two rooms that look alike (Holmes & Isbell's "flip"): one action leads to the left one, one to the right one, one stays. All
/// that is sensed is whether the room was changed.
struct Rooms {
    learner: Learner,
    effects: Vec<Effect>,
    right: bool,
    changed: bool,
    /// Whether what is sensed has nothing to do with the rooms.
    coin: bool,
    /// After how many actions an episode is cut off; the next begins in the left room.
    episode: usize,
    random: Random,
    wrong: Vec<bool>,
}

impl Rooms {
    fn new(seed: u64, mechanisms: Mechanisms, coin: bool) -> Self {
        let mut learner = Learner::new(seed, Parameters::default(), free()).unwrap();
        let mut effects = learner.set_mechanisms(mechanisms);
        let changed = DeclaredProperty { name: "is".into(), unit: String::new(), kind: ValueKind::Boolean };
        let sensed = DeclaredType {
            name: "changed".into(),
            own: false,
            transient: false,
            heard: false,
            value: false,
            properties: vec![changed],
        };
        let action = |name: &str| DeclaredAction { name: name.into(), parameters: Vec::new() };
        let declaration = Declaration {
            body: "rooms".into(),
            observation_types: vec![sensed],
            actions: ["left", "right", "stay"].map(action).into(),
            repertoire: (0..3).map(|number| (number, Vec::new())).collect(),
        };
        effects.extend(learner.declare(declaration).unwrap().1);
        let random = Random::from_seed(seed ^ 0x77);
        Self {
            learner,
            effects,
            right: false,
            changed: false,
            coin,
            episode: usize::MAX,
            random,
            wrong: Vec::new(),
        }
    }

    fn sensed(&self) -> Observation {
        Observation::new(TypeId(0), [(PropertyId(0), Value::Boolean(self.changed))])
    }

    /// What is foretold most surely.
    fn foretold(&self, action: PrimitiveId) -> Option<Vec<Observation>> {
        let content = self.learner.memory().content();
        let world = content.perceived(BodyId(0), &WorldState::new([self.sensed()]));
        let facets =
            content.evidence.foretell(&content.vocabulary, Some(BodyId(0)), action, world.observations());
        let about = facets.into_iter().find(|facet| facet.kinds == [TypeId(0)])?;
        about.outcomes.into_iter().next().map(|(after, _)| after)
    }

    /// It is led to actions at random: what it would like to do is no matter here.
    fn live(mut self, actions: usize) -> Self {
        let frame = |outcome, sensed| Frame { body: BodyId(0), outcome, observations: vec![sensed] };
        self.effects.extend(self.learner.step(&frame(None, self.sensed())).effects);
        self.effects.extend(self.learner.set_held(true));
        for number in 1..=actions {
            let action = PrimitiveId(u32::try_from(self.random.below(3)).unwrap());
            let world =
                self.learner.memory().content().perceived(BodyId(0), &WorldState::new([self.sensed()]));
            self.effects.push(common::lead(&mut self.learner, BodyId(0), action, world));
            if number % self.episode == 0 {
                (self.right, self.changed) = (false, false);
                let step = self.learner.step(&frame(Some(ActionOutcome::EpisodeCut), self.sensed()));
                self.effects.extend(step.effects);
                continue;
            }
            let foretold = self.foretold(action);
            let was = self.right;
            self.right = [false, true, was][action.0 as usize];
            self.changed = if self.coin { self.random.below(2) == 0 } else { self.right != was };
            self.wrong.push(foretold != Some(vec![self.sensed()]));
            let step = self.learner.step(&frame(Some(ActionOutcome::Done), self.sensed()));
            self.effects.extend(step.effects);
        }
        self.effects.extend(self.learner.set_held(false));
        self
    }

    /// The share of the last actions of which something else was foretold.
    fn wrong(&self, last: usize) -> f64 {
        let wrong = self.wrong.iter().rev().take(last).filter(|wrong| **wrong).count();
        wrong as f64 / last as f64
    }

    fn items(&self) -> usize {
        self.learner.memory().content().items.all.iter().filter(|item| !item.dropped).count()
    }
}

#[test]
fn what_is_hidden_is_told_once_an_item_is_supposed() {
    let without = Mechanisms { items: false, ..Mechanisms::FULL };
    for seed in 1..=5 {
        let (plain, supposing) =
            (Rooms::new(seed, without, false), Rooms::new(seed, Mechanisms::FULL, false));
        let (plain, supposing) = (plain.live(700), supposing.live(700));
        let (before, after) = (plain.wrong(300), supposing.wrong(300));
        assert!(before > 0.1 && after == 0.0, "seed {seed}: {before} wrong without items, {after} with");
        assert!((1..=4).contains(&supposing.items()), "seed {seed}: {} items", supposing.items());
    }
}

/// An item would go on as it was in the episode before, where a new one always begins in the same room.
#[test]
fn what_is_hidden_where_an_episode_begins_is_found_out_like_all_else() {
    for seed in 1..=5 {
        let rooms = Rooms { episode: 7, ..Rooms::new(seed, Mechanisms::FULL, false) }.live(900);
        assert_eq!(rooms.wrong(250), 0.0, "seed {seed}");
        let items = &rooms.learner.memory().content().items.all;
        let beginning = |item: &Item| item.updates.iter().any(|(event, _)| event.is_beginning());
        assert!(items.iter().any(beginning), "seed {seed}: {items:?}");
    }
}

/// Where nothing tells, nothing is supposed for long.
#[test]
fn a_coin_makes_no_items() {
    let items: Vec<_> =
        (1..=5).map(|seed| Rooms::new(seed, Mechanisms::FULL, true).live(700).items()).collect();
    assert!(items.iter().sum::<usize>() <= 2, "seeds 1 to 5: {items:?}");
}

#[test]
fn items_follow_from_the_effects_and_a_restored_memory_goes_on_alike() {
    let lived = Rooms::new(2, Mechanisms::FULL, false).live(200);
    assert!(lived.items() > 0);
    let mut told = Memory::new(2, Parameters::default());
    lived.effects.iter().for_each(|effect| told.apply(effect).unwrap());
    let content = lived.learner.memory().content();
    assert_eq!(digest(told.content()), digest(content));
    assert_eq!(told.content().items, content.items);
    let restored = Memory::restore(content.clone(), Parameters::default());
    let learner = Learner::resume(restored, free()).unwrap();
    let again = Rooms { learner, wrong: Vec::new(), effects: Vec::new(), random: lived.random, ..lived };
    let twin = Learner::resume(told, free()).unwrap();
    let twin = Rooms { learner: twin, wrong: Vec::new(), effects: Vec::new(), ..again_of(&again) };
    let (again, twin) = (again.live(100), twin.live(100));
    assert_eq!(digest(again.learner.memory().content()), digest(twin.learner.memory().content()));
}

/// The same rooms with the same learner.
fn again_of(rooms: &Rooms) -> Rooms {
    let Rooms { learner, right, changed, coin, episode, random, .. } = rooms;
    let (learner, effects, wrong) = (learner.clone(), Vec::new(), Vec::new());
    let (right, changed, coin, episode, random) = (*right, *changed, *coin, *episode, *random);
    Rooms { learner, effects, right, changed, coin, episode, random, wrong }
}

#[test]
fn a_dropped_item_is_perceived_no_more_and_unsound_ones_are_refused() {
    let lived = Rooms::new(2, Mechanisms::FULL, false).live(200);
    let mut memory = lived.learner.memory().clone();
    let perceived = |memory: &Memory| {
        memory.content().perceived(BodyId(0), &WorldState::new([lived.sensed()])).observations().len()
    };
    let before = perceived(&memory);
    memory.apply(&Effect::Dropped { item: 0 }).unwrap();
    assert_eq!(perceived(&memory), before - 1);
    let digest_before = digest(memory.content());
    let known = memory.content().items.all.len();
    let item = memory.content().items.all[0].clone();
    let supposed = |primitive, kinds: &[TypeId]| Effect::Supposed {
        body: BodyId(0),
        on: true,
        primitive,
        kinds: kinds.into(),
        updates: item.updates.clone(),
    };
    for unsound in [
        Effect::Dropped { item: 64 },
        Effect::Followed { body: BodyId(0), on: vec![true; known + 1] },
        Effect::Followed { body: BodyId(3), on: vec![true; known] },
        supposed(PrimitiveId(9), &item.kinds),
        supposed(item.primitive, &[TypeId(900)]),
        supposed(item.primitive, &[TypeId(0), TypeId(0)]),
    ] {
        memory.apply(&unsound).unwrap_err();
        assert_eq!(digest(memory.content()), digest_before, "{unsound:?}");
    }
}

/// Items that nobody follows any more would stand in the world of a learner that is switched back to the paper's, as they were last.
#[test]
fn without_the_mechanism_nothing_is_supposed() {
    let mut lived = Rooms::new(2, Mechanisms::FULL, false).live(200);
    assert!(lived.items() > 0);
    lived.learner.set_mechanisms(Mechanisms::PAPER);
    let content = lived.learner.memory().content();
    let world = WorldState::new([lived.sensed()]);
    assert_eq!(content.perceived(BodyId(0), &world), world);
    assert!(content.items.lines.iter().all(|line| line.recent.is_empty()));
    let frame =
        Frame { body: BodyId(0), outcome: Some(ActionOutcome::Done), observations: vec![lived.sensed()] };
    let decision = lived.learner.step(&frame).decision.unwrap();
    assert_eq!(decision.world, world);
    // And it may be supposed again.
    lived.learner.set_mechanisms(Mechanisms::FULL);
    assert_eq!(lived.live(700).wrong(300), 0.0);
}
