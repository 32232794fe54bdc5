//! Executions: the schema that a body was sent to execute, and the chain that it is part of.

use crate::nouns::observation::Substitution;
use crate::nouns::schema::SchemaId;
use crate::nouns::vocabulary::PrimitiveId;
use crate::nouns::world_state::WorldState;

/// An execution under way: the decision, and the world state in which it was made.
#[derive(Clone, Debug, PartialEq)]
pub struct Execution {
    /// The schema being executed; none when a primitive is tried for which no schema holds here.
    pub schema: Option<SchemaId>,
    /// The binding, when it is a generalised schema.
    pub binding: Substitution,
    /// The concrete schema that achieves a generalised schema's target.
    pub carrier: Option<SchemaId>,
    /// The primitive that was sent.
    pub action: PrimitiveId,
    /// The world state in which it was decided, under the constraints of the stage.
    pub before: WorldState,
    /// The rest of a chain after this schema, in order; the schema that the chain is for is the last.
    pub chain: Vec<ChainLink>,
    /// Whether it was decided in pursuit of a goal, so that the curriculum does not count it.
    pub for_goal: bool,
}

/// One schema still to be executed in a chain.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChainLink {
    /// The schema.
    pub schema: SchemaId,
    /// Its binding, when it is generalised.
    pub binding: Substitution,
    /// The concrete schema that achieves its target, when it is generalised.
    pub carrier: Option<SchemaId>,
}
