//! The things that learning is about, as plain data: what is perceived, what can be done, schemas, and where the curriculum
//! and a goal stand. Nothing here knows a memory.

pub mod claim;
pub mod curriculum;
pub mod decision;
pub mod effect;
pub mod effect_error;
pub mod execution;
pub mod experience;
pub mod frame;
pub mod item;
pub mod mechanisms;
pub mod observation;
pub mod parameters;
pub mod policy;
pub mod probability;
pub mod progress;
pub mod pursuit;
pub mod random;
pub mod schema;
pub(crate) mod terms;
pub mod vocabulary;
pub mod world_state;
