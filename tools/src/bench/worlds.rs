//! Small worlds that a learner can live in without a body, a camera or physics: what is measured in them is the learner
//! alone. Each grows memory in another way.

use pschema_learner::curriculum::{Afterwards, Curriculum, Lift, Stage};
use pschema_learner::observation::{Observation, PropertyId, SymbolId, TypeId, Value};
use pschema_learner::parameters::Parameters;
use pschema_learner::random::Random;
use pschema_learner::step::{ActionOutcome, Frame, Learner, LearnerError, Output};
use pschema_learner::vocabulary::{
    BodyId, Declaration, DeclaredAction, DeclaredProperty, DeclaredType, Parameter, ValueKind,
};

/// The learner's observation types, as they are declared.
const FINGER: TypeId = TypeId(0);
const OBJECT: TypeId = TypeId(1);
const TOUCH: TypeId = TypeId(2);
/// Colours that objects have.
const COLOURS: u32 = 8;

/// What memory is filled with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mix {
    /// As in scenario 1: postures, touches, and then a block in ever new places beyond reach: each a context of its own.
    Scenario1,
    /// As in scenario 3: every posture tried with the block in every field.
    Scenario3,
    /// Twelve objects at a time, of eight colours; the one that is touched rolls on.
    Wide,
}

impl Mix {
    /// All of them.
    pub(crate) const ALL: [Self; 3] = [Self::Scenario1, Self::Scenario3, Self::Wide];

    /// Its name in tables.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Scenario1 => "scenario-1",
            Self::Scenario3 => "scenario-3",
            Self::Wide => "wide",
        }
    }

    /// Postures of the arm.
    fn postures(self) -> i64 {
        match self {
            Self::Scenario1 | Self::Wide => 228,
            Self::Scenario3 => 1_010,
        }
    }

    /// Objects on the table.
    fn objects(self) -> u32 {
        match self {
            Self::Scenario1 | Self::Scenario3 => 1,
            Self::Wide => 12,
        }
    }
}

/// A learner in a world.
pub(crate) struct World {
    mix: Mix,
    learner: Learner,
    body: BodyId,
    random: Random,
    finger: Option<i64>,
    /// Colour and field.
    objects: Vec<(u32, i64)>,
    touched: Option<usize>,
    outcome: Option<ActionOutcome>,
    /// Actions since the objects were last put elsewhere.
    since: i64,
    /// The next place that nothing was ever put in.
    next: i64,
    /// Places to be learnt within reach before that.
    within_reach: u32,
    /// Actions before there is anything on the table: the arm is learnt first.
    alone: i64,
}

impl World {
    /// A learner that knows nothing, in a world that `seed` decides.
    pub(crate) fn new(mix: Mix, seed: u64) -> Result<Self, LearnerError> {
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
        let curriculum = Curriculum {
            name: mix.name().into(),
            pools: Vec::new(),
            stages: vec![stage],
            afterwards: Afterwards::Continue,
        };
        let mut learner = Learner::new(seed, Parameters::default(), curriculum)?;
        for colour in 0..COLOURS {
            learner.symbol(&format!("colour {colour}"));
        }
        // What is declared here is within every limit.
        let body = learner.declare(declaration(mix.postures())).map_or(BodyId(u16::MAX), |(body, _)| body);
        let objects = (0..).zip(0..mix.objects()).map(|(at, number)| (number % COLOURS, at * 7)).collect();
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
            next: mix.postures(),
            within_reach: 30,
            alone: mix.postures() * 5 / 4,
        })
    }

    /// The learner.
    pub(crate) fn learner(&self) -> &Learner {
        &self.learner
    }

    /// The learner, for a step.
    pub(crate) fn learner_mut(&mut self) -> &mut Learner {
        &mut self.learner
    }

    /// What is perceived now.
    pub(crate) fn frame(&mut self) -> Frame {
        let seen = |kind, colour, field| {
            let colour = Value::Symbol(SymbolId(colour));
            Observation::new(kind, [(PropertyId(0), colour), (PropertyId(1), Value::Integer(field))])
        };
        let mut observations: Vec<_> = self.finger.map(|field| seen(FINGER, 0, field)).into_iter().collect();
        let objects = self.objects.iter().filter(|_| self.alone == 0);
        observations.extend(objects.map(|(colour, field)| seen(OBJECT, *colour, *field)));
        observations.extend(self.touched.map(|_| Observation::new(TOUCH, [])));
        Frame { body: self.body, outcome: self.outcome.take(), observations }
    }

    /// Does what the learner says, and lets the world go on.
    pub(crate) fn follow(&mut self, output: &Output) {
        if let Some(at) = self.touched.take()
            && self.mix == Mix::Wide
        {
            // What is touched rolls on.
            if let Some((_, field)) = self.objects.get_mut(at) {
                *field = (*field + 1) % (self.mix.postures() * 2);
            }
        }
        let Output::Act(primitive) = output else {
            return;
        };
        self.outcome = Some(ActionOutcome::Done);
        let vocabulary = &self.learner.memory().content().vocabulary;
        let parameters = vocabulary.primitives().get(primitive.0 as usize).map(|known| &known.parameters[..]);
        let Some([Parameter::Integer(field)]) = parameters else {
            return;
        };
        self.finger = Some(*field);
        if self.alone > 0 {
            self.alone -= 1;
            return;
        }
        self.touched = self.objects.iter().position(|(_, at)| at == field);
        self.since += 1;
        self.elsewhere();
    }

    /// Puts objects elsewhere when it is time. That is no action's doing, and nothing is learnt from it: what the next
    /// frame says of the last action is that nothing was asked.
    fn elsewhere(&mut self) {
        let postures = self.mix.postures();
        let since = match self.mix {
            Mix::Scenario1 if self.within_reach > 0 && self.touched.is_some() => 1,
            Mix::Scenario1 if self.within_reach > 0 => 20,
            Mix::Scenario1 => 2,
            Mix::Scenario3 => postures,
            Mix::Wide => 20,
        };
        if self.since < since {
            return;
        }
        let mut draw =
            |of: i64| i64::try_from(self.random.below(usize::try_from(of).unwrap_or(1))).unwrap_or(0);
        match self.mix {
            Mix::Scenario1 if self.within_reach > 0 => {
                self.within_reach -= 1;
                self.objects = vec![(1, draw(postures))];
            }
            Mix::Scenario1 => {
                self.next += 1;
                self.objects = vec![(1, self.next)];
            }
            Mix::Scenario3 => self.objects = vec![(1, draw(postures))],
            Mix::Wide => {
                let (field, colour) = (draw(postures * 2), draw(i64::from(COLOURS)));
                let at = self.random.below(self.objects.len());
                self.objects[at] = (u32::try_from(colour).unwrap_or(0), field);
            }
        }
        self.since = 0;
        self.touched = None;
        self.outcome = None;
    }
}

fn declaration(postures: i64) -> Declaration {
    let property = |name: &str, kind| DeclaredProperty { name: name.into(), unit: String::new(), kind };
    let seen = || vec![property("colour", ValueKind::Symbol), property("field", ValueKind::Integer)];
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
        ],
        actions: vec![DeclaredAction {
            name: "move".into(),
            parameters: vec![property("posture", ValueKind::Integer)],
        }],
        repertoire: (0..postures).map(|posture| (0, vec![Parameter::Integer(posture)])).collect(),
    }
}
