//! The schema learner: pure, deterministic, no I/O.
#![forbid(unsafe_code)]

mod association;
mod attention;
mod babbling;
mod bound;
mod chaining;
mod choice;
pub mod chunks;
mod creation;
pub mod curriculum;
pub mod decision;
pub mod digest;
mod draft;
pub mod effect;
mod excitation;
mod generalisation;
pub mod goals;
mod groups;
mod habituation;
mod index;
pub mod memory;
pub mod notation;
pub mod observation;
mod outline;
pub mod parameters;
pub mod plan;
pub mod probability;
pub mod progress;
pub mod pursuit;
pub mod random;
pub mod schema;
mod search;
mod stages;
pub mod step;
mod target_action;
pub mod vocabulary;
pub mod world_state;
