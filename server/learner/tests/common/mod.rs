//! A small abstract table shared by the tests: fields, postures that bring the finger to them, blocks.
#![allow(dead_code, unreachable_pub, missing_docs, clippy::unwrap_used)]

use std::sync::Arc;

use pschema_learner::curriculum::{
    Afterwards, Argument, Curriculum, Lift, NamedObservation, Pool, Saturation, SceneCommand, Stage,
};
use pschema_learner::effect::Effect;
use pschema_learner::execution::Execution;
use pschema_learner::observation::{Observation, PropertyId, Substitution, SymbolId, TypeId, Value};
use pschema_learner::parameters::Parameters;
use pschema_learner::vocabulary::{
    BodyId, Declaration, DeclaredAction, DeclaredProperty, DeclaredType, Parameter, PrimitiveId, ValueKind,
};
use pschema_learner::world_state::WorldState;
use pschema_learner::{ActionOutcome, Frame, Learner, Output, Step};

pub const FINGER: TypeId = TypeId(0);
pub const OBJECT: TypeId = TypeId(1);
pub const TOUCH: TypeId = TypeId(2);
pub const WORD: TypeId = TypeId(3);

fn property(name: &str, kind: ValueKind) -> DeclaredProperty {
    DeclaredProperty { name: name.into(), unit: String::new(), kind }
}

/// `finger{colour, field}` (own), `object{colour, field}`, `touch{}` (transient), `word{text}` (heard), and
/// `fields` postures.
pub fn declaration(fields: i64) -> Declaration {
    let seen = || vec![property("colour", ValueKind::Symbol), property("field", ValueKind::Integer)];
    let kind = |name: &str, own, transient, heard, properties| DeclaredType {
        name: name.into(),
        own,
        transient,
        heard,
        value: false,
        properties,
    };
    Declaration {
        body: "table".into(),
        observation_types: vec![
            kind("finger", true, false, false, seen()),
            kind("object", false, false, false, seen()),
            kind("touch", false, true, false, vec![]),
            kind("word", false, true, true, vec![property("text", ValueKind::Symbol)]),
        ],
        actions: vec![DeclaredAction {
            name: "move".into(),
            parameters: vec![property("posture", ValueKind::Integer)],
        }],
        repertoire: (0..fields).map(|posture| (0, vec![Parameter::Integer(posture)])).collect(),
    }
}

pub fn stage(name: &str, lift: &[&str]) -> Stage {
    Stage { lift: Lift::Types(lift.iter().map(|s| (*s).to_owned()).collect()), ..Stage::free(name) }
}

pub fn free() -> Curriculum {
    Curriculum { stages: vec![Stage::free("free play")], ..Curriculum::free("free") }
}

/// Experiment 1, scenario 1.
pub fn exp1_s1(within: i64, beyond: i64) -> Curriculum {
    let place = |pool: &str| SceneCommand {
        command: "place".into(),
        arguments: vec![("position".into(), Argument::Draw(pool.into()))],
    };
    let touch = Some(NamedObservation { kind: "touch".into(), properties: Vec::new() });
    let seen = ["finger", "object", "touch"];
    let reaching = |name: &str, pool: &str, trials, actions| Stage {
        trials,
        arrange: vec![place(pool)],
        until: touch.clone(),
        trial_actions_max: actions,
        ..stage(name, &seen)
    };
    let babbling = Stage {
        saturation: Some(Saturation { excitation_below: 1.0, actions: 5 }),
        ..stage("motor babbling", &["finger"])
    };
    Curriculum {
        name: "exp1-s1".into(),
        pools: vec![
            Pool { name: "table".into(), from: 0, to: within - 1 },
            Pool { name: "beyond".into(), from: within, to: within + beyond - 1 },
        ],
        stages: vec![
            babbling,
            reaching("first touches", "table", 2, 20),
            reaching("a new place", "table", 1, 20),
            reaching("out of reach", "beyond", 1, 1),
            Stage { learning: false, ..reaching("probe", "table", within as u32 - 3, 5) },
        ],
        afterwards: Afterwards::Hold,
    }
}

/// A table with `fields` fields, of which those below `within` can be touched. Moving to a posture brings
/// the finger to the field of that number; if a block is there, within reach, it is felt.
pub struct Table {
    pub learner: Learner,
    pub body: BodyId,
    pub within: i64,
    pub finger: Option<i64>,
    pub blocks: Vec<(u32, i64)>,
    pub touching: bool,
    pub outcome: Option<ActionOutcome>,
    pub words: Vec<&'static str>,
    pub steps: Vec<Step>,
}

pub fn finger(field: i64) -> Observation {
    seen(FINGER, 0, field)
}

pub fn object(colour: u32, field: i64) -> Observation {
    seen(OBJECT, colour, field)
}

pub fn touch() -> Observation {
    Observation::new(TOUCH, [])
}

fn seen(kind: TypeId, colour: u32, field: i64) -> Observation {
    let colour = Value::Symbol(SymbolId(colour));
    Observation::new(kind, [(PropertyId(0), colour), (PropertyId(1), Value::Integer(field))])
}

impl Table {
    pub fn new(seed: u64, fields: i64, within: i64, curriculum: Curriculum, parameters: Parameters) -> Self {
        let mut learner = Learner::new(seed, parameters, curriculum).unwrap();
        for colour in ["green", "blue", "red"] {
            learner.symbol(colour);
        }
        let (body, _) = learner.declare(declaration(fields)).unwrap();
        Self {
            learner,
            body,
            within,
            finger: None,
            blocks: Vec::new(),
            touching: false,
            outcome: None,
            words: Vec::new(),
            steps: Vec::new(),
        }
    }

    pub fn frame(&mut self) -> Frame {
        let mut observations: Vec<_> = self.finger.map(finger).into_iter().collect();
        observations.extend(self.blocks.iter().map(|(colour, field)| object(*colour, *field)));
        if self.touching {
            observations.push(touch());
        }
        for word in std::mem::take(&mut self.words) {
            let (symbol, _) = self.learner.symbol(word);
            let text = self.learner.memory().content().vocabulary.property_named("text").unwrap();
            observations.push(Observation::new(WORD, [(text, Value::Symbol(symbol))]));
        }
        Frame { body: self.body, outcome: self.outcome.take(), observations }
    }

    /// Senses, steps the learner and does what it says. False when it says to wait.
    pub fn step(&mut self) -> bool {
        let frame = self.frame();
        let step = self.learner.step(&frame);
        let output = step.output.clone();
        self.steps.push(step);
        self.follow(output)
    }

    /// Does what the learner says. False when it says to wait.
    pub fn follow(&mut self, output: Output) -> bool {
        match output {
            Output::Hold => return false,
            Output::Arrange(commands) => {
                self.finger = None;
                self.touching = false;
                for command in commands {
                    if let [(_, Argument::Integer(field))] = command.arguments[..] {
                        self.blocks = vec![(1, field)];
                    }
                }
            }
            Output::Act(primitive) => {
                let vocabulary = &self.learner.memory().content().vocabulary;
                let Parameter::Integer(field) = vocabulary.primitives()[primitive.0 as usize].parameters[0]
                else {
                    panic!("a posture is an integer")
                };
                self.finger = Some(field);
                self.touching = field < self.within && self.blocks.iter().any(|(_, at)| *at == field);
            }
        }
        self.outcome = Some(ActionOutcome::Done);
        true
    }
}

/// Has a learner that is held carry `action` out in `world`, as if it had chosen that there. Returns the effect.
pub fn lead(learner: &mut Learner, body: BodyId, action: PrimitiveId, world: WorldState) -> Effect {
    let pending = Execution {
        schema: None,
        binding: Substitution::new(),
        carrier: None,
        action,
        before: world,
        chain: Vec::new(),
        for_goal: false,
    };
    let random = learner.memory().content().random.state();
    let led = Effect::StepEnded { body, random, pending: Some(Arc::new(pending)) };
    let curriculum = learner.curriculum().clone();
    let nobody = Learner::new(0, Parameters::default(), curriculum.clone()).unwrap();
    let mut memory = std::mem::replace(learner, nobody).into_memory();
    memory.apply(&led).unwrap();
    *learner = Learner::resume(memory, curriculum).unwrap();
    led
}
