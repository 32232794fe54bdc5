//! The cycle: what is done with a frame. `step.rs` reads as the numbered list of the paper, and each of its steps is a file.

mod association;
mod attention;
mod babbling;
mod carrier;
mod chaining;
mod choice;
mod claims;
mod creation;
mod curiosity;
mod excitation;
mod frontier;
mod generalisation;
pub mod goals;
mod habituation;
pub(crate) mod learner;
mod match_cache;
mod most;
pub mod plan;
mod policy;
mod pursue;
mod search;
mod stages;
mod step;
mod supposing;
mod target_action;
mod valuation;
pub mod why_not;
