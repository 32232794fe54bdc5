//! The learner with claims, beside the learner of the paper, where nothing is staged and much of what is seen does not matter.

// A test may stop at what cannot be; every number here is small.
#![allow(clippy::unwrap_used)]

mod common;

use common::{FINGER, OBJECT, TOUCH, declaration, free};
use pschema_learner::digest::digest;
use pschema_learner::effect::Effect;
use pschema_learner::evidence::Evidence;
use pschema_learner::mechanisms::Mechanisms;
use pschema_learner::memory::Memory;
use pschema_learner::observation::{Observation, Pattern, PropertyId, SymbolId, Value};
use pschema_learner::parameters::Parameters;
use pschema_learner::random::Random;
use pschema_learner::vocabulary::{BodyId, PrimitiveId};
use pschema_learner::{ActionOutcome, Frame, Learner, Output};

const FIELDS: i64 = 16;
const COLOUR: PropertyId = PropertyId(0);
const FIELD: PropertyId = PropertyId(1);
const GREEN: usize = 0;
const BLUE: usize = 1;
const RED: usize = 2;

/// A table with one object at a time, and things that do not matter.
#[derive(Clone, Copy, Default)]
struct Table {
    /// Things that can't be reached: each is there or not, at random.
    bystanders: i64,
    /// Whether only blue objects are felt.
    only_blue: bool,
    /// The share of touches that are not felt.
    lost: f64,
}

/// A learner at a table, and what it did there.
struct Life {
    learner: Learner,
    effects: Vec<Effect>,
    colours: Vec<SymbolId>,
    finger: Option<i64>,
    random: Random,
    table: Table,
}

impl Life {
    fn new(seed: u64, mechanisms: Mechanisms, table: Table) -> Self {
        let mut learner = Learner::new(seed, Parameters::default(), free()).unwrap();
        let mut effects = learner.set_mechanisms(mechanisms);
        effects.extend(learner.declare(declaration(FIELDS)).unwrap().1);
        let mut colours = Vec::new();
        for name in ["green", "blue", "red"] {
            let (id, met) = learner.symbol(name);
            effects.extend(met);
            colours.push(id);
        }
        Self { learner, effects, colours, finger: None, random: Random::from_seed(seed ^ 0xA5), table }
    }

    fn seen(&self, kind: pschema_learner::observation::TypeId, colour: usize, field: i64) -> Observation {
        let colour = Value::Symbol(self.colours[colour]);
        Observation::new(kind, [(COLOUR, colour), (FIELD, Value::Integer(field))])
    }

    fn chance(&mut self, share: f64) -> bool {
        (self.random.below(1_000_000) as f64) < share * 1e6
    }

    fn frame(&mut self, object: (usize, i64), touched: bool, outcome: Option<ActionOutcome>) -> Frame {
        let mut observations: Vec<_> =
            self.finger.map(|field| self.seen(FINGER, GREEN, field)).into_iter().collect();
        observations.push(self.seen(OBJECT, object.0, object.1));
        for number in 0..self.table.bystanders {
            if self.chance(0.5) {
                observations.push(self.seen(OBJECT, GREEN, FIELDS + number));
            }
        }
        observations.extend(touched.then(|| Observation::new(TOUCH, [])));
        Frame { body: BodyId(0), outcome, observations }
    }

    /// The object is put somewhere, until it is felt or `actions` have been made; how many were made.
    fn place(&mut self, object: (usize, i64), actions: usize) -> usize {
        let (mut touched, mut outcome) = (false, None);
        for made in 0..=actions {
            let frame = self.frame(object, touched, outcome);
            let step = self.learner.step(&frame);
            self.effects.extend(step.effects);
            let Output::Act(action) = step.output else { panic!("nothing was chosen") };
            if touched || made == actions {
                return made;
            }
            self.finger = Some(i64::from(action.0));
            let felt = (!self.table.only_blue || object.0 == BLUE) && !self.chance(self.table.lost);
            touched = self.finger == Some(object.1) && felt;
            outcome = Some(ActionOutcome::Done);
        }
        actions
    }

    fn somewhere(&mut self) -> i64 {
        i64::try_from(self.random.below(usize::try_from(FIELDS).unwrap())).unwrap()
    }

    fn live(mut self, places: usize) -> Self {
        for _ in 0..places {
            let colour = if self.table.only_blue && self.random.below(2) == 0 { RED } else { BLUE };
            let object = (colour, self.somewhere());
            self.place(object, 60);
        }
        self
    }

    /// Of so many places, the share in which a copy touches the object with its first action.
    fn first_try(&mut self, places: usize) -> f64 {
        let touched = (0..places).filter(|_| {
            let object = (BLUE, self.somewhere());
            let frame = self.frame(object, false, None);
            let output = self.learner.clone().step(&frame).output;
            output == Output::Act(PrimitiveId(u32::try_from(object.1).unwrap()))
        });
        touched.count() as f64 / places as f64
    }

    /// The probability of a touch that is foretold for reaching to `field`, with an object of that colour there.
    fn foretold(&self, colour: usize, field: i64) -> f64 {
        let content = self.learner.memory().content();
        let context = [self.seen(OBJECT, colour, field)];
        let action = PrimitiveId(u32::try_from(field).unwrap());
        let facets = content.evidence.foretell(&content.vocabulary, Some(BodyId(0)), action, &context);
        let touch = facets.iter().find(|facet| facet.kinds.contains(&TOUCH)).unwrap();
        let felt = touch.outcomes.iter().filter(|(after, _)| after.iter().any(|o| o.kind() == TOUCH));
        f64::from(felt.map(|(_, count)| count).sum::<u32>()) / f64::from(touch.trials)
    }

    fn schemas(&self) -> usize {
        self.learner.memory().content().schemas.len()
    }

    fn laws(&self) -> u32 {
        self.learner.memory().content().generalised_count
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// The paper's scenario 3 in small: 625 schemas and no law was what the learner of the paper made of it. A schema for each posture,
/// and the law, are enough.
#[test]
fn without_stages_a_schema_for_each_posture_and_a_law_are_enough() {
    let lives = |mechanisms| -> Vec<Life> {
        (1..=5).map(|seed| Life::new(seed, mechanisms, Table::default()).live(20)).collect()
    };
    let (mut full, paper) = (lives(Mechanisms::FULL), lives(Mechanisms::PAPER));
    for (life, seed) in full.iter().zip(1..) {
        assert!(life.laws() >= 1, "seed {seed}: no law");
        assert!(life.schemas() <= 30, "seed {seed}: {} schemas", life.schemas());
        // One experience makes one law, whichever claims tell of its target.
        for law in life.learner.memory().content().schemas.iter().filter_map(|schema| schema.generalised()) {
            let told = |wanted: &Pattern| law.post.iter().any(|post| !post.absent && post.what == *wanted);
            assert!(
                law.target.iter().all(told),
                "seed {seed}: a law does not say that its target comes about"
            );
        }
    }
    let schemas = |lives: &[Life]| median(lives.iter().map(|life| life.schemas() as f64).collect());
    assert!(schemas(&full) * 4.0 < schemas(&paper), "{} and {}", schemas(&full), schemas(&paper));
    let touched = median(full.iter_mut().map(|life| life.first_try(40)).collect());
    assert!(touched >= 0.9, "touched at the first try: {touched}");
}

/// "Things in view that don't matter": each state of them used to be a new context, with schemas of its own.
#[test]
fn things_that_do_not_matter_cost_no_schemas() {
    let schemas = |bystanders| {
        let table = Table { bystanders, ..Table::default() };
        let lives = (1..=5).map(|seed| Life::new(seed, Mechanisms::FULL, table).live(20));
        let mut lives: Vec<_> = lives.collect();
        let touched = median(lives.iter_mut().map(|life| life.first_try(40)).collect());
        assert!(touched >= 0.85, "{bystanders} bystanders: touched at the first try {touched}");
        median(lives.iter().map(|life| life.schemas() as f64).collect())
    };
    let (none, six) = (schemas(0), schemas(6));
    assert!(six <= 1.5 * none, "{none} schemas without bystanders, {six} with six");
}

#[test]
fn a_law_holds_for_the_kind_that_it_holds_for() {
    let table = Table { only_blue: true, ..Table::default() };
    for seed in 1..=3 {
        let life = Life::new(seed, Mechanisms::FULL, table).live(40);
        let mean =
            |colour| (0..FIELDS).map(|field| life.foretold(colour, field)).sum::<f64>() / FIELDS as f64;
        let (blue, red) = (mean(BLUE), mean(RED));
        assert!(blue >= 0.9, "seed {seed}: a touch of what is blue is foretold with {blue}");
        assert!(red <= 0.1, "seed {seed}: a touch of what is red is foretold with {red}");
    }
}

/// One unlucky spell took the law out of use for life.
#[test]
fn touches_that_are_lost_do_not_lose_the_law() {
    let table = Table { lost: 0.2, ..Table::default() };
    let mut first = Vec::new();
    for seed in 1..=5 {
        let mut life = Life::new(seed, Mechanisms::FULL, table).live(30);
        let touch = (0..FIELDS).map(|field| life.foretold(BLUE, field)).sum::<f64>() / FIELDS as f64;
        assert!(
            (0.6..=0.95).contains(&touch),
            "seed {seed}: a touch is foretold with {touch}, and .8 is true"
        );
        first.push(life.first_try(40));
    }
    let touched = median(first);
    assert!(touched >= 0.8, "touched at the first try {touched}");
}

/// Effects alone make the same memory, and the experiences that evidence keeps, with what was found of them, the same evidence.
#[test]
fn claims_follow_from_the_effects_and_evidence_from_what_it_keeps() {
    let table = Table { bystanders: 2, lost: 0.1, ..Table::default() };
    for seed in 1..=3 {
        let life = Life::new(seed, Mechanisms::FULL, table).live(12);
        let lived = life.learner.memory().content();
        let mut replayed = Memory::new(seed, Parameters::default());
        for effect in &life.effects {
            replayed.apply(effect).unwrap();
        }
        assert_eq!(digest(replayed.content()), digest(lived), "seed {seed}");
        assert_eq!(replayed.content().evidence, lived.evidence, "seed {seed}");
        let mut back = Evidence::default();
        for (pool, found) in lived.evidence.found() {
            let experiences = lived.evidence.kept().filter(|(of, _)| *of == pool);
            back.restore(
                &lived.vocabulary,
                pool,
                experiences.map(|(_, experience)| experience.clone()).collect(),
                found,
            );
        }
        for (body, recalled) in lived.evidence.recollections() {
            back.recall(body, recalled.clone());
        }
        assert_eq!(back, lived.evidence, "seed {seed}");
    }
}

/// Switched off, claims change nothing; switched off again, they are kept and not asked.
#[test]
fn the_learner_of_the_paper_keeps_no_evidence() {
    let paper = Life::new(7, Mechanisms::PAPER, Table::default()).live(5);
    assert!(paper.learner.memory().content().evidence.is_empty());
    let mut life = Life::new(7, Mechanisms::FULL, Table::default()).live(5);
    let kept = life.learner.memory().content().evidence.kept().count();
    assert!(kept > 0);
    assert_eq!(life.learner.set_mechanisms(Mechanisms::PAPER).len(), 1);
    assert!(life.learner.set_mechanisms(Mechanisms::PAPER).is_empty());
    let life = life.live(5);
    assert_eq!(life.learner.memory().content().evidence.kept().count(), kept);
}
