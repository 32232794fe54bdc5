#![doc = include_str!("../README.md")]
//!
//! # Inside
//!
//! Three storeys, each of which imports only from itself and from those below it. `nouns` has the things that learning is about,
//! as plain data. `memory` has what is known and the indexes that make it fast to ask, with the only place that changes it.
//! `cycle` has what is done with a frame, in the order of the paper. Section numbers in this documentation (II-C, IV-A) and
//! equation (1) are those of the paper.
#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod cycle;
pub mod memory;
mod nouns;

pub use cycle::learner::{Learner, LearnerError};
pub use cycle::{goals, plan, why_not};
pub use memory::{chunks, digest, evidence, notation};
pub use nouns::frame::{ActionOutcome, Frame, Output, Step};
pub use nouns::{
    claim, curriculum, decision, effect, effect_error, execution, experience, frame, item, mechanisms,
    observation, parameters, policy, probability, progress, pursuit, random, schema, vocabulary, world_state,
};
