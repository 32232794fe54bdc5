//! Schemas: in a list, one whole, and as one is used.

use serde::{Deserialize, Serialize};

use crate::claims::Foretold;
use crate::closed_set::closed_set;
use crate::notation::{Condition, NamedValues, ObservationText};

closed_set! {
    /// What a schema is.
    SchemaKind {
        /// With constants only.
        Concrete = "concrete",
        /// With variables.
        Generalised = "generalised",
        /// Generalised, and never chosen again: it failed too often.
        Retired = "retired",
        /// Concrete, and where a generalised schema does not hold.
        CounterExample = "counter-example",
    }
}

/// A list of schemas.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SchemaList {
    /// How many schemas fit, listed or not; the offset does not change it.
    pub matching: u32,
    /// Those listed.
    pub schemas: Vec<SchemaSummary>,
}

/// One schema in a list.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SchemaSummary {
    /// Its number.
    pub id: u32,
    /// What it is.
    pub kind: SchemaKind,
    /// Pre-conditions as they print.
    pub pre: Vec<String>,
    /// Action (or target action) as it prints.
    pub action: String,
    /// Post-conditions as they print.
    pub post: Vec<String>,
    /// The share of executions in which each of them held, in 0..=1; none before the first. Outcomes that exclude each other
    /// share them.
    pub post_shares: Vec<Option<f64>>,
    /// Executions.
    pub executions: u32,
    /// Executions in which everything happened that the schema predicts.
    pub successes: u32,
    /// Share of successes; with `low` and `high`, its 95 % interval.
    pub probability: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

/// One schema whole.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SchemaDetail {
    /// Its number.
    pub id: u32,
    /// What it is.
    pub kind: SchemaKind,
    /// The primitive as it prints, or the target's observations.
    pub action: String,
    /// The target action of a generalised schema.
    pub target: Vec<ObservationText>,
    /// Pre-conditions.
    pub pre: Vec<ObservationText>,
    /// Post-conditions.
    pub post: Vec<Condition>,
    /// Associated observations.
    pub associated: Vec<Condition>,
    /// Executions.
    pub executions: u32,
    /// Executions in which everything happened that the schema predicts.
    pub successes: u32,
    /// Share of successes.
    pub probability: f64,
    /// Lower end of its 95 % interval.
    pub low: f64,
    /// Upper end of its 95 % interval.
    pub high: f64,
    /// The schema whose execution led to it.
    pub parent: Option<u32>,
    /// The generalised schema that it is a counter-example to.
    pub contradicts: Option<u32>,
    /// Generalised schemas that count it as an example; of a generalised schema, its examples.
    pub examples: Vec<u32>,
    /// Counter-examples of a generalised schema.
    pub counter_examples: Vec<u32>,
    /// The step that made it.
    pub created_step: u64,
    /// The claims that it rests on: what they foretell of its action under its pre-conditions (of a law, under those of its first
    /// example), of the types that it tells of. Left out where there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub claims: Vec<Foretold>,
}

/// A schema as it is used in one situation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SchemaInUse {
    /// Its number.
    pub id: u32,
    /// What it is.
    pub kind: SchemaKind,
    /// The schema as it prints.
    pub text: String,
    /// Values of its variables.
    pub binding: NamedValues,
    /// The primitive that it comes to, as it prints.
    pub action: String,
    /// The concrete schema that achieves its target, when it is generalised.
    pub carrier: Option<u32>,
}
