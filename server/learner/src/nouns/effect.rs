//! Effects: every change of memory in a step, as values. [`crate::memory::Memory::apply`] is the only thing that changes memory, in
//! the live loop and in recovery alike.

use std::sync::Arc;

use crate::nouns::execution::Execution;
use crate::nouns::experience::Experience;
use crate::nouns::item::{Event, Update};
use crate::nouns::mechanisms::Mechanisms;
use crate::nouns::observation::{Observation, Pattern, TypeId};
use crate::nouns::progress::StageEffect;
use crate::nouns::pursuit::PursuitEffect;
use crate::nouns::schema::SchemaId;
use crate::nouns::vocabulary::{BodyId, Declaration, PrimitiveId};

/// One change of memory. Observations are given whole, not by number, so that effects mean the same to
/// any memory they are applied to in the same order.
#[derive(Clone, Debug, PartialEq)]
pub enum Effect {
    /// A body declared itself.
    Declared(Box<Declaration>),
    /// Symbols (words, mostly) were met for the first time.
    SymbolsMet(Vec<String>),
    /// The body was asked for a primitive, and did or did not carry it out.
    Attempted {
        /// The primitive.
        primitive: PrimitiveId,
        /// Whether the body carried it out.
        carried_out: bool,
    },
    /// A schema was executed and its predictions were scored (II-A).
    Executed {
        /// The schema.
        schema: SchemaId,
        /// Whether every predicted post-condition of a lifted type happened.
        success: bool,
        /// One entry a post-condition, in order.
        post: Vec<Score>,
        /// One entry an association, in order.
        associations: Vec<Score>,
    },
    /// A concrete schema gained an outcome that it did not know.
    OutcomeAdded {
        /// The schema.
        schema: SchemaId,
        /// The observation that was made, or no longer made.
        observation: Observation,
        /// Whether it was no longer made.
        absent: bool,
    },
    /// A concrete schema was made (II-D).
    Created {
        /// Its pre-conditions, in canonical order.
        pre: Vec<Observation>,
        /// Its action.
        action: PrimitiveId,
        /// Its post-conditions, each with whether it is an absence, in canonical order.
        post: Vec<(Observation, bool)>,
        /// The schema whose execution led to this one.
        parent: Option<SchemaId>,
        /// The generalised schema whose prediction failed.
        contradicts: Option<SchemaId>,
    },
    /// A generalised schema was made (II-E).
    Generalised {
        /// Its pre-conditions.
        pre: Vec<Pattern>,
        /// Its target: the observations that are to be achieved.
        target: Vec<Pattern>,
        /// Its post-conditions, each with whether it is an absence.
        post: Vec<(Pattern, bool)>,
        /// The new concrete schema that it was lifted from.
        parent: SchemaId,
        /// The concrete schemas that it represents, its parent included.
        examples: Vec<SchemaId>,
    },
    /// A new concrete schema is represented by a generalised one that was there.
    Supported {
        /// The generalised schema.
        generalised: SchemaId,
        /// The new example.
        example: SchemaId,
    },
    /// A generalised schema fails too often to be used any more.
    Retired {
        /// The generalised schema.
        generalised: SchemaId,
    },
    /// An observation was there alongside a schema for the first time (II-B).
    Associated {
        /// The schema.
        schema: SchemaId,
        /// The observation.
        observation: Observation,
        /// The index of the association that makes room, when the schema has no more room.
        replaces: Option<usize>,
    },
    /// These events were perceived before or after an execution that was learnt from.
    Happened(Vec<Observation>),
    /// N(x) rises by one for each of these (II-C).
    Attended(Vec<Observation>),
    /// Developmental control (II-F).
    Stage(StageEffect),
    /// A goal is pursued, or no more.
    Pursuit(PursuitEffect),
    /// The step is over: memory counts it, and keeps the execution until the next frame of the body.
    StepEnded {
        /// The body.
        body: BodyId,
        /// The state of the generator.
        random: u64,
        /// The execution that the body was sent out on; none when it was sent to do nothing.
        pending: Option<Arc<Execution>>,
    },
    /// Memory has come to the limit that its host sets, and takes in nothing new; or it has room again.
    Full(bool),
    /// A body attached that describes itself otherwise than before, or is described for the first time.
    Described {
        /// The body.
        body: BodyId,
        /// The description, at most [`DESCRIPTION_BYTES_MAX`](crate::vocabulary::limits::DESCRIPTION_BYTES_MAX) bytes.
        text: String,
    },
    /// These mechanisms are on from here, and no others.
    Mechanisms(Mechanisms),
    /// What an action was carried out in, and what was there afterwards: evidence for claims.
    Experienced(Box<Experience>),
    /// What was just experienced, if anything was, is of this body, and it supposes these of the items from then on.
    Followed {
        /// The body.
        body: BodyId,
        /// For each item whether it is supposed.
        on: Vec<bool>,
    },
    /// A synthetic item is made: what becomes of it at each event, in order, tells these outcomes of the action apart.
    Supposed {
        /// The body in whose life it was found.
        body: BodyId,
        /// Whether the body supposes it now.
        on: bool,
        /// The action.
        primitive: PrimitiveId,
        /// The types of the outcomes, in order.
        kinds: Box<[TypeId]>,
        /// What becomes of it at each event.
        updates: Box<[(Event, Update)]>,
    },
    /// No claim asks for this synthetic item, and it is not kept any longer.
    Dropped {
        /// Its number.
        item: u32,
    },
}

/// Whether something held after an execution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Score {
    /// It did.
    Held,
    /// It did not.
    Missed,
    /// Its sense was constrained in this stage, so nothing is known.
    Constrained,
}
