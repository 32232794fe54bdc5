//! A body small enough to reason about: a finger over a row of fields, and a block that can be put into one.
#![allow(dead_code, reason = "each test file uses a part of it")]

pub(crate) mod process;

use pschema_learner::curriculum::{
    Afterwards, Argument, Curriculum, Habituation, Lift, NamedObservation, Pool, Saturation, SceneCommand,
    Stage,
};
use pschema_learner::parameters::Parameters;
use pschema_protocol::body::{Body, Outcome, Senses};
use pschema_protocol::description::{
    Action, ActionType, Description, ObservationType, Property, Value, ValueKind,
};
use pschema_server::Setup;

pub(crate) const FINGER: u16 = 0;
pub(crate) const OBJECT: u16 = 1;
pub(crate) const TOUCH: u16 = 2;
pub(crate) const FIELDS: i64 = 8;

/// A finger that can be moved to any of [`FIELDS`] fields, and sees itself and a block there.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    name: String,
    fields: i64,
    finger: Option<i64>,
    block: Option<(u32, i64)>,
    moved: bool,
}

impl Row {
    pub(crate) fn new(name: &str) -> Self {
        Self { name: name.to_owned(), fields: FIELDS, finger: None, block: None, moved: false }
    }

    /// With the block in `field` from the beginning.
    pub(crate) fn with_block(name: &str, field: i64) -> Self {
        Self { block: Some((1, field)), ..Self::new(name) }
    }
}

fn property(name: &str, kind: ValueKind) -> Property {
    Property { name: name.to_owned(), kind, unit: String::new() }
}

fn symbols(names: &[&str]) -> ValueKind {
    ValueKind::Symbol { symbols: names.iter().map(|name| (*name).to_owned()).collect() }
}

impl Body for Row {
    fn describe(&self) -> Description {
        let field = || property("field", ValueKind::Integer { min: 0, max: self.fields - 1 });
        let sense = |name: &str, own, transient, properties| ObservationType {
            name: name.to_owned(),
            own,
            transient,
            properties,
        };
        let reach = ValueKind::Real { min: 0.0, max: 1.0, resolution: 0.01 };
        Description {
            name: self.name.clone(),
            kind: "row".to_owned(),
            observation_types: vec![
                sense("finger", true, false, vec![field()]),
                sense("object", false, false, vec![property("colour", symbols(&["red", "blue"])), field()]),
                sense("touch", false, true, vec![]),
            ],
            actions: vec![ActionType { name: "move".to_owned(), parameters: vec![property("reach", reach)] }],
            repertoire: (0..self.fields)
                .map(|field| Action {
                    action: 0,
                    parameters: vec![Value::Real(field as f64 / self.fields as f64)],
                })
                .collect(),
            scene_commands: vec![ActionType {
                name: "place".to_owned(),
                parameters: vec![
                    property("object", symbols(&["red-block", "blue-block"])),
                    property("position", ValueKind::Integer { min: 0, max: self.fields - 1 }),
                ],
            }],
        }
    }

    fn sense(&mut self, frame: &mut Senses) {
        if let Some(field) = self.finger {
            frame.observe(FINGER, &[Value::Integer(field)]);
        }
        if let Some((colour, field)) = self.block {
            frame.observe(OBJECT, &[Value::Symbol(colour), Value::Integer(field)]);
        }
        if self.moved && self.finger.is_some() && self.finger == self.block.map(|(_, field)| field) {
            frame.observe(TOUCH, &[]);
        }
    }

    fn act(&mut self, action: &Action) -> Outcome {
        let Some(Value::Real(reach)) = action.parameters.first() else { return Outcome::Refused };
        self.finger = Some((reach * self.fields as f64).round() as i64);
        self.moved = true;
        Outcome::Done
    }

    fn arrange(&mut self, command: &Action) -> Outcome {
        let [Value::Symbol(colour), Value::Integer(field)] = command.parameters[..] else {
            return Outcome::Refused;
        };
        (self.finger, self.block, self.moved) = (None, Some((colour, field)), false);
        Outcome::Done
    }
}

fn stage(name: &str, lift: &[&str]) -> Stage {
    Stage {
        name: name.to_owned(),
        lift: Lift::Types(lift.iter().map(|name| (*name).to_owned()).collect()),
        learning: true,
        trials: 0,
        arrange: Vec::new(),
        until: None,
        trial_actions_max: 0,
        saturation: None,
        habituation: None,
        until_absent: None,
        say: Vec::new(),
    }
}

pub(crate) fn place(object: &str, position: Argument) -> SceneCommand {
    let object = ("object".to_owned(), Argument::Symbol(object.to_owned()));
    SceneCommand { command: "place".to_owned(), arguments: vec![object, ("position".to_owned(), position)] }
}

/// The paper's first scenario on a row: babble, touch twice, then try every other field with learning off.
pub(crate) fn curriculum() -> Curriculum {
    let touching = |name: &str, trials| Stage {
        trials,
        arrange: vec![place("blue-block", Argument::Draw("fields".to_owned()))],
        until: Some(NamedObservation { kind: "touch".to_owned(), properties: Vec::new() }),
        trial_actions_max: 20,
        ..stage(name, &["finger", "object", "touch"])
    };
    Curriculum {
        name: "row".to_owned(),
        pools: vec![Pool { name: "fields".to_owned(), from: 0, to: FIELDS - 1 }],
        stages: vec![
            Stage {
                saturation: Some(Saturation { excitation_below: 1.0, actions: 3 }),
                habituation: Some(Habituation { executions_min: 1, interval_max: 0.0 }),
                ..stage("babbling", &["finger"])
            },
            touching("touching", 2),
            Stage { learning: false, ..touching("probe", 6) },
        ],
        afterwards: Afterwards::Hold,
    }
}

/// One stage in which everything is lifted and that never ends.
pub(crate) fn free() -> Curriculum {
    Curriculum {
        name: "free".to_owned(),
        pools: Vec::new(),
        stages: vec![Stage { lift: Lift::All, ..stage("free", &[]) }],
        afterwards: Afterwards::Continue,
    }
}

pub(crate) fn setup(seed: u64, curriculum: Curriculum) -> Setup {
    println!("seed {seed}");
    Setup { seed, parameters: Parameters::default(), curriculum }
}
