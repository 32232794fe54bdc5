//! Small worlds that a learner can live in without a body, a camera or physics: what is measured in them is the learner
//! alone. Each grows memory in another way.
#![forbid(unsafe_code)]

use pschema_learner::curriculum::{Curriculum, Stage};
use pschema_learner::observation::{Observation, PropertyId, TypeId, Value};
use pschema_learner::parameters::Parameters;
use pschema_learner::random::Random;
use pschema_learner::vocabulary::{
    BodyId, Declaration, DeclaredAction, DeclaredProperty, DeclaredType, Parameter, ValueKind,
};
use pschema_learner::{ActionOutcome, Frame, Learner, LearnerError, Output};
use serde::{Deserialize, Serialize};

/// The learner's observation types, as they are declared.
const FINGER: TypeId = TypeId(0);
const OBJECT: TypeId = TypeId(1);
const TOUCH: TypeId = TypeId(2);
const FEEL: TypeId = TypeId(3);
/// Properties, in the order in which they are declared.
const KIND: PropertyId = PropertyId(0);
const FIELD: PropertyId = PropertyId(1);
const TEXTURE: PropertyId = PropertyId(2);
/// Postures of the arm, each of which brings the finger to a field of its own.
const POSTURES: i64 = 228;
/// The same in the scenario without stages: with as many places of the block they are a million pairs.
const POSTURES_UNSTAGED: i64 = 1_010;
/// Objects that are smooth, until there is a law of touching.
const SMOOTH: i64 = 32;
/// What objects can feel like besides.
const TEXTURES: i64 = 16;
/// Objects at a time in the wide world.
const CROWD: i64 = 12;

/// What memory is filled with. In each the learner makes every schema itself, from frames alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Mix {
    /// As in scenario 1: the arm is learnt first; then comes one new object after another, each put somewhere within reach. The
    /// first of them make the law of touching; what each later one feels like besides is remembered of that one alone.
    #[value(name = "scenario-1")]
    Scenario1,
    /// As in scenario 3, without stages: every posture is tried with the block in every field.
    #[value(name = "scenario-3")]
    Scenario3,
    /// The same with twelve objects at a time, so that the law has twelve conditions, and every schema that is made too.
    Wide,
}

impl Mix {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Scenario1, Self::Scenario3, Self::Wide];

    /// Its name in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Scenario1 => "scenario-1",
            Self::Scenario3 => "scenario-3",
            Self::Wide => "wide",
        }
    }

    /// Postures of the arm.
    fn postures(self) -> i64 {
        match self {
            Self::Scenario1 | Self::Wide => POSTURES,
            Self::Scenario3 => POSTURES_UNSTAGED,
        }
    }

    /// Actions between two placements.
    fn actions(self) -> i64 {
        match self {
            Self::Scenario1 => 2,
            Self::Scenario3 => POSTURES_UNSTAGED,
            Self::Wide => 3,
        }
    }
}

/// An object on the table.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Object {
    kind: i64,
    field: i64,
}

/// Everything in a world but the learner. A learner that is found again on disk goes on in it as if nothing had been.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Surroundings {
    /// The state of the generator that decides where objects are put.
    random: u64,
    finger: Option<i64>,
    objects: Vec<Object>,
    /// The object that was touched by the last action.
    touched: Option<usize>,
    /// Whether the last action was carried out, and the learner is still to be told so.
    acted: bool,
    /// Actions since the last placement.
    since: i64,
    /// Placements so far.
    placements: i64,
    /// Whether the arm is still learnt, before there is anything on the table.
    alone: bool,
}

/// A learner in a world.
pub struct World {
    mix: Mix,
    learner: Learner,
    surroundings: Surroundings,
}

/// The only body in these worlds.
const BODY: BodyId = BodyId(0);

impl World {
    /// A learner that knows nothing, in a world that `seed` decides.
    ///
    /// # Errors
    /// Never, as long as the curriculum here is within the learner's limits.
    ///
    /// # Panics
    /// Never, as long as the declaration here is within the learner's limits.
    pub fn new(mix: Mix, seed: u64) -> Result<Self, LearnerError> {
        let mut learner = Learner::new(seed, Parameters::default(), curriculum(mix))?;
        let declared = learner.declare(declaration(mix.postures()));
        assert_eq!(declared.map(|(body, _)| body), Ok(BODY), "the learner takes the first body");
        let objects = match mix {
            Mix::Scenario1 | Mix::Scenario3 => vec![Object { kind: 0, field: 0 }],
            Mix::Wide => (0..CROWD).map(|kind| Object { kind, field: kind * 7 }).collect(),
        };
        let surroundings = Surroundings {
            random: seed,
            finger: None,
            objects,
            touched: None,
            acted: false,
            since: 0,
            placements: 0,
            alone: mix != Mix::Scenario3,
        };
        Ok(Self { mix, learner, surroundings })
    }

    /// A learner that has lived in a world of this mix, and the surroundings that it had there.
    #[must_use]
    pub fn resume(mix: Mix, learner: Learner, surroundings: Surroundings) -> Self {
        Self { mix, learner, surroundings }
    }

    /// Everything but the learner, to be kept beside its memory.
    #[must_use]
    pub fn surroundings(&self) -> &Surroundings {
        &self.surroundings
    }

    /// The learner.
    #[must_use]
    pub fn learner(&self) -> &Learner {
        &self.learner
    }

    /// The learner, for a step.
    pub fn learner_mut(&mut self) -> &mut Learner {
        &mut self.learner
    }

    /// What is perceived now.
    pub fn frame(&mut self) -> Frame {
        let Surroundings { finger, objects, touched, acted, alone, .. } = &mut self.surroundings;
        let at = |of, kind, field| {
            Observation::new(of, [(KIND, Value::Integer(kind)), (FIELD, Value::Integer(field))])
        };
        // The end effector is of a kind that nothing else is of.
        let mut observations: Vec<_> = finger.map(|field| at(FINGER, -1, field)).into_iter().collect();
        if !*alone {
            observations.extend(objects.iter().map(|object| at(OBJECT, object.kind, object.field)));
        }
        if let Some(object) = touched.and_then(|number| objects.get(number)) {
            observations.push(Observation::new(TOUCH, []));
            if self.mix != Mix::Scenario3 && object.kind >= SMOOTH {
                let texture = Value::Integer(object.kind % TEXTURES);
                observations.push(Observation::new(FEEL, [(TEXTURE, texture)]));
            }
        }
        let outcome = std::mem::take(acted).then_some(ActionOutcome::Done);
        Frame { body: BODY, outcome, observations }
    }

    /// Schemas that the learner has.
    #[must_use]
    pub fn schemas(&self) -> usize {
        self.learner.memory().content().schemas.len()
    }

    /// Does what the learner says, and lets the world go on.
    pub fn follow(&mut self, output: &Output) {
        let schemas = i64::try_from(self.schemas()).unwrap_or(i64::MAX);
        let around = &mut self.surroundings;
        around.touched = None;
        let Output::Act(primitive) = output else {
            return;
        };
        around.acted = true;
        let vocabulary = &self.learner.memory().content().vocabulary;
        let parameters = vocabulary.primitives().get(primitive.0 as usize).map(|known| &known.parameters[..]);
        let Some([Parameter::Integer(field)]) = parameters else {
            return;
        };
        around.finger = Some(*field);
        if around.alone {
            around.alone = schemas < self.mix.postures();
            // The table is laid by others, and no action brings that about.
            around.acted = around.alone;
            return;
        }
        around.touched = around.objects.iter().position(|object| object.field == *field);
        around.since += 1;
        if around.since >= self.mix.actions() {
            around.place(self.mix);
        }
    }
}

impl Surroundings {
    /// Puts an object elsewhere. No action brings that about, and nothing is learnt from it: the next frame says that nothing was
    /// asked of the body.
    fn place(&mut self, mix: Mix) {
        self.since = 0;
        self.placements += 1;
        let postures = mix.postures();
        let mut random = Random::from_seed(self.random);
        let mut draw = |of: i64| i64::try_from(random.below(usize::try_from(of).unwrap_or(1))).unwrap_or(0);
        match mix {
            Mix::Scenario1 => {
                self.objects = vec![Object { kind: self.placements, field: draw(postures) }];
            }
            // All fields, one after another in no order that a learner could make use of; then again with another block.
            Mix::Scenario3 => {
                let (kind, at) = (self.placements / postures, self.placements % postures);
                self.objects = vec![Object { kind, field: at * 389 % postures }];
            }
            Mix::Wide => {
                let (field, at) = (draw(postures), random.below(self.objects.len()));
                if self.objects.iter().all(|object| object.field != field) {
                    self.objects[at] = Object { kind: CROWD + self.placements, field };
                }
            }
        }
        self.random = random.state();
        self.touched = None;
        self.acted = false;
    }
}

/// Free play with all senses: the curriculum of every life here.
#[must_use]
pub fn curriculum(mix: Mix) -> Curriculum {
    Curriculum { stages: vec![Stage::free("free play")], ..Curriculum::free(mix.name()) }
}

fn declaration(postures: i64) -> Declaration {
    let property =
        |name: &str| DeclaredProperty { name: name.into(), unit: String::new(), kind: ValueKind::Integer };
    let seen = || vec![property("kind"), property("field")];
    let kind = |name: &str, own, transient, properties| DeclaredType {
        name: name.into(),
        own,
        transient,
        heard: false,
        value: false,
        properties,
    };
    Declaration {
        body: "table".into(),
        observation_types: vec![
            kind("finger", true, false, seen()),
            kind("object", false, false, seen()),
            kind("touch", false, true, Vec::new()),
            kind("feel", false, true, vec![property("texture")]),
        ],
        actions: vec![DeclaredAction { name: "move".into(), parameters: vec![property("posture")] }],
        repertoire: (0..postures).map(|posture| (0, vec![Parameter::Integer(posture)])).collect(),
    }
}
