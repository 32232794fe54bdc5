//! What is known, to be drawn: schemas and what ties them together.

use serde::{Deserialize, Serialize};

use crate::closed_set::closed_set;
use crate::schema::{SchemaKind, SchemaSummary};

/// Schemas and what ties them together. Of the same memory always the same, and in the same order.
///
/// Of all of memory, when there are more schemas than were asked for: generalised ones first, then their counter-examples and
/// examples, then those that were executed most. The others stand together by action and by the types of what they need
/// and make, with their ties to those that are shown one by one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Graph {
    /// Steps taken in the life of this memory.
    pub step: u64,
    /// What it is of.
    pub scope: GraphScope,
    /// The schema that it is around, if it is.
    pub around: Option<u32>,
    /// The goal, as it prints; empty without.
    pub goal: Vec<String>,
    /// How probable it is that the chain brings the goal about; none without a goal.
    pub probability: Option<f64>,
    /// Schemas in its scope, shown one by one or not. Around a schema, those that were found.
    pub nodes_total: u64,
    /// Schemas shown one by one.
    pub shown: u32,
    /// Whether something in its scope was left out, or stands together with others: ask for more, or for a part.
    pub truncated: bool,
    /// What belongs side by side.
    pub clusters: Vec<GraphCluster>,
    /// Schemas by number, then the nodes that stand for several.
    pub nodes: Vec<GraphNode>,
    /// Ties between them: by `from`, `to` and kind; at most 20,000.
    pub edges: Vec<GraphEdge>,
    /// Ties that there are between these nodes, listed or not.
    pub edges_total: u64,
}

closed_set! {
    /// What a graph is of.
    GraphScope {
        /// Of everything that is known.
        All = "all",
        /// Of what is tied to one schema.
        Around = "around",
        /// Of the chain to a goal.
        Goal = "goal",
    }
}

/// Schemas that do the same kind of thing in the same kind of situation.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct GraphCluster {
    /// What they have in common: `move for finger and touch, given object`; `generalised`.
    pub name: String,
    /// How many schemas of the scope it has.
    pub members: u64,
}

/// A schema, or several that stand together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct GraphNode {
    /// The schema; none where it stands for several.
    pub schema: Option<SchemaSummary>,
    /// How many schemas it stands for.
    pub members: u64,
    /// What they are.
    pub kind: SchemaKind,
    /// An index into `clusters`.
    pub cluster: u32,
}

/// A tie between two nodes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct GraphEdge {
    /// An index into `nodes`.
    pub from: u32,
    /// An index into `nodes`.
    pub to: u32,
    /// What ties them.
    pub kind: GraphTie,
    /// How many ties between schemas it stands for.
    pub count: u64,
}

closed_set! {
    /// What ties one schema to another.
    GraphTie {
        /// The second follows the first in the chain to the goal.
        Next = "next",
        /// The first predicts a pre-condition of the second that it does not need itself.
        Enables = "enables",
        /// The first predicts something of the second's target: it may carry it out.
        Carries = "carries",
        /// The first is an example of the second.
        ExampleOf = "example-of",
        /// The first is a counter-example to the second.
        CounterExampleTo = "counter-example-to",
        /// The execution of the first led to the second.
        ParentOf = "parent-of",
    }
}
