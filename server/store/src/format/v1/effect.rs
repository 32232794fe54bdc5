//! Effects, and the execution that a step leaves behind.

use pschema_learner::effect as live;
use pschema_learner::execution;
use pschema_learner::observation::{self as seen};
use pschema_learner::schema::SchemaId;
use pschema_learner::vocabulary::{BodyId, PrimitiveId};
use pschema_learner::world_state::WorldState;
use serde::{Deserialize, Serialize};

use super::observation::{Observation, Pattern, Substitution, back, list};
use super::stage::{PursuitEffect, StageEffect};
use super::vocabulary::Declaration;
use super::{Impossible, index};

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Seen {
    Held,
    Missed,
    Constrained,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ChainLink {
    pub(super) schema: u32,
    pub(super) binding: Substitution,
    pub(super) carrier: Option<u32>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Execution {
    pub(super) schema: Option<u32>,
    pub(super) binding: Substitution,
    pub(super) carrier: Option<u32>,
    pub(super) action: u32,
    pub(super) before: Vec<Observation>,
    pub(super) chain: Vec<ChainLink>,
    pub(super) for_goal: bool,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Effect {
    Declared(Box<Declaration>),
    SymbolsMet(Vec<String>),
    Attempted {
        primitive: u32,
        carried_out: bool,
    },
    Executed {
        schema: u32,
        success: bool,
        post: Vec<Seen>,
        associations: Vec<Seen>,
    },
    OutcomeAdded {
        schema: u32,
        observation: Observation,
        absent: bool,
    },
    Created {
        pre: Vec<Observation>,
        action: u32,
        post: Vec<(Observation, bool)>,
        parent: Option<u32>,
        contradicts: Option<u32>,
    },
    Generalised {
        pre: Vec<Pattern>,
        target: Vec<Pattern>,
        post: Vec<(Pattern, bool)>,
        parent: u32,
        examples: Vec<u32>,
    },
    Supported {
        generalised: u32,
        example: u32,
    },
    Retired {
        generalised: u32,
    },
    Associated {
        schema: u32,
        observation: Observation,
        replaces: Option<u64>,
    },
    Happened(Vec<Observation>),
    Attended(Vec<Observation>),
    Stage(StageEffect),
    Pursuit(PursuitEffect),
    StepEnded {
        body: u16,
        random: u64,
        pending: Option<Box<Execution>>,
    },
}

fn number(id: Option<SchemaId>) -> Option<u32> {
    id.map(|id| id.0)
}

impl From<&live::Score> for Seen {
    fn from(seen: &live::Score) -> Self {
        match seen {
            live::Score::Held => Self::Held,
            live::Score::Missed => Self::Missed,
            live::Score::Constrained => Self::Constrained,
        }
    }
}

impl From<Seen> for live::Score {
    fn from(seen: Seen) -> Self {
        match seen {
            Seen::Held => Self::Held,
            Seen::Missed => Self::Missed,
            Seen::Constrained => Self::Constrained,
        }
    }
}

impl From<&execution::ChainLink> for ChainLink {
    fn from(link: &execution::ChainLink) -> Self {
        Self { schema: link.schema.0, binding: (&link.binding).into(), carrier: number(link.carrier) }
    }
}

impl From<ChainLink> for execution::ChainLink {
    fn from(link: ChainLink) -> Self {
        Self {
            schema: SchemaId(link.schema),
            binding: link.binding.into(),
            carrier: link.carrier.map(SchemaId),
        }
    }
}

impl From<&execution::Execution> for Execution {
    fn from(execution: &execution::Execution) -> Self {
        Self {
            schema: number(execution.schema),
            binding: (&execution.binding).into(),
            carrier: number(execution.carrier),
            action: execution.action.0,
            before: list(execution.before.observations()),
            chain: list(&execution.chain),
            for_goal: execution.for_goal,
        }
    }
}

impl From<Execution> for execution::Execution {
    fn from(execution: Execution) -> Self {
        Self {
            schema: execution.schema.map(SchemaId),
            binding: execution.binding.into(),
            carrier: execution.carrier.map(SchemaId),
            action: PrimitiveId(execution.action),
            before: WorldState::new(execution.before.into_iter().map(seen::Observation::from)),
            chain: back(execution.chain),
            for_goal: execution.for_goal,
        }
    }
}

impl From<&live::Effect> for Effect {
    fn from(effect: &live::Effect) -> Self {
        use live::Effect as Live;
        match effect {
            Live::Declared(declaration) => Self::Declared(Box::new((&**declaration).into())),
            Live::SymbolsMet(symbols) => Self::SymbolsMet(symbols.clone()),
            Live::Attempted { primitive, carried_out } => {
                Self::Attempted { primitive: primitive.0, carried_out: *carried_out }
            }
            Live::Executed { schema, success, post, associations } => Self::Executed {
                schema: schema.0,
                success: *success,
                post: list(post),
                associations: list(associations),
            },
            Live::OutcomeAdded { schema, observation, absent } => {
                Self::OutcomeAdded { schema: schema.0, observation: observation.into(), absent: *absent }
            }
            Live::Created { pre, action, post, parent, contradicts } => Self::Created {
                pre: list(pre),
                action: action.0,
                post: post.iter().map(|(what, absent)| (what.into(), *absent)).collect(),
                parent: number(*parent),
                contradicts: number(*contradicts),
            },
            Live::Generalised { pre, target, post, parent, examples } => Self::Generalised {
                pre: list(pre),
                target: list(target),
                post: post.iter().map(|(what, absent)| (what.into(), *absent)).collect(),
                parent: parent.0,
                examples: examples.iter().map(|id| id.0).collect(),
            },
            Live::Supported { generalised, example } => {
                Self::Supported { generalised: generalised.0, example: example.0 }
            }
            Live::Retired { generalised } => Self::Retired { generalised: generalised.0 },
            Live::Associated { schema, observation, replaces } => Self::Associated {
                schema: schema.0,
                observation: observation.into(),
                replaces: replaces.map(|at| at as u64),
            },
            Live::Happened(events) => Self::Happened(list(events)),
            Live::Attended(observations) => Self::Attended(list(observations)),
            Live::Stage(effect) => Self::Stage(effect.into()),
            Live::Pursuit(effect) => Self::Pursuit(effect.into()),
            Live::StepEnded { body, random, pending } => Self::StepEnded {
                body: body.0,
                random: *random,
                pending: pending.as_ref().map(|execution| Box::new((&**execution).into())),
            },
        }
    }
}

impl TryFrom<Effect> for live::Effect {
    type Error = Impossible;

    fn try_from(effect: Effect) -> Result<Self, Impossible> {
        let outcome = |(what, absent): (Observation, bool)| (what.into(), absent);
        let lifted = |(what, absent): (Pattern, bool)| (what.into(), absent);
        Ok(match effect {
            Effect::Declared(declaration) => Self::Declared(Box::new((*declaration).into())),
            Effect::SymbolsMet(symbols) => Self::SymbolsMet(symbols),
            Effect::Attempted { primitive, carried_out } => {
                Self::Attempted { primitive: PrimitiveId(primitive), carried_out }
            }
            Effect::Executed { schema, success, post, associations } => Self::Executed {
                schema: SchemaId(schema),
                success,
                post: back(post),
                associations: back(associations),
            },
            Effect::OutcomeAdded { schema, observation, absent } => {
                Self::OutcomeAdded { schema: SchemaId(schema), observation: observation.into(), absent }
            }
            Effect::Created { pre, action, post, parent, contradicts } => Self::Created {
                pre: back(pre),
                action: PrimitiveId(action),
                post: post.into_iter().map(outcome).collect(),
                parent: parent.map(SchemaId),
                contradicts: contradicts.map(SchemaId),
            },
            Effect::Generalised { pre, target, post, parent, examples } => Self::Generalised {
                pre: back(pre),
                target: back(target),
                post: post.into_iter().map(lifted).collect(),
                parent: SchemaId(parent),
                examples: examples.into_iter().map(SchemaId).collect(),
            },
            Effect::Supported { generalised, example } => {
                Self::Supported { generalised: SchemaId(generalised), example: SchemaId(example) }
            }
            Effect::Retired { generalised } => Self::Retired { generalised: SchemaId(generalised) },
            Effect::Associated { schema, observation, replaces } => Self::Associated {
                schema: SchemaId(schema),
                observation: observation.into(),
                replaces: replaces.map(index),
            },
            Effect::Happened(events) => Self::Happened(back(events)),
            Effect::Attended(observations) => Self::Attended(back(observations)),
            Effect::Stage(effect) => Self::Stage(effect.try_into()?),
            Effect::Pursuit(effect) => Self::Pursuit(effect.into()),
            Effect::StepEnded { body, random, pending } => Self::StepEnded {
                body: BodyId(body),
                random,
                pending: pending.map(|execution| Box::new((*execution).into())),
            },
        })
    }
}
