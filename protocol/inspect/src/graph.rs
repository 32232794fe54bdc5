//! What tools ask for to draw what is known: schemas and what ties them together.

use serde::{Deserialize, Serialize};

use super::SchemaSummary;

/// Which part of memory is to be drawn. With neither `around` nor `goal`, the whole.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GraphQuery {
    /// Only what is tied to the schema of this number.
    pub around: Option<u32>,
    /// How many ties away from it, 1 to 8; 0 for 1.
    pub depth: u32,
    /// Only the chain that would bring this goal about from the world as it is: a pattern for each thing wanted.
    pub goal: Vec<String>,
    /// Schemas to be told one by one, at most; the others stand together. 0 for the daemon's limit.
    pub limit: u32,
}

/// Schemas and what ties them together. Of the same memory always the same, and in the same order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Graph {
    /// Steps taken in the life of this memory.
    pub step: u64,
    /// `all`, `around` or `goal`.
    pub scope: GraphScope,
    /// The schema that it is around, if it is.
    pub around: Option<u32>,
    /// The goal, as it prints; empty without.
    pub goal: Vec<String>,
    /// How probable it is that the chain brings the goal about; none without a goal.
    pub probability: Option<f64>,
    /// Schemas in its scope, told one by one or not. Around a schema, those that were come to.
    pub nodes_total: u64,
    /// Schemas told one by one.
    pub shown: u32,
    /// Whether something in its scope was left out, or stands together with others: ask for more, or for a part.
    pub truncated: bool,
    /// What belongs side by side.
    pub clusters: Vec<GraphCluster>,
    /// Schemas by number, then what stands for several.
    pub nodes: Vec<GraphNode>,
    /// Ties between them: by `from`, `to` and kind.
    pub edges: Vec<GraphEdge>,
    /// Ties that there are between these nodes, listed or not.
    pub edges_total: u64,
}

/// What a graph is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GraphScope {
    /// Of all that is known.
    All,
    /// Of what is tied to one schema.
    Around,
    /// Of the chain to a goal.
    Goal,
}

/// Schemas that do the same kind of thing in the same kind of situation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GraphCluster {
    /// What they have in common: `move for finger and touch, given object`; `generalised`.
    pub name: String,
    /// How many schemas of the scope it has.
    pub members: u64,
}

/// A schema, or several that stand together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GraphNode {
    /// The schema; none where it stands for several.
    pub schema: Option<SchemaSummary>,
    /// How many schemas it stands for.
    pub members: u64,
    /// `concrete`, `generalised`, `retired`, `counter-example`.
    pub kind: String,
    /// An index into [`Graph::clusters`].
    pub cluster: u32,
}

/// A tie between two nodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GraphEdge {
    /// An index into [`Graph::nodes`].
    pub from: u32,
    /// An index into [`Graph::nodes`].
    pub to: u32,
    /// What ties them.
    pub kind: GraphTie,
    /// How many ties between schemas it stands for.
    pub count: u64,
}

/// What ties one schema to another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GraphTie {
    /// The second follows the first in the chain to the goal.
    Next,
    /// The first predicts a pre-condition of the second that it does not need itself.
    Enables,
    /// The first predicts something of the second's target: it may carry it out.
    Carries,
    /// The first is an example of the second.
    ExampleOf,
    /// The first is a counter-example to the second.
    CounterExampleTo,
    /// The execution of the first led to the second.
    ParentOf,
}
