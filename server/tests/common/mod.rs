//! A body small enough to reason about: a finger over a row of fields, and a block that can be put into one.
#![allow(dead_code, reason = "each test file uses a part of it")]

pub(crate) mod process;

use pschema_inspect::{Ask, AskError};
use pschema_learner::curriculum::{
    Afterwards, Argument, Curriculum, Habituation, Lift, NamedObservation, Pool, Saturation, SceneCommand,
    Stage,
};
use pschema_learner::mechanisms::Mechanisms;
use pschema_protocol::client::{Client, ClientError};
use pschema_protocol::prelude::*;
use pschema_server::{LearnerSettings, Setup};

/// Asks a daemon, or gives it an order.
pub(crate) fn ask<Q: Ask>(client: &mut Client, asked: Q) -> Result<Q::Answer, AskError<ClientError>> {
    pschema_inspect::ask(asked, |request| client.request(request))
}

/// Why a daemon does not answer, or not obey.
pub(crate) fn problem<Q: Ask>(client: &mut Client, asked: Q) -> String {
    match ask(client, asked) {
        Err(AskError::Problem(problem)) => problem.0,
        Err(error) => panic!("{error}"),
        Ok(_) => panic!("it was answered"),
    }
}

pub(crate) const FIELDS: i64 = 8;

/// A finger that can be moved to any of some fields, [`FIELDS`] if not otherwise said, and sees itself and a block there.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    description: Description,
    fields: i64,
    senses: [SenseId; 3],
    finger: Option<i64>,
    block: Option<(u32, i64)>,
    moved: bool,
    /// Whether a red block is not felt.
    only_blue: bool,
}

impl Row {
    pub(crate) fn new(name: &str) -> Self {
        Self::with_fields(name, FIELDS)
    }

    /// With so many fields.
    pub(crate) fn with_fields(name: &str, fields: i64) -> Self {
        let mut description = Description::new(name, "row");
        let field = |name| Property::integer(name, 0..=fields - 1);
        let colour = Property::symbol("colour", ["red", "blue"]);
        let senses = [
            ObservationType::state("finger").own().property(field("field")),
            ObservationType::state("object").property(colour).property(field("field")),
            ObservationType::event("touch"),
        ]
        .map(|sense| description.observation(sense));
        // Fine enough for each field to be a place of its own: 0.01 with eight fields.
        let reach = Property::real("reach", 0.0..=1.0, 0.08 / fields as f64);
        let reach = description.action(ActionType::new("move").parameter(reach));
        for field in 0..fields {
            description.primitive(reach, [field as f64 / fields as f64]);
        }
        let object = Property::symbol("object", ["red-block", "blue-block"]);
        let place = ActionType::new("place").parameter(object).parameter(field("position"));
        description.scene_command(place);
        Self { description, fields, senses, finger: None, block: None, moved: false, only_blue: false }
    }

    /// One that does not feel red blocks.
    pub(crate) fn feeling_blue_alone(name: &str) -> Self {
        Self { only_blue: true, ..Self::new(name) }
    }

    /// With the block in `field` from the beginning.
    pub(crate) fn with_block(name: &str, field: i64) -> Self {
        Self { block: Some((1, field)), ..Self::new(name) }
    }
}

impl Body for Row {
    fn describe(&self) -> Description {
        self.description.clone()
    }

    fn sense(&mut self, frame: &mut Senses) {
        let [finger, object, touch] = self.senses;
        if let Some(field) = self.finger {
            frame.observe(finger, [field]);
        }
        if let Some((colour, field)) = self.block {
            frame.observe(object, (Value::Symbol(colour), field));
        }
        let felt = self.block.filter(|(colour, _)| !self.only_blue || *colour == 1);
        if self.moved && self.finger.is_some() && self.finger == felt.map(|(_, field)| field) {
            frame.observe(touch, ());
        }
    }

    fn act(&mut self, action: &Action) -> Outcome {
        let Some(reach) = action.real(0) else { return Outcome::refused("no reach") };
        self.finger = Some((reach * self.fields as f64).round() as i64);
        self.moved = true;
        Outcome::Done
    }

    fn arrange(&mut self, command: &Action) -> Outcome {
        let [Value::Symbol(colour), Value::Integer(field)] = command.parameters[..] else {
            return Outcome::refused("no object or position");
        };
        (self.finger, self.block, self.moved) = (None, Some((colour, field)), false);
        Outcome::Done
    }
}

fn stage(name: &str, lift: &[&str]) -> Stage {
    Stage { lift: Lift::Types(lift.iter().map(|name| (*name).to_owned()).collect()), ..Stage::free(name) }
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
    Curriculum::free("free")
}

/// A learner of the paper: what it makes of the row of fields can be worked out.
pub(crate) fn setup(seed: u64, curriculum: Curriculum) -> Setup {
    println!("seed {seed}");
    let learner = LearnerSettings::of(Mechanisms::PAPER);
    Setup { seed, learner, curriculum }
}
