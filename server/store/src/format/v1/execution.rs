//! Executions under way.

use pschema_learner::execution as live;

use super::observation::{Observation, Substitution};
use crate::format::mirror::mirror;

mirror! {
    /// One schema still to be executed in a chain.
    struct ChainLink = live::ChainLink {
        /// The schema.
        schema: u32,
        /// The values of its variables.
        binding: Substitution,
        /// The concrete schema that carries out a generalised one.
        carrier: Option<u32>,
    }

    /// What a body was sent to do, and in which world state.
    struct Execution = live::Execution {
        /// The schema; none where a primitive was tried that no schema covers.
        schema: Option<u32>,
        /// The values of its variables.
        binding: Substitution,
        /// The concrete schema that carries out a generalised one.
        carrier: Option<u32>,
        /// The number of the primitive that was sent.
        action: u32,
        /// The observations in whose presence it was decided.
        before: Vec<Observation>,
        /// The rest of a chain after this schema; the schema that the chain is for is the last.
        chain: Vec<ChainLink>,
        /// Whether it was decided in pursuit of a goal.
        for_goal: bool,
    }
}
