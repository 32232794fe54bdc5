//! The schema learner: pure, deterministic, no I/O.
//!
//! Three storeys, each of which imports only from itself and from those below it: [`nouns`](self#reexports), the things that
//! learning is about, as plain data; `memory`, what is known and what makes it fast to ask, with the only place that
//! changes it; `cycle`, what is done with a frame, in the order of the paper.
#![forbid(unsafe_code)]

mod cycle;
pub mod memory;
mod nouns;

pub use cycle::learner::{Learner, LearnerError};
pub use cycle::{goals, plan, why_not};
pub use memory::{chunks, digest, notation};
pub use nouns::frame::{ActionOutcome, Frame, Output, Step};
pub use nouns::{
    curriculum, decision, effect, effect_error, execution, frame, observation, parameters, probability,
    progress, pursuit, random, schema, vocabulary, world_state,
};
