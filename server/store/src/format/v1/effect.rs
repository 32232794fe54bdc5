//! Effects: what changes memory.

use pschema_learner::effect as live;

use super::execution::Execution;
use super::experience::{Event, Experience, Mechanism, Update};
use super::goal::PursuitEffect;
use super::observation::{Observation, Pattern};
use super::stage::StageEffect;
use super::vocabulary::{Declaration, ValuedDeclaration, has_values};
use crate::format::mirror::mirror;

mirror! {
    /// Whether something held after an execution.
    #[derive(Copy)]
    enum Score = live::Score {
        Held,
        Missed,
        Constrained,
    }

    /// One change of memory.
    enum Effect = live::Effect {
        Declared(declaration: Box<Declaration>),
        SymbolsMet(symbols: Vec<String>),
        Attempted { primitive: u32, carried_out: bool },
        Executed { schema: u32, success: bool, post: Vec<Score>, associations: Vec<Score> },
        OutcomeAdded { schema: u32, observation: Observation, absent: bool },
        Created {
            pre: Vec<Observation>,
            action: u32,
            post: Vec<(Observation, bool)>,
            parent: Option<u32>,
            contradicts: Option<u32>
        },
        Generalised {
            pre: Vec<Pattern>,
            target: Vec<Pattern>,
            post: Vec<(Pattern, bool)>,
            parent: u32,
            examples: Vec<u32>
        },
        Supported { generalised: u32, example: u32 },
        Retired { generalised: u32 },
        Associated { schema: u32, observation: Observation, replaces: Option<u64> },
        Happened(events: Vec<Observation>),
        Attended(observations: Vec<Observation>),
        Stage(effect: StageEffect),
        Pursuit(effect: PursuitEffect),
        StepEnded { body: u16, random: u64, pending: Option<Box<Execution>> },
        Full(full: bool),
        Described { body: u16, text: String },
        Mechanisms(mechanisms: Vec<Mechanism>),
        Experienced(experience: Box<Experience>),
        Followed { body: u16, on: Vec<bool> },
        Supposed { body: u16, on: bool, primitive: u32, kinds: Vec<u16>, updates: Vec<(Event, Update)> },
        Dropped { item: u32 },
        ..DeclaredValues(Box<ValuedDeclaration>) as Declared if has_values,
    }
}
