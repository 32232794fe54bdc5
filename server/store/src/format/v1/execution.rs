//! Executions under way.

use pschema_learner::execution as live;

use super::observation::{Observation, Substitution};
use crate::format::mirror::mirror;

mirror! {
    /// One schema still to be executed in a chain.
    struct ChainLink = live::ChainLink {
        schema: u32,
        binding: Substitution,
        carrier: Option<u32>,
    }

    /// What a body was sent to do, and in which world state.
    struct Execution = live::Execution {
        schema: Option<u32>,
        binding: Substitution,
        carrier: Option<u32>,
        action: u32,
        before: Vec<Observation>,
        chain: Vec<ChainLink>,
        for_goal: bool,
    }
}
