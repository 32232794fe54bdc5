//! What somebody who watches a learner is shown, all of one moment.

use serde::{Deserialize, Serialize};

use crate::decision::Explanation;
use crate::notation::ObservationText;
use crate::schema::SchemaSummary;
use crate::status::Status;
use crate::trace::TracePage;

/// A learner at one moment, for those who watch it. Cheap to answer at any size of memory: what takes a look at all of
/// memory is left out ([`Status::memory_digest`]) or asked for apart ([`SchemaQuery`](crate::SchemaQuery), the most used).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Live {
    /// How the daemon and its learner are, without the digest of memory, and with at most 256 observations in its `world`.
    #[serde(flatten)]
    pub status: Status,
    /// The observations of `world`, in the same order.
    pub observations: Vec<WorldObservation>,
    /// Why the last action was chosen; none before the first.
    pub explanation: Option<Explanation>,
    /// The newest schemas, the newest first.
    pub newest: Vec<SchemaSummary>,
    /// What was decided in the steps asked for.
    pub trace: TracePage,
}

/// One observation of the world state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct WorldObservation {
    /// What is observed.
    pub observation: ObservationText,
    /// Whether it was not observed in the frame before.
    pub new: bool,
    /// N of equation (1): how often it has been attended to.
    pub attention: u32,
}
