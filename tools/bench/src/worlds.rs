//! Small worlds that a learner can live in without a body, a camera or physics: what is measured in them is the learner
//! alone. Each grows memory in another way.

use pschema_learner::curriculum::{Afterwards, Curriculum, Lift, Stage};
use pschema_learner::observation::{Observation, PropertyId, TypeId, Value};
use pschema_learner::parameters::Parameters;
use pschema_learner::random::Random;
use pschema_learner::vocabulary::{
    BodyId, Declaration, DeclaredAction, DeclaredProperty, DeclaredType, Parameter, ValueKind,
};
use pschema_learner::{ActionOutcome, Frame, Learner, LearnerError, Output};

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
#[derive(Clone, Copy)]
struct Object {
    kind: i64,
    field: i64,
}

/// A learner in a world.
pub struct World {
    mix: Mix,
    learner: Learner,
    body: BodyId,
    random: Random,
    finger: Option<i64>,
    objects: Vec<Object>,
    /// The object that was touched by the last action.
    touched: Option<usize>,
    outcome: Option<ActionOutcome>,
    /// Actions since the last placement.
    since: i64,
    /// Placements so far.
    placements: i64,
    /// Whether the arm is still learnt, before there is anything on the table.
    alone: bool,
}

impl World {
    /// A learner that knows nothing, in a world that `seed` decides.
    ///
    /// # Errors
    /// Never, as long as the curriculum and the declaration here are within the learner's limits.
    pub fn new(mix: Mix, seed: u64) -> Result<Self, LearnerError> {
        let mut learner = Learner::new(seed, Parameters::default(), curriculum(mix))?;
        // What is declared here is within every limit.
        let body = learner.declare(declaration(mix.postures())).map_or(BodyId(u16::MAX), |(body, _)| body);
        let objects = match mix {
            Mix::Scenario1 | Mix::Scenario3 => vec![Object { kind: 0, field: 0 }],
            Mix::Wide => (0..CROWD).map(|kind| Object { kind, field: kind * 7 }).collect(),
        };
        Ok(Self {
            mix,
            learner,
            body,
            random: Random::from_seed(seed),
            finger: None,
            objects,
            touched: None,
            outcome: None,
            since: 0,
            placements: 0,
            alone: mix != Mix::Scenario3,
        })
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
        let seen = |of, kind, field| {
            Observation::new(of, [(KIND, Value::Integer(kind)), (FIELD, Value::Integer(field))])
        };
        // The end effector is of a kind that nothing else is of.
        let mut observations: Vec<_> = self.finger.map(|field| seen(FINGER, -1, field)).into_iter().collect();
        if !self.alone {
            observations.extend(self.objects.iter().map(|object| seen(OBJECT, object.kind, object.field)));
        }
        if let Some(object) = self.touched.and_then(|at| self.objects.get(at)) {
            observations.push(Observation::new(TOUCH, []));
            if self.mix != Mix::Scenario3 && object.kind >= SMOOTH {
                let texture = Value::Integer(object.kind % TEXTURES);
                observations.push(Observation::new(FEEL, [(TEXTURE, texture)]));
            }
        }
        Frame { body: self.body, outcome: self.outcome.take(), observations }
    }

    /// Schemas that the learner has.
    #[must_use]
    pub fn schemas(&self) -> usize {
        self.learner.memory().content().schemas.len()
    }

    /// Does what the learner says, and lets the world go on.
    pub fn follow(&mut self, output: &Output) {
        self.touched = None;
        let Output::Act(primitive) = output else {
            return;
        };
        self.outcome = Some(ActionOutcome::Done);
        let vocabulary = &self.learner.memory().content().vocabulary;
        let parameters = vocabulary.primitives().get(primitive.0 as usize).map(|known| &known.parameters[..]);
        let Some([Parameter::Integer(field)]) = parameters else {
            return;
        };
        let field = *field;
        self.finger = Some(field);
        if self.alone {
            let schemas = self.learner.memory().content().schemas.len();
            self.alone = i64::try_from(schemas).unwrap_or(i64::MAX) < self.mix.postures();
            if !self.alone {
                // The table is laid by others: no action's doing either.
                self.outcome = None;
            }
            return;
        }
        self.touched = self.objects.iter().position(|object| object.field == field);
        self.since += 1;
        if self.since >= self.mix.actions() {
            self.place();
        }
    }

    /// Puts an object elsewhere. That is no action's doing, and nothing is learnt from it: what the next frame says of the last
    /// action is that nothing was asked.
    fn place(&mut self) {
        self.since = 0;
        self.placements += 1;
        let postures = self.mix.postures();
        let mut draw =
            |of: i64| i64::try_from(self.random.below(usize::try_from(of).unwrap_or(1))).unwrap_or(0);
        match self.mix {
            Mix::Scenario1 => {
                self.objects = vec![Object { kind: self.placements, field: draw(postures) }];
            }
            // All fields, one after another in no order that a learner could make use of; then again with another block.
            Mix::Scenario3 => {
                let (kind, at) = (self.placements / postures, self.placements % postures);
                self.objects = vec![Object { kind, field: at * 389 % postures }];
            }
            Mix::Wide => {
                let (field, at) = (draw(postures), self.random.below(self.objects.len()));
                if self.objects.iter().all(|object| object.field != field) {
                    self.objects[at] = Object { kind: CROWD + self.placements, field };
                }
            }
        }
        self.touched = None;
        self.outcome = None;
    }
}

/// Free play with all senses.
fn curriculum(mix: Mix) -> Curriculum {
    let stage = Stage {
        name: "free play".into(),
        lift: Lift::All,
        learning: true,
        trials: 0,
        arrange: Vec::new(),
        until: None,
        trial_actions_max: 0,
        saturation: None,
        habituation: None,
        until_absent: None,
        say: Vec::new(),
    };
    Curriculum {
        name: mix.name().into(),
        pools: Vec::new(),
        stages: vec![stage],
        afterwards: Afterwards::Continue,
    }
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
